"""Friction of a smooth sliding plate at finite strain: gross slip only, no stick.

The surface of a plate that moves in its plane stays where it is: only friction makes the finger
notice. Once the whole contact slips, the traction is the kinetic coefficient times the pressure in
the direction of the slide. Stick is left out, and a slide that does not end it is refused.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from fefinger.geometry.profiles import frame
from fefinger.mechanics.press.placement import on_neighborhood
from fefinger.mechanics.press.problem import FiniteStrainHistory, Press
from fefinger.results.records import Lateral
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import InputError
from fefinger.support.units import NEWTON_PER_MILLINEWTON


IN_PLANE = "Sliding: a smooth plate that moves in its plane leaves its surface where it was."
"""Note on every answer with a path."""

GROSS = (
    "Friction: while the plate slides, the traction on the skin is the kinetic coefficient times "
    "the pressure in the direction of the slide; where the plate starts and turns it grows with "
    "the speed, and where it stops it stays. Stick is left out: a press before has no friction, "
    "and work counts once the whole contact slips. Stated errors are those of a press without "
    "sliding."
)
"""Note on every answer with friction."""


def drag(press: Press, time: float) -> Array:
    """Return the friction (3,) of the plate at a time in s, as a part of the pressure."""
    return press.indenter.kinetic * press.motion.heading(time) @ frame(press.obstacle.axis)[:2]


@dataclass(frozen=True)
class Dragged:
    """Motion of the skin under a sliding plate, at all times of an answer.

    moved (n_t, n_seen, 2) mm: the skin along the plane of the plate; touching (n_t, n_seen);
    heading (n_t, 2) as of the motion; shift (n_t, 2) mm of the plate.
    """

    time: Array
    moved: Array
    touching: Flags
    heading: Array
    shift: Array

    @classmethod
    def of(cls, press: Press, history: FiniteStrainHistory, pressure: Array) -> Self:
        """Return the skin of a solved press with the pressure (n_t, n_candidates) kPa."""
        steps = history.steps
        across = frame(press.obstacle.axis)[:2]
        return cls(
            time=steps.time,
            moved=steps.smooth(history.moved @ across.T),
            touching=on_neighborhood(pressure, history.contact.neighborhood) > 0,
            heading=press.motion.heading(steps.time),
            shift=press.motion.shift(steps.time),
        )

    @property
    def slip(self) -> Array:
        """Slip (n_t, n_seen, 2) mm of the skin over the plate since first contact."""
        slid = np.diff(self.moved, axis=0) - np.diff(self.shift, axis=0)[:, None]
        slid[~self.touching[1:]] = 0.0
        return np.concatenate([np.zeros((1, *slid.shape[1:])), np.cumsum(slid, axis=0)])

    def passes(self) -> list[tuple[int, int]]:
        """Return the first and last times (numbers) of every pass in one direction."""
        moving = np.flatnonzero(self.heading.any(axis=1))
        if not len(moving):
            return []
        first = self.heading[moving[0]]
        side = np.sign(self.heading[moving] @ first)
        ends = np.append(np.flatnonzero(np.diff(side)), len(moving) - 1)
        starts = np.append(0, ends[:-1] + 1)
        return [(int(moving[a]) - 1, int(moving[b])) for a, b in zip(starts, ends, strict=True)]

    def onset(self, begin: int, end: int) -> tuple[int, float]:
        """Return the onset of gross slip in a pass: number of the time, and travel in mm.

        That is where the plate has moved farther than any skin under it that friction draws along:
        in Mindlin's theory exactly the end of partial slip. The number is past the end of a pass
        that is too short.
        """
        pass_ = slice(begin, end + 1)
        along = self.heading[begin + 1 : end + 1].sum(axis=0)
        along /= np.linalg.norm(along)
        drawn = (self.moved[pass_] - self.moved[begin]) @ along
        drawn = np.where(self.touching[pass_], drawn, -np.inf).max(axis=1)
        gone = (self.shift[pass_] - self.shift[begin]) @ along
        held = np.flatnonzero(drawn > gone)
        after = int(held[-1]) + 1 if len(held) else 1
        return begin + after, float(gone[after] if after < len(gone) else drawn[-1])

    def deviation(self, begin: int, end: int) -> float:
        """Return the largest angle in degrees of the slip from the slide, at speed."""
        speed = np.gradient(self.shift, self.time, axis=0)
        slid = speed[:, None] - np.gradient(self.moved, self.time, axis=0)
        along = self.heading[end]
        aside = np.abs(slid @ np.array([-along[1], along[0]]))
        angles = np.degrees(np.arctan2(aside, slid @ along))
        fast = speed @ along > (speed @ along).max() / 2
        fast[:begin], fast[end + 1 :] = False, False
        return float(angles[self.touching & fast[:, None]].max(initial=0.0))


def smooth(press: Press, time: Array) -> Lateral:
    """Return the path of a frictionless plate at times (n_t,) s, with zero tangential force."""
    shift = press.motion.shift(time)
    return Lateral(shift, np.zeros_like(shift))


def lateral(
    press: Press, history: FiniteStrainHistory, pressure: Array, force: Array, column: Integers
) -> Lateral:
    """Collect path, friction and slip; pressure (n_t, n_candidates) kPa, force (n_t,) N."""
    if not press.indenter.friction:
        return smooth(press, history.steps.time)
    skin = Dragged.of(press, history, pressure)
    words = "" if history.halt else outcome(skin)
    friction, slip = press.indenter.kinetic * skin.heading, skin.slip
    signs = np.ones((len(column), 2))
    signs[len(history.contact.neighborhood.vertices) :, 1] = -1.0
    seen = on_neighborhood(pressure, history.contact.neighborhood)
    areas = history.contact.projected
    slid = np.diff(slip, axis=0)[:, : len(areas)]
    for begin, end in skin.passes():  # until all of it slips, it has moved as it was pulled
        slid[begin : min(skin.onset(begin, end)[0], end)] = 0.0
    pulled = friction[1:, None] * (pressure[1:] * areas)[..., None]
    lost = -np.einsum("tvk,tvk->t", pulled, slid) * press.body.sides * NEWTON_PER_MILLINEWTON
    return Lateral(
        shift=skin.shift,
        force=friction * force[:, None],
        torque=np.zeros(len(force)),
        stick_area=np.zeros(len(force)),
        traction=friction[:, None] * seen[:, column, None] if press.pressure else None,
        slip=slip[:, column] * signs if press.pressure else None,
        work=np.append(0.0, np.cumsum(lost)),
        outcome=words,
    )


def notes(press: Press) -> tuple[str, ...]:
    """Return the notes on a press with a path."""
    if not press.tangential:
        return ()
    return (IN_PLANE, GROSS) if press.indenter.friction else (IN_PLANE,)


def outcome(skin: Dragged) -> str:
    """Return in words since when the whole contact slips.

    InputError if a pass is too short for that.
    """
    onsets, angle = [], 0.0
    for number, (begin, end) in enumerate(skin.passes()):
        start, gone = skin.onset(begin, end)
        if start > end:
            moved = float(np.linalg.norm(skin.shift[end] - skin.shift[begin]))
            turn = " and turns back" if number else ""
            raise InputError(
                f"motion.distance: expected a slide over more than {gone:.3g} mm, as far as "
                f"friction draws the skin along{turn}, received {moved:.3g} mm, over which part of "
                "the contact sticks; finite strain leaves stick out: slide farther, or take "
                "'condensed' or 'linear'"
            )
        onsets.append((float(skin.time[start]), gone))
        angle = max(angle, skin.deviation(start, end))
    since, gone = onsets[0]
    turned = f", and {max(x for _, x in onsets[1:]):.3g} mm after a turn" if onsets[1:] else ""
    return (
        f"Gross slip: from {since:.4g} s on, with the indenter moved by {gone:.3g} mm{turned}, the "
        f"whole contact slips, within {angle:.2g} degrees of the slide; before, part of it would "
        "stick, and its friction is stated too large."
    )
