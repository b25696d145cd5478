"""Harmonic answer of a finger about a preload, in closed form over its modes.

Contact is as of the relaxed finger at the preload, and stays as it is: the answer is the
derivative with respect to the amplitude. Two static terms stand for the modes that are left out.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy import sparse

from fefinger.contact.complementarity import Complementarity, pressure_at_force
from fefinger.contact.oscillators import ClosedContact
from fefinger.fem.condensation import Operator, displaced, reduce
from fefinger.fem.contact.obstacle import Rigid
from fefinger.fem.contact.patch import Patch, patch
from fefinger.fem.elements.probe import recovered_strain_at
from fefinger.geometry import finger_mesh
from fefinger.mechanics.press import mesh_limits, modal_body, problem
from fefinger.mechanics.press.modal_body import FingerModes, ModalBody
from fefinger.results.records import Complex, Harmonic, Sites, apart
from fefinger.scene.finger import Finger
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError, numbers
from fefinger.support.tensors import tensor_from_voigt
from fefinger.support.units import NEWTON_PER_MILLINEWTON


CONTACT = (
    "Harmonic answer: the contact is that of the relaxed finger at the preload and does not change "
    "with the oscillation, whose amplitude is infinitesimal."
)


class RimError(InputError):
    """Error for contact that reaches the rim of the candidates."""


@dataclass(frozen=True)
class Static:
    """Response of the body to unit loads at some of the candidates, in ascending order.

    rows (n_rows, k): strain and displacement of the skin, without the share of the modes; inertia
    (k, k): the second static term.
    """

    candidates: Integers
    rows: Array
    inertia: Array

    def at(self, candidates: Integers) -> Self:
        """Return the response to the loads at fewer candidates."""
        place = np.searchsorted(self.candidates, candidates)
        inertia = self.inertia[np.ix_(place, place)]
        return type(self)(candidates, self.rows[:, place], inertia)


@dataclass
class Vibrating:
    """A finger under an indenter, prepared for harmonic answers at any preload.

    body: on the candidates, without strain in its statics; its modes have rows for the strain at
    `sites` and then for the displacement of the skin at the vertices `line`; complete: the relaxed
    frequency in Hz below which no mode lacks; deepest: largest preload in mm.
    """

    finger: Finger
    solid: Operator
    body: ModalBody
    sites: Sites | None
    line: Integers
    complete: float
    deepest: float
    stiffening: float
    _static: Static | None = None

    @classmethod
    def of(
        cls,
        finger: Finger,
        solid: Operator,
        modes: FingerModes,
        on_pad: Patch,
        deepest: float,
        sites: Sites | None = None,
        stiffening: float = 1.0,
    ) -> Self:
        """Read modes and statics of a finger on the candidates of a press of `deepest` mm.

        `stiffening` multiplies the moduli.

        InputError if no vertex of the pad is under the obstacle.
        """
        if not len(on_pad.vertices):
            raise InputError(mesh_limits.NOTHING_UNDER)
        line = skin_line(solid)
        rows = _rows(solid, sites, line)
        still = modal_body.stiffened(reduce(solid, on_pad, rows[:0]), stiffening)
        body = modal_body.body_of_modes(finger, modes, still, lambda: rows, stiffening)
        last = modes.complete * float(np.sqrt(stiffening))
        return cls(finger, solid, body, sites, line, last, deepest, stiffening)

    @property
    def _unit(self) -> float:
        """Force in N of the whole finger for one of 1 mN on the meshed part."""
        return self.solid.sides * NEWTON_PER_MILLINEWTON

    def static(self, candidates: Integers) -> Static:
        """Return the static response to unit loads at some of the candidates (k,).

        What was computed is kept: first for the candidates that were wanted, which takes half the
        time, and for all of them where others are wanted later.
        """
        if self._static is None or not np.isin(candidates, self._static.candidates).all():
            everywhere = np.arange(self.body.participation.shape[1])
            self._static = self._respond(candidates if self._static is None else everywhere)
        return self._static.at(candidates)

    def _respond(self, candidates: Integers) -> Static:
        """Compute the static response to unit loads at some of the candidates."""
        body = self.body
        moved = displaced(self.solid, body.static.patch.loads[:, candidates]) / self.stiffening
        work = body.participation[:, candidates] / body.oscillators.omega_squared[:, None]
        rows = _rows(self.solid, self.sites, self.line) @ moved - body.strain_operator @ work
        return Static(
            candidates, rows, modal_body.residual_inertia(self.finger, self.solid, moved, work)
        )

    def harmonic(
        self, frequency: Array, *, depth: float | None = None, force: float | None = None
    ) -> Harmonic:
        """Compute the harmonic answer at frequencies (n_f,) in Hz, at a depth in mm or force in N.

        InputError for frequencies that are not above 0 or too high for the modes, or no contact.
        """
        frequency = np.array(numbers("frequency", frequency.tolist()))
        self._check(frequency)
        depth, pressure = self.preload(depth, force)
        active = np.flatnonzero(pressure > 0)
        body, on_pad = self.body, self.body.static.patch
        static = self.static(active)
        held, first = self._held(static)
        stiffness, rough = held.stiffness(frequency), first.stiffness(frequency)
        ratio = (2 * np.pi * frequency) ** 2 / np.abs(
            held.modulus(frequency) * body.oscillators.omega_squared[-1]
        )
        strain, skin = self._read(held, static, frequency)
        unit = self._unit
        listed = 20  # modes of the held finger that are stored
        return Harmonic(
            frequency=frequency,
            stiffness_parts=apart(unit * stiffness),
            strain_parts=apart(strain),
            skin_points=self.solid.space.points[self.line],
            skin_parts=apart(skin),
            error=np.abs(stiffness - rough) / np.abs(stiffness) * ratio,
            modes=held.frequencies[:listed],
            preload_depth=depth,
            preload_force=float(unit * pressure @ on_pad.projected),
            contact_area=float(self.solid.sides * on_pad.areas[active].sum()),
            notes=(CONTACT,),
        )

    def preload(self, depth: float | None, force: float | None) -> tuple[float, Array]:
        """Depth in mm and pressure (n_pad,) kPa of the relaxed finger at a preload."""
        on_pad = self.body.static.patch
        gap, areas = on_pad.gap, on_pad.projected
        solver = Complementarity(self.body.static.flexibility)
        if depth is None:
            wanted = float(force or 0.0) / self._unit
            start = 0.3 * self.deepest
            depth, pressure, _ = pressure_at_force(solver, 1.0, gap, areas, wanted, start, wanted)
        else:
            pressure = solver.solve(gap - depth * areas)
        if not (pressure > 0).any():
            raise InputError(mesh_limits.unresolved(depth))
        if (pressure[on_pad.obstacle_border] > 0).any():
            raise InputError(mesh_limits.rim_reached(len(pressure)))
        if (pressure[on_pad.border] > 0).any():
            raise RimError(
                f"preload: expected contact as of a depth of at most {self.deepest:g} mm, received "
                "one that reaches the rim of the candidates; press less, or give a larger "
                "`deepest`"
            )
        return float(depth), pressure

    def _held(self, static: Static) -> tuple[ClosedContact, ClosedContact]:
        """Return the body held at its contact, with two static terms and with the first alone."""
        body, o, active = self.body, self.body.oscillators, static.candidates
        participation = body.participation[:, active]
        residual = body.residual_flexibility[np.ix_(active, active)]
        projected = body.static.patch.projected[active]
        parts = o.omega_squared, participation, residual, projected, o.weights, o.rates
        return ClosedContact.of(*parts, static.inertia), ClosedContact.of(*parts)

    def _read(
        self, held: ClosedContact, static: Static, frequency: Array
    ) -> tuple[Complex, Complex]:
        """Strain (n_f, n_sites, 3, 3) and displacement (n_f, n_skin, 3) per mm of oscillation."""
        pressure, amplitude = held.amplitudes(frequency)
        sites = self.sites
        rows = pressure @ static.rows.T + amplitude @ self.body.strain_operator.T
        n_sites = 0 if sites is None else len(sites.points)
        flat = rows[:, : 6 * n_sites].reshape(len(frequency), n_sites, 6)
        strain = tensor_from_voigt(flat.real) + 1j * tensor_from_voigt(flat.imag)
        if sites is not None:
            strain = self.solid.unfolded(strain, sites.points)
        return strain, rows[:, 6 * n_sites :].reshape(len(frequency), -1, 3)

    def _check(self, frequency: Array) -> None:
        if not len(frequency) or not (frequency > 0).all():
            message = f"frequency: expected values above 0 Hz, received {frequency.tolist()}"
            raise InputError(message)
        o = self.body.oscillators
        # Highest frequency over that of the last mode, with the modulus at that frequency.
        highest = 0.75
        reached = highest * self.complete * np.sqrt(np.abs(o.modulus(frequency)))
        beyond = frequency > reached
        if beyond.any():
            raise InputError(
                f"frequency: expected at most {reached[beyond].min():.4g} Hz, {highest:g} of "
                f"the frequency of the last of {len(o.omega_squared)} modes, received "
                f"{frequency[beyond].max():g} Hz; lower it, or take stiffer tissue"
            )


def skin_line(solid: Operator) -> Integers:
    """Return palmar vertices of the pad in the medial plane, from proximal to distal."""
    vertices = np.unique(solid.pad)
    vertices = vertices[solid.normals[vertices, 2] < 0]
    points = solid.space.points[vertices]
    near = np.abs(points[:, 1]) < finger_mesh.ROUNDING * np.ptp(points)
    chosen = vertices[near]
    return np.asarray(chosen[np.argsort(solid.space.points[chosen, 0])])


def _rows(solid: Operator, sites: Sites | None, line: Integers) -> sparse.csr_matrix:
    where = solid.folded(sites.points if sites is not None else np.empty((0, 3)))
    strain = recovered_strain_at(solid.space, where, solid.planes)
    columns = (3 * line[:, None] + np.arange(3)).ravel()
    skin = sparse.eye(solid.space.n_unknowns, format="csr")[columns]
    return sparse.vstack([strain, skin]).tocsr()


def about(
    make: Callable[[Patch, float], Vibrating],
    solid: Operator,
    obstacle: Rigid,
    deepest: float,
    frequency: Array,
    *,
    depth: float | None = None,
    force: float | None = None,
) -> Harmonic:
    """Compute a harmonic answer about a preload, with more candidates where contact needs them.

    make: prepares a finger on the candidates of a depth in mm; deepest: for the first attempt.
    Beside an edge the gap grows within a facet to any reach: each attempt has one more ring.

    Errors as `Vibrating.harmonic`.
    """
    surface = solid.space, solid.pad, solid.normals

    def attempt(rings: int) -> Harmonic:
        reached = deepest * problem.GROW**rings
        on_pad = patch(*surface, obstacle, problem.REACH * reached, rings, solid.loadable)
        return make(on_pad, reached).harmonic(frequency, depth=depth, force=force)

    for rings in range(problem.ATTEMPTS - 1):
        with suppress(RimError):
            return attempt(rings)
    return attempt(problem.ATTEMPTS - 1)
