"""Chapter 2 of Pawluk (1997): the forces of the lumped finger."""

import math
from collections.abc import Callable, Iterator
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.oracles.ergonomics import Vibration, vibration
from fefinger.validation.oracles.impedance import relaxation_spectrum

from fefinger.scene import library
from fefinger.support.arrays import Array
from fefinger.theory.lumped.spring import Spring, constant_velocity, force
from fefinger.theory.relaxation import Prony


DIGITS = "half a unit of the last digit of the recomputation, and its own rounding"
SPEEDS = (
    *((0.1, 0.294), (0.2, 0.321), (0.5, 0.367), (1, 0.403), (8, 0.538), (16, 0.596), (32, 0.661)),
    *((48, 0.703), (60, 0.727), (64, 0.735), (80, 0.760), (1000, 0.962)),
)
"""P / T at 2 mm of a.h. by speed in mm/s (section 2.3, recomputed)."""

DEEP = 8.0  # mm, where the -1 of Eq. 2.1 no longer counts

FORCES = (
    *((1.5, "mean", 0.492, 0.48), (1.5, "peak_to_peak", 0.820, 0.93)),
    *((1.5, "first_peak_to_peak", 0.945, None), (3.0, "mean", 11.95, 11.2)),
    *((3.0, "peak_to_peak", 19.14, 21), (3.0, "first_peak_to_peak", 22.15, None)),
)
"""Offset in mm, force at 16 Hz and 0.28 mm in N, recomputed, printed (section 2.4.3)."""

OFFSETS = ((1.5, 0.28), (3.0, 0.28), (1.5, 0.14), (3.0, 0.14))  # with peak to peak, mm

PEAKS = (2.32, 2.18, 2.14, 2.10, 2.07)
"""Peaks in N of Figure 2-4, a.h., 1.5 mm and 0.4 mm amplitude (recomputed)."""


def finger(subject: str) -> tuple[Spring, Prony]:
    """Return the elastic response and the relaxation of a row of Table 2.1."""
    row = library.lumped()[subject]
    return Spring(row.b, row.m), row.prony


@cache
def vibrated(
    offset: float, peak_to_peak: float, frequency: float, seconds: float = 8.0
) -> Vibration:
    """Return the simulated task of section 2.4.3, a.h."""
    return vibration(
        *finger("a.h."),
        offset=offset,
        peak_to_peak=peak_to_peak,
        frequency=frequency,
        seconds=seconds,
    )


def simulated(offset: float, name: str) -> float:
    """Return a force in N of the simulated task at 16 Hz and 0.28 mm, by its name."""
    return float(getattr(vibrated(offset, 0.28, 16), name))


def periodic(offset: float, peak_to_peak: float, frequency: float) -> tuple[Array, Array]:
    """Return position in mm and force in N over a cycle of the steady state, by Fourier series.

    A second method for `vibration`, without contact loss: (1024,) each, from the mean upward.
    """
    spring, prony = finger("a.h.")
    turn = np.arange(1024) / 1024
    position = offset + peak_to_peak / 2 * np.sin(2 * np.pi * turn)
    harmonics = np.fft.rfft(spring.force(position))
    tones = frequency * np.arange(1, len(harmonics))
    transfer = 2j * np.pi * tones * relaxation_spectrum(prony, tones)
    harmonics *= np.concatenate([[prony.long_time], transfer])
    return position, np.fft.irfft(harmonics)


def swing_growth(offset: float, peak_to_peak: float) -> float:
    """Return the peak-to-peak force of `periodic` at 128 Hz over that at 1 Hz."""
    fast, slow = (np.ptp(periodic(offset, peak_to_peak, frequency)[1]) for frequency in (128, 1))
    return float(fast / slow)


def digits(number: float) -> float:
    """Return a tolerance for a number printed with three digits or a little more."""
    return 6e-3 * 10 ** math.floor(math.log10(number))


def ratio(subject: str, speed: float, depth: float = 2.0) -> float:
    """Return P / T at a depth in mm reached with constant speed."""
    spring, prony = finger(subject)
    pressed = constant_velocity(spring, prony, depth, speed)
    return float(pressed / spring.force(depth))


def exponential_ratio(subject: str, speed: float) -> float:
    """Return P / T of a purely exponential T at constant speed."""
    row = library.lumped()[subject]
    growth = row.m * speed
    rates = (0.0, *row.prony.v)
    return sum(c * growth / (growth + v) for c, v in zip(row.prony.weights, rates, strict=True))


@cache
def sinusoid() -> tuple[Array, Array]:
    """Return time in s and force in N of Figure 2-4: 20 mm/s to 1.5 mm, then 5 cycles at 4 Hz."""
    turns = np.linspace(0.0, 5.0, 5001)
    time = np.concatenate([[0.0], 0.075 + turns / 4])
    position = np.concatenate([[0.0], 1.5 + 0.4 * np.sin(2 * np.pi * turns)])
    return time, force(*finger("a.h."), time, position)


