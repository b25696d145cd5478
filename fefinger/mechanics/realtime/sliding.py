"""A finger under a sliding object, stepped in real time, with or without friction.

    finger = ff.Sliding(ff.Finger.subject("a.h.", tissue="maeno1998"), ff.Dots(3.0, friction=0.3))
    step = finger.step(depth=0.5, shift=(-1.2, 0.0), dt=1e-3)
    step.force, step.lateral_force, step.strain

It is `mechanics/condensed` along a path that is not known before: candidates are those of the plane
through the crests of the object, or of all places that an object without such a plane may take.
"""

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from fefinger.fem.body import Reduced
from fefinger.fem.contact import friction_state, friction_step, lcp_compiled, step_compiled
from fefinger.fem.contact.march import sticks
from fefinger.fem.contact.patch import Patch
from fefinger.fem.contact.travel import Travel
from fefinger.fem.elements.recovery import recovered_strain_at
from fefinger.geometry.profiles import frame
from fefinger.mechanics.press import operator, placement
from fefinger.mechanics.press import sliding as press_sliding
from fefinger.mechanics.press.sites import central_sites
from fefinger.mechanics.realtime.condensed import reduced_to_candidates, step_output
from fefinger.mechanics.realtime.loop import Loop, Step, quick_number, warn_of_softness
from fefinger.results.records import Sites
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice, number
from fefinger.support.units import NEWTON_PER_MILLINEWTON


LEFT = (
    "shift: expected a place at which the pad stays on the object, received ({:.4g}, {:.4g}) mm, "
    "where contact reaches its end; move it less, or take a larger object"
)

APART = 0.25
"""Distance in mm of the places within `reach` at which candidates are sought."""

FAR = (
    "shift: expected a place at most `reach` = {:g} mm from the first one, received "
    "({:.4g}, {:.4g}) mm; give a larger `reach`"
)


@dataclass(slots=True, repr=False)
class SlidingStep(Step):
    """Result of a step of `Sliding`: a `Step` with the quantities along the object's plane.

    shift (2,) mm of the object, lateral_force (2,) N on the finger, both distal and radial; torque
    N mm on the finger about the normal through the center of pressure, and stick_area mm² of the
    vertices that do not slip, both of friction; work mJ that friction has lost so far.
    """

    shift: Array
    lateral_force: Array
    torque: float = 0.0
    stick_area: float = 0.0
    work: float = 0.0


