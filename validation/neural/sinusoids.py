"""Chapter 4 of Pawluk (1997), sinusoids: its claims on frequency, amplitude and range."""

from collections.abc import Iterator
from functools import partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.neural.filters import derivative
from fefinger.validation.neural.sweep import (
    DAMPER,
    FREQUENCIES,
    IN_RANGE,
    MODELS,
    SECOND,
    SLOWED,
    SPRING,
    STANDARD,
    THESIS,
    Organ,
    cornered,
    impulses,
    peaks,
    swept,
    swing,
    tallest,
)

from fefinger.neural.endorgans import END_ORGANS
from fefinger.neural.membranes import HodgkinHuxley, IntegrateAndFire


TOP = 111.0
"""uA/cm² above which the peaks fail the 40 mV rule in constant current: the plateau of 4.2.2."""

QUIET = 45.0
"""dB below TOP that a threshold is looked for."""

COUNTER = IntegrateAndFire(threshold=1e-4, time_constant=10.0, refractory=0.0)
"""Impulses per second in proportion to the mean current: the approximation of 4.3.1."""

FALL = "1/f is -1; locking to the cycle flattens it"


def fall(name: str) -> float:
    """Return the slope of log(impulses per cycle) over log(frequency) at 0 dB, 0.5 to 64 Hz."""
    first, last = impulses(name)[[FREQUENCIES.index(0.5), FREQUENCIES.index(64.0)], 0]
    return float(np.log(last / first) / np.log(128.0))


def shift(name: str) -> float:
    """Return the octaves by which the peak moves up from the largest to the smallest amplitude."""
    frequencies = peaks(name)
    return float(frequencies[-1] - frequencies[0])


def steadiness(name: str) -> float:
    """Return the rank correlation of the peak's frequency with the attenuation."""
    from scipy.stats import spearmanr

    frequencies = peaks(name)
    return float(spearmanr(np.arange(len(frequencies)), frequencies).statistic)


def smallest(name: str, frequency: float) -> float:
    """Return the peak frequency in Hz at the smallest amplitude that fires at a frequency."""
    table = np.nan_to_num(impulses(name))
    row = MODELS[name].frequencies.index(frequency)
    column = np.flatnonzero(table[row] > 0).max()
    return float(MODELS[name].frequencies[table[:, column].argmax()])


def input_range(name: str) -> float:
    """Return the dB from the smallest amplitude that fires at any frequency to the largest.

    The largest is that which reaches TOP at 0.5 Hz, beyond which the voltage has a plateau.
    """
    model, least = MODELS[name], np.inf
    steps = 10.0 ** (-np.arange(0.0, QUIET, 0.5) / 20.0)
    for frequency in FREQUENCIES:
        amplitudes = TOP / tallest(model.organ, frequency) * steps
        fires = swing(model.organ, model.membrane, frequency, amplitudes).impulses > 0
        least = min(least, float(amplitudes[fires].min()))
    return float(20.0 * np.log10(TOP / tallest(model.organ, 0.5) / least))


def wider(name: str, other: str) -> float:
    """Return by how many dB the input range of one model is the wider."""
    return input_range(name) - input_range(other)


def few(membrane: HodgkinHuxley) -> float:
    """Return the dB of amplitude at 0.5 Hz that give 1 to 20 impulses per cycle (4.3.2)."""
    steps = np.arange(0.0, 20.0, 0.25)
    amplitudes, samples = 50.0 / 10.0 ** (steps / 20.0), cornered(membrane, 0.5)
    impulses = swing(SPRING, membrane, 0.5, amplitudes, samples).impulses
    return 0.25 * float(np.sum((impulses > 0) & (impulses <= 20)))


def logarithmic(organ: Organ, membrane: HodgkinHuxley, frequency: float) -> float:
    """Return R² of impulses per cycle over log amplitude, less R² over amplitude."""
    amplitudes = IN_RANGE / tallest(organ, frequency)
    impulses = swing(organ, membrane, frequency, amplitudes, cornered(membrane, frequency)).impulses
    fires = impulses > 0

    def explained(x: np.ndarray) -> float:
        return float(np.corrcoef(x[fires], impulses[fires])[0, 1] ** 2)

    return explained(np.log(amplitudes)) - explained(amplitudes)


