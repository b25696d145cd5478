"""How deep a force presses: by presses that were measured, and beyond them as far as they grew."""

import numpy as np
import pytest

import fefinger as ff
from fefinger.mechanics.evidence import reached_depth
from fefinger.mechanics.evidence.table import LUMPED, TRADEOFF, read
from fefinger.mechanics.situation import Situation


def pressed(force: float, tissue: str = "maeno1998", indenter: object = None) -> ff.Scene:
    finger = ff.Finger.subject("a.h.", tissue=tissue)
    motion = ff.ForceRamp(40.0, force, corner=0.0)
    return ff.Scene(finger=finger, indenter=indenter or ff.Flat(30), motion=motion)


def test_a_measured_force_goes_as_deep_as_it_did_and_more_goes_deeper() -> None:
    row = read(TRADEOFF)["rules"]["presses"]["flat-30"]
    for force, depth in list(zip(row["force_N"], row["depth_mm"], strict=True))[2::3]:
        found = Situation.of(pressed(force)).deepest("flat-30") * row["thickness_mm"]
        assert found == pytest.approx(depth, rel=1e-9)
    last, slope = row["depth_mm"][-1], np.diff(row["depth_mm"])[-1] / np.diff(row["force_N"])[-1]
    found = Situation.of(pressed(row["force_N"][-1] + 0.1)).deepest("flat-30") * row["thickness_mm"]
    assert found == pytest.approx(last + 0.1 * slope, rel=1e-9)


def test_a_calibrated_finger_goes_as_deep_as_its_own_curve_says() -> None:
    """By its modulus at rest, which then stiffens, it would go 2.5 times as deep."""
    press = reached_depth.calibrated(ff.Finger.subject("a.h.", tissue="calibrated_ah"))
    assert press == "calibrated a.h."
    own = read(LUMPED)["calibrated"]["a.h."]
    depth = float(np.interp(1.0, own["force_N"], own["depth_mm"]))
    found = Situation.of(pressed(1.0, "calibrated_ah")).deepest("flat-30")
    assert found == pytest.approx(depth / 10.0, rel=1e-9)
    ball = Situation.of(pressed(1.0, "calibrated_ah", ff.Sphere(5.0))).deepest("sphere-5")
    assert ball > 2 * found
    changed = ff.Finger.subject("a.h.", tissue="calibrated_ah", nail="free")
    assert reached_depth.calibrated(changed) == ""
    assert reached_depth.calibrated(ff.Finger.subject("a.h.", tissue="maeno1998")) == ""
