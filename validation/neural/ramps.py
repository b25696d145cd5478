"""Thesis 4.3.5: ramp, hold and retract at 2, 8 and 32 mm/s with corners of 10 ms."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.neural.filters import derivative
from fefinger.validation.neural.sweep import SPRING

from fefinger.neural.endorgans import END_ORGANS, GAINS, GENERATOR_BY_NAME, Organ
from fefinger.neural.membranes import HodgkinHuxley
from fefinger.scene.motions import Trapezoid
from fefinger.support.arrays import Array


SPEEDS = (2.0, 8.0, 32.0)
DEPTH, HOLD, CORNER, AFTER = 2.0, 1.0, 0.01, 0.3
"""mm (2 to 3 in the experiment), s, s, and s of rest after the probe has left."""

STEP = 2e-4
"""s between the samples of the current."""

MODELS: dict[str, tuple[Organ, float]] = {
    "spring": (SPRING, 50.0),
    "damper": (derivative(100.0), 3.0),
    "SAI": (END_ORGANS["SAI"], 50.0),
    "SAII": (END_ORGANS["SAII"], 50.0),
    "FAI": (END_ORGANS["FAI"], 200.0),
    "FAII": (END_ORGANS["FAII"], 5e4),
}
"""End organ and linear gain in uA/cm² per mm (damper: per mm/s). The largest one that keeps every
current of the three ramps below block; spring, SAI and SAII share one, as 4.2.1 has it."""

RULE = {kind: (END_ORGANS[kind], gain) for kind, gain in GAINS.items()}

FIRST = {"SAI": 16.3014, "SAII": 16.7564}
"""ms: first impulse at 8 mm/s by order 8 at rtol 1e-10."""

THESIS = "Pawluk (1997), 4.3.5"


@dataclass(frozen=True)
class Course:
    """What a ramp, hold and retraction does to a unit: signals (n_t,) and spike times in s.

    retract: when the probe starts back; back: when the last corner begins, before it is at 0.
    """

    time: Array
    depth: Array
    current: Array
    spikes: Array
    reached: float
    retract: float
    back: float
    end: float

    def between(self, start: float, stop: float) -> Array:
        """Return the spikes from `start` up to `stop`."""
        return self.spikes[(self.spikes >= start) & (self.spikes < stop)]


@cache
def course(
    name: str,
    speed: float,
    *,
    rule: bool = False,
    generator: str = "linear",
    divisor: float = 6.0,
    method: str = "runge-kutta",
) -> Course:
    """Return the answer of a model; with `rule` at the gain of `neural.gains`."""
    organ, gain = (RULE if rule else MODELS)[name]
    motion = Trapezoid(speed=speed, depth=DEPTH, hold=HOLD, corner=CORNER)
    end = motion.duration
    corners = np.concatenate([np.linspace(b, b + CORNER, 101) for b in motion.breakpoints])
    kinks = np.unique(np.append(corners[corners < end], [end, end + AFTER]))
    bent = np.where(kinks <= end, motion.value(np.minimum(kinks, end)), 0.0)
    time = np.linspace(0.0, end + AFTER, int((end + AFTER) / STEP) + 1)
    depth = np.interp(time, kinks, bent)
    current = GENERATOR_BY_NAME[generator](np.maximum(organ.respond(kinks, bent, time), 0.0), gain)
    membrane = HodgkinHuxley(divisor)
    (spikes,) = membrane.fire(time, current, method=method, stimulus_driven=False).times
    breaks = motion.breakpoints
    return Course(time, depth, current, spikes, breaks[3], breaks[-4], breaks[-2], end)


def in_ramp(name: str, speed: float) -> float:
    """Return the highest rate in Hz up to the hold: one over the interval; 0 for one impulse."""
    response = course(name, speed)
    return fastest(response.between(0.0, response.reached + 0.02))


def fastest(spikes: Array) -> float:
    """Return one over the shortest interval in Hz, 0 with fewer than two spikes."""
    return float(1.0 / np.diff(spikes).min()) if len(spikes) > 1 else 0.0


def in_hold(name: str, speed: float, divisor: float = 6.0) -> float:
    """Return the mean rate in Hz in the last 0.6 s of the hold."""
    response = course(name, speed, divisor=divisor)
    late = response.between(response.retract - 0.6, response.retract)
    return float(1.0 / np.diff(late).mean()) if len(late) > 1 else 0.0


def retracting(name: str, speed: float, **options: Any) -> float:
    """Return the impulses from the start of the retraction until the probe is almost out."""
    response = course(name, speed, **options)
    return float(len(response.between(response.retract + CORNER, response.back)))


def holding(name: str, speed: float) -> float:
    """Return the impulses in the hold, from 50 ms after its start on."""
    response = course(name, speed)
    return float(len(response.between(response.reached + 0.05, response.retract)))


def returning(name: str, speed: float) -> float:
    """Return the impulses from the last corner on, when the probe comes back to zero."""
    response = course(name, speed)
    return float(len(response.between(response.back, response.end + AFTER)))


def rise(measure: Callable[[str, float], float], name: str, speeds: tuple[float, ...]) -> float:
    """Return the smallest increase of a measure from one speed to the next."""
    return float(np.diff([measure(name, speed) for speed in speeds]).min())


def first(name: str, speed: float) -> float:
    """Return the time of the first spike in ms."""
    return float(1e3 * course(name, speed).spikes[0])


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the claims."""
    yield from _slow()
    yield from _spring()
    yield from _fast()
    yield from _faster()


