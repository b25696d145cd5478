"""Faults of a record and its rig are told by their trace, with the number, and no other is."""

import numpy as np
import pytest
from scipy.signal import lfilter

from fefinger.calibration import record_file
from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.outcome import findings, told
from fefinger.calibration.rig import Rig
from fefinger.theory.relaxation import Prony


PRONY = Prony((0.3, 0.42, 0.16, 0.12), (220.0, 9.0, 0.6))
FIT = {"x0": 0.4, "delay": 0.02, "offset": 0.3, "drift": 0.1, "v1": 220.0}
SURE = dict.fromkeys(FIT, 0.05)


def press(law, rest=0.1, rate=5e3):
    """Return a record (n_t, 3): s, mm and N, with the noise of a good rig."""
    time = np.arange(0.0, 2.0, 1 / rate)
    path = np.clip(60 * (time - rest), 0.0, 1.8)
    force = ForceLaw(law.at(2.4, 14.0), PRONY, 0.7).loading(time, path - 0.4)
    off = 2e-3 * np.random.default_rng(0).normal(size=(2, len(time)))
    return np.column_stack([time, path + off[0], force + off[1]])


def warming(table):
    """Add noise of 4 mN that fades within 20 ms."""
    rng = np.random.default_rng(1)
    kept = np.exp(-np.median(np.diff(table[:, 0])) / 0.02)
    wander = lfilter([np.sqrt(1 - kept**2)], [1, -kept], rng.normal(size=len(table)))
    table[:, 2] += 4e-3 * wander
    return table


def ahead(table):
    """Let the force come 5 ms before the position, so that it falls before the hold."""
    table[:, 2] = np.interp(table[:, 0] + 5e-3, table[:, 0], table[:, 2])
    return table


def touched_before(table):
    first = (table[:, 0] > 0.02) & (table[:, 0] < 0.06)
    table[first, 2] += 0.3 * np.sin(np.pi * (table[first, 0] - 0.02) / 0.04)
    return table


def slipped(table):
    late = table[:, 0] - 0.124
    table[late > 0, 2] *= 1 - 0.4 * np.exp(-late[late > 0] / 0.004)
    return table


def saturated(table):
    top = 0.97 * table[:, 2].max()
    return np.column_stack([table[:, :2], np.minimum(table[:, 2], top)])


def begun_late(table):
    return table[table[:, 0] > 0.105]


FAULTS = {
    "none": (lambda t: t, {}, ()),
    "late": (lambda t: t, {"delay": 1.98}, ("late force: ", "1.98 +- 0.05 ms")),
    "early": (ahead, {"delay": -5.0}, ("late force: ", "-5 +- 0.05 ms")),
    "colored": (warming, {}, ("colored noise: an average of the force over 0.1 s is ",)),
    "offset": (lambda t: t, {"offset": -20.0}, ("offset: ", "-20 +- 0.05 mN")),
    "drift": (lambda t: t, {"drift": 8.0}, ("drift: ", "8 +- 0.05 mN/s")),
    "two touches": (touched_before, {}, ("two touches: 0.3 N already at 0.03",)),
    "slip": (slipped, {}, ("slip: the force falls by",)),
    "saturated": (saturated, {}, ("saturated sensor: ",)),
    "no rest": (begun_late, {}, ("no free stretch: ",)),
    "slow sampling": (lambda t: t[::5], {}, ("sampling: 2", "samples on the ramp")),
}


@pytest.mark.parametrize(("spoil", "values", "words"), FAULTS.values(), ids=FAULTS)
def test_a_fault_is_told_and_no_other(law, spoil, values, words):
    table = spoil(press(law))
    target = record_file.made("twin", *table.T, "coarse")
    found = findings(target, FIT | values, SURE)
    assert len(found) == bool(words)
    for word in words:
        assert word in found[0].text


def test_a_press_of_several_is_named_and_what_they_share_is_told_once(law):
    rig = Rig(compliance=(0.0, 0.05), lag=(0.0, 2.0))
    values = {"offset 2": 30.0, "drift 2": 0.0, "x0 2": 0.4, "compliance": 0.04, "lag": 3.0}
    values |= FIT | {"delay": 2.0, "offset": 0.0}
    sure = dict.fromkeys(values, 0.005)
    first, second = (
        record_file.made("twin", *press(law).T, "coarse", rig, press=each) for each in ("", " 2")
    )
    (one,) = told(second, findings(second, values, sure))
    assert one.startswith("press 2: offset: the force reads 30 ")
    found = [each.name for each in findings(first, values, sure)]
    assert found == ["late force", "low-pass", "position of the motor"]
    assert findings(first, values | {"compliance": 0.01, "lag": 0.01}, sure)[1:] == ()
