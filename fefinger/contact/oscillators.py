"""Viscoelastic modes as sums of exponentials: poles, residues, and their exact step.

A mode of the relaxed square w² obeys a'' + w² (G * a') = f with the relaxation function G of the
body, 1 at long times. Its answer to a force is a sum over the m + 2 poles of 1 / (s² + w² G(s)),
where G(s) = 1 + sum of g_j s / (s + v_j); each pole is a first-order filter, which a step of any
length solves exactly. In statics a force is linear in the step. With inertia that would let errors
grow from step to step, where contact prescribes the motion of a mass: then a step takes the mean of
the forces at both ends and, so that what alternates dies out, a share of their second difference.
Both are exact to the second order of the step.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError


Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Oscillators:
    """Modes of a body with one relaxation function.

    omega_squared (n,) of the relaxed angular frequencies in 1/s²; weights and rates (m,) of the
    Prony terms, over the long-time modulus; poles and residues (n, m + 2) of each mode.
    """

    omega_squared: Array
    weights: Array
    rates: Array
    poles: Complex
    residues: Complex

    def only(self, chosen: Integers) -> "Oscillators":
        """Return some of the modes."""
        return replace(
            self,
            omega_squared=self.omega_squared[chosen],
            poles=self.poles[chosen],
            residues=self.residues[chosen],
        )

    @classmethod
    def of(cls, omega_squared: Array, weights: Array, rates: Array) -> "Oscillators":
        """Compute the poles of modes under a relaxation function.

        Raises
        ------
        ConvergenceError
            If two poles of a mode coincide, so that its answer is no sum of exponentials.
        """
        poles = np.linalg.eigvals(_systems(omega_squared, weights, rates)).astype(np.complex128)
        near = poles[..., None] + rates
        near = np.where(near == 0, 1e-300, near)
        slope = 2 * poles + omega_squared[:, None] * (weights * rates / near**2).sum(axis=-1)
        residues = 1.0 / slope
        error = np.abs((residues * poles).sum(axis=1) - 1.0)
        missed = 1e-6  # largest error of the sum rules of the residues
        if len(error) and not error.max() <= missed:
            worst = int(np.argmax(error))
            message = (
                f"mode {worst + 1}: expected poles that differ, received two that coincide to "
                f"{error[worst]:.1e}; change a rate of the relaxation in its fourth digit"
            )
            raise ConvergenceError(message)
        return cls(omega_squared, weights, rates, poles, residues)

    @property
    def glassy(self) -> Array:
        """Angular frequencies (n,) in 1/s with the modulus of a sudden strain."""
        return np.asarray(np.sqrt(self.omega_squared * (1.0 + self.weights.sum())))

    def modulus(self, frequency: Array) -> Complex:
        """Complex modulus (n_f,) over the long-time one at frequencies (n_f,) in Hz."""
        return complex_modulus(self.weights, self.rates, frequency)

    def filters(self, dt: float, *, swing: bool) -> tuple[Complex, Complex, Complex, Complex]:
        """Factors (n, m + 2) of a step: decay, and shares of forces a step ago, now and at its end.

        `swing`: a step with inertia, which takes the forces as the head of this file says; else a
        force that is linear in the step.
        """
        x = self.poles * dt
        small = 0.05  # |x| below which (e^x - 1 - x) / x² is summed as a series
        safe = np.where(np.abs(x) < small, 1.0, x)
        second = np.where(np.abs(x) < small, _series(x), (np.exp(safe) - 1 - safe) / safe**2)
        first = 1 + x * second  # (e^x - 1) / x
        if not swing:
            return np.exp(x), np.zeros_like(x), dt * (first - second), np.asarray(dt * second)
        # Share of the second difference of the force. At -1, pressures that alternate from step to
        # step then die out within some ten steps; an oscillation of 60 steps is changed by 0.1 %.
        damping = 0.1
        shares = (damping, 0.5 - 2 * damping, 0.5 + damping)
        earlier, before, after = (dt * share * first for share in shares)
        return np.exp(x), earlier, before, after


def complex_modulus(weights: Array, rates: Array, frequency: Array) -> Complex:
    """Complex modulus (n_f,) over the long-time one, 1 + sum of g i w / (i w + v)."""
    omega = 2j * np.pi * np.asarray(frequency, dtype=np.float64)[:, None]
    return np.asarray(1.0 + (weights * omega / (omega + rates)).sum(axis=1))


def _systems(omega_squared: Array, weights: Array, rates: Array) -> Array:
    """State matrices (n, m + 2, m + 2) of (w a, a', w sqrt(g) z): damped, else skew-symmetric."""
    frequency, m = np.sqrt(omega_squared), len(rates)
    systems = np.zeros((len(omega_squared), m + 2, m + 2))
    systems[:, 0, 1], systems[:, 1, 0] = frequency, -frequency
    coupling = frequency[:, None] * np.sqrt(weights)
    systems[:, 2:, 1], systems[:, 1, 2:] = coupling, -coupling
    diagonal = np.arange(2, m + 2)
    systems[:, diagonal, diagonal] = -rates
    return systems


def _series(x: Complex) -> Complex:
    """Sum (e^x - 1 - x) / x² for small x."""
    total = np.full_like(x, 1.0)
    terms = 9  # of the series; those left out add less than 1e-21
    for n in range(terms, 0, -1):
        total = 1.0 + x / (n + 2) * total
    return total / 2
