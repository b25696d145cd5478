"""A finger with inertia to drive from a loop, and its harmonic answer about a preload.

    finger = ff.Modal(ff.Finger.subject("a.h.", tissue="maeno1998"), ff.Flat(angle=30))
    step = finger.step(depth=0.3, dt=1e-4)
    step.force, step.strain
    finger.harmonic([10, 100, 300], force=0.5).stiffness

It is `mechanics/modal` at small strain without a scene: operator and modes of the finger are built
once and kept.
"""

from collections.abc import Iterable
from functools import cached_property
from os import PathLike
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from fefinger.fem.contact import lcp_compiled, step_compiled
from fefinger.fem.contact.modal_step import add_strain, release
from fefinger.fem.elements.probe import strain_at_vertices
from fefinger.mechanics.press import limits
from fefinger.mechanics.press.fields import no_fields
from fefinger.mechanics.press.harmonic import Vibrating
from fefinger.mechanics.press.modal_body import body_of_modes, finger_modes
from fefinger.mechanics.press.modal_press import contact_of
from fefinger.mechanics.press.time_steps import RESOLVED
from fefinger.mechanics.realtime.condensed import Condensed, read_summary, unfolded
from fefinger.mechanics.realtime.loop import Loop, Step
from fefinger.mesh.store import load_or_build
from fefinger.results import vtkhdf
from fefinger.results.harmonic import Harmonic
from fefinger.results.records import Fields, Sites
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number, numbers
from fefinger.support.progress import Progress, Stages
from fefinger.support.units import NEWTON_PER_MILLINEWTON


DT = 1e-4
"""Step in s that the modes are chosen for by default."""