class Sliding(Loop):
    """A whole finger under an object that is pressed and moved sideways in real time.

    Parameters
    ----------
    finger, indenter
        As in a scene; the friction is that of the indenter. Tissue that stiffens is taken as soft
        as it is at first touch, with a warning.
    deepest
        Depth in mm that the pad has to answer.
    reach
        How far in mm an object without a plane of crests, as a ball, is moved from its place.
    sites
        End organs at which the strain is wanted; the central ones by default.
    precision
        "double", or "single" for strains to 1e-5 of the largest in half the time.

    Raises
    ------
    InputError
        If the indenter misses the pad, a site lies outside the soft tissue, or the tissues do not
        relax as one.
    """

    def __init__(
        self,
        finger: Finger,
        indenter: Indenter,
        *,
        deepest: float = 1.5,
        reach: float = 0.0,
        sites: Sites | None = None,
        precision: Literal["double", "single"] = "double",
    ) -> None:
        super().__init__(finger, deepest)
        self.indenter = indenter
        self.reach = number("reach", reach, at_least=0, unit="mm")
        choice("precision", precision, ("double", "single"))
        warn_of_softness(finger, indenter, self.deepest)
        solid = self.solid = operator.operator(finger, half=False)
        obstacle = self._obstacle = placement.obstacle(indenter, solid)
        self.sites = sites or central_sites(Ask(), finger.pulp, obstacle.origin, obstacle.axis)
        mu = indenter.friction
        reduced = self._reduced()
        on = self.patch = reduced.patch
        self.flexibility, count = reduced.flexibility, len(on.vertices)
        self.shown = (f"{count} vertices may touch",)
        self._travel = Travel.of(solid.space, solid.normals, on, obstacle)
        self._output = step_output(solid, reduced, self.sites.points, precision)
        self._limits = self._output.limits.copy()
        size = len(reduced.flexibility)
        self._memory = step_compiled.pad_state(
            np.zeros(count), on.projected, *finger.prony.branches, components=3 if mu else 1
        )
        self._friction_history = friction_step.friction_history(count, mu, indenter.kinetic)
        self._state = lcp_compiled.lcp_state(np.zeros((0, 0)) if mu else reduced.flexibility)
        self._friction_state = friction_state.friction_state(
            reduced.flexibility if mu else np.zeros((0, 0)), mu
        )
        self._bounds = self._friction_state.mu.copy()
        self._chosen = np.zeros(size, dtype=np.int64)
        self._factor = np.zeros(size, dtype=self._output.rows.dtype)
        across = frame(obstacle.axis)[:2]
        self._places = (solid.space.points[on.vertices] - obstacle.origin) @ across.T
        self._shift = np.zeros(2)
        self.now = SlidingStep(
            *(0.0, 0.0, 0.0, np.nan, np.nan),
            pressure=np.zeros(count),
            strain=self._output.strain.reshape(-1, 6),
            shift=np.zeros(2),
            lateral_force=np.zeros(2),
        )
        self._advance(0.0, (0.0, 0.0), 0.0, by_force=False)  # compiles or loads what steps need
        self.reset()

    def _reduced(self) -> Reduced:
        """Return the finger reduced to candidates that a press of `deepest` mm stays within."""
        solid, obstacle = self.solid, self._obstacle
        path = _disc(self.reach)
        probe = partial(recovered_strain_at, solid.space, self.sites.points, solid.planes)

        def candidates(rings: int) -> Patch:
            return press_sliding.candidates(solid, obstacle, path, self.deepest, rings)

        def reduce(on: Patch) -> Reduced:
            friction, axis = self.indenter.friction, obstacle.axis
            loaded = press_sliding.with_tractions(solid, on, axis) if friction else on
            made = operator.reduced(self.finger, solid, loaded, self.sites.points, probe)
            return replace(made, patch=on)

        return reduced_to_candidates(solid, self.deepest, candidates, reduce, lambda on: on.border)

    def reset(self) -> None:
        """Lift the object off at its first place, and clear the stress history."""
        self._shift = np.zeros(2)
        if self.indenter.friction:
            friction_step.reset(self._friction_state, self._memory, self._friction_history)
        else:
            step_compiled.reset(self._state, self._memory)
        self._output.strain[:] = 0.0
        self._read()

    def step(self, depth: float, shift: tuple[float, float], dt: float) -> SlidingStep:
        """Move the object to `depth` mm and (x, y) mm in `dt` s; return force, pressure and strain.

        The depth counts from first touch at the first place. A step that is refused leaves the
        finger as it was.

        Raises
        ------
        InputError
            If contact reaches the rim of the candidates, which is beyond `deepest`, or the end of
            the object; or a number is not finite.
        ConvergenceError
            If no contact is found.
        """
        depth = quick_number("depth", depth, unit="mm")
        return self._advance(depth, shift, dt, by_force=False)

    def step_force(self, force: float, shift: tuple[float, float], dt: float) -> SlidingStep:
        """Move the object to (x, y) mm in `dt` s under `force` N.

        Errors as `step`.
        """
        force = quick_number("force", force, 0.0, unit="N")
        return self._advance(force / NEWTON_PER_MILLINEWTON, shift, dt, by_force=True)

    def _advance(
        self, target: float, shift: tuple[float, float], dt: float, *, by_force: bool
    ) -> SlidingStep:
        place = _place(shift)
        dt = quick_number("dt", dt, 0.0, unit="s")
        if not self._obstacle.profile.level and math.hypot(*place) > self.reach * (1 + 1e-9):
            raise InputError(FAR.format(self.reach, *place))
        gap, rim = self._travel.gap(place)
        limits_here = np.where(rim, lcp_compiled.TURNED, self._limits)
        memory, output, mu = self._memory, self._output, self.indenter.friction
        if mu:
            history, state = self._friction_history, self._friction_state
            bounds = state.mu.copy()
            memory.gap[:], history.limits[:] = gap, limits_here
            x, y = (place - self._shift).tolist()
            outcome = friction_step.step(state, memory, history, dt, x, y, target, by_force)
            if outcome == lcp_compiled.DONE:
                self._bounds = bounds
                lcp_compiled.combine(
                    output.strain, output.rows, memory.elastic, self._chosen, self._factor
                )
        else:
            before = memory.gap.copy()
            memory.gap[:], output.limits[:] = gap, limits_here
            outcome = step_compiled.real_time_step(
                self._state, memory, output, dt, target, by_force, 1.0
            )
            if outcome != lcp_compiled.DONE:
                memory.gap[:] = before
        if outcome == lcp_compiled.TURNED:
            raise InputError(LEFT.format(*place))
        if outcome == lcp_compiled.BEYOND or not mu:
            step_compiled.check(outcome, self.deepest)
        friction_step.check(outcome, mu, "in a step")
        self._shift = place
        return self._read()

    def _read(self) -> SlidingStep:
        now, on, mu = self.now, self.patch, self.indenter.friction
        now.pressure[:] = self._friction_state.x[: len(now.pressure)] if mu else self._state.x
        weights, areas = now.pressure * on.projected, self._output.areas
        force = float(weights.sum())
        now.depth, now.force = float(self._memory.depth[0]), force * NEWTON_PER_MILLINEWTON
        now.contact_area = float(areas[now.pressure > 0].sum())
        moments = self._output.moments @ now.pressure
        now.x, now.y = (
            (moments / (areas @ now.pressure)).tolist() if force > 0 else (np.nan, np.nan)
        )
        now.shift[:] = self._shift
        now.lateral_force[:] = self._travel.push(self._shift, now.pressure) * NEWTON_PER_MILLINEWTON
        if mu:
            self._read_friction(weights, force)
        return now

    def _read_friction(self, weights: Array, force: float) -> None:
        now, on, count = self.now, self.patch, len(self.patch.vertices)
        traction = self._friction_state.x[count:].reshape(2, count)
        now.lateral_force += traction @ on.projected * NEWTON_PER_MILLINEWTON
        sticking = sticks(now.pressure, traction, self._bounds)
        now.stick_area = float(self._output.areas[sticking].sum())
        now.work = 1e-3 * self._friction_history.lost[0]
        if force > 0:
            x, y = (self._places - weights @ self._places / force).T
            turning = (x * traction[1] - y * traction[0]) @ on.projected
            now.torque = float(turning) * NEWTON_PER_MILLINEWTON
        else:
            now.torque = 0.0


def _place(shift: tuple[float, float]) -> Array:
    """Return the place (2,) mm of the object; InputError if it is not two finite numbers."""
    try:
        x, y = shift
        return np.array([number("shift", x), number("shift", y)])
    except (TypeError, ValueError) as error:
        message = f"shift: expected two finite numbers in mm, received {shift!r}"
        raise InputError(message) from error


def _disc(radius: float) -> Array:
    """Places (n, 2) mm that fill a disc, APART mm from each other, and its rim."""
    count = math.ceil(radius / APART)
    even = np.linspace(-radius, radius, 2 * count + 1)
    square = np.stack(np.meshgrid(even, even), axis=-1).reshape(-1, 2)
    turn = np.linspace(0.0, 2 * np.pi, 8 * count, endpoint=False)
    rim = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.vstack([square[np.hypot(*square.T) < radius], rim, np.zeros((1, 2))])
