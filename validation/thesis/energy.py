"""Chapter 2 of Pawluk (1997): energy and impedance of the lumped finger."""

from collections.abc import Iterator
from functools import partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.oracles.ergonomics import tap
from fefinger.validation.oracles.impedance import decibel, impedance, phase, relaxation_spectrum
from fefinger.validation.thesis.lumped import DIGITS, digits, finger, periodic, vibrated

from fefinger.theory.relaxation import hereditary_integral


FREQUENCIES = (1, 2, 4, 8, 16)
FRACTIONS = {
    (1.5, 0.28): (17.3, 21.5, 22.2, 23.4, 29.3),
    (3.0, 0.28): (16.6, 20.7, 21.4, 22.5, 28.2),
    (1.5, 0.14): (9.0, 11.3, 11.7, 12.3, 15.7),
    (3.0, 0.14): (8.7, 10.9, 11.2, 11.9, 15.1),
}
"""Dissipated share in % by offset and peak to peak in mm (section 2.4.3, recomputed).

At 30 Hz the recomputation counts 333 of the 333.3 steps of 0.1 ms as a cycle; a second method
takes its place there.
"""

POWERS = {(1.5, 0.28): 0.738, (3.0, 0.28): 17.2, (1.5, 0.14): 0.183, (3.0, 0.14): 4.27}
"""Dissipated power in mW at 16 Hz (section 2.4.3, recomputed)."""

PHASES = (
    *((1, -78.1), (10, -76.5), (30, -74.0), (37, -74.7), (100, -81.8), (200, -85.6)),
    (1000, -89.1),
)
MAGNITUDES = {
    1.0: ((30, 34.0, 9.5), (100, 12.6, 3.5), (200, 6.5, 1.8)),
    5.6: ((30, 189.0, 49.6), (100, 69.0, 18.3), (200, 36.0, 9.4)),
}
"""|Z| in N s/m by preload in N: frequency in Hz, right and by Eq. 2.12 (recomputed)."""

TAPS = ((1, 41), (10, 44), (50, 46), (100, 45), (300, 33))  # mm/s, %
RELAXED = 16.0  # s, after which the slowest exponential is below 1e-4


def periodic_work(offset: float, peak_to_peak: float, frequency: float) -> tuple[float, float]:
    """Return the loading work and the dissipated work of a cycle in mJ, by Fourier series."""
    _, pressed = periodic(offset, peak_to_peak, frequency)
    work = pressed * np.cos(2 * np.pi * np.arange(1024) / 1024) * np.pi * peak_to_peak / 1024
    return float(work[work > 0].sum()), float(work.sum())


def transient_work(offset: float, peak_to_peak: float, frequency: float) -> float:
    """Return the work in mJ of the first half cycle, by the hereditary integral of sampled T."""
    spring, prony = finger("a.h.")
    ramp, turn = np.linspace(0.0, 1.0, 2001), np.linspace(0.0, 0.5, 2001)
    time = np.concatenate([ramp[:-1] * offset / 100, offset / 100 + turn / frequency])
    wave = offset + peak_to_peak / 2 * np.sin(2 * np.pi * turn)
    pressed = hereditary_integral(prony, time, spring.force(np.append(ramp[:-1] * offset, wave)))
    return float(np.trapezoid(pressed[2000:], wave))


def slope(subject: str, low: float, high: float) -> float:
    """Return the slope of |G(i omega)| between two frequencies in dB per decade."""
    ends = decibel(relaxation_spectrum(finger(subject)[1], [low, high]))
    return float(np.diff(ends)[0] / np.log10(high / low))


def magnitude(preload: float, frequency: float) -> float:
    """Return |Z| in N s/m of the mean finger."""
    spring, prony = finger("means")
    return 1e3 * float(np.abs(impedance(spring, prony, frequency, preload)))


