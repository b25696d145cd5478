"""A finger on a patch as modes with residual flexibility (static correction)."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from fefinger.fem.body import Reduced
from fefinger.fem.condensation import Operator
from fefinger.fem.contact.oscillators import Oscillators
from fefinger.fem.elements.mass import mass
from fefinger.mechanics.press.mode_store import PER_CUBIC_METER, FingerModes
from fefinger.scene.finger import Finger
from fefinger.support.arrays import Array, Integers
from fefinger.support.threads import one_thread


@dataclass(frozen=True)
class ModalBody:
    """Response of a body to loads on a patch: that of its modes, and the static correction.

    static: the response without inertia; oscillators: the modes; participation (n, n_pad): work
    of each unit load on each mode; residual_flexibility (n_pad, n_pad): that of `static` less that
    of the modes (static correction); strain_operator (n_rows, n) and normal_displacement (n_near,
    n) of each mode, as those of `static`.
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

        elastic (n_t, n_pad + n): as for `complete`. The displacement is that of statics under its
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