def _spring() -> Iterator[Case]:
    for speed in (2.0, 8.0):
        name = f"4.3.5, Fig. 4-13: spring, {speed:g} mm/s: impulses in the retraction"
        measure = partial(retracting, "spring", speed)
        source = f"{THESIS}: the spring model goes on well into the retraction"
        yield Case(name, measure, Expected.between(3.0, 40.0), source, reason="three or more")
    yield Case(
        "4.3.5, Fig. 4-13: spring, 2 mm/s: highest rate in the ramp, over that in the hold",
        lambda: in_ramp("spring", 2.0) / in_hold("spring", 2.0),
        Expected.between(0.0, 1.02),
        f"{THESIS}: the rate of the spring model rises until the steady input and stays",
        reason="the last interval of the ramp is that of the hold",
    )


def _slow() -> Iterator[Case]:
    for name in ("SAI", "SAII"):
        figure = "a" if name == "SAI" else "b"
        for speed in SPEEDS:
            title = f"4.3.5, Fig. 4-14{figure}: {name}, {speed:g} mm/s: impulses in the retraction"
            measure = partial(retracting, name, speed)
            source = f"{THESIS}: neither SA model continues to respond into the retraction"
            yield Case(title, measure, Expected.between(0.0, 0.0), source, reason="none")
            yield Case(
                f"4.3.5, Fig. 4-14{figure}: {name}, {speed:g} mm/s: rate in the ramp over the hold",
                partial(
                    lambda name, speed: in_ramp(name, speed) / in_hold(name, speed), name, speed
                ),
                Expected.between(1.05, 3.0),
                f"{THESIS}: both SA models fire faster in the ramp than in the hold",
                reason="five percent faster or more",
            )
            yield Case(
                f"4.3.5, Fig. 4-14{figure}: {name}, {speed:g} mm/s: rate in the hold",
                partial(in_hold, name, speed),
                Expected.between(10.0, 30.0, "Hz"),
                f"{THESIS}: both SA models have a static response",
                reason="from the onset of the slowed membrane to its fastest",
            )
        yield Case(
            f"4.3.5: {name}: smallest rise of the rate in the ramp from one speed to the next",
            partial(rise, in_ramp, name, SPEEDS),
            Expected.between(0.3, 20.0, "Hz"),
            f"{THESIS}: the rate in the ramp rises with the speed",
            reason="it rises at each step",
        )
    for speed, expected in ((2.0, 4.0), (8.0, 0.0), (32.0, 0.0)):
        yield Case(
            f"4.3.5: SAII at the default gain, {speed:g} mm/s: impulses in the retraction",
            partial(retracting, "SAII", speed, rule=True, generator="saturating"),
            Expected(expected, 0.0),
            "order 8, rtol 1e-10",
            printed=0.0,
            erratum=(
                "At 2 mm/s the filter of SAII (pole 5 Hz) follows the retraction, and its hold is "
                "far enough above the onset to go on firing on the way out. Silent from 8 mm/s on."
            )
            if expected
            else "",
            reason="a count",
        )
    for name, expected in FIRST.items():
        title = f"4.3.5: {name}, 8 mm/s: first impulse"
        limits = Expected(expected, 1e-4, "ms")
        reason = "the error of Runge-Kutta at 50 us"
        yield Case(title, partial(first, name, 8.0), limits, "order 8, rtol 1e-10", reason=reason)


