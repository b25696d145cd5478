"""Chapters 4 and 5 of Pawluk (1997): end organs as filters, forces, and what rates cannot tell."""

import math
from collections.abc import Iterator
from functools import partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.neural.sweep import (
    SLOWED,
    SPRING,
    THESIS,
    current,
    later,
    swing,
    tallest,
)
from fefinger.validation.oracles.chains import Resonant, realize, under_force

from fefinger.neural.endorgans import END_ORGANS, GAINS, PoleZero, saturating
from fefinger.support.arrays import Array


ORGANS = {
    "SAI": ((0.1,), (1.0,)),
    "SAII": ((0.5,), (5.0,)),
    "FAI": ((0.0, 0.0), (1.0, 10.0)),
    "FAII": ((0.0, 0.0), (100.0, 1000.0)),
}
"""Zeros and poles in Hz as the thesis prints them in 4.3.4."""

PHASED = {
    "SAI": (0.5, 1.0, 2.0, 4.0, 8.0),
    "SAII": (0.5, 1.0, 2.0, 4.0, 8.0),
    "FAI": (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0),
    "FAII": (16.0, 64.0, 256.0),
}
"""Hz at which the phase of each end organ is compared."""

SLOW = tuple(2.0**k for k in range(-1, 7))
"""Hz over which 4.3.4 compares filters."""


def phase(kind: str, frequency: float) -> float:
    """Return the phase lead of an end organ in degrees."""
    response = END_ORGANS[kind].frequency_response(np.array([frequency]))[0]
    return float(np.degrees(np.angle(response)) % 360)


def closed_phase(kind: str, frequency: float) -> float:
    """Return the phase lead in degrees by the arctangents of the poles and zeros."""
    zeros, poles = ORGANS[kind]
    lead = sum(math.atan2(frequency, zero) for zero in zeros)
    return math.degrees(lead - sum(math.atan2(frequency, pole) for pole in poles))


def counts(organ: PoleZero) -> Array:
    """Return impulses per cycle at SLOW for currents that peak at 50 uA/cm² at 4 Hz."""
    amplitude = 50.0 / tallest(organ, 4.0)
    return np.array([swing(organ, SLOWED, f, amplitude).impulses[0] for f in SLOW])


def magnitude_change(organ: PoleZero, other: PoleZero) -> float:
    """Return the mean change of impulses per cycle between two filters, over their mean."""
    a, b = counts(organ), counts(other)
    both = (a > 0) & (b > 0)
    return float(np.mean(np.abs(a - b)[both] / (0.5 * (a + b))[both]))


def phase_change(organ: PoleZero, other: PoleZero) -> float:
    """Return the largest change of phase lead between two filters in degrees, at SLOW."""
    lead = [np.angle(each.frequency_response(np.array(SLOW))) for each in (organ, other)]
    turned = np.exp(1j * (lead[0] - lead[1]))
    return float(np.degrees(np.abs(np.angle(turned)).max()))


def held(organ: PoleZero | Resonant, at: float) -> float:
    """Return the output at `at` s of a unit step of force, over that just after the step."""
    out = organ.respond([0.0, at], [1.0, 1.0], [1e-9, at])
    return float(out[1] / out[0])


def ratio_drift(least: float) -> float:
    """Return the largest change of x_nerve / x_in with the force (5.1), for k = m F + b.

    `least`: stiffness b at no force of skin, end organ and nerve alike, over m.
    """
    m = np.array([1.6, 3.2, 0.8])
    forces = np.geomspace(0.02, 2.0, 40)[:, None]
    travel = np.log1p(forces * m / (least * np.array([1.0, 0.5, 2.0]))) / m
    ratio = travel[:, 2] / travel.sum(axis=1)
    return float(ratio.max() / ratio.min() - 1.0)


def coded(kind: str, amplitudes: tuple[float, float], frequency: float) -> tuple[float, float]:
    """Return the differences of two amplitudes in mm, in impulses per cycle and in degrees.

    At the gains of `neural.gains` with the saturating generator.
    """
    turn = np.arange(4 * int(frequency) * 60 + 1) / 60
    shape = current(END_ORGANS[kind], frequency, turn)
    currents = saturating(np.outer(shape, amplitudes), GAINS[kind])
    firing = SLOWED.fire(turn / frequency, currents, stimulus_driven=False)
    late = [times[times > 2.0] * frequency for times in firing.times]
    rates = [len(times) / (2.0 * frequency) for times in late]
    phases = [np.angle(np.mean(np.exp(2j * np.pi * times))) for times in late]
    apart = np.angle(np.exp(1j * (phases[0] - phases[1])))
    return abs(rates[0] - rates[1]), abs(float(np.degrees(apart)))


