"""Harmonic answer of a body of modes whose contact stays closed: in closed form at any frequency.

A preload sets the contact. Small oscillations do not change it, so that all elastic forces
share one factor G*, and the body held by its indenter has modes of its own: one small eigenproblem
serves every frequency. With the second static term (`inertia`), what the modes leave over has mass
too, and the error of leaving modes out is of second order in (frequency / last mode)².
"""

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from fefinger.contact.oscillators import Complex, complex_modulus
from fefinger.support.arrays import Array


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
