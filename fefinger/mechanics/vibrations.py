"""Vibration modes of a finger, and its harmonic answer about a preload.

    finger = ff.Vibrations(ff.Finger.subject("a.h.", tissue="maeno1998"), ff.Flat(angle=30))
    finger.frequencies
    finger.harmonic([10, 100, 300], force=0.5).stiffness

It is `mechanics/modal` at small strain without a scene; operator and modes are built once and kept.
"""

from collections.abc import Iterable
from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fefinger.contact.soft import RIGID
from fefinger.fem.condensation import Operator
from fefinger.fem.elements.probe import strain_at_vertices
from fefinger.mechanics.loop_setup import MODAL, LoopOptions, prepare
from fefinger.mechanics.press.frequency_response import Vibrating
from fefinger.mechanics.press.prepared import Prepared
from fefinger.mechanics.press.response import no_fields
from fefinger.mesh.store import load_or_build
from fefinger.results import netcdf
from fefinger.results.records import Fields, Harmonic, Sites
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number, numbers
from fefinger.support.progress import Progress, Stages


class Vibrations:
    """A finger with inertia under an indenter, in frequency.

    Parameters
    ----------
    finger, indenter
        As in a scene. Tissue that stiffens is taken as soft as it is at first touch, with a
        warning; a scene with a vibration has the stiffness at its preload.
    deepest
        Largest depth in mm of a preload.
    sites
        End organs at which the strain is wanted; the central ones by default.
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
        progress: Progress | None = None,
    ) -> None:
        options = LoopOptions(finger, indenter, MODAL, deepest, sites=sites)
        self._of(prepare(options, Stages(progress)), options.deepest)

    @classmethod
    def of(cls, prepared: Prepared, deepest: float) -> "Vibrations":
        """Return the vibrations of a finger that a loop was prepared with."""
        vibrations = cls.__new__(cls)
        vibrations._of(prepared, deepest)
        return vibrations

    def _of(self, prepared: Prepared, deepest: float) -> None:
        if prepared.modes is None:
            raise InputError(
                "vibrations: expected a finger with modes, received one without; make the loop "
                "with mechanics='modal'"
            )
        if prepared.on_pad.object is not RIGID:
            raise InputError(
                "indenter.modulus: expected a rigid object, as the closed form has one complex "
                "modulus for all that gives way, received a soft one; step a loop through time"
            )
        self.prepared, self.modes, self.deepest = prepared, prepared.modes, deepest
        self.finger, self.solid, self.sites = prepared.finger, prepared.solid, prepared.sites

    @property
    def frequencies(self) -> Array:
        """Frequencies (n,) in Hz of the free finger with relaxed tissue."""
        return self.modes.frequencies

    def harmonic(
        self, frequency: ArrayLike, *, depth: float | None = None, force: float | None = None
    ) -> Harmonic:
        """Return the harmonic answer at frequencies (n_f,) in Hz about a preload.

        The preload is a depth in mm or a force in N of relaxed tissue.

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

        `which` counts from 0, the lowest; the cycle is as of relaxed tissue without damping.

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
        netcdf.write_vtkhdf(self.shape(which), path)

    @cached_property
    def vibrating(self) -> Vibrating:
        """The finger prepared for harmonic answers, once."""
        on_pad, solid = self.prepared.on_pad.patch, self.solid
        assert isinstance(solid, Operator)  # as there are modes
        return Vibrating.of(self.finger, solid, self.modes, on_pad, self.deepest, self.sites)
