"""A finger as modes: computed or read from the cache, and on a patch with static correction.

Modes depend on the ratios of moduli and densities only: they are computed for a skin of 1 kPa and
1 kg/mm³, and scaled.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy import sparse

from fefinger.contact.oscillators import Oscillators
from fefinger.fem.body import Reduced
from fefinger.fem.condensation import Operator
from fefinger.fem.elements.assembly import mass, numbering
from fefinger.fem.modes import Modes, modes_of
from fefinger.mechanics.press.operator_cache import MODES, description, modes_folder
from fefinger.scene.finger import Finger
from fefinger.support import cache
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError
from fefinger.support.processes import one_thread


PER_CUBIC_METER = 1e-9
"""kg/m³ in kg/mm³."""

NAMES = ("squares", "shapes", "residual")
"""Names of the files of stored modes."""


@dataclass(frozen=True)
class FingerModes:
    """Modes of a finger or of half of it, lowest first, with unit modal mass of what is meshed.

    omega_squared (n,) of the relaxed angular frequencies in 1/s²; parts: for each parity the
    numbers of its modes here and their shapes (n_displacements of the half, n) in mm/sqrt(kg);
    unfold: from a field of the half to one of the body; complete: the frequency in Hz below which
    no mode lacks.
    """

    omega_squared: Array
    parts: tuple[tuple[Integers, Array, sparse.csr_matrix], ...]
    complete: float

    @property
    def frequencies(self) -> Array:
        """Relaxed frequencies (n,) in Hz."""
        return np.asarray(np.sqrt(self.omega_squared) / (2 * np.pi))

    def read(self, rows: sparse.csr_matrix) -> Array:
        """`rows` (n_rows, n_unknowns) @ the displacement of each mode: (n_rows, n)."""
        values = np.empty((rows.shape[0], len(self.omega_squared)))
        for numbers, shapes, unfold in self.parts:
            there = (rows @ unfold).tocsr()[:, : shapes.shape[0]]
            values[:, numbers] = there @ shapes
        return values

    def combined(self, size: int, numbers: Integers, amplitudes: Array) -> Array:
        """Displacement (size, n_frames) of the sum of modes `numbers` (k,), amplitudes (n_f, k)."""
        total = np.zeros((size, len(amplitudes)))
        for members, shapes, unfold in self.parts:
            chosen, here, there = np.intersect1d(members, numbers, return_indices=True)
            half = np.zeros((unfold.shape[1], len(amplitudes)))
            if len(chosen):
                half[: len(shapes)] = shapes[:, here] @ amplitudes[:, there].T
            total += (unfold @ half)[:size]
        return total


def finger_modes(
    finger: Finger,
    solid: Operator,
    progress: Callable[[float], None] = lambda fraction: None,
) -> FingerModes:
    """Return the modes of a finger on its operator, from the cache or computed and put there.

    ConvergenceError if the modes do not converge.
    """
    sets = []
    for number in range(len(solid.parts)):

        def report(fraction: float, done: int = number) -> None:
            progress((done + fraction) / len(solid.parts))

        sets.append(_part(finger, solid, number, report))
    light = finger.skin.density * PER_CUBIC_METER
    scale = finger.skin.modulus / light
    omega_squared = np.concatenate([each.omega_squared for each in sets]) * scale
    order = np.argsort(omega_squared, kind="stable")
    place = numbering(order, len(order))
    split = np.split(place, np.cumsum([len(each.omega_squared) for each in sets])[:-1])
    norm = 1.0 / np.sqrt(light * len(sets))
    parts = tuple(
        (numbers, each.shapes * np.float32(norm), part.unfold)
        for numbers, each, part in zip(split, sets, solid.parts, strict=True)
    )
    highest = min(float(each.omega_squared[-1]) for each in sets) * scale
    return FingerModes(omega_squared[order], parts, float(np.sqrt(highest) / (2 * np.pi)))


def _part(finger: Finger, solid: Operator, number: int, progress: Callable[[float], None]) -> Modes:
    """Modes of one parity, for a skin of 1 kPa and 1 kg/mm³."""
    part, identity = solid.parts[number], solid.identities[number]
    place = None if identity is None else modes_folder(finger, identity)
    stored = None if place is None else cache.load(place, _read)
    if stored is not None:
        return stored
    heavy = mass(solid.space, {1: 1.0, 2: finger.subcutaneous.density / finger.skin.density})
    unfold = part.unfold[: heavy.shape[0]]
    unfold = unfold[:, np.flatnonzero(unfold.getnnz(axis=0))]
    heavy = (unfold.T @ heavy @ unfold).tocsr() / len(solid.parts)
    computed = modes_of(part.compliance, heavy, min(MODES, heavy.shape[0] // 8), progress)
    if not computed.omega_squared[0] > 0:
        raise ConvergenceError(
            "modes: expected frequencies above 0, received a square of "
            f"{computed.omega_squared[0]:g}; check the held facets of the finger"
        )
    # Single precision for shapes: the flexibility that modes leave over makes up for its rounding.
    kept = Modes(computed.omega_squared, computed.shapes.astype(np.float32), computed.residual)
    if place is not None and identity is not None:
        what = description(finger, identity, "modal")
        with suppress(OSError), cache.appearing(place, what) as new:
            values = kept.omega_squared, kept.shapes, kept.residual
            for name, value in zip(NAMES, values, strict=True):
                np.save(new / f"{name}.npy", np.asarray(value))
        cache.limit("modes")
    return kept


def _read(place: Path) -> Modes:
    """Return the modes in a folder, their shapes mapped into memory."""
    omega_squared, shapes, residual = (
        np.load(place / f"{name}.npy", mmap_mode="r") for name in NAMES
    )
    return Modes(np.array(omega_squared), shapes, float(residual))


@dataclass(frozen=True)
class ModalBody:
    """Response of a body to loads on a patch: its modes, and the static correction.

    static: the response without inertia; oscillators: the modes; participation (n, n_pad): work
    of each unit load on each mode; residual_flexibility (n_pad, n_pad): of `static` less the part
    of the modes (static correction); strain_operator (n_rows, n) and normal_displacement (n_near,
    n) of each mode, as in `static`.
    """

    static: Reduced
    oscillators: Oscillators
    participation: Array
    residual_flexibility: Array
    strain_operator: Array
    normal_displacement: Array

    @property
    def complete(self) -> Reduced:
        """Response to pressures on the residual flexibility, then to amplitudes of the modes."""
        part = self.participation.T / self.oscillators.omega_squared
        own = self.strain_operator
        strain = np.hstack([self.static.strain_operator - own @ part.T, own])
        normal = self.static.normal_displacement - self.normal_displacement @ part.T
        moved = np.hstack([normal, self.normal_displacement])
        return replace(self.static, strain_operator=strain, normal_displacement=moved)

    def below(self, glassy: float) -> "ModalBody":
        """Return the body with only the modes of glassy frequencies below `glassy` in Hz.

        Those are with the modulus of a sudden strain. The others deform as in statics.
        """
        chosen = np.flatnonzero(self.oscillators.glassy < 2 * np.pi * glassy)
        return self.only(chosen)

    def only(self, chosen: Integers) -> "ModalBody":
        """Return the same body with some of its modes; the others deform as in statics."""
        return modal(
            self.static,
            self.oscillators.only(chosen),
            self.participation[chosen],
            self.strain_operator[:, chosen],
            self.normal_displacement[:, chosen],
        )

    def amplitudes(self, elastic: Array) -> Array:
        """Amplitudes (n_t, n) of the modes beside the static field of the elastic pressures.

        elastic (n_t, n_pad + n): as for `complete`. The displacement is the static one under its
        pressures, and of the modes of these amplitudes.
        """
        count = self.participation.shape[1]
        pressure, amplitude = elastic[:, :count], elastic[:, count:]
        return np.asarray(
            amplitude - pressure @ self.participation.T / self.oscillators.omega_squared
        )


@one_thread
def modal(
    static: Reduced,
    oscillators: Oscillators,
    participation: Array,
    strain: Array,
    normal: Array,
) -> ModalBody:
    """Make a body from its modes, with the residual flexibility that they leave."""
    residual = static.flexibility - (participation.T / oscillators.omega_squared) @ participation
    return ModalBody(
        static, oscillators, participation, (residual + residual.T) / 2, strain, normal
    )


def body_of_modes(
    finger: Finger,
    modes: FingerModes,
    static: Reduced,
    probe: Callable[[], sparse.csr_matrix],
    stiffening: float = 1.0,
) -> ModalBody:
    """Read the modes of a finger on a patch, where `static` is its response without inertia.

    probe: the strain at the points of `static`; stiffening: factor on the moduli, which `static`
    includes.
    """
    oscillators = Oscillators.of(modes.omega_squared * stiffening, *finger.prony.branches)
    participation = modes.read(static.patch.loads.T.tocsr()).T
    normal = modes.read(static.patch.places.T.tocsr())
    return modal(
        static, oscillators, np.ascontiguousarray(participation), modes.read(probe()), normal
    )


def stiffened(static: Reduced, factor: float) -> Reduced:
    """Return the response of a body with moduli that are `factor` times as large."""
    return replace(
        static,
        flexibility=static.flexibility / factor,
        strain_operator=static.strain_operator / factor,
        normal_displacement=static.normal_displacement / factor,
    )


@one_thread
def residual_inertia(finger: Finger, solid: Operator, moved: Array, modes: Array) -> Array:
    """Residual inertia (k, k), the second static term: mass of the residual displacement.

    The integral of density times the product of the residual displacements under two unit loads:
    K^-1 M K^-1 less phi phi' / w^4, in kg mm²/mN². moved (n_unknowns, k): unknowns of the relaxed
    body under each load; modes (n, k): amplitudes of the modes in them.
    """
    densities = {1: finger.skin.density, 2: finger.subcutaneous.density}
    heavy = mass(solid.space, {k: value * PER_CUBIC_METER for k, value in densities.items()})
    # M is a matrix and its transpose, which takes half the time.
    upper = (sparse.triu(heavy, 1) + sparse.diags(heavy.diagonal() / 2)).tocsr()
    moved = moved[: solid.space.n_displacements]
    half = moved.T @ (upper @ moved)
    return np.asarray(half + half.T - modes.T @ modes)
