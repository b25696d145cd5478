"""Harmonic answer of a body of modes whose contact stays closed: in closed form at any frequency.

The contact is that of a preload. Small oscillations do not change it, so that all elastic forces
share one factor G*, and the body held by its indenter has modes of its own: one small eigenproblem
serves every frequency. With the second static term (`inertia`), what the modes leave over has mass
too, and the error of leaving modes out is of second order in (frequency / last mode)².
"""

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from fefinger.fem.contact.oscillators import Complex, complex_modulus
from fefinger.support.arrays import Array


@dataclass(frozen=True)
class ClosedContact:
    """A body held by an indenter in contact: amplitudes per unit of its oscillation.

    squares (n,) of the relaxed angular frequencies of the held body; stiff, heavy (n,): elastic
    and inertial coupling of each of its modes to the indenter; spring mN/mm and mass kg of the
    indenter's motion alone; carried (n_pad, n) and carried_rest (n_pad,): elastic pressure of the
    rest per mode and per unit of motion; turned (n_modes, n): amplitudes of the free modes.
    """

    squares: Array
    stiff: Array
    heavy: Array
    spring: float
    mass: float
    carried: Array
    carried_rest: Array
    turned: Array
    weights: Array
    rates: Array

    @classmethod
    def of(
        cls,
        squares: Array,
        shares: Array,
        rest: Array,
        direction: Array,
        weights: Array,
        rates: Array,
        inertia: Array | None = None,
    ) -> "ClosedContact":
        """Compute the modes of a body that the indenter holds from those of the free body.

        squares (n,) and shares (n, k): of the free modes, on the k loads in contact; rest (k, k):
        residual flexibility; direction (k,): displacement under the loads per unit of motion;
        inertia (k, k): residual inertia, the second static term, or none.
        """
        factor = linalg.cho_factor(rest)
        carried_rest = linalg.cho_solve(factor, direction)
        carried = linalg.cho_solve(factor, shares.T)
        stiffness = np.diag(squares) + shares @ carried
        mass, heavy, of_motion = np.eye(len(squares)), np.zeros(len(squares)), 0.0
        if inertia is not None:
            mass = mass + carried.T @ inertia @ carried
            heavy = carried.T @ (inertia @ carried_rest)
            of_motion = float(carried_rest @ inertia @ carried_rest)
        values, turned = linalg.eigh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
        return cls(
            squares=values,
            stiff=turned.T @ (shares @ carried_rest),
            heavy=turned.T @ heavy,
            spring=float(direction @ carried_rest),
            mass=of_motion,
            carried=carried @ turned,
            carried_rest=carried_rest,
            turned=turned,
            weights=weights,
            rates=rates,
        )

    @property
    def frequencies(self) -> Array:
        """Relaxed frequencies (n,) in Hz of the body held by the indenter."""
        return np.asarray(np.sqrt(self.squares) / (2 * np.pi))

    def stiffness(self, frequency: Array) -> Complex:
        """Force (n_f,) in mN per mm of oscillation of the indenter."""
        modulus, omega, amplitude = self._driven(frequency)
        coupled = (amplitude * self._coupling(modulus, omega)).sum(axis=1)
        return np.asarray(modulus * self.spring - omega**2 * self.mass - coupled)

    def amplitudes(self, frequency: Array) -> tuple[Complex, Complex]:
        """Elastic pressure (n_f, n_pad) of the rest and amplitudes (n_f, n) of the free modes.

        Per mm of oscillation of the indenter.
        """
        _, _, amplitude = self._driven(frequency)
        return self.carried_rest - amplitude @ self.carried.T, amplitude @ self.turned.T

    def _driven(self, frequency: Array) -> tuple[Complex, Array, Complex]:
        frequency = np.asarray(frequency, dtype=np.float64)
        modulus, omega = self.modulus(frequency), 2 * np.pi * frequency
        below = np.multiply.outer(modulus, self.squares) - omega[:, None] ** 2
        return modulus, omega, self._coupling(modulus, omega) / below

    def _coupling(self, modulus: Complex, omega: Array) -> Complex:
        elastic = np.multiply.outer(modulus, self.stiff)
        return np.asarray(elastic - np.multiply.outer(omega**2, self.heavy))

    def modulus(self, frequency: Array) -> Complex:
        """Complex modulus (n_f,) over the long-time one."""
        return complex_modulus(self.weights, self.rates, frequency)