def order(organ: Organ, low: float, high: float) -> float:
    """Return the slope of log(impulses per second) over log(frequency) between two frequencies."""
    amplitude = 5.0 / tallest(organ, high)
    rates = [f * swing(organ, COUNTER, f, amplitude).impulses[0] for f in (low, high)]
    return float(np.log(rates[1] / rates[0]) / np.log(high / low))


def closed(pole: float) -> float:
    """Return the largest difference in impulses per cycle that a pole makes to the damper.

    Up to 8 Hz, at the amplitudes of the figure that do not block.
    """
    model, most = MODELS["damper"], 0.0
    for frequency, pure in zip(model.frequencies, swept("damper"), strict=True):
        if frequency <= 8.0:
            poled = swing(derivative(pole), SLOWED, frequency, model.amplitudes)
            free = (pure.blocked == 0) & (poled.blocked == 0)
            most = max(most, float(np.abs(poled.impulses - pure.impulses)[free].max()))
    return most


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the claims."""
    yield from _shapes()
    yield from _ranges(quick=quick)
    yield from _orders()
    yield from _poles(quick=quick)


def _shapes() -> Iterator[Case]:
    for section, name, middle in (
        ("4.2.2, Fig. 4-4b", "spring, 6.3 C", 16.0),
        ("4.3.3, Fig. 4-8", "spring", 4.0),
        ("4.3.4, Fig. 4-10a", "SAI", 4.0),
        ("4.3.4, Fig. 4-10b", "SAII", 4.0),
    ):
        title = f"{section}: {name}: fall of impulses per cycle with frequency at 0 dB"
        source = f"{THESIS}{section}: hyperbolic at large amplitudes"
        yield Case(title, partial(fall, name), Expected.between(-1.25, -0.75), source, reason=FALL)
        yield Case(
            f"{section}: {name}: peak at the smallest amplitude that fires at {middle:g} Hz",
            partial(smallest, name, middle),
            Expected.between(1.0, 32.0, "Hz"),
            f"{THESIS}{section}: an inverted U at lower amplitudes",
            reason="a peak within the frequencies, at neither end",
        )
    for section, name in (
        ("4.2.2, Fig. 4-4b", "spring, 6.3 C"),
        ("4.2.2, Fig. 4-5b", "damper, 6.3 C"),
        ("4.3.3, Fig. 4-8", "spring"),
        ("4.3.3, Fig. 4-9", "damper"),
        ("4.3.4, Fig. 4-11a", "FAI"),
        ("4.3.4, Fig. 4-11b", "FAII"),
    ):
        title = f"{section}: {name}: octaves by which the peak moves up as the amplitude falls"
        limits = Expected.between(2.0, 12.0)
        source = f"{THESIS}{section}: the peak shifts to higher frequencies at lower amplitudes"
        yield Case(title, partial(shift, name), limits, source, reason="two octaves or more")
        yield Case(
            f"{section}: {name}: rank correlation of the peak's frequency with the attenuation",
            partial(steadiness, name),
            Expected.between(0.8, 1.0),
            f"{THESIS}{section}: the shift is steady",
            reason="1 would be strictly steady; subharmonics compete at the smallest amplitudes",
        )
    yield Case(
        "4.2.2: spring on integrate-and-fire: octaves by which the peak moves",
        partial(shift, "spring, integrate and fire"),
        Expected.between(-0.5, 0.5),
        f"{THESIS}4.2.2: the shift is a property of the membrane, so a leaky integrator lacks it",
        reason="none",
    )
    for name, membrane in (("6.3 C", STANDARD), ("rates / 6", SLOWED)):
        yield Case(
            f"4.2.2: spring, {name}, 1 Hz: R² of growth with log amplitude, less that with it",
            partial(logarithmic, SPRING, membrane, 1.0),
            Expected.between(0.02, 1.0),
            f"{THESIS}4.2.2: the variation with the input amplitude is logarithmic",
            reason="a logarithm explains more than a straight line",
        )


def _ranges(*, quick: bool) -> Iterator[Case]:
    yield Case(
        "4.3.2: spring, 6.3 C, 0.5 Hz: amplitudes with 1 to 20 impulses per cycle",
        partial(few, STANDARD),
        Expected.between(0.0, 0.5, "dB"),
        f"{THESIS}4.3.2: the range below 20 impulses per cycle is extremely small",
        reason="the first amplitude that fires gives more at once",
    )
    yield Case(
        "4.3.2: spring, rates / 6, 0.5 Hz: amplitudes with 1 to 20 impulses per cycle",
        partial(few, SLOWED),
        Expected.between(6.0, 20.0, "dB"),
        f"{THESIS}4.3.2: slower kinetics open that range",
        reason="a factor of 2 in amplitude or more",
    )
    if quick:
        return
    pairs = (
        ("4.2.2", "damper, 6.3 C", "spring, 6.3 C", "the damper widens the input range"),
        ("4.3.3", "damper", "spring", "the damper widens the input range"),
        ("4.3.4", "FAII", "FAI", "higher poles increase the response range"),
        ("4.3.4", "FAII", "damper", "FAII can finally encompass the large range of the receptors"),
    )
    for section, name, other, words in pairs:
        yield Case(
            f"{section}: input range of {name}, over that of {other}",
            partial(wider, name, other),
            Expected.between(6.0, 80.0, "dB"),
            f"{THESIS}{section}: {words}",
            reason="a factor of 2 or more",
        )
    for name, expected in RANGES.items():
        yield Case(
            f"input range of {name}, 0.5 to 512 Hz",
            partial(input_range, name),
            Expected(expected, 2.0, "dB"),
            "threshold on steps of 0.5 dB, Runge-Kutta at 2 us instead of 50",
            reason="a step on either side, and the length of the run",
        )


RANGES = {"spring, 6.3 C": 32.5, "spring": 37.5, "SAI": 45.0, "SAII": 52.0, "FAI": 70.5}


def _orders() -> Iterator[Case]:
    source = f"{THESIS}4.3.1, Figs. 4-6a and 4-7a: the slope of impulses per second tells the order"
    for name, organ, low, high, limits in (
        ("spring", SPRING, 2.0, 64.0, (-0.05, 0.05)),
        ("damper", DAMPER, 2.0, 64.0, (0.95, 1.05)),
        ("second derivative", SECOND, 2.0, 16.0, (1.95, 2.05)),
        ("SAI, about its pole", END_ORGANS["SAI"], 0.25, 4.0, (0.2, 1.0)),
        ("SAII, about its pole", END_ORGANS["SAII"], 1.0, 16.0, (0.2, 1.0)),
        ("FAI, below its poles", END_ORGANS["FAI"], 0.125, 0.5, (1.0, 2.05)),
        ("FAII, below its poles", END_ORGANS["FAII"], 2.0, 16.0, (1.9, 2.05)),
    ):
        title = f"4.3.1: {name}: slope of impulses per second over frequency"
        measure = partial(order, organ, low, high)
        reason = "0, 1 and 2 for the orders; a first-order corner lies between 0 and 1"
        yield Case(title, measure, Expected.between(*limits), source, reason=reason)


def _poles(*, quick: bool) -> Iterator[Case]:
    for pole in (30.0,) if quick else (10.0, 30.0, 100.0):
        name = f"4.3.3: damper with a pole at {pole:g} Hz: largest change in impulses per cycle"
        limits = Expected.between(0.0, 1.0)
        source = f"{THESIS}4.3.3: a pole at 10 to 100 Hz keeps magnitude and range"
        yield Case(name, partial(closed, pole), limits, source, reason="one impulse, up to 8 Hz")
        title = f"4.3.3: damper with a pole at {pole:g} Hz: current at 512 Hz, times smaller"
        measure = partial(lambda p: tallest(DAMPER, 512.0) / tallest(derivative(p), 512.0), pole)
        origin = f"{THESIS}4.3.3: the pole significantly reduces unrealistically high voltages"
        yield Case(title, measure, Expected.between(2.0, 100.0), origin, reason="twofold or more")
