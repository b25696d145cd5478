"""What is wrong with a record or its rig, recognized by its trace, in words and with numbers."""

from collections.abc import Iterator

import numpy as np

from fefinger.calibration.inverse import Values
from fefinger.calibration.record_target import RecordTarget
from fefinger.support.arrays import Array
from fefinger.theory.lumped.ramp_hold import SMOOTHING, STEPPED, smooth


SURE = 3.0
"""Standard deviations from 0 from which a fault of the rig is told."""

SEEN = {"delay": 0.1, "offset": 5.0, "drift": 2.0}
"""Sizes in ms, mN and mN/s below which faults of a rig are not told, as they are in the fit."""

WORDS = {
    "delay": "the force is {value:.3g} +- {sd:.2g} ms late behind the position",
    "offset": "the force reads {value:.3g} +- {sd:.2g} mN without contact",
    "drift": "the force drifts by {value:.3g} +- {sd:.2g} mN/s",
}

CONTACT = 0.02
"""Part of the largest force from which a record is in contact, as in `ramp_hold.split`."""

AT_TOP = 5
"""Successive samples at the largest force that noise does not give."""

SHORT = 0.02
"""Time in s of a rest before touch below which the offset of the force is hardly known."""

FEW = 60
"""Samples of a ramp in contact below which its force is coarse, as the corner is."""

GIVES = 0.05
"""Standard deviation in mm/N of the give that a position of a motor may include."""


def findings(target: RecordTarget, values: Values, deviations: Values) -> tuple[str, ...]:
    """Return sentences on a record and its rig; values and deviations of its fit."""
    found = [
        *_of_rig(target, values, deviations),
        *_before_touch(target),
        *_on_the_ramp(target),
        *_saturated(target.record.force),
        *_sampled(target, values),
    ]
    which = target.press.strip()
    return tuple(f"press {which}: {each}" if which else each for each in found)


def _of_rig(target: RecordTarget, values: Values, deviations: Values) -> Iterator[str]:
    for each in target.rig.unknowns(target.press):
        what = each.name.removesuffix(target.press)
        value, sd = values[each.name], deviations[each.name]
        if what in WORDS and abs(value) > max(SURE * sd, SEEN[what]):
            yield f"{WORDS[what].format(value=value, sd=sd)}, which the fit takes into account"


def _before_touch(target: RecordTarget) -> Iterator[str]:
    """Tell of a missing rest before touch, and of an earlier touch."""
    record = target.record
    limit = max(2 * target.noise[0], CONTACT * float(record.force.max()))
    before = smooth(record.force)[: record.touch]
    above = np.flatnonzero(before > limit)
    if above.size and above[-1] < record.touch - SMOOTHING:
        at = int(np.argmax(before))
        yield (
            f"two touches: {before[at]:.2g} N already at {record.time[at]:.3g} s, and contact for "
            f"good from {record.time[record.touch]:.3g} s on; the tissue has not recovered, so "
            "wait longer between them, or cut the first out"
        )
    free = float(record.time[max(record.touch - 1, 0)] - record.time[0])
    if free < SHORT:
        yield (
            f"no free stretch: {1e3 * free:.2g} ms before touch; offset and noise of the force are "
            "hardly known, begin the record some 100 ms earlier"
        )


def _on_the_ramp(target: RecordTarget) -> Iterator[str]:
    """Tell of a force that falls while the indenter goes in: it slips, or the finger yields."""
    record = target.record
    ramp = slice(record.touch, max(record.beyond - SMOOTHING, record.touch))
    forward = np.diff(smooth(record.position)[ramp]) > 0
    force = smooth(record.force)[ramp]
    if len(force) < SMOOTHING:
        return
    fallen = np.maximum.accumulate(force) - force
    at = int(np.argmax(fallen))
    limit = max(3 * target.noise[0], CONTACT * float(record.force.max()))
    if fallen[at] > limit and forward[: max(at, 1)].mean() > 0.5:
        yield (
            f"slip: the force falls by {fallen[at]:.2g} N until {record.time[ramp][at]:.4g} s, "
            f"{1e3 * (record.time[ramp][at] - record.time[record.touch]):.2g} ms after touch, "
            "while the indenter goes in; fix the finger, or dry it"
        )


def _saturated(force: Array) -> Iterator[str]:
    """Tell of a sensor at the end of its range."""
    largest = float(force.max())
    at_top = np.diff((force == largest).astype(np.int8), prepend=0, append=0)
    longest = int((np.flatnonzero(at_top < 0) - np.flatnonzero(at_top > 0)).max())
    same = np.diff(force[force > largest / 2]) == 0
    if longest >= AT_TOP and same.mean() < STEPPED:
        yield (
            f"saturated sensor: {longest} successive samples read {largest:.4g} N, its largest; "
            "use a range that is wider, or press less"
        )


def _sampled(target: RecordTarget, values: Values) -> Iterator[str]:
    record = target.record
    count = record.hold - record.touch
    rate = values.get("v1", 0.0)
    step = float(np.median(np.diff(record.time[record.touch : record.hold + 1])))
    if count < FEW or rate * step > 1:
        yield (
            f"sampling: {count} samples on the ramp in contact, one every {1e3 * step:.3g} ms, and "
            f"the fastest term fades in {1e3 / max(rate, 1e-9):.3g} ms; sample faster, or ramp "
            "more slowly"
        )


def of_motor(value: float, sd: float) -> tuple[str, ...]:
    """Return a sentence on a give in mm/N that a fit finds, () where there is none."""
    if value <= SURE * sd:
        return ()
    return (
        f"position of the motor: the record is met better if the position includes {value:.2g} +- "
        f"{sd:.2g} mm/N of the rig's own give; press a stiff block with the rig, and give what you "
        "find as `compliance` in --rig",
    )