class Modal(Loop):
    """A finger with inertia under an indenter, stepped in real time, and in frequency.

    Parameters
    ----------
    finger, indenter
        As in a scene. Tissue that stiffens is taken as soft as it is at first touch, with a
        warning; a scene with a vibration has the stiffness at its preload.
    deepest
        Depth in mm that the pad has to answer.
    sites
        End organs at which the strain is wanted; the central ones by default.
    dt
        Longest step in s in which the modes have inertia; those too fast for it have none.
    precision
        "double", or "single" for strains to 1e-5 of the largest in half the time.
    progress
        Called with the name of a stage and the fraction of it that is done.

    Raises
    ------
    InputError
        If the indenter misses the pad, a site lies outside the soft tissue, or the tissues do not
        relax as one.
    ConvergenceError
        If the modes of the finger do not converge.
    """

    def __init__(
        self,
        finger: Finger,
        indenter: Indenter = STANDARD,
        *,
        deepest: float = 1.5,
        sites: Sites | None = None,
        dt: float = DT,
        precision: Literal["double", "single"] = "double",
        progress: Progress | None = None,
    ) -> None:
        self.dt = number("dt", dt, above=0, unit="s")
        still = self._still = Condensed(
            finger, indenter, deepest=deepest, sites=sites, precision=precision, progress=progress
        )
        super().__init__(finger, deepest)
        self.indenter, self.sites, self.solid = indenter, still.sites, still.solid
        with Stages(progress).stage("modes") as report:
            self.modes = finger_modes(finger, self.solid, report)
        low, high = self.frequencies[[0, -1]]
        self.shown = (f"{len(self.frequencies)} modes, {low:.3g} to {high:.3g} Hz relaxed",)
        body = body_of_modes(finger, self.modes, still.reduced, still.probe)
        self.body = body.below(RESOLVED / self.dt)
        self._contact = contact_of(self.body, self.dt * (1 + 1e-9), still.output.limits)
        rows = unfolded(self.solid, self.sites.points, self.body.complete.strain_operator).T
        kind, count = still.output.rows.dtype, len(still.patch.vertices)
        self._rows = np.ascontiguousarray(rows[count:], dtype=kind)
        self._output = still.output._replace(
            rows=np.ascontiguousarray(rows[:count], dtype=kind),
            elastic=np.zeros(count),
            strain=np.zeros(len(rows.T), dtype=kind),
        )
        self._sides = self.solid.sides
        strain = self._output.strain.reshape(-1, 6)
        self.now = Step.at_rest(self._contact.lcp.x, strain)
        self._advance(self.dt, 0.0, by_force=False)  # compiles or loads what a step needs
        self.reset()

    @property
    def frequencies(self) -> Array:
        """Frequencies (n,) in Hz of the free finger with relaxed tissue."""
        return self.modes.frequencies

    def reset(self) -> None:
        """Lift the indenter off, and bring the finger to rest."""
        release(self._contact.lcp, self._contact.pad, self._contact.modes)
        self._read()

    def step(self, depth: float, dt: float) -> Step:
        """Move the indenter to `depth` mm in `dt` s and return force, pressure and strain.

        A step that is refused leaves the finger as it was.

        Raises
        ------
        InputError
            If the step is longer than the finger was made for, contact reaches the rim of the
            candidates or of the indenter, or a number is not finite.
        ConvergenceError
            If no contact is found.
        """
        dt = self._checked_step(dt)
        return self._advance(dt, number("depth", depth, unit="mm"), by_force=False)

    def step_force(self, force: float, dt: float) -> Step:
        """Load the indenter with `force` N in `dt` s and return force, pressure and strain.

        Errors as `step`.
        """
        dt = self._checked_step(dt)
        wanted = number("force", force, at_least=0, unit="N")
        return self._advance(dt, wanted / (NEWTON_PER_MILLINEWTON * self._sides), by_force=True)

    def rest(self, depth: float, seconds: float) -> Step:
        """Hold a depth in mm for some s, in one step without inertia.

        Errors as `step`.
        """
        held = number("seconds", seconds, at_least=0, unit="s")
        return self._advance(held, number("depth", depth, unit="mm"), by_force=False)

    def harmonic(
        self, frequency: ArrayLike, *, depth: float | None = None, force: float | None = None
    ) -> Harmonic:
        """Return the harmonic answer at frequencies (n_f,) in Hz about a preload.

        The preload is a depth in mm or a force in N of relaxed tissue; the present state of the
        loop does not matter.

        Raises
        ------
        InputError
            If not one preload is given, a frequency is beyond the modes, or there is no contact.
        """
        if (depth is None) == (force is None):
            message = "preload: expected a depth in mm or a force in N, received both or none"
            raise InputError(message)
        if depth is not None:
            number("depth", depth, above=0, at_most=self.deepest, unit="mm")
        else:
            number("force", force, above=0, unit="N")
        given: Any = frequency.tolist() if isinstance(frequency, np.ndarray) else frequency
        several = isinstance(given, Iterable) and not isinstance(given, str | bytes)
        wanted = np.array(numbers("frequency", given if several else [given]))
        return self.vibrating.harmonic(wanted, depth=depth, force=force)

    def shape(self, which: int, *, frames: int = 24) -> Fields:
        """Return one cycle of a free mode on the mesh, with a largest displacement of 1 mm.

        `which` counts from 0, the lowest; the cycle is that of relaxed tissue without damping.

        Raises
        ------
        InputError
            If there is no such mode, or a cycle has no frames.
        """
        last = len(self.modes.omega_squared) - 1
        if which not in range(last + 1):
            raise InputError(f"mode: expected a number from 0 to {last}, received {which!r}")
        frames = int(number("frames", frames, at_least=1))
        solid, mesh = self.solid, load_or_build(self.finger, half=self.solid.half)
        size, moved = solid.space.n_displacements, np.zeros(solid.space.n_unknowns)
        moved[:size] = self.modes.combined(size, np.array([which]), np.ones((1, 1)))[:, 0]
        moved /= np.linalg.norm(moved[:size].reshape(-1, 3), axis=1).max()
        swing = np.cos(2 * np.pi * np.arange(frames) / frames)
        strain = (strain_at_vertices(solid.space) @ moved).reshape(-1, 6)
        shown = moved[: 3 * len(solid.original)].reshape(-1, 3)
        fields = no_fields(mesh, np.arange(frames) / frames / self.frequencies[which])
        fields.displacement[:, solid.original] = swing[:, None, None] * shown
        fields.strain[:, solid.original] = swing[:, None, None] * strain
        return fields

    def save_shape(self, path: str | PathLike[str], which: int) -> None:
        """Write one cycle of a free mode as a VTK time series, for ParaView and PyVista.

        Errors as `shape`.
        """
        vtkhdf.write(self.shape(which), path)

    @cached_property
    def vibrating(self) -> Vibrating:
        """The finger prepared for harmonic answers, once."""
        still = self._still
        return Vibrating.of(
            self.finger, self.solid, self.modes, still.patch, self.deepest, self.sites
        )

    def _checked_step(self, dt: float) -> float:
        dt = number("dt", dt, unit="s")
        if not 0 < dt <= self._contact.longest:
            raise InputError(
                f"dt: expected a step above 0 and of at most {self.dt:g} s, for which the finger "
                f"was made, received {dt!r}; make it with a longer `dt`, or call `rest`"
            )
        return dt

    def _advance(self, dt: float, target: float, *, by_force: bool) -> Step:
        outcome = self._contact.step(dt, target, by_force=by_force)
        if outcome == lcp_compiled.TURNED:
            raise InputError(limits.rim_reached(len(self._contact.pad.gap)))
        step_compiled.check(outcome, self.deepest)
        return self._read()

    def _read(self) -> Step:
        contact, output = self._contact, self._output
        step_compiled.read(contact.lcp, contact.pad, output, 1.0)
        add_strain(output, self._rows, contact.modes.amplitude.astype(self._rows.dtype))
        return read_summary(self.now, contact.pad, output, self._sides)