def _fast() -> Iterator[Case]:
    for name, figure in (
        ("damper", "Fig. 4-16: "),
        ("FAI", "Fig. 4-17: "),
        ("FAII", "left open: "),
    ):
        for speed in SPEEDS:
            title = f"4.3.5, {figure}{name}, {speed:g} mm/s: impulses in the hold"
            measure = partial(holding, name, speed)
            source = f"{THESIS}: FA units have no static response"
            yield Case(title, measure, Expected.between(0.0, 0.0), source, reason="none")
            title = f"4.3.5, {figure}{name}, {speed:g} mm/s: impulses between retraction and return"
            measure = partial(retracting, name, speed)
            source = f"{THESIS}: the damper model and FAI do not respond to the retraction"
            yield Case(title, measure, Expected.between(0.0, 0.0), source, reason="none")
    for name, figure in (("damper", "Fig. 4-16: "), ("FAI", "Fig. 4-17: ")):
        title = f"4.3.5, {figure}{name}: rise of the rate in the ramp from 8 to 32 mm/s"
        measure = partial(rise, in_ramp, name, (8.0, 32.0))
        source = f"{THESIS}: the firing rate upon indentation increases with velocity"
        yield Case(title, measure, Expected.between(1.0, 30.0, "Hz"), source, reason="it rises")
    for name, speed, expected in (
        *(("damper", speed, 0.0) for speed in SPEEDS),
        *(("FAI", speed, count) for speed, count in zip(SPEEDS, (1.0, 2.0, 3.0), strict=True)),
        *(("FAII", speed, 1.0) for speed in SPEEDS),
    ):
        silent = expected == 0.0
        yield Case(
            f"4.3.5: {name}, {speed:g} mm/s: impulses on the return to zero",
            partial(returning, name, speed),
            Expected(expected, 0.0),
            "order 8, rtol 1e-10",
            printed=None if silent else 0.0,
            erratum=""
            if silent
            else (
                "The probe stops at zero: a second-order filter answers that deceleration as it "
                "answers a touch. The thesis expects no response from the models here; the "
                "recorded FA units have one."
            ),
            reason="a count",
        )


def _faster() -> Iterator[Case]:
    note = f"{THESIS}: recorded rates are higher, so the rates were divided by too much"
    for divisor, least in ((4.0, 1.2), (3.0, 1.5)):
        yield Case(
            f"4.3.5: SAI, 8 mm/s: rate in the hold with rates / {divisor:g}, over that with / 6",
            partial(lambda divisor: in_hold("SAI", 8.0, divisor) / in_hold("SAI", 8.0), divisor),
            Expected.between(least, 6.0 / divisor),
            note,
            reason="less than in proportion: the membrane equation is not slowed",
        )
        name = f"4.3.5: SAI, 8 mm/s, rates / {divisor:g}: impulses in the retraction"
        measure = partial(retracting, "SAI", 8.0, divisor=divisor)
        source = f"{THESIS}: this is not expected to change the results qualitatively"
        yield Case(name, measure, Expected.between(0.0, 0.0), source, reason="none")
