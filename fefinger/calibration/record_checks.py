"""What is wrong with a record or its rig, recognized by its trace, in words and with numbers."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from fefinger.calibration.inverse import Values
from fefinger.calibration.record_target import RecordTarget
from fefinger.calibration.rig import SHARED
from fefinger.theory.lumped.ramp_hold import SMOOTHING, STEPPED, RampHold, smooth


SEEN = {"delay": 0.1, "lag": 0.1, "compliance": 5e-3, "offset": 5.0, "drift": 2.0}
"""Sizes in the units of a Rig below which its faults are not told, as they are in the fit."""

WORDS = {
    "delay": "late force: it is {value:.3g} +- {sd:.2g} ms behind the position",
    "lag": "low-pass: the force passes one of {value:.2g} +- {sd:.2g} ms",
    "compliance": "position of the motor: it includes {value:.2g} +- {sd:.2g} mm/N of rig",
    "offset": "offset: the force reads {value:.3g} +- {sd:.2g} mN without contact",
    "drift": "drift: the force changes by {value:.3g} +- {sd:.2g} mN/s",
}

MORE = {
    "lag": "; turn the filter of the sensor off, or give its time constant as `lag` in --rig",
    "compliance": "; press a stiff block with the rig, and give what you find as `compliance` in "
    "--rig",
}
"""What to do about faults that the fit takes into account less well than a measurement would."""

CONTACT = 0.02
"""Part of the largest force from which a record is in contact, as in `ramp_hold.split`."""

CERTAIN = 6.0
"""Standard deviations of a smoothed force that its noise does not reach in a record."""

AVERAGED = 0.1
"""Time in s of an average by which the color of noise is told."""

AT_TOP = 5
"""Successive samples at the largest force that noise does not give."""


class Finding(NamedTuple):
    """A sentence on a record, and the time in s at which the record shows it, if at one."""

    text: str
    time: float | None = None

    @property
    def name(self) -> str:
        """The first words of the sentence."""
        return self.text.partition(":")[0]


def findings(target: RecordTarget, values: Values, deviations: Values) -> tuple[Finding, ...]:
    """List the faults of a record and its rig; values and deviations of its fit."""
    found = [
        *_of_rig(target, values, deviations),
        *_of_noise(target),
        *_before_touch(target),
        *_on_the_ramp(target, values),
        *_saturated(target.record),
        *_sampled(target, values),
    ]
    return tuple(found)


def told(target: RecordTarget, found: Iterable[Finding]) -> tuple[str, ...]:
    """Return the sentences on a record, which name the press if it is not the first."""
    which = target.press.strip()
    return tuple(f"press {which}: {each.text}" if which else each.text for each in found)


def marks(found: Iterable[Finding]) -> tuple[tuple[float, str], ...]:
    """Return times in s and names of what the record shows at a time."""
    return tuple((each.time, each.name) for each in found if each.time is not None)


def is_seen(name: str, value: float, sd: float) -> bool:
    """Whether a rig does something beyond doubt, and enough to be told; in the units of a Rig."""
    sure = 3.0  # standard deviations from 0 from which a fault of the rig is told
    return abs(value) > max(sure * sd, SEEN[name])


def _of_rig(target: RecordTarget, values: Values, deviations: Values) -> Iterator[Finding]:
    record = target.record
    for each in target.rig.unknowns(target.press):
        what = each.name.removesuffix(target.press)
        value, sd = values[each.name], deviations[each.name]
        if is_seen(what, value, sd) and not (target.press and what in SHARED):
            words = WORDS[what].format(value=value, sd=sd)
            text = f"{words}, which the fit takes into account{MORE.get(what, '')}"
            place = record.hold if what in SHARED else 0
            yield Finding(text, float(record.time[place]))


def _of_noise(target: RecordTarget) -> Iterator[Finding]:
    """Tell of noise that averages do not lessen."""
    noise, record = target.force_noise, target.record
    step = float(np.median(np.diff(record.time)))
    count = min(max(round(AVERAGED / step), 1), len(record.time))
    more = noise.of_average(count) * np.sqrt(count) / noise.sd
    if noise.colored and more > 1:
        yield Finding(
            f"colored noise: an average of the force over {count * step:.2g} s is {more:.2g} times "
            "less sure than with white noise of its size, which the deviations include; look for "
            "hum, a filter, or a sensor that warms up"
        )


def _smoothed_noise(target: RecordTarget) -> float:
    """Return the standard deviation in N of the noise of a smoothed force."""
    return target.force_noise.of_average(SMOOTHING)


def _before_touch(target: RecordTarget) -> Iterator[Finding]:
    """Tell of a missing rest before touch, and of an earlier touch."""
    record = target.record
    limit = max(CERTAIN * _smoothed_noise(target), CONTACT * float(record.force.max()))
    before = smooth(record.force)[: record.touch]
    above = np.flatnonzero(before > limit)
    if above.size and above[-1] < record.touch - SMOOTHING:
        at = int(np.argmax(before))
        when = float(record.time[at])
        yield Finding(
            f"two touches: {before[at]:.2g} N already at {when:.3g} s, and contact for good from "
            f"{record.time[record.touch]:.3g} s on; the tissue has not recovered, so wait longer "
            "between them, or cut the first out",
            when,
        )
    free = float(record.time[max(record.touch - 1, 0)] - record.time[0])
    # Time in s of a rest before touch below which the offset of the force is hardly known.
    short = 0.02
    if free < short:
        yield Finding(
            f"no free stretch: {1e3 * free:.2g} ms before touch; offset and noise of the force are "
            "hardly known, begin the record some 100 ms earlier",
            float(record.time[0]),
        )


def _on_the_ramp(target: RecordTarget, values: Values) -> Iterator[Finding]:
    """Tell of a force that falls while the indenter goes in: it slips, or the finger yields.

    A force that is ahead of the position falls before the hold.
    """
    record = target.record
    ahead = 1e-3 * min(target.rig.at(values, target.press)["delay"], 0.0)
    end = int(np.searchsorted(record.time, record.time[record.beyond] + ahead)) - SMOOTHING
    ramp = slice(record.touch, max(end, record.touch))
    forward = np.diff(smooth(record.position)[ramp]) > 0
    force = smooth(record.force)[ramp]
    if len(force) < SMOOTHING:
        return
    fallen = np.maximum.accumulate(force) - force
    at = int(np.argmax(fallen))
    falls = np.sqrt(2) * CERTAIN * _smoothed_noise(target)
    limit = max(falls, CONTACT * float(record.force.max()))
    if fallen[at] > limit and forward[: max(at, 1)].mean() > 0.5:
        when = float(record.time[ramp][at])
        yield Finding(
            f"slip: the force falls by {fallen[at]:.2g} N until {when:.4g} s, "
            f"{1e3 * (when - record.time[record.touch]):.2g} ms after touch, while the indenter "
            "goes in; fix the finger, or dry it",
            when,
        )


def _saturated(record: RampHold) -> Iterator[Finding]:
    """Tell of a sensor at the end of its range."""
    force = record.force
    largest = float(force.max())
    at_top = np.diff((force == largest).astype(np.int8), prepend=0, append=0)
    starts = np.flatnonzero(at_top > 0)
    lengths = np.flatnonzero(at_top < 0) - starts
    longest = int(lengths.max())
    same = np.diff(force[force > largest / 2]) == 0
    if longest >= AT_TOP and same.mean() < STEPPED:
        yield Finding(
            f"saturated sensor: {longest} successive samples read {largest:.4g} N, its largest; "
            "use a range that is wider, or press less",
            float(record.time[starts[lengths.argmax()]]),
        )


def _sampled(target: RecordTarget, values: Values) -> Iterator[Finding]:
    record = target.record
    count = record.hold - record.touch
    rate = values.get("v1", 0.0)
    step = float(np.median(np.diff(record.time[record.touch : record.hold + 1])))
    few = 60  # samples of a ramp in contact below which its force is coarse, as the corner is
    if count < few or rate * step > 1:
        yield Finding(
            f"sampling: {count} samples on the ramp in contact, one every {1e3 * step:.3g} ms, and "
            f"the fastest term fades in {1e3 / max(rate, 1e-9):.3g} ms; sample faster, or ramp "
            "more slowly"
        )
