"""A wavy plate that slides over a viscoelastic half-space in full contact: drag and pressure.

In plane strain the pressure under heights h cos(k (x - v t)) is E*(k v) k h / 2 times that wave,
with E* the complex plane-strain modulus, so that the mean force along the surface is
(k h)² Im E* / 4 per area (Hunter, J. Appl. Mech. 28:611, 1961; Persson, J. Chem. Phys. 115:3840,
2001). The half-space is a circulant matrix, exact for its first harmonics.
"""

from dataclasses import dataclass

import numpy as np

from fefinger.contact.frictionless import FrictionlessContact
from fefinger.contact.stepper import Prescribed, march
from fefinger.support.arrays import Array, Flags
from fefinger.theory.relaxation import Prony


NODES, LENGTH, HEIGHT, MODULUS, POISSON = 48, 2.0, 0.05, 60.0, 0.48
PRONY = Prony((0.4, 0.35, 0.25), (200.0, 12.0))
STEPS = 200  # in a cycle
SETTLED = 12.0  # times of the slowest relaxation before the cycle that is measured
DEPTH = 8.0  # mm, with which the wave stays in contact


@dataclass(frozen=True)
class Wave:
    """The wavy plate over nodes of one wavelength, as `Gaps`."""

    @property
    def places(self) -> Array:
        """Places (n,) mm of the nodes."""
        return np.asarray(self.share * np.arange(NODES), dtype=np.float64)

    @property
    def number(self) -> float:
        """2 pi over the wavelength in 1/mm."""
        return 2 * np.pi / LENGTH

    @property
    def share(self) -> float:
        """Area in mm² of a node, of a strip 1 mm wide."""
        return LENGTH / NODES

    def gap(self, shift: Array, incline: Array | None) -> tuple[Array, Flags]:
        """Return the weighted gaps (n,) at a place (2,) mm, and no rim."""
        heights = HEIGHT * (1 - np.cos(self.number * (self.places - shift[0])))
        return self.share * heights, np.zeros(NODES, dtype=bool)

    def push(self, shift: Array, pressure: Array, incline: Array | None) -> Array:
        """Return the force (2,) mN of pressures on the inclined heights."""
        slope = HEIGHT * self.number * np.sin(self.number * (self.places - shift[0]))
        return np.array([self.share * float(pressure @ slope), 0.0])


def flexibility(wave: Wave) -> Array:
    """F (n, n): 2 / (E* k) of every harmonic, and that of a layer of the mean."""
    numbers = np.abs(np.fft.fftfreq(NODES, 1 / NODES)) * wave.number
    plane = MODULUS / (1 - POISSON**2)
    symbol = 2 / (plane * np.where(numbers > 0, numbers, 2 / (plane * 0.1)))
    column = np.fft.ifft(symbol).real
    index = np.arange(NODES)
    return np.asarray(wave.share * column[(index[:, None] - index) % NODES])


def drag_ratio(speed: float) -> float:
    """Return the mean drag of a cycle at a speed in mm/s over the exact one."""
    wave = Wave()
    cycles = int(np.ceil(SETTLED / min(PRONY.v) * speed / LENGTH)) + 1
    steps = np.linspace(0, cycles * LENGTH / speed, cycles * STEPS + 1)
    rest = SETTLED / min(PRONY.v)
    time = np.concatenate([[0.0, rest], rest + steps[1:]])
    shift = np.zeros((len(time), 2))
    shift[1:, 0] = speed * steps
    weights = np.full(NODES, wave.share)
    history = march(
        FrictionlessContact(flexibility(wave), wave, weights, PRONY.branches),
        Prescribed("depth", time, np.full(len(time), DEPTH), shift),
    )
    assert (history.pressure > 0).all()
    assert history.sliding is not None
    measured = history.sliding.slopes[-STEPS:, 0].mean() / LENGTH
    return float(measured) / exact(speed)


def exact(speed: float) -> float:
    """Return (k h)² Im E* / 4 in mN per mm² at a speed in mm/s; without inertia."""
    omega, wave = 2 * np.pi / LENGTH * speed, Wave()
    weights, rates = PRONY.branches
    loss = float(np.sum(weights * omega / rates / (1 + (omega / rates) ** 2)))
    plane = MODULUS / (1 - POISSON**2)
    return (wave.number * HEIGHT) ** 2 * plane * loss / 4
