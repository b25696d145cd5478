"""Stated errors under many objects: those of the presses of reports/press-mesh.json."""

import json
from dataclasses import replace

import numpy as np
import pytest

from fefinger.mechanics import get
from fefinger.mechanics.evidence import carrying, press_mesh
from fefinger.mechanics.evidence.table import PRESS_MESH, TRADEOFF, read
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Bar, Cylinder, Flat, Pin, Sphere
from fefinger.scene.motions import ForceRampHold, Ramp
from fefinger.scene.scene import Scene
from fefinger.scene.textured import Grating, Relief
from fefinger.support.package_data import report


ROWS = json.loads(report(PRESS_MESH))["rows"]

GRATING = Grating(period=4.0, ridge=2.0, depth=0.6)
CREST = Relief.of(lambda x, y: 0.1 * np.cos(x + y), np.arange(-4, 5.0), np.arange(-4, 5.0))


def case(indenter, depth=1.0, mesh="standard", subject="a.h.", **changes) -> Situation:
    finger = replace(Finger.subject(subject, resolution=mesh), **changes)
    return Situation.of(Scene(finger=finger, indenter=indenter, motion=Ramp(60, depth, corner=0)))


def in_press(label: str, candidate: str, part: float, quantity: str = "force") -> float:
    row = ROWS[label]
    parts = np.array(row["depth_mm"]) / row["thickness_mm"]
    return float(np.interp(part, parts, row["errors"][candidate][quantity]))


def steps(quantity: str = "force") -> float:
    return read(TRADEOFF)["rules"]["steps"]["solid"][quantity]


@pytest.mark.parametrize("quantity", ["force", "pressure", "area", "strain"])
@pytest.mark.parametrize("mesh", ["coarse", "standard", "fine"])
def test_under_a_measured_object_it_is_the_error_of_that_press(mesh, quantity) -> None:
    found, source = get("solid").error(case(Flat(30), 1.5, mesh), quantity)
    known = in_press("a.h./flat-30", f"solid {mesh}", 0.15, quantity)
    assert found == pytest.approx(known + steps(quantity), rel=1e-9)
    assert source.startswith(f"reports/{PRESS_MESH}, a.h./flat-30")


@pytest.mark.parametrize(
    ("indenter", "names"),
    [
        (Flat(20), ("flat-15", "flat-30")),
        (Flat(55), ("flat-45", "flat-60")),
        (Flat(20, tilt=10), ("flat-15", "flat-30", "tilt-15")),
        (Sphere(7), ("sphere-5", "sphere-10")),
        (Sphere(40), ("sphere-10", "flat-30")),
        (Sphere(5, at=(0.0, 3.0)), ("sphere-5", "sphere-5, 4 mm beside")),
        (Cylinder(6), ("sphere-5", "sphere-10", "cylinder")),
        (GRATING, ("grating",)),
        (replace(GRATING, angle=20.0), ("grating", "grating-10")),
        (Bar(3.0, corner=1.5), ("bar",)),
        (Pin(2.0), ("pin",)),
    ],
    ids=str,
)
def test_an_object_has_the_largest_error_of_those_it_lies_between(indenter, names) -> None:
    assert set(press_mesh.between(indenter)[0]) == set(names)
    found, source = get("solid").error(case(indenter, 0.7))
    known = max(in_press(f"a.h./{name}", "solid standard", 0.07) for name in names)
    assert found == pytest.approx(known + steps(), rel=1e-9)
    assert all(f"a.h./{name}" in source for name in names)


@pytest.mark.parametrize(
    ("indenter", "reason"),
    [
        (Flat(30, tilt=40), "tilt is measured to 15 degrees"),
        (Sphere(1.5), "measured to radii of 2 mm"),
        (Sphere(5, at=(0.0, 5.0)), "measured to 4 mm from the middle"),
        (replace(GRATING, period=2.0, ridge=1.0), "measured to widths of 2 mm"),
        (replace(GRATING, angle=45.0), "measured at angles of 10 to 30 degrees"),
        (replace(GRATING, tilt=3.0), "without tilt"),
        (Bar(1.0, corner=0.5), "measured to widths of 2 mm and radii of 1 mm"),
        (Bar(2.0, corner=1.0, at=(3.0, 0.0)), "measured to 2 mm from the middle"),
        (CREST, "no object of kind 'relief' was pressed"),
    ],
    ids=str,
)
def test_an_object_that_was_not_measured_has_no_error(indenter, reason) -> None:
    found, source = get("pressed").error(case(indenter, 0.7))
    assert np.isnan(found)
    assert source.startswith("not known: ")
    assert reason in source


