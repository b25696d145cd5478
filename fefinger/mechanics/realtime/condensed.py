"""A finger in real time, advanced by your own loop at the rates of a haptic controller.

    finger = ff.Condensed(ff.Finger.subject("a.h.", tissue="maeno1998"), ff.Flat(angle=30))
    step = finger.step(depth=0.3, dt=1e-3)
    step.force, step.strain

It is `mechanics/condensed` without a scene: the operator of the finger is built once and cached, an
indenter is placed in about a second, and no memory is allocated from one step to the next.
"""

from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np

from fefinger.fem.body import Reduced, Solid
from fefinger.fem.contact import lcp_compiled, step_compiled
from fefinger.fem.contact.complementarity import Complementarity
from fefinger.fem.contact.obstacle import Rigid
from fefinger.fem.contact.patch import Patch, patch
from fefinger.fem.elements.recovery import recovered_strain_at
from fefinger.geometry import mirror
from fefinger.mechanics.press import limits, operator, placement, problem
from fefinger.mechanics.press.placement import first_moments, whole_pad
from fefinger.mechanics.press.sites import central_sites
from fefinger.mechanics.realtime.loop import (
    Loop,
    Step,
    check_frictionless,
    quick_number,
    warn_of_softness,
)
from fefinger.results.records import Sites
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import InputError, choice
from fefinger.support.progress import Progress, Stages
from fefinger.support.tolerances import COMPLEMENTARITY
from fefinger.support.units import NEWTON_PER_MILLINEWTON


