"""The evidence that the planner reads: what it is derived from, and depths under a force."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fefinger.validation.evidence import derive

import fefinger as ff
from fefinger.mechanics.evidence import presses
from fefinger.mechanics.evidence.presses import EVIDENCE, read
from fefinger.mechanics.situation import Situation


REPORTS = Path(__file__).resolve().parents[3] / "reports"


@pytest.fixture(scope="module")
def derived() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(json.dumps(derive.joined(REPORTS)))
    return found


def test_the_report_is_what_the_measured_ones_give(derived) -> None:
    held = read(EVIDENCE)["presses"]
    assert derived.keys() == held.keys()
    for name, press in derived.items():
        assert press["features"]["numbers"] == pytest.approx(
            held[name]["features"]["numbers"], abs=2e-4
        )
        for label, row in press["errors"].items():
            for quantity, values in row.items():
                found = np.array(values, dtype=float)
                known = np.array(held[name]["errors"][label][quantity], dtype=float)
                # Numbers of two digits, rounded from what another machine may round otherwise.
                np.testing.assert_allclose(found, known, rtol=0.11)


def test_a_press_keeps_the_errors_that_were_measured(derived) -> None:
    measured = read("press-mesh.json")["rows"]["a.h./sphere-5"]
    press = derived["a.h./sphere-5"]
    for label in ("layered", "linear coarse", "solid standard"):
        for quantity in ("force", "area"):
            kept, known = press["errors"][label][quantity], measured["errors"][label][quantity]
            np.testing.assert_allclose(kept, known, rtol=0.051)  # two digits
    assert press["force_N"] == pytest.approx(measured["force_N"])
    (whole,) = (each for each in presses.presses() if each.name == "a.h./sphere-5")
    tabulated, mesh = (whole.errors[f"{name} coarse"]["force"] for name in ("pressed", "solid"))
    assert (tabulated > mesh).all()
    assert (np.hypot(mesh, 0.03) > tabulated).all()


def test_the_factors_are_those_of_the_scenes_today() -> None:
    found = derive.factors(REPORTS)
    for mechanics, row in read(EVIDENCE)["factors"].items():
        assert found[mechanics] == pytest.approx(row, rel=0.02)


def test_every_press_has_numbers_and_a_force_that_grows() -> None:
    every = presses.presses()
    assert len(every) > 70
    for press in every:
        assert (np.diff(press.part) > 0).all()
        assert (np.diff(press.force) > 0).all()
        for row in press.errors.values():
            for errors in row.values():
                assert errors.shape == press.part.shape
                assert not (errors < 0).any()


def pressed(force: float, tissue_set: str = "maeno1998", indenter: object = None) -> ff.Scene:
    finger = ff.Finger.subject("a.h.", tissue=tissue_set)
    motion = ff.Ramp(loading_rate=40.0, force=force, corner=0.0)
    return ff.Scene(finger=finger, indenter=indenter or ff.Flat(30), motion=motion)


def part(*scene: Any) -> float:
    return Situation.of(pressed(*scene)).depth_over_thickness


@pytest.mark.parametrize(
    ("name", "press"), [("maeno1998", "maeno1998/flat-30"), ("calibrated_ah", "a.h./flat-30")]
)
def test_a_measured_force_goes_as_deep_as_it_did_and_more_goes_deeper(
    name: str, press: str
) -> None:
    row = read(EVIDENCE)["presses"][press]
    for force, depth in list(zip(row["force_N"], row["part"], strict=True))[2::3]:
        assert part(force, name) == pytest.approx(depth, rel=1e-9)
    slope = np.diff(row["part"])[-1] / np.diff(row["force_N"])[-1]
    assert part(row["force_N"][-1] + 0.1, name) == pytest.approx(row["part"][-1] + 0.1 * slope)


def test_a_ball_goes_deeper_than_a_plate_and_raised_parts_as_deep() -> None:
    assert part(1.0, "calibrated_ah", ff.Sphere(5.0)) > 1.5 * part(1.0, "calibrated_ah")
    assert part(1.0, "maeno1998", ff.Dots(3.0)) == pytest.approx(part(1.0, "maeno1998"))


def test_forces_grow_with_the_modulus_and_the_square_of_the_size() -> None:
    (press,) = (each for each in presses.presses() if each.name == "maeno1998/flat-30")
    once = press.depth_under(0.5, press.thickness, press.modulus)
    assert press.depth_under(1.0, press.thickness, 2 * press.modulus) == pytest.approx(once)
    assert press.depth_under(2.0, 2 * press.thickness, press.modulus) == pytest.approx(once)


def test_only_an_unchanged_finger_is_that_of_the_subject() -> None:
    assert presses.calibrated_subject(ff.Finger.subject("a.h.")) == "a.h."
    changed = ff.Finger.subject("a.h.", nail="free")
    assert presses.calibrated_subject(changed) is None
    assert presses.calibrated_subject(ff.Finger.subject("a.h.", tissue="maeno1998")) is None


def test_a_formula_states_no_error_of_a_finger_of_another_form() -> None:
    free = replace(pressed(0.1), finger=ff.Finger.subject("a.h.", nail="free"))
    case = Situation.of(free)
    assert not case.as_pressed
    from fefinger.mechanics import get

    assert np.isnan(get("layered").error(case)[0])
    assert np.isfinite(get("linear").error(case)[0])


def test_one_module_of_the_mechanics_opens_reports() -> None:
    room = Path(presses.__file__).parents[1]
    readers = [path for path in room.rglob("*.py") if "read_report" in path.read_text("utf-8")]
    assert readers == [Path(presses.__file__)]
