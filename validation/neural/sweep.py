"""Sinusoids A (1 - cos) into the end organs and membranes of chapter 4: what its figures plot.

The end organ is in its steady state, A [H(0) - Re(H(f) exp(i w t))], so that no sampling of the
input stands between the equations of the thesis and the current.
"""

from dataclasses import dataclass, field
from functools import cache

import numpy as np
from fefinger.validation.neural.connor_stevens import ConnorStevens
from numpy.typing import ArrayLike, NDArray

from fefinger.neural.endorgans import END_ORGANS, PoleZero
from fefinger.neural.membranes import HodgkinHuxley, IntegrateAndFire, Membrane
from fefinger.support.arrays import Array


SECONDS, CYCLES = 1.0, 4
"""A run lasts this long at least, and so many cycles; its second half is counted."""

IN_RANGE = np.geomspace(8.0, 100.0, 30)
"""uA/cm²: largest currents of a cycle, from the onset of firing to just below block."""

THESIS = "Pawluk (1997), "

LARGEST = 9000.0
"""uA/cm²: beyond it nothing is fired, for the potential then follows the current."""

FREQUENCIES = tuple(2.0**k for k in range(-1, 10))
DAMPED = tuple(2.0**k for k in range(-3, 10))
"""Hz: 0.5 to 512, and from 0.125 on for the damper (thesis 4.2.2, 4.3.3)."""


