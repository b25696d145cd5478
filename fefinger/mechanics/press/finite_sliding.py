"""An object with a path or with friction at finite strain: what it pulls, and where skin sticks."""

import numpy as np

from fefinger.mechanics.press.notes import told
from fefinger.mechanics.press.placement import on_neighborhood
from fefinger.mechanics.press.problem import FiniteStrainHistory, Press
from fefinger.results.records import Lateral
from fefinger.support.arrays import Array, Integers
from fefinger.support.tolerances import PRESS_EQUILIBRIUM
from fefinger.support.units import NEWTON_PER_MILLINEWTON


IN_PLANE = "Sliding: a smooth plate that moves in its plane leaves its surface where it was."
"""Note on every answer of a plate with a path."""

COULOMB = (
    "Friction: Coulomb's law at every vertex of the deformed skin, along the surface of the "
    "object; the slip of a load step counts from the step before. Stated errors are those of a "
    "press without friction."
)
"""Note on every answer with friction."""


def frictionless_plate(press: Press, time: Array) -> Lateral:
    """Return the path of a frictionless plate at times (n_t,) s, with zero tangential force."""
    shift = press.motion.shift(time)
    return Lateral(shift, np.zeros_like(shift))


def lateral(
    press: Press, history: FiniteStrainHistory, pressure: Array, scale: Array, column: Integers
) -> Lateral:
    """Collect path, force across the axis and friction, at all times of the answer.

    pressure (n_t, n_candidates) kPa; scale (n_t,): the force over what the steps give between them,
    1 under depth control; column (n_pad,) as of `whole_pad`.
    """
    steps = history.steps
    if press.indenter.friction:
        return _with_friction(press, history, pressure, scale, column)
    if press.obstacle.profile.plane:
        return frictionless_plate(press, steps.time)
    force = steps.bounded(history.sideways.force) * scale[:, None] * _newtons(press)
    return Lateral(press.motion.shift(steps.time), force)


def _newtons(press: Press) -> Array:
    """Return N on the finger per mN on the meshed part (2,), along and across the finger."""
    return NEWTON_PER_MILLINEWTON * np.array([2.0, 0.0] if press.body.half else [1.0, 1.0])


def _with_friction(
    press: Press, history: FiniteStrainHistory, pressure: Array, scale: Array, column: Integers
) -> Lateral:
    steps, at, seen = history.steps, history.sideways, history.contact.neighborhood
    areas, sides = history.contact.projected, press.body.sides
    # Traction is what is read between the steps, so that friction is its sum at all times, and it
    # is within its bound there too.
    traction = steps.bounded(at.traction) * scale[:, None, None]
    bound, size = press.indenter.friction * pressure, np.hypot(traction[:, 0], traction[:, 1])
    traction *= np.divide(bound, size, where=size > bound, out=np.ones_like(size))[:, None]
    force = steps.bounded(at.force - at.traction @ areas) * scale[:, None] + traction @ areas
    signs = np.ones((len(column), 2))
    signs[len(seen.vertices) :, 1] = -1.0
    on_skin = [
        signs * np.stack([on_neighborhood(each[:, k], seen)[:, column] for k in (0, 1)], axis=-1)
        for each in (traction, steps.bounded(at.slip))
    ]
    torque = np.zeros(len(scale)) if press.body.half else steps.bounded(at.torque) * scale
    stick = at.sticking @ areas
    return Lateral(
        shift=press.motion.shift(steps.time),
        force=force * _newtons(press),
        torque=torque * NEWTON_PER_MILLINEWTON,
        stick_area=sides * steps.bounded(stick),
        traction=on_skin[0] if press.pressure else None,
        slip=on_skin[1] if press.pressure else None,
        work=sides * steps.bounded(at.work) * 1e-3,  # mJ from µJ
        outcome=outcome(press, history, stick),
    )


def notes(press: Press) -> tuple[str, ...]:
    """Return the notes on a press with a path or with friction."""
    plate = (IN_PLANE,) if press.motion.slides and press.obstacle.profile.plane else ()
    return (*plate, COULOMB) if press.indenter.friction else plate


def outcome(press: Press, history: FiniteStrainHistory, stick: Array) -> str:
    """Return in words whether the contact stuck, slipped in part, or slid, and since when.

    stick (n,) mm²: the area that sticks at the steps.
    """
    time = history.steps.times
    area = (history.pressure > 0) @ history.contact.projected
    shift = press.motion.shift(time)
    moving = np.append(False, np.diff(shift, axis=0).any(axis=1))
    return told(time, area, stick, shift, moving, PRESS_EQUILIBRIUM)
