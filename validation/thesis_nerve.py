"""Chapter 4 of Pawluk (1997): impulses per cycle of the membranes to A (1 - cos)."""

from collections.abc import Iterator
from functools import partial

import numpy as np
from fefinger.validation.case import Case

from fefinger.neural.membranes import HodgkinHuxley


SAMPLES = 400  # of the current per cycle
AMPLITUDES = (12.5, 25.0, 50.0)  # uA/cm²
SLOWED = {1: (9, 14, 18), 2: (5, 7, 9), 4: (3, 3, 4), 8: (1, 2, 2), 16: (1, 1, 1)}
"""Impulses per cycle with the rates divided by 6, by frequency in Hz (an independent solution)."""

STANDARD = {6.5: 0, 12.5: 79, 25.0: 128, 50.0: 181}
"""Impulses per cycle at 0.5 Hz at full rate, by amplitude in uA/cm² (an independent solution)."""


def per_cycle(divisor: float, frequency: float, amplitude: float) -> float:
    """Return the impulses per cycle in the second half of 4 cycles (16 from 8 Hz on, 2 of 2 s)."""
    cycles = 2 if frequency < 1 else 4 if frequency < 8 else 16
    turn = np.linspace(0.0, cycles, cycles * SAMPLES + 1)
    current = amplitude * (1 - np.cos(2 * np.pi * turn))
    (times,) = HodgkinHuxley(divisor).fire(turn / frequency, current).times
    return float(np.sum(times * frequency >= cycles / 2) / (cycles / 2))


def warm(temperature: float) -> float:
    """Return the impulses in 0.5 s of 50 uA/cm² at a temperature in degrees Celsius."""
    membrane = HodgkinHuxley(1.0, temperature=temperature)
    (times,) = membrane.fire([0.0, 0.5], [50.0, 50.0]).times
    return float(len(times))


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield impulses per cycle."""
    for frequency, counts in SLOWED.items():
        for amplitude, expected in zip(AMPLITUDES, counts, strict=True):
            yield Case(
                "thesis",
                f"4.3.3: impulses per cycle at {frequency} Hz, {amplitude:g} uA/cm², rates / 6",
                partial(per_cycle, 6.0, frequency, amplitude),
                expected,
                1e-9,
                "1",
                "an independent Runge-Kutta solution",
                reason="a count, locked to the cycle",
            )
    for amplitude, expected in STANDARD.items():
        yield Case(
            "thesis",
            f"4.3.3: impulses per cycle at 0.5 Hz, {amplitude:g} uA/cm², full rate",
            partial(per_cycle, 1.0, 0.5, amplitude),
            expected,
            1.0 if expected else 1e-9,
            "1",
            "an independent Runge-Kutta solution",
            reason="an impulse on the border between two cycles",
        )
    for temperature in (30.0, 37.0):
        yield Case(
            "thesis",
            f"4.3.3: impulses in 0.5 s of 50 uA/cm² at {temperature:g} degrees",
            partial(warm, temperature),
            0.0,
            1.0,
            "1",
            "an independent Runge-Kutta solution: peaks below 40 mV at 30 and 37 degrees, Q10 = 3",
            printed=500.0,
            erratum=(
                "The thesis says that at 37 degrees there would be over a thousand impulses per "
                "cycle at 0.5 Hz, 500 in half a second. With a Q10 of 3 the membrane then does not "
                "fire any more."
            ),
            reason="the onset of the step may give one",
        )