def tapped(speed: float) -> float:
    """Return the dissipated share in % of a tap to 2 mm at a speed in mm/s, a.h."""
    spring, prony = finger("a.h.")
    return 100 * tap(spring, prony, depth=2.0, speed=speed).fraction


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the energy and the impedance of chapter 2."""
    yield from _energy()
    yield from _impedance()
    for speed, expected in TAPS:
        name = f"2.4.3: dissipated in a tap to 2 mm at {speed} mm/s, a.h."
        measure = partial(tapped, speed)
        source = "section 2.4.3, recomputed; measured taps dissipate 81 % (Jindrich et al. 2003)"
        yield Case(name, measure, Expected(expected, 0.6, "%"), source, reason=DIGITS)


def _energy() -> Iterator[Case]:
    for (offset, size), values in FRACTIONS.items():
        for frequency, expected in zip(FREQUENCIES, values, strict=True):
            yield Case(
                f"2.4.3: dissipated, {frequency} Hz, {size:g} mm about {offset:g} mm",
                partial(
                    lambda o, s, f: 100 * vibrated(o, s, f).steady.fraction, offset, size, frequency
                ),
                Expected(expected, 0.06, "%"),
                "section 2.4.3, recomputed; Figure 2-10",
                reason=DIGITS,
            )
        loading, dissipated = periodic_work(offset, size, 30)
        yield Case(
            f"2.4.3: dissipated, 30 Hz, {size:g} mm about {offset:g} mm, after 16 s",
            partial(lambda o, s: 100 * vibrated(o, s, 30, RELAXED).steady.fraction, offset, size),
            Expected(100 * dissipated / loading, 0.01, "%"),
            "second method: Fourier series of T; Figure 2-10",
            reason="samples of the two methods",
        )
    for (offset, size), expected in POWERS.items():
        name = f"2.4.3: power at 16 Hz, {size:g} mm about {offset:g} mm"
        measure = partial(lambda o, s: vibrated(o, s, 16).steady.power, offset, size)
        limits = Expected(expected, digits(expected), "mW")
        yield Case(name, measure, limits, "section 2.4.3, recomputed; Figure 2-10", reason=DIGITS)
    for size, frequency in ((0.28, 1), (0.28, 30), (0.14, 1), (0.14, 30)):
        transient = 2 * transient_work(1.5, size, frequency)
        yield Case(
            f"2.4.3: transient over steady power, {frequency} Hz, {size:g} mm about 1.5 mm",
            partial(
                lambda s, f: vibrated(1.5, s, f).transient.power / vibrated(1.5, s, f).steady.power,
                size,
                frequency,
            ),
            Expected(transient / periodic_work(1.5, size, frequency)[1], 0.01),
            "second method: hereditary integral of sampled T over a Fourier series",
            printed=3.0 if size == 0.14 else None,
            erratum="Section 2.4.3 says 1.5 to 3. So it is for 0.28 mm; for 0.14 mm it is more."
            if size == 0.14
            else "",
            reason="samples of the two methods",
        )
    yield Case(
        "2.4.3: dissipated share about 3.0 mm over that about 1.5 mm, 16 Hz, 0.28 mm",
        lambda: vibrated(3.0, 0.28, 16).steady.fraction / vibrated(1.5, 0.28, 16).steady.fraction,
        Expected(28.2 / 29.3, 0.003),
        "section 2.4.3, recomputed",
        printed=1.0,
        erratum=(
            "Section 2.4.3 lets the offset cancel. It does for changes of the force; the -1 of "
            "Eq. 2.1 leaves a constant force that enters the work on loading."
        ),
        reason="the two shares have three digits",
    )


def _impedance() -> Iterator[Case]:
    name = "2.4.2: corner frequency v1 / 2 pi, means"
    limits = Expected(36.8, 0.06, "Hz")
    source = "recomputed; section 2.4.2 prints 37"
    yield Case(name, lambda: finger("means")[1].v[0] / (2 * np.pi), limits, source, reason=DIGITS)
    for frequency, expected in PHASES:
        yield Case(
            f"2.4.2: phase of G at {frequency:g} Hz, means",
            partial(lambda f: float(phase(relaxation_spectrum(finger("means")[1], f))), frequency),
            Expected(expected, 0.06, "degrees"),
            "section 2.4.2, recomputed; Figure 2-8",
            reason=DIGITS,
        )
    for low, high, expected, tolerance in (
        (30, 200, -17.5, 0.06),
        (1, 10, -17, 0.5),
        (200, 1e3, -19.9, 0.06),
    ):
        yield Case(
            f"2.4.2: slope of |G| from {low:g} to {high:g} Hz, means",
            partial(slope, "means", low, high),
            Expected(expected, tolerance, "dB/decade"),
            "section 2.4.2, recomputed; Figure 2-6",
            printed=-20.0 if low == 30 else None,
            erratum="-20 dB per decade is the limit of a spring; the fitted G is not there yet."
            if low == 30
            else "",
            reason=DIGITS,
        )
    for preload, rows in MAGNITUDES.items():
        for frequency, expected, printed in rows:
            yield Case(
                f"2.4.2: |Z| at {frequency} Hz, preload {preload:g} N, means",
                partial(magnitude, preload, frequency),
                Expected(expected, 0.6 if expected >= 20 else 0.06, "N s/m"),
                "section 2.4.2, recomputed: K = m P0 / c0 + b",
                printed=printed,
                erratum=(
                    "Eq. 2.12 takes K = m P0 + b, but P0 has relaxed: T = P0 / c0. The printed "
                    "form is 3.4 to 3.8 times too soft."
                ),
                reason=DIGITS,
            )
    yield Case(
        "2.4.2: stiffness of the pad at 2 N, means",
        lambda: float(finger("means")[0].stiffness(2.0)),
        Expected(4.39, 0.005, "kN/m"),
        "Eq. 2.4; section 2.4.2 prints 4.4",
        reason=DIGITS,
    )
