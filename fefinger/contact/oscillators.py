"""Viscoelastic modes as sums of exponentials: exact step, and harmonic answer in closed form.

A mode of the relaxed square w² obeys a'' + w² (G * a') = f with the relaxation function G of the
body, 1 at long times. Its answer to a force is a sum over the m + 2 poles of 1 / (s² + w² G(s)),
where G(s) = 1 + sum of g_j s / (s + v_j); each pole is a first-order filter, which a step of any
length solves exactly. In statics a force is linear in the step. With inertia that would let errors
grow from step to step, where contact prescribes the motion of a mass: then a step takes the mean of
the forces at both ends and, so that what alternates dies out, a share of their second difference.
Both are exact to the second order of the step.

Of a harmonic answer a preload sets the contact. Small oscillations do not change it, so that all
elastic forces share one factor G*, and the body held by its indenter has modes of its own: one
small eigenproblem serves every frequency. With the second static term (`inertia`), what the modes
leave over has mass too, and the error of leaving modes out is of second order in (frequency / last
mode)².
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

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


@dataclass(frozen=True)
class ClosedContact:
    """A body held by an indenter in contact: amplitudes per unit of its oscillation.

    omega_squared (n,): squares of the relaxed angular frequencies of the held body;
    elastic_coupling, inertial_coupling (n,): of each of its modes to the indenter; spring mN/mm
    and mass kg of the indenter's motion alone; modal_pressure (n_pad, n) and motion_pressure
    (n_pad,): elastic pressure on the residual flexibility per mode and per unit of motion;
    mode_shapes (n_modes, n): amplitudes of the free modes.
    """

    omega_squared: Array
    elastic_coupling: Array
    inertial_coupling: Array
    spring: float
    mass: float
    modal_pressure: Array
    motion_pressure: Array
    mode_shapes: Array
    weights: Array
    rates: Array

    @classmethod
    def of(
        cls,
        omega_squared: Array,
        participation: Array,
        residual_flexibility: Array,
        direction: Array,
        weights: Array,
        rates: Array,
        inertia: Array | None = None,
    ) -> "ClosedContact":
        """Compute the modes of a body that the indenter holds from the modes of the free body.

        omega_squared (n,) and participation (n, k): of the free modes, on the k loads in contact;
        residual_flexibility (k, k): what the free modes leave; direction (k,): displacement under
        the loads per unit of motion; inertia (k, k): residual inertia, the second static term, or
        none.
        """
        factor = linalg.cho_factor(residual_flexibility)
        motion_pressure = linalg.cho_solve(factor, direction)
        modal_pressure = linalg.cho_solve(factor, participation.T)
        stiffness = np.diag(omega_squared) + participation @ modal_pressure
        count = len(omega_squared)
        mass, inertial_coupling, of_motion = np.eye(count), np.zeros(count), 0.0
        if inertia is not None:
            mass = mass + modal_pressure.T @ inertia @ modal_pressure
            inertial_coupling = modal_pressure.T @ (inertia @ motion_pressure)
            of_motion = float(motion_pressure @ inertia @ motion_pressure)
        values, mode_shapes = linalg.eigh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
        return cls(
            omega_squared=values,
            elastic_coupling=mode_shapes.T @ (participation @ motion_pressure),
            inertial_coupling=mode_shapes.T @ inertial_coupling,
            spring=float(direction @ motion_pressure),
            mass=of_motion,
            modal_pressure=modal_pressure @ mode_shapes,
            motion_pressure=motion_pressure,
            mode_shapes=mode_shapes,
            weights=weights,
            rates=rates,
        )

    @property
    def frequencies(self) -> Array:
        """Relaxed frequencies (n,) in Hz of the body held by the indenter."""
        return np.asarray(np.sqrt(self.omega_squared) / (2 * np.pi))

    def stiffness(self, frequency: Array) -> Complex:
        """Force (n_f,) in mN per mm of oscillation of the indenter."""
        modulus, omega, amplitude = self._driven(frequency)
        coupled = (amplitude * self._coupling(modulus, omega)).sum(axis=1)
        return np.asarray(modulus * self.spring - omega**2 * self.mass - coupled)

    def amplitudes(self, frequency: Array) -> tuple[Complex, Complex]:
        """Elastic pressure (n_f, n_pad) on the residual flexibility, amplitudes (n_f, n) of modes.

        The modes are the free ones. Per mm of oscillation of the indenter.
        """
        _, _, amplitude = self._driven(frequency)
        pressure = self.motion_pressure - amplitude @ self.modal_pressure.T
        return pressure, amplitude @ self.mode_shapes.T

    def _driven(self, frequency: Array) -> tuple[Complex, Array, Complex]:
        frequency = np.asarray(frequency, dtype=np.float64)
        modulus, omega = self.modulus(frequency), 2 * np.pi * frequency
        below = np.multiply.outer(modulus, self.omega_squared) - omega[:, None] ** 2
        return modulus, omega, self._coupling(modulus, omega) / below

    def _coupling(self, modulus: Complex, omega: Array) -> Complex:
        elastic = np.multiply.outer(modulus, self.elastic_coupling)
        return np.asarray(elastic - np.multiply.outer(omega**2, self.inertial_coupling))

    def modulus(self, frequency: Array) -> Complex:
        """Complex modulus (n_f,) over the long-time one."""
        return complex_modulus(self.weights, self.rates, frequency)