def test_deeper_than_measured_no_error_is_known() -> None:
    found, source = get("solid").error(case(Flat(30), 2.2))
    assert np.isnan(found)
    assert "goes to 0.22 of the finger's thickness, and presses like it were measured" in source


def test_deeper_than_its_own_press_a_plate_has_the_error_of_those_around() -> None:
    found, source = get("solid").error(case(Flat(45), 1.95))
    known = max(
        in_press(f"a.h./{name}", "solid standard", 0.195) for name in ("flat-30", "flat-60")
    )
    assert found == pytest.approx(known + steps())
    assert "a.h./flat-30 and a.h./flat-60" in source


def test_a_subject_has_its_own_press_and_another_finger_a_margin() -> None:
    own, _ = get("solid").error(case(Flat(30), 1.3, subject="p.w."))
    assert own == pytest.approx(in_press("p.w./flat-30", "solid standard", 0.1) + steps())
    main, _ = get("solid").error(case(Flat(30), 1.0))
    other, source = get("solid").error(case(Flat(30), 1.0, pad_radius=16.0))
    worst = max(
        in_press(f"{subject}/{name}", "solid standard", part)
        - in_press(f"a.h./{name}", "solid standard", part)
        for subject in ("d.s.", "d.p.", "p.w.")
        for name in ("flat-30", "sphere-5")
        for part in (0.05, 0.1, 0.15)
    )
    assert other - main >= worst * (1 - 1e-9)
    assert "for another finger" in source


def test_under_a_force_the_depth_is_that_of_the_press() -> None:
    row = ROWS["a.h./sphere-5"]
    scene = Scene(
        finger=Finger.subject("a.h.", resolution="standard"),
        indenter=Sphere(5),
        motion=ForceRampHold(1, row["force_N"][7], hold=1),
    )
    found, _ = get("solid").error(Situation.of(scene))
    known = row["errors"]["solid standard"]["force"][7]
    assert found == pytest.approx(known + steps(), rel=1e-6)


@pytest.mark.parametrize("quantity", ["force", "pressure", "area", "strain"])
def test_pressed_adds_what_carrying_errs_by(quantity) -> None:
    there = case(Flat(30), 1.5)
    mesh, carried = get("solid").error(there, quantity)[0], carrying.error(there, quantity)
    assert get("pressed").error(there, quantity)[0] == pytest.approx(np.hypot(mesh, carried))


@pytest.mark.parametrize("name", ["layered", "condensed", "linear"])
@pytest.mark.parametrize("object_", ["flat-60", "grating", "bar"])
def test_on_published_tissue_small_strain_has_the_error_of_the_same_object(name, object_) -> None:
    row = ROWS[f"maeno1998/{object_}"]
    label = name if name == "layered" else f"{name} standard"
    finger = Finger.subject("a.h.", tissue="maeno1998", resolution="standard")
    depth = row["depth_mm"][5]
    there = Scene(
        finger=finger, indenter=press_mesh.objects()[object_], motion=Ramp(60, depth, corner=0)
    )
    found, _ = get(name).error(Situation.of(there))
    if label not in row["errors"]:
        assert np.isnan(found)
        return
    of_steps = read(TRADEOFF)["rules"]["steps"][name]["force"]
    assert found == pytest.approx(row["errors"][label]["force"][5] + of_steps)


def test_errors_of_the_report_shrink_with_the_mesh() -> None:
    for label, row in ROWS.items():
        if "refused" in row:
            continue
        for quantity in ("force", "pressure", "area", "strain"):
            coarse, standard, fine = (
                np.array(row["errors"][f"solid {mesh}"][quantity])
                for mesh in ("coarse", "standard", "fine")
            )
            assert (fine < standard).all(), label
            assert (standard < coarse).all(), label


def test_a_candidate_that_was_not_compared_has_no_error() -> None:
    assert np.isnan(press_mesh.error(Candidate("hertz"), case(GRATING)).error)