class Condensed(Loop):
    """A finger under an indenter, stepped in real time.

    Parameters
    ----------
    finger, indenter
        As in a scene; or an obstacle with an `axis` and a `gap(points)`, as
        `fem.contact.obstacle.Rigid`.
        Tissue that stiffens is taken as soft as it is at first touch, with a warning: use `Pressed`
        for it.
    deepest
        Depth in mm that the pad has to answer; the candidate vertices follow from it.
    sites
        End organs at which the strain is wanted; the central ones by default.
    precision
        "double", or "single" for strains to 1e-5 of the largest in half the time.
    stiffening
        t(u) of Pawluk (1997), Eq. 3.11, over a constant modulus, at a depth in mm: the contact
        pressure is then the integral of G(t - s) d(t q)(s), with q that of the linear body. Under
        depth control and while t > 0.
    tolerance
        Penetration, over the largest gap or depth, that counts as none.
    progress
        Called with the name of a stage and the fraction of it that is done.

    Raises
    ------
    InputError
        If the indenter misses the pad, a site lies outside the soft tissue, or the tissues do not
        relax as one.
    """

    def __init__(
        self,
        finger: Finger,
        indenter: Indenter | Rigid = STANDARD,
        *,
        deepest: float = 1.5,
        sites: Sites | None = None,
        precision: Literal["double", "single"] = "double",
        stiffening: Callable[[float], float] | None = None,
        tolerance: float = COMPLEMENTARITY,
        progress: Progress | None = None,
    ) -> None:
        super().__init__(finger, deepest)
        self.indenter = indenter
        choice("precision", precision, ("double", "single"))
        if stiffening is None:
            warn_of_softness(finger, indenter, self.deepest)
        if not isinstance(indenter, Rigid):
            check_frictionless(indenter)
        half = not isinstance(indenter, Rigid) and indenter.mirrored
        with Stages(progress).stage("factor") as report:
            solid = self.solid = operator.operator(finger, half=half, progress=report)
        touch: Rigid = (
            indenter if isinstance(indenter, Rigid) else placement.obstacle(indenter, solid)
        )
        origin = getattr(touch, "origin", np.zeros(3))
        self.sites = sites or central_sites(Ask(), finger.pulp, origin, touch.axis)
        where = solid.folded(self.sites.points)
        probe = self.probe = partial(recovered_strain_at, solid.space, where, solid.planes)
        surface, reach, within = solid.space, problem.REACH * self.deepest, solid.loadable
        reduced = reduced_to_candidates(
            solid,
            self.deepest,
            lambda rings: patch(surface, solid.pad, solid.normals, touch, reach, rings, within),
            lambda on_pad: operator.reduced(finger, solid, on_pad, where, probe),
            lambda on_pad: on_pad.border & ~on_pad.obstacle_border,
        )
        self.reduced, self.patch, self.flexibility = reduced, reduced.patch, reduced.flexibility
        self.shown = (f"{len(self.patch.vertices)} vertices may touch",)
        self._sides, self._stiffening = solid.sides, stiffening
        self._state = lcp_compiled.lcp_state(reduced.flexibility)
        gap, areas = self.patch.gap, self.patch.projected
        self._memory = step_compiled.pad_state(gap, areas, *finger.prony.branches, tolerance)
        self.output = step_output(solid, reduced, self.sites.points, precision)
        nothing = np.empty((len(areas), 0), dtype=self.output.rows.dtype)
        self._without = self.output._replace(rows=nothing, strain=nothing[0])
        self.now = Step.at_rest(self._state.x, self.output.strain.reshape(-1, 6))
        self._advance(0.0, 0.0, False)  # compiles or loads what a step needs: none of them waits
        self.reset()

    @property
    def counts(self) -> Integers:
        """Counts (5,) of the work of the solver, by the indices of `fem.contact.lcp_compiled`."""
        return self._state.counts

    @property
    def elastic(self) -> Array:
        """Pressure (n,) kPa of the linear body at the present displacement."""
        return self.output.elastic

    def energy(self) -> tuple[float, float]:
        """Return the stored energy in µJ and the dissipated power in µW, both without t(u)."""
        memory, flexibility = self._memory, self.flexibility
        stored, lost = memory.elastic @ flexibility @ memory.elastic / 2, 0.0
        for weight, rate, term in zip(memory.weights, memory.rates, memory.terms, strict=True):
            held = float(term @ flexibility @ term / weight)
            stored, lost = stored + held / 2, lost + rate * held
        return self._sides * float(stored), self._sides * lost

    def reset(self) -> None:
        """Lift the indenter off and clear the stress history."""
        step_compiled.reset(self._state, self._memory)
        step_compiled.read(self._state, self._memory, self.output, 1.0)
        self._read()

    def step(self, depth: float, dt: float) -> Step:
        """Move the indenter to `depth` mm in `dt` s and return force, pressure and strain.

        A step that is refused leaves the finger as it was.

        Raises
        ------
        InputError
            If contact reaches the rim of the candidates, which is beyond `deepest`, or that of the
            indenter or of the pad before it; or a number is not finite.
        ConvergenceError
            If no contact is found.
        """
        return self._advance(dt, depth, False)

    def step_contact(self, depth: float, dt: float) -> Step:
        """Move as `step` does, but compute contact and force alone; the strain is not updated.

        Errors as `step`.
        """
        return self._advance(dt, depth, False, self._without)

    def step_force(self, force: float, dt: float) -> Step:
        """Load the indenter with `force` N in `dt` s and return force, pressure and strain.

        Errors as `step`.
        """
        if self._stiffening is not None:
            message = "step_force: expected depth control, as t(u) is a function of the depth"
            raise InputError(message)
        force = quick_number("force", force, 0.0, unit="N")
        return self._advance(dt, force / (NEWTON_PER_MILLINEWTON * self._sides), True)

    def _advance(
        self, dt: float, target: float, by_force: bool, output: step_compiled.Output | None = None
    ) -> Step:
        target = quick_number("depth", target, unit="mm")
        dt = quick_number("dt", dt, 0.0, unit="s")
        stiffening = 1.0 if by_force else self._stiffness(target)
        state, memory = self._state, self._memory
        output = output or self.output
        outcome = step_compiled.real_time_step(
            state, memory, output, dt, target, by_force, stiffening
        )
        if outcome == lcp_compiled.TURNED:
            raise InputError(limits.rim_reached(len(self.patch.vertices)))
        step_compiled.check(outcome, self.deepest)
        return self._read()

    def _stiffness(self, depth: float) -> float:
        """Return t at a depth; it may be 0 or less only while the pad has no stress history."""
        if self._stiffening is None:
            return 1.0
        value = float(self._stiffening(depth))
        if value > 0.0:
            return value
        if self._memory.elastic.any():
            raise InputError(
                "stiffening: expected t above 0 while the tissue has stress history, "
                f"received {value:g} at a depth of {depth:g} mm; reset, or stay in contact"
            )
        return 1.0

    def _read(self) -> Step:
        return read_summary(self.now, self._memory, self.output, self._sides)


