"""Chapter 4 of Pawluk (1997): impulses per cycle of the membranes to A (1 - cos)."""

from collections.abc import Iterator
from functools import partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.oracles.chains import SpringDamper, slow_chain

from fefinger.neural.endorgans import END_ORGANS
from fefinger.neural.membranes import HodgkinHuxley


SAMPLES = 400  # of the current per cycle
AMPLITUDES = (12.5, 25.0, 50.0)  # uA/cm²
SLOWED = {1: (9, 14, 18), 2: (5, 7, 9), 4: (3, 3, 4), 8: (1, 2, 2), 16: (1, 1, 1)}
"""Impulses per cycle with the rates divided by 6, by frequency in Hz (an independent solution)."""

FASTER: dict[tuple[float, float], float] = {
    (32, 12.5): 1 / 2,
    (32, 50.0): 1,
    **{(64, 12.5): 1 / 4, (64, 25.0): 1 / 3, (64, 50.0): 1 / 2},
}
"""The same by frequency and amplitude where units skip cycles."""

CORNERS = {6.0: 50, 1.0: 200}
"""Straight pieces of the current per cycle at 0.5 Hz, by the divisor of the rates.

Under a smooth current that rises so slowly the membrane stays at its unstable rest until what
disturbs it has grown, and that is rounding: 22 or 26 impulses a cycle at full rate, 7 uA/cm², on
two processors. The corners of such pieces disturb it far more, and alike everywhere.
"""

SLOWEST = {8.0: 14, 12.5: 19, 25.0: 28, 50.0: 37}
"""Impulses per cycle at 0.5 Hz with the rates divided by 6, by amplitude in uA/cm²."""

INVERTED_U = {0.5: 0, 1: 0, 2: 3, 4: 2, 8: 1, 16: 1, 32: 0.5}
"""The same at 6 uA/cm², by frequency."""

STANDARD = {6.5: 43, 7.0: 50, 8.0: 61, 12.5: 93, 25.0: 140, 50.0: 192}
"""The same at full rate; both by an independent solution."""


def per_cycle(divisor: float, frequency: float, amplitude: float, samples: int = SAMPLES) -> float:
    """Return the impulses per cycle in the second half of 4 cycles (16 or 48 fast ones, 2 of 2 s).

    48 from 32 Hz on: its half is a whole number of 2, 3 and 4 skipped cycles.
    """
    cycles = 2 if frequency < 1 else 4 if frequency < 8 else 16 if frequency < 32 else 48
    turn = np.linspace(0.0, cycles, cycles * samples + 1)
    current = amplitude * (1 - np.cos(2 * np.pi * turn))
    (times,) = HodgkinHuxley(divisor).fire(turn / frequency, current).times
    return float(np.sum(times * frequency >= cycles / 2) / (cycles / 2))


def warm(temperature: float) -> float:
    """Return the impulses in 0.5 s of 50 uA/cm² at a temperature in degrees Celsius."""
    membrane = HodgkinHuxley(1.0, temperature=temperature)
    (times,) = membrane.fire([0.0, 0.5], [50.0, 50.0]).times
    return float(len(times))


def decay() -> float:
    """Return the rate in 1/s at which the FAI end organ forgets a step, from its late response."""
    time = np.array([0.0, 0.0, 0.5, 0.7])
    out = END_ORGANS["FAI"].respond(time, np.array([0.0, 1.0, 1.0, 1.0]))
    return float(np.log(out[3] / out[2]) / 0.2)


def spring_chain() -> float:
    """Nerve input per displacement of a slow chain of springs 2, 0.3 and 0.7."""
    chain = slow_chain(2.0, SpringDamper(0.3, 0.05), 0.7)
    return float(np.abs(chain.displacement_filter().frequency_response([1e-6]))[0])


def _equations() -> Iterator[Case]:
    yield Case(
        "Eq. B.29: rate of the FAI end organ after a step",
        decay,
        Expected(-2 * np.pi, 1e-3, "1/s"),
        "slower pole of Eq. B.28, 1 Hz; the faster one is gone by then",
        printed=5.3,
        erratum="With the printed sign of the last term the response grows at 5.3 1/s and more.",
        reason="what is left of the pole at 10 Hz",
    )
    yield Case(
        "Eq. 5.8: part of the displacement that reaches the nerve, springs 2, 0.3, 0.7",
        spring_chain,
        Expected(0.6 / (0.6 + 0.7 * 2.3), 1e-6),
        "three springs in series",
        printed=0.6 / (0.7 * 2.3),
        erratum="The printed form is the limit of a stiff nerve; for a soft one it exceeds 1.",
        reason="frequency of 1e-6 Hz",
    )


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield impulses per cycle."""
    yield from _equations()
    for frequency, counts in SLOWED.items():
        for amplitude, expected in zip(AMPLITUDES, counts, strict=True):
            yield Case(
                f"4.3.3: impulses per cycle at {frequency} Hz, {amplitude:g} uA/cm², rates / 6",
                partial(per_cycle, 6.0, frequency, amplitude),
                Expected(expected, 1e-9),
                "an independent Runge-Kutta solution",
                reason="a count, locked to the cycle",
            )
    slowed: dict[tuple[float, float], float] = {
        **{(frequency, 6.0): count for frequency, count in INVERTED_U.items()},
        **FASTER,
    }
    for (tone, current), count in slowed.items():
        yield Case(
            f"4.3.2: impulses per cycle at {tone:g} Hz, {current:g} uA/cm², rates / 6",
            partial(per_cycle, 6.0, tone, current),
            Expected(count, 1e-9),
            "an independent Runge-Kutta solution",
            reason="a count, locked to the cycle",
        )
    for divisor, what, counted in (
        (6.0, "4.3.2: {} rates / 6", SLOWEST),
        (1.0, "4.3.3: {} full rate", STANDARD),
    ):
        for amplitude, expected in counted.items():
            yield Case(
                what.format(f"impulses per cycle at 0.5 Hz, {amplitude:g} uA/cm²,"),
                partial(per_cycle, divisor, 0.5, amplitude, CORNERS[divisor]),
                Expected(expected, min(1.0, 0.05 * expected)),
                "an independent Runge-Kutta solution of the same straight pieces",
                reason="an impulse on the border between two cycles, and less of few",
            )
    for temperature in (30.0, 37.0):
        yield Case(
            f"4.3.3: impulses in 0.5 s of 50 uA/cm² at {temperature:g} degrees",
            partial(warm, temperature),
            Expected(0.0, 1.0),
            "an independent Runge-Kutta solution: peaks below 40 mV at 30 and 37 degrees, Q10 = 3",
            printed=500.0,
            erratum=(
                "The thesis says that at 37 degrees there would be over a thousand impulses per "
                "cycle at 0.5 Hz, 500 in half a second. With a Q10 of 3 the membrane then does not "
                "fire any more."
            ),
            reason="the onset of the step may give one",
        )