def same_rate(frequency: float, amplitude: float) -> float:
    """Return by how many dB the amplitude can vary with the same impulses per cycle (Fig. 5-3).

    Spring model, rates / 6; zero where there is no response.
    """
    steps = np.arange(-80, 81) * 0.25
    impulses = swing(SPRING, SLOWED, frequency, amplitude * 10.0 ** (steps / 20.0)).impulses
    if impulses[80] == 0.0:
        return 0.0
    other = np.flatnonzero(impulses != impulses[80])
    below, above = other[other < 80], other[other > 80]
    low = below.max() if len(below) else 0
    high = above.min() if len(above) else len(steps) - 1
    return 0.25 * float(high - low - 1)


def width(frequencies: tuple[float, ...], amplitude: float) -> float:
    """Return the mean of `same_rate` over frequencies."""
    return float(np.mean([same_rate(f, amplitude) for f in frequencies]))


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield phases, sensitivities, forces, and the arguments of 5.1."""
    for kind, frequencies in PHASED.items():
        for frequency in frequencies:
            name = f"4.3.4: phase of {kind} at {frequency:g} Hz"
            limits = Expected(closed_phase(kind, frequency), 1e-6, "degrees")
            source = "Eq. 4.3 and 4.6, by arctangents of the poles and zeros"
            yield Case(name, partial(phase, kind, frequency), limits, source, reason="rounding")
    yield from _sensitivity()
    yield from _forces()
    yield from _ratios()
    yield from _codes(quick=quick)


def _sensitivity() -> Iterator[Case]:
    source = f"{THESIS}4.3.4: moving the zero and the pole "
    for name, organ, other in (
        ("zero 0.1 to 0.5 Hz, pole 1 to 5 Hz", END_ORGANS["SAI"], END_ORGANS["SAII"]),
        ("pole 1 to 2 Hz", END_ORGANS["SAI"], PoleZero((0.1,), (2.0,))),
        ("zero 0.1 to 0.2 Hz", END_ORGANS["SAI"], PoleZero((0.2,), (1.0,))),
    ):
        title = f"4.3.4: SA filter, {name}: mean change of impulses per cycle, 0.5 to 64 Hz"
        measure = partial(magnitude_change, organ, other)
        origin = f"{source}hardly changes the magnitude"
        yield Case(title, measure, Expected.between(0.0, 0.15), origin, reason="fifteen percent")
        yield Case(
            f"4.3.4: SA filter, {name}: largest change of phase, 0.5 to 64 Hz",
            partial(phase_change, organ, other),
            Expected.between(9.0, 60.0, "degrees"),
            f"{source}changes the phase noticeably",
            reason="a fortieth of the cycle or more",
        )
    higher = PoleZero((0.0, 0.0), (10.0, 100.0))
    yield Case(
        "4.3.4: FA filter, poles 1 and 10 to 10 and 100 Hz: largest change of phase",
        partial(phase_change, END_ORGANS["FAI"], higher),
        Expected.between(30.0, 180.0, "degrees"),
        f"{THESIS}4.3.4: poles placed higher give an increasing lead in the phase",
        reason="far more than in the SA filter",
    )
    for frequency in (2.0, 8.0):
        yield Case(
            f"4.3.4: FA filter, {frequency:g} Hz: share in the retraction with the poles of FAII, "
            "less that with those of FAI",
            partial(later, "FAII", "FAI", frequency),
            Expected.between(0.2, 1.0),
            f"{THESIS}4.3.4: FAII was chosen to respond more to the retraction",
            reason="a fifth of the impulses or more",
        )


def _forces() -> Iterator[Case]:
    chain = realize(PoleZero((0.1,), (1.0,), 0.5))
    for kind in ("SAI", "FAI"):
        organ = PoleZero(END_ORGANS[kind].zeros, END_ORGANS[kind].poles, 0.5)
        name = f"4.4.1: serial {kind} model: response to a step of force after 10 s, over the first"
        measure = partial(held, under_force(organ, nerve=1.0, parallel=0.0), 10.0)
        source = f"{THESIS}4.4.1: in a serial chain every unit answers a force as the bare nerve"
        yield Case(name, measure, Expected(1.0, 1e-12), source, reason="rounding")
    yield Case(
        "4.4.1: FAI model with a parallel spring: response to a step of force after 10 s",
        partial(held, under_force(END_ORGANS["FAI"], nerve=1.0, parallel=1.0), 10.0),
        Expected.between(-0.01, 0.01),
        f"{THESIS}4.4.1, Fig. 4-18b: FA units do not respond to a constant force",
        reason="a hundredth of the first response",
    )
    yield Case(
        "4.4.1: SA chain with a parallel spring: response to a step of force after 60 s",
        partial(held, chain.force_filter(1.0), 60.0),
        Expected(1.0 / 7.0, 1e-6),
        "statics: the end organ (1/18 mN/mm by Eq. 4.5) bears its share late, the damper early",
        reason="the slowest pole has died away",
    )


def _ratios() -> Iterator[Case]:
    name = "5.1: springs k = m F + b, b of 1e-6 N/mm: change of x_nerve / x_in from 0.02 to 2 N"
    measure = partial(ratio_drift, 1e-6)
    source = f"{THESIS}Eqs. 5.1 to 5.7: with b near 0 the ratio stays constant"
    yield Case(name, measure, Expected.between(0.0, 0.05), source, reason="b = 0 gives none at all")
    name = "5.1: springs k = m F + b, b of 0.2 N/mm: change of x_nerve / x_in from 0.02 to 2 N"
    source = "Eq. 5.1 with b not near 0, as Table 2.1 has it: b = 0.19 N/mm in the mean"
    reason = "then the argument does not hold"
    yield Case(name, partial(ratio_drift, 0.2), Expected.between(0.2, 2.0), source, reason=reason)
    for nerve, exact in ((1.0, 1.5), (20.0, 1.025)):
        yield Case(
            f"5.8 as printed, over the exact share, nerve {nerve:g} times as stiff as the rest",
            partial(lambda k: (1.0 / (k * 2.0)) / float(spring(1.0, 1.0, k).gain), nerve),
            Expected(exact, 1e-12),
            "1 + k / kn, with k of skin and end organ in series",
            printed=1.0,
            erratum=(
                "Eq. 5.8 leaves the nerve out of the series: it is the limit of a stiff nerve. Its "
                "conclusion, a constant ratio, holds for the exact form as well."
            ),
            reason="rounding",
        )


def _codes(*, quick: bool) -> Iterator[Case]:
    yield Case(
        "5.1: FAII, 256 Hz, 1 against 0.25 mm peak to peak: difference in impulses per cycle",
        lambda: coded("FAII", (0.5, 0.125), 256.0)[0],
        Expected.between(0.0, 0.02),
        f"{THESIS}5.1: indistinguishable by rate",
        reason="one impulse in fifty cycles",
    )
    yield Case(
        "5.1: FAII, 256 Hz, 1 against 0.25 mm peak to peak: difference in phase",
        lambda: coded("FAII", (0.5, 0.125), 256.0)[1],
        Expected.between(5.0, 180.0, "degrees"),
        f"{THESIS}5.1: phase may be a code that tells them apart",
        reason="5 degrees are 54 us, 14 times the error of a spike time here",
    )
    if quick:
        return
    low = tuple(2.0**k for k in range(-1, 7))
    name = "5.1, Fig. 5-3: amplitude range with the same rate, 0.5 to 64 Hz, 0 dB less -12 dB"
    limits = Expected.between(0.0, 20.0, "dB")
    source = f"{THESIS}5.1: the range is quite large, particularly at higher amplitudes"
    yield Case(name, lambda: width(low, 50.0) - width(low, 12.5), limits, source, reason="larger")
    name = "5.1, Fig. 5-3: amplitude range with the same rate at 128 Hz, 0 dB"
    measure = partial(same_rate, 128.0, 50.0)
    source = f"{THESIS}5.1, note 1: quite small at 128 Hz and above"
    yield Case(name, measure, Expected.between(0.0, 3.0, "dB"), source, reason="a factor of 1.4")


def spring(skin: float, organ: float, nerve: float) -> PoleZero:
    """Filter of three springs in series (Fig. 4-4a): the nerve's share of a skin displacement.

    k_s k_e / (k_s k_e + k_n (k_s + k_e)); Eq. 5.8 prints its limit for a stiff nerve. Stiffnesses
    above 0, in any one unit. Three dampers in series (Fig. 4-5a) share in the same way.
    """
    return PoleZero((), (), skin * organ / (skin * organ + nerve * (skin + organ)))


def derivative(*poles: float) -> PoleZero:
    """Filter that is a derivative below its poles, one order per pole.

    One pole: velocity in mm/s, the damper model that thesis 4.3.3 closes with a pole at 10 to 100
    Hz. Two distinct poles: acceleration in mm/s². Poles in Hz.
    """
    return PoleZero((0.0,) * len(poles), poles, math.prod(2.0 * math.pi * p for p in poles))