def peak(cycle: int) -> float:
    """Return the peak in N of a cycle of Figure 2-4."""
    return float(sinusoid()[1][1 + 1000 * cycle : 1001 + 1000 * cycle].max())


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the forces of chapter 2."""
    yield from _velocity()
    yield from _forces()
    yield from _sinusoid()


def _velocity() -> Iterator[Case]:
    for speed, expected in SPEEDS:
        printed = {0.2: 0.25, 60: 1.0}.get(speed)
        yield Case(
            f"2.3: P / T at {speed:g} mm/s, a.h., 2 mm",
            partial(ratio, "a.h.", speed),
            Expected(expected, 6e-4),
            "section 2.3, recomputed: sum of ci m v / (m v + vi)",
            printed=printed,
            erratum=(
                "Section 2.3 says that the force saturates above about 60 mm/s (P = T) and below "
                "0.2 mm/s (P = c0 T). With the fitted parameters it does at neither end."
                if printed is not None
                else ""
            ),
            reason=DIGITS,
        )
    for subject in library.lumped():
        yield Case(
            f"2.3: force at 0.2 mm/s above c0 T, {subject}",
            partial(lambda s: 100 * (ratio(s, 0.2, DEEP) / finger(s)[1].long_time - 1), subject),
            Expected(
                100 * (exponential_ratio(subject, 0.2) / finger(subject)[1].long_time - 1),
                0.01,
                "%",
            ),
            "closed form for an exponential T: sum of ci m v / (m v + vi); section 2.3, recomputed",
            printed=0,
            erratum="Section 2.3 takes 0.2 mm/s for the steady state; it is 15 to 44 % above.",
            reason="exp(-m x) at 8 mm, below which the -1 of Eq. 2.1 has sunk",
        )


def _forces() -> Iterator[Case]:
    for offset, name, expected, printed in FORCES:
        yield Case(
            f"2.4.3: {name.replace('_', ' ')} force, 16 Hz, 0.28 mm about {offset:g} mm, a.h.",
            partial(simulated, offset, name),
            Expected(expected, digits(expected), "N"),
            "section 2.4.3, recomputed with steps of 0.1 ms",
            printed=printed,
            erratum=(
                "Printed means are 2 to 6 % below, peak to peak 10 to 13 % above what the "
                "printed parameters give. A convolution by rectangles with steps of 4 ms, the "
                "fast time constant, gives 0.894 and 20.9 N peak to peak: a "
                "plausible cause, not a proven one. The means are within what two digits allow."
                if printed is not None
                else ""
            ),
            reason=DIGITS,
        )
    for name, measure, expected, tolerance, printed, erratum in _factors():
        title = f"2.4.3: {name}, a.h."
        limits = Expected(expected, tolerance)
        source = "section 2.4.3, recomputed"
        yield Case(title, measure, limits, source, printed=printed, erratum=erratum, reason=DIGITS)


def _factors() -> Iterator[tuple[str, Callable[[], float], float, float, float | None, str]]:
    yield (
        "ratio of the elastic forces at 3.0 and 1.5 mm",
        lambda: float(np.divide(*finger("a.h.")[0].force([3.0, 1.5]))),
        24.33, 0.01, 23.3,
        "The means 11.2 and 0.48 N have the ratio exp(3.15) = 23.3: the -1 of Eq. 2.1 is missing.",
    )  # fmt: skip
    yield (
        "instantaneous over relaxed force",
        lambda: 1 / finger("a.h.")[1].long_time,
        4.0, 0.005, 4, "",
    )  # fmt: skip
    yield (
        "mean of the first cycle over the steady mean",
        lambda: vibrated(1.5, 0.28, 16).first_mean / vibrated(1.5, 0.28, 16).mean,
        2.12, 0.006, None, "",
    )  # fmt: skip
    for offset, size in OFFSETS:
        yield (
            f"growth of peak to peak from 1 to 128 Hz by Eq. 2.3, {size:g} mm about {offset:g} mm",
            partial(swing_growth, offset, size),
            2.16, 0.006, None, "The text says about 2, and so it is, the same at every offset.",
        )  # fmt: skip


def _sinusoid() -> Iterator[Case]:
    for cycle, expected in enumerate(PEAKS):
        name = f"Figure 2-4: peak of cycle {cycle + 1}, a.h., 0.4 mm at 4 Hz about 1.5 mm"
        limits = Expected(expected, 0.006, "N")
        yield Case(name, partial(peak, cycle), limits, "Figure 2-4, recomputed", reason=DIGITS)
    name = "Figure 2-4: least force by Eq. 2.3, which pulls where contact is lost"
    limits = Expected(-0.12, 0.006, "N")
    source = "Figure 2-4, recomputed"
    yield Case(name, lambda: float(sinusoid()[1].min()), limits, source, reason=DIGITS)