def reduced_to_candidates(
    solid: Solid,
    deepest: float,
    candidates: Callable[[int], Patch],
    reduce: Callable[[Patch], Reduced],
    rim: Callable[[Patch], Flags],
) -> Reduced:
    """Return a finger reduced to the candidates of a press of `deepest` mm.

    candidates: those with a number of additional rings: beside an edge the gap grows within a facet
    to any reach, and there is one ring more each time. reduce: the finger on candidates, whose
    first unit loads are the pressures on them. rim (n,): where contact asks for one more ring.

    InputError if that contact reaches skin beyond the palmar part of the pad.
    """
    for rings in range(problem.ATTEMPTS):
        on_pad = candidates(rings)
        count = len(on_pad.vertices)
        if count == 0:
            raise InputError(limits.NOTHING_UNDER)
        reduced = reduce(on_pad)
        solver = Complementarity(reduced.flexibility[:count, :count])
        pressure = solver.solve(on_pad.gap - deepest * on_pad.projected)
        reached = rim(on_pad) & (pressure > 0)
        if not reached.any():
            break
        if solid.cut_off(on_pad.vertices[reached]):
            raise InputError(
                "deepest: expected a depth at which contact stays on the palmar part of the pad, "
                f"received {deepest:g} mm; give a smaller `deepest`"
            )
    return reduced


def read_summary(
    now: Step, pad: step_compiled.PadState, output: step_compiled.Output, sides: int
) -> Step:
    """Set depth, force, area and center of pressure of a step, of a finger of so many `sides`."""
    force, now.contact_area, now.x, now.y = output.summary.tolist()
    now.depth, now.force = float(pad.depth[0]), force * sides * NEWTON_PER_MILLINEWTON
    return now


def unfolded(solid: Solid, points: Array, strain: Array) -> Array:
    """Return strain (6 n, ...) at points (n, 3), given that at their places in the half body."""
    if not solid.half:
        return strain
    signs = np.where(points[:, 1:2] < 0, mirror.VOIGT_SIGNS, 1.0)
    return signs.reshape(-1, 1) * strain


def step_output(
    solid: Solid, reduced: Reduced, points: Array, precision: str
) -> step_compiled.Output:
    """Allocate the quantities of every step: those on the pad, and the strain at points (n, 3)."""
    on_pad, count = reduced.patch, len(reduced.patch.vertices)
    pad, column = whole_pad(solid, on_pad)
    areas = np.bincount(column, pad.areas, minlength=count)
    first = first_moments(pad)
    moments = [np.bincount(column, first[:, c], minlength=count) for c in (0, 1)]
    edge = on_pad.border | np.isin(on_pad.vertices, placement.border(solid))
    kind = np.float32 if precision == "single" else np.float64
    return step_compiled.Output(
        areas=np.asarray(areas, dtype=np.float64),
        moments=np.array(moments),
        limits=np.select(
            [on_pad.obstacle_border, edge],
            [lcp_compiled.TURNED, lcp_compiled.BEYOND],
            lcp_compiled.DONE,
        ),
        elastic=np.zeros(count),
        rows=np.ascontiguousarray(unfolded(solid, points, reduced.strain_operator).T, dtype=kind),
        chosen=np.zeros(count, dtype=np.int64),
        factor=np.zeros(count, dtype=kind),
        strain=np.zeros(len(reduced.strain_operator), dtype=kind),
        summary=np.zeros(4),
    )