@dataclass(frozen=True)
class Derivative:
    """The derivative of order 1 or 2: the damper model of thesis 4.2.2."""

    order: int

    def frequency_response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return (2 pi i f)^order at frequencies in Hz."""
        return (2j * np.pi * np.asarray(frequency, float)) ** self.order


Organ = PoleZero | Derivative


@dataclass(frozen=True)
class Model:
    """A chain of chapter 4.

    largest: the amplitude of 0 dB in uA/cm² at a gain of 1 per mm (mm/s, mm/s² for derivatives);
    octaves: how many amplitudes follow, each half of the one before.
    """

    name: str
    organ: Organ
    membrane: Membrane
    largest: float
    octaves: int
    frequencies: tuple[float, ...] = field(default=FREQUENCIES)

    @property
    def amplitudes(self) -> Array:
        """Amplitudes (octaves + 1,) from the largest on."""
        return np.asarray(self.largest / 2.0 ** np.arange(self.octaves + 1), np.float64)


STANDARD, SLOWED = HodgkinHuxley(1.0), HodgkinHuxley(6.0)
SPRING, DAMPER, SECOND = PoleZero((), ()), Derivative(1), Derivative(2)
_SHARE = 50.0 / np.pi
"""Amplitude at which the velocity at 0.5 Hz gives 50 uA/cm²."""

MODELS = {
    model.name: model
    for model in (
        Model("spring, 6.3 C", SPRING, STANDARD, 50.0, 5),
        Model("damper, 6.3 C", DAMPER, STANDARD, _SHARE, 11),
        Model("second derivative, 6.3 C", SECOND, STANDARD, _SHARE / np.pi, 11),
        Model("spring", SPRING, SLOWED, 50.0, 5),
        Model("damper", DAMPER, SLOWED, _SHARE, 12, DAMPED),
        Model("second derivative", SECOND, SLOWED, _SHARE / np.pi, 12),
        Model("SAI", END_ORGANS["SAI"], SLOWED, 100.0, 7),
        Model("SAII", END_ORGANS["SAII"], SLOWED, 200.0, 8),
        Model("FAI", END_ORGANS["FAI"], SLOWED, 1600.0, 11),
        Model("FAII", END_ORGANS["FAII"], SLOWED, 4e6, 18),
        Model("spring, A current", SPRING, ConnorStevens(), 50.0, 5),
        Model("spring, integrate and fire", SPRING, IntegrateAndFire(), 50.0, 5),
    )
}
"""0 dB: the largest input without depolarization block at the lowest frequency that answers."""


@dataclass(frozen=True)
class Swing:
    """What sinusoids of one frequency do, one entry per amplitude; nan where none was fired.

    impulses per cycle; phases in degrees of the input cycle, 0 where the probe is farthest out,
    below 180 while it goes in; peak in mV; blocked: seconds of depolarization block.
    """

    impulses: Array
    phases: tuple[Array, ...]
    peak: Array
    blocked: Array


def current(organ: Organ, frequency: float, turn: ArrayLike) -> Array:
    """Return the half-wave rectified output for A = 1 at these turns of the cycle."""
    response = organ.frequency_response(np.array([0.0, frequency]))
    swung = np.real(response[1] * np.exp(2j * np.pi * np.asarray(turn, float)))
    return np.maximum(np.real(response[0]) - swung, 0.0)


def cornered(membrane: HodgkinHuxley, frequency: float) -> int:
    """Count the samples per cycle that put corners near the resonance of a membrane at rest.

    Under a smooth current that rises slowly, a membrane stays at its unstable rest until what
    disturbs it has grown, and that is rounding, which differs between processors. Corners 10 ms
    apart (at full rate) disturb it far more, and alike everywhere.
    """
    return round(100.0 / (membrane.rate_divisor * frequency))


def swing(
    organ: Organ,
    membrane: Membrane,
    frequency: float,
    amplitudes: ArrayLike,
    samples: int | None = None,
) -> Swing:
    """Response of a membrane to A (1 - cos) of these amplitudes (uA/cm² at a gain of 1).

    samples: of a cycle, between which the current goes straight; None for a smooth one.
    """
    amplitudes = np.atleast_1d(np.asarray(amplitudes, float))
    cycles = max(CYCLES, 2 * int(np.ceil(0.5 * SECONDS * frequency)))
    if samples is None:
        samples = int(np.clip(np.ceil(2000 / frequency), 40, 400))
    turn = np.arange(cycles * samples + 1) / samples
    shape = current(organ, frequency, turn)
    fired = amplitudes * shape.max() <= LARGEST
    impulses, peak, blocked = np.full((3, len(amplitudes)), np.nan)
    phases = [np.empty(0)] * len(amplitudes)
    if fired.any():
        currents = np.outer(shape, amplitudes[fired])
        firing = membrane.fire(turn / frequency, currents, dt=None, stimulus_driven=False)
        late = [t[t * frequency >= cycles / 2] * frequency for t in firing.times]
        impulses[fired] = [len(t) / (cycles / 2) for t in late]
        peak[fired], blocked[fired] = firing.peak_mV, firing.block_seconds
        for i, t in zip(np.flatnonzero(fired), late, strict=True):
            phases[i] = 360.0 * (t % 1.0)
    return Swing(impulses, tuple(phases), peak, blocked)


@cache
def swept(name: str) -> tuple[Swing, ...]:
    """Return a Swing for every frequency of a model, with its amplitudes."""
    model = MODELS[name]
    return tuple(
        swing(model.organ, model.membrane, frequency, model.amplitudes)
        for frequency in model.frequencies
    )


def impulses(name: str) -> Array:
    """Return impulses per cycle (n_frequencies, n_amplitudes) of a model."""
    return np.array([each.impulses for each in swept(name)])


def peaks(name: str) -> Array:
    """Return log2 of the frequency of most impulses per cycle, for each amplitude that fires.

    Amplitudes descend. Of frequencies with equally many the lowest counts.
    """
    table = np.nan_to_num(impulses(name))
    some = table.max(axis=0) > 0
    return np.log2(np.array(MODELS[name].frequencies)[table.argmax(axis=0)[some]])


def retracting(organ: Organ, membrane: Membrane, frequency: float, currents: ArrayLike) -> float:
    """Return the share of impulses that fall while the probe goes out.

    The mean over amplitudes that give these largest currents in uA/cm², where they fire.
    """
    response = swing(organ, membrane, frequency, np.asarray(currents) / tallest(organ, frequency))
    shares = [np.mean(phases > 180.0) for phases in response.phases if len(phases)]
    return float(np.mean(shares))


def later(kind: str, other: str, frequency: float) -> float:
    """Return the share in the retraction of an end organ, less another's; rates / 6."""
    organs = END_ORGANS[kind], END_ORGANS[other]
    shares = [retracting(organ, SLOWED, frequency, IN_RANGE) for organ in organs]
    return shares[0] - shares[1]


def tallest(organ: Organ, frequency: float) -> float:
    """Return the largest current that an amplitude of 1 gives at a frequency."""
    return float(current(organ, frequency, np.arange(1000) / 1000).max())
