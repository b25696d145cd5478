"""Suite `neural`: the membrane and the end organs against published and closed-form numbers."""

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from fefinger.validation.case import Case

from fefinger.neural.endorgans import END_ORGANS
from fefinger.neural.membranes import HodgkinHuxley


STANDARD, SLOWED = 1.0, 6.0
RATES = {
    STANDARD: {7: 58.33, 10: 68.32, 20: 86.47, 50: 117.04, 100: 147.27},
    SLOWED: {7: 11.39, 10: 13.11, 20: 16.25, 50: 21.66, 100: 27.25},
}
ONSETS = {STANDARD: 6.2603, SLOWED: 6.1978}
ORGANS = {
    "SAI": ((0.1,), (1.0,)),
    "SAII": ((0.5,), (5.0,)),
    "FAI": ((0.0, 0.0), (1.0, 10.0)),
    "FAII": ((0.0, 0.0), (100.0, 1000.0)),
}
"""Zeros and poles in Hz as the thesis prints them in 4.3.4."""

ROUNDING = 0.5
"""Half of the whole degrees in which A5-8 gives the phases."""

PHASES = {
    "SAI": ((0.5, 52), (1, 39), (2, 24), (4, 13), (8, 6)),
    "SAII": ((0.5, 39), (1, 52), (2, 54), (4, 44), (8, 28)),
    "FAI": ((0.5, 151), (1, 129), (2, 105), (4, 82), (8, 59), (16, 36), (32, 19)),
    "FAII": ((16, 170), (64, 144), (256, 97)),
}


def peak() -> float:
    """Return the peak in mV of the action potential after 20 uA/cm² for 1 ms."""
    pulse = HodgkinHuxley(STANDARD).fire([0, 1e-3, 1e-3, 0.05], [20.0, 20.0, 0.0, 0.0], dt=1e-5)
    return float(pulse.peak_mV[0])


def rate(divisor: float, current: float) -> float:
    """Return the firing rate in Hz in constant current, in the second half of 1 s (5 s slowed)."""
    seconds = 1.0 if divisor == STANDARD else 5.0
    (times,) = HodgkinHuxley(divisor).fire([0.0, seconds], [current, current]).times
    return float(1 / np.diff(times[times > seconds / 2]).mean())


def onset(divisor: float) -> float:
    """Return the least current in uA/cm² to which a step from rest gives repetitive firing."""
    seconds = 3.0 if divisor == STANDARD else 15.0

    def repetitive(current: float) -> bool:
        membrane = HodgkinHuxley(divisor)
        (times,) = membrane.fire([0, seconds], [current] * 2, stimulus_driven=False).times
        return bool((times > 0.9 * seconds).any())

    return _bisect(repetitive, 6.1, 6.4, 2e-4)


def phase(kind: str, frequency: float) -> float:
    """Return the phase lead of an end organ in degrees."""
    response = END_ORGANS[kind].frequency_response(np.array([frequency]))[0]
    return float(np.degrees(np.angle(response)) % 360)


def closed_phase(kind: str, frequency: float) -> float:
    """Return the phase lead in degrees by the arctangents of the poles and zeros."""
    zeros, poles = ORGANS[kind]
    lead = sum(math.atan2(frequency, zero) for zero in zeros)
    return math.degrees(lead - sum(math.atan2(frequency, pole) for pole in poles))


def _bisect(fires: Callable[[float], bool], low: float, high: float, digits: float) -> float:
    while high - low > digits:
        middle = (low + high) / 2
        low, high = (low, middle) if fires(middle) else (middle, high)
    return high


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the action potential, thresholds, rates and phases."""
    yield Case(
        "neural",
        "peak after 1 ms of 20 uA/cm²",
        peak,
        105.5,
        0.05,
        "mV",
        "Hodgkin & Huxley 1952; recomputed A5-8",
    )
    for divisor, table in RATES.items():
        kind = "rates / 6" if divisor == SLOWED else "standard"
        yield Case(
            "neural",
            f"onset of repetitive firing, {kind}",
            partial(onset, divisor),
            ONSETS[divisor],
            5e-4,
            "uA/cm²",
            "adaptive DOP853 at rtol 1e-10, bisected",
        )
        for current, expected in table.items():
            if not quick or current == 20:
                yield Case(
                    "neural",
                    f"rate at {current} uA/cm², {kind}",
                    partial(rate, divisor, current),
                    expected,
                    2e-3 * expected,
                    "Hz",
                    "adaptive DOP853 at rtol 1e-10",
                )
    for organ, pairs in PHASES.items():
        for frequency, whole in pairs:
            exact = closed_phase(organ, frequency)
            misprinted = abs(whole - exact) > ROUNDING
            yield Case(
                "neural",
                f"phase of {organ} at {frequency:g} Hz",
                partial(phase, organ, frequency),
                exact,
                1e-6,
                "degrees",
                "Eq. 4.3 and 4.6, by arctangents of the poles and zeros; recomputed A5-8",
                printed=whole if misprinted else None,
                erratum=f"{exact:.2f} was rounded to {whole}" if misprinted else "",
            )
