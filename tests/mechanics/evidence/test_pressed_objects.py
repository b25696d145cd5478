"""How deep a force presses: by presses that were measured, and beyond them as far as they grew."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import fefinger as ff
from fefinger.mechanics.evidence import measured_tissue, press_mesh, pressed_objects
from fefinger.mechanics.evidence.pressed_objects import neighbor_presses
from fefinger.mechanics.evidence.table import PRESS_MESH, read
from fefinger.mechanics.situation import Situation


def pressed(force: float, tissue: str = "maeno1998", indenter: object = None) -> ff.Scene:
    finger = ff.Finger.subject("a.h.", tissue=tissue)
    motion = ff.Ramp(loading_rate=40.0, force=force, corner=0.0)
    return ff.Scene(finger=finger, indenter=indenter or ff.Flat(30), motion=motion)


def part(*scene: Any) -> float:
    return Situation.of(pressed(*scene)).depth_over_thickness


@pytest.mark.parametrize(
    ("tissue", "press"), [("maeno1998", "maeno1998/flat-30"), ("calibrated_ah", "a.h./flat-30")]
)
def test_a_measured_force_goes_as_deep_as_it_did_and_more_goes_deeper(
    tissue: str, press: str
) -> None:
    row = read(PRESS_MESH)["rows"][press]
    for force, depth in list(zip(row["force_N"], row["depth_mm"], strict=True))[2::3]:
        found = part(force, tissue) * row["thickness_mm"]
        assert found == pytest.approx(depth, rel=1e-9)
    last, slope = row["depth_mm"][-1], np.diff(row["depth_mm"])[-1] / np.diff(row["force_N"])[-1]
    found = part(row["force_N"][-1] + 0.1, tissue) * row["thickness_mm"]
    assert found == pytest.approx(last + 0.1 * slope, rel=1e-9)


def test_between_two_objects_the_deeper_press_counts() -> None:
    low, high = (part(1.0, "maeno1998", ff.Flat(angle)) for angle in (15, 30))
    assert part(1.0, "maeno1998", ff.Flat(20)) == pytest.approx(max(low, high), rel=1e-12)
    assert part(1.0, "calibrated_ah", ff.Sphere(5.0)) > 1.5 * part(1.0, "calibrated_ah")


def test_an_object_like_no_press_counts_as_the_plate() -> None:
    steep = ff.Flat(30, tilt=45.0)
    assert not neighbor_presses(steep)[0]
    plate = part(1.0, "maeno1998")
    assert part(1.0, "maeno1998", steep) == pytest.approx(plate, rel=1e-12)


def test_forces_grow_with_the_modulus_and_the_square_of_the_size() -> None:
    finger = ff.Finger.subject("a.h.", tissue="maeno1998")
    (curve,) = pressed_objects.curves(finger, ff.Flat(30))
    stiff = replace(finger, subcutaneous=replace(finger.subcutaneous, modulus=68.0))
    once = pressed_objects.under_force(finger, 0.5, [curve])
    assert pressed_objects.under_force(stiff, 1.0, [curve]) == pytest.approx(once)
    large = ff.Finger(14.0, 20.0, tissue="maeno1998")
    assert pressed_objects.under_force(large, 2.0, [curve]) == pytest.approx(once)


def test_only_an_unchanged_finger_is_that_of_the_subject() -> None:
    assert measured_tissue.subject(ff.Finger.subject("a.h.")) == "a.h."
    changed = ff.Finger.subject("a.h.", nail="free")
    assert measured_tissue.subject(changed) is None
    assert measured_tissue.subject(ff.Finger.subject("a.h.", tissue="maeno1998")) is None


def test_under_a_force_each_press_is_read_at_the_depth_that_it_has_itself() -> None:
    case = Situation.of(pressed(0.08, "maeno1998", ff.Sphere(3.0)))
    curves = {curve.object: curve for curve in case.force_curves}
    assert set(curves) == {"sphere-2", "sphere-5"}
    found = {
        name: press_mesh._reached(curve, case) * curve.conditions["thickness_mm"]
        for name, curve in curves.items()
    }
    for name, curve in curves.items():
        assert np.interp(found[name], curve.depth, curve.values) == pytest.approx(0.08)
    assert found["sphere-2"] > 1.2 * found["sphere-5"]
