"""Stated errors under many objects: the presses of reports/press-mesh.json."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from fefinger.mechanics import get
from fefinger.mechanics.evidence import (
    measured_tissue,
    press_mesh,
    pressed_objects,
    tabulation_error,
)
from fefinger.mechanics.evidence.press_mesh import SHALLOW
from fefinger.mechanics.evidence.table import PRESS_MESH, TIME_STEPS, read
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Bar, Cylinder, Flat, Pin, Sphere
from fefinger.scene.motions import Ramp, RampHold
from fefinger.scene.scene import Scene
from fefinger.scene.textured import Grating, Relief
from fefinger.support.inputs import read_report
from fefinger.theory.relaxation import Prony


ROWS = json.loads(read_report(PRESS_MESH))["rows"]

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
    return read(TIME_STEPS)["rows"]["solid"][quantity]


@pytest.mark.parametrize("quantity", ["force", "pressure", "area", "strain"])
@pytest.mark.parametrize("mesh", ["coarse", "standard", "fine"])
def test_under_a_measured_object_it_is_the_error_of_that_press(mesh, quantity) -> None:
    found, source = get("solid").error(case(Flat(30), 1.5, mesh), quantity)
    known = in_press("a.h./flat-30", f"solid {mesh}", 0.15, quantity)
    assert found == pytest.approx(np.hypot(known, steps(quantity)), rel=1e-9)
    assert source.startswith(f"reports/{PRESS_MESH}, a.h./flat-30")


@pytest.mark.parametrize("quantity", ["force", "pressure", "area", "strain"])
@pytest.mark.parametrize("mesh", ["coarse", "standard", "fine"])
def test_shallower_than_measured_the_error_of_a_mesh_grows(mesh, quantity) -> None:
    first = ROWS["a.h./flat-30"]["depth_mm"][0]
    known = in_press("a.h./flat-30", f"solid {mesh}", 0.0, quantity)
    for depth, grown in ((first, 1.0), (first / 2, 2**SHALLOW), (first / 16, 16**SHALLOW)):
        found, _ = get("solid").error(case(Flat(30), depth, mesh), quantity)
        assert found == pytest.approx(np.hypot(grown * known, steps(quantity)), rel=1e-9)


def test_shallower_than_measured_the_error_of_a_formula_does_not_grow() -> None:
    first = ROWS["a.h./flat-30"]["depth_mm"][0]
    near, far = (get("layered").error(case(Flat(30), first / by))[0] for by in (1.01, 16))
    assert near == pytest.approx(far, rel=0.3)


def test_at_a_light_touch_stated_errors_are_no_smaller_than_those_that_were_found() -> None:
    """Of the standard mesh against the fine one under the plate at 30 degrees, on a.h."""
    for depth, off in ((0.013, 0.05), (0.017, 0.03), (0.025, 0.005)):
        assert get("pressed").error(case(Flat(30), depth))[0] > off
    assert get("pressed").error(case(Flat(30), 0.05), "strain")[0] > 0.11  # of FAI


PLATES = {
    name: float(name[5:])
    for name in (
        *("flat-0", "flat-7.5", "flat-15", "flat-22.5", "flat-30", "flat-37", "flat-45"),
        *("flat-52.5", "flat-60"),
    )
}
BALLS = {"flat-30": 0.0, "sphere-10": 0.1, "sphere-5": 0.2, "sphere-2": 0.5, "sphere-1": 1.0}


def between(
    names: tuple[str, str], share: float, places: dict[str, float], part: float
) -> tuple[float, float]:
    """Return the error between two presses, and the margin of those at some places, anew."""
    missed = []
    for finger in ("a.h.", "d.s.", "d.p.", "p.w.", "means", "maeno1998"):
        row = sorted((at, name) for name, at in places.items() if f"{finger}/{name}" in ROWS)
        for (left, low), (at, here), (right, high) in zip(row, row[1:], row[2:], strict=False):
            press, weight = ROWS[f"{finger}/{here}"], (at - left) / (right - left)
            sides = [ROWS[f"{finger}/{name}"] for name in (low, high)]
            deep = min(side["depth_mm"][-1] / side["thickness_mm"] for side in sides)
            errors = press["errors"]["solid standard"]["force"]
            for depth, error in zip(press["depth_mm"], errors, strict=True):
                there = depth / press["thickness_mm"]
                # exact: divisions of the same numbers
                if part / 2 < there < part * 2 and there <= deep:
                    before, after = (
                        in_press(f"{finger}/{name}", "solid standard", there)
                        for name in (low, high)
                    )
                    told = (1 - weight) * before + weight * after
                    missed.append(error / told - 1)
    low, high = (in_press(f"a.h./{name}", "solid standard", part) for name in names)
    error = (1 - share) * low + share * high
    return error, error * max(float(np.quantile(missed, 0.95)), 0.0)


@pytest.mark.parametrize(
    ("indenter", "names", "share", "places"),
    [
        (Flat(20), ("flat-15", "flat-22.5"), 2 / 3, PLATES),
        (Flat(55), ("flat-52.5", "flat-60"), 1 / 3, PLATES),
        (Sphere(7), ("sphere-10", "sphere-5"), (1 / 7 - 0.1) / 0.1, BALLS),
        (Sphere(40), ("flat-30", "sphere-10"), 0.25, BALLS),
    ],
    ids=str,
)
def test_a_plate_or_ball_has_the_error_between_its_neighbors(
    indenter, names, share, places
) -> None:
    assert set(pressed_objects.neighbor_presses(indenter)[0]) == set(names)
    found, source = get("solid").error(case(indenter, 0.71))
    error, margin = between(names, share, places, 0.071)
    middle = 4 * share * (1 - share) if places is BALLS else 1.0
    assert found == pytest.approx(np.hypot(error + middle * margin, steps()), rel=1e-9)
    assert all(f"a.h./{name}" in source for name in names)


@pytest.mark.parametrize(
    ("indenter", "names"),
    [
        (Flat(20, tilt=10), ("flat-15", "flat-22.5", "tilt-15")),
        (Sphere(5, at=(0.0, 3.0)), ("sphere-5", "sphere-5, 4 mm beside")),
        (Cylinder(6), ("sphere-5", "sphere-10", "cylinder")),
        (GRATING, ("grating",)),
        (replace(GRATING, angle=20.0), ("grating", "grating-10")),
        (Grating(5.0, 2.4, 0.6, angle=20.0), ("grating", "grating-10", "grating-6")),
        (Bar(3.0, corner=1.5), ("bar", "bar-4")),
        (Pin(2.0), ("pin",)),
    ],
    ids=str,
)
def test_any_other_object_has_the_largest_error_of_those_it_lies_between(indenter, names) -> None:
    assert set(pressed_objects.neighbor_presses(indenter)[0]) == set(names)
    found, source = get("solid").error(case(indenter, 0.7))
    known = max(in_press(f"a.h./{name}", "solid standard", 0.07) for name in names)
    assert found == pytest.approx(np.hypot(known, steps()), rel=1e-9)
    assert all(f"a.h./{name}" in source for name in names)


@pytest.mark.parametrize(
    ("indenter", "reason"),
    [
        (Flat(30, tilt=40), "tilt is measured to 15 degrees"),
        (Sphere(0.9), "measured to radii of 1 mm"),
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
    found, source = get("solid").error(case(Flat(30), 3.0))
    assert np.isnan(found)
    assert "goes to 0.3 of the finger's thickness, and presses like it were measured" in source


def test_deeper_than_its_own_press_a_plate_has_the_error_of_those_around() -> None:
    found, source = get("solid").error(case(Flat(45), 1.95))
    known = sum(between(("flat-37", "flat-52.5"), 8 / 15.5, PLATES, 0.195))
    assert found == pytest.approx(np.hypot(known, steps()))
    assert "a.h./flat-37 and a.h./flat-52.5" in source


def on_other_fingers(candidate: str, quantity: str, part: float) -> list[float]:
    """Return the excess over the errors of a.h., as a share, at half to twice a depth."""
    more = []
    for label, row in ROWS.items():
        subject, _, object_ = label.partition("/")
        if subject not in ("d.s.", "d.p.", "p.w.", "means"):
            continue
        main = ROWS[f"a.h./{object_}"]
        deepest = main["depth_mm"][-1] / main["thickness_mm"]
        parts = np.array(row["depth_mm"]) / row["thickness_mm"]
        for there, error in zip(parts, row["errors"][candidate][quantity], strict=True):
            # exact: divisions of the same numbers
            if part / 2 < there < part * 2 and there <= deepest:
                more.append(error / in_press(f"a.h./{object_}", candidate, there, quantity) - 1)
    return more


def test_deeper_than_its_own_press_a_ball_has_the_error_of_those_around() -> None:
    found, source = get("solid").error(case(Sphere(2), 1.5))
    error, margin = between(("sphere-5", "sphere-1"), 0.375, BALLS, 0.15)
    assert found == pytest.approx(np.hypot(error + 4 * 0.375 * 0.625 * margin, steps()))
    assert all(f"a.h./{name}" in source for name in ("sphere-1", "sphere-5"))


def test_a_subject_has_its_own_press_and_another_finger_a_margin() -> None:
    own, _ = get("solid").error(case(Flat(30), 1.3, subject="p.w."))
    assert own == pytest.approx(np.hypot(in_press("p.w./flat-30", "solid standard", 0.1), steps()))
    main = in_press("a.h./flat-30", "solid standard", 0.09)
    other, source = get("solid").error(case(Flat(30), 0.9, pad_radius=16.0))
    more = on_other_fingers("solid standard", "force", 0.09)
    assert other == pytest.approx(np.hypot(main * (1 + np.quantile(more, 0.95)), steps()))
    assert "of margin" in source


@pytest.mark.parametrize("mesh", ["coarse", "standard"])
@pytest.mark.parametrize("subject", ["a.h.", "d.s."])
def test_the_error_of_a_mesh_is_of_the_finger_whatever_its_tissue(mesh, subject) -> None:
    errors = []
    for tissue in (None, "maeno1998"):
        finger = Finger.subject(subject, tissue=tissue, resolution=mesh)
        scene = Scene(finger=finger, indenter=Flat(0), motion=Ramp(60, 1.0, corner=0))
        errors.append(get("solid").error(Situation.of(scene)))
    assert errors[0] == (pytest.approx(errors[1][0], rel=1e-12), *errors[1][1:])
    assert f"{subject}/flat-0" in errors[0][1]


def test_the_margin_of_another_finger_is_on_what_was_measured_there() -> None:
    """Between a plate of its own and one of a.h., the margin grows with the share of the latter."""
    found = [get("solid").error(case(Flat(at), 1.15, subject="d.s."))[1] for at in (0.0, 1.0, 4.0)]
    margins = [float(re.findall(r"and ([0-9.]+) % of margin", each)[0]) for each in found[1:]]
    assert "margin" not in found[0]
    assert 0 < margins[0] < margins[1]


@pytest.mark.parametrize("name", ["layered", "condensed", "linear"])
@pytest.mark.parametrize("quantity", ["area", "strain"])
def test_small_strain_on_a_calibrated_finger_has_the_error_of_its_press(name, quantity) -> None:
    label = name if name == "layered" else f"{name} standard"
    for subject, row in (("a.h.", ROWS["a.h./flat-30"]), ("d.p.", ROWS["d.p./flat-30"])):
        there = case(Flat(30), row["depth_mm"][6], subject=subject)
        known = row["errors"][label][quantity][6]
        tabulation = (1 - min(known, 1.0)) * tabulation_error.error(there, quantity, table=False)
        of_steps = read(TIME_STEPS)["rows"].get(name, {}).get(quantity, 0.0)
        assert get(name).error(there, quantity)[0] == pytest.approx(
            np.hypot(known + tabulation, of_steps)
        )


def test_of_a_motion_small_strain_leaves_out_what_relaxation_leaves_of_it() -> None:
    """The force that is missing, summed over small steps of the depth with G of what has passed."""
    row = ROWS["a.h./flat-30"]
    depth, known = row["depth_mm"][8], row["errors"]["linear standard"]["force"][8]
    there = case(Flat(30), depth)
    force, missing = (
        np.concatenate([[0.0], np.array(row["force_N"]) * factor])
        for factor in (1.0, np.array(row["errors"]["linear standard"]["force"]))
    )
    time = np.linspace(0.0, depth / 60, 20_001)
    depths = np.concatenate([[0.0], row["depth_mm"]])
    left = there.finger.prony.relaxation(time[-1] - (time[1:] + time[:-1]) / 2)
    borne, wrong = (
        left @ np.diff(np.interp(60 * time, depths, values)) for values in (force, missing)
    )
    of_steps = read(TIME_STEPS)["rows"]["linear"]["force"]
    found = np.sqrt(get("linear").error(there)[0] ** 2 - of_steps**2)
    share = wrong / borne
    assert share > 1.02 * known, "nothing would be seen of it"
    through = tabulation_error.error(there, "force", table=False)
    assert found == pytest.approx(share + (1 - share) * through, rel=1e-3)


def test_tissue_of_a_larger_exponent_errs_as_much_less_deep() -> None:
    """Demiray's law stiffens by b (I1 - 3), and I1 - 3 grows as the square of the depth."""
    soft = Finger(14.0, 10.0, tissue="calibrated_ah")
    steep = Finger(14.0, 10.0, tissue="calibrated_dp")
    shallower = (soft.subcutaneous.exponent / steep.subcutaneous.exponent) ** 0.5
    reports_of = []
    for finger, depth in ((soft, 1.0), (steep, 1.0 * shallower)):
        scene = Scene(
            finger=replace(finger, resolution="standard", prony=Prony((1.0,), ())),
            indenter=Flat(37),
            motion=Ramp(60, depth, corner=0.0),
        )
        found = press_mesh.error(Candidate("linear", "standard"), Situation.of(scene), "strain")
        reports_of.append(found.error)
    assert reports_of[1] == pytest.approx(reports_of[0], rel=1e-9)


@pytest.mark.parametrize("quantity", ["pressure", "area"])
def test_which_vertices_an_edge_touches_is_by_chance_at_the_depths_about_a_scene(quantity) -> None:
    row = ROWS["a.h./grating"]
    parts = np.array(row["depth_mm"]) / row["thickness_mm"]
    curve = row["errors"]["solid coarse"][quantity]
    known = max(np.interp(0.1 * factor, parts, curve) for factor in np.linspace(0.8, 1.25, 9))
    there = case(GRATING, 1.0, "coarse")
    assert press_mesh.error(Candidate("solid", "coarse"), there, quantity).error == pytest.approx(
        known, rel=0.02
    )
    other = case(replace(GRATING, period=4.5, ridge=2.2), 1.0, "coarse")
    assert press_mesh.error(Candidate("solid", "coarse"), other, quantity).error > known


def test_under_a_force_the_depth_is_that_of_the_press() -> None:
    row = ROWS["a.h./sphere-5"]
    scene = Scene(
        finger=Finger.subject("a.h.", resolution="standard"),
        indenter=Sphere(5),
        motion=RampHold(loading_rate=1, force=row["force_N"][7], hold=1),
    )
    found, _ = get("solid").error(Situation.of(scene))
    known = row["errors"]["solid standard"]["force"][7]
    assert found == pytest.approx(np.hypot(known, steps()), rel=1e-6)


@pytest.mark.parametrize("quantity", ["force", "pressure", "area", "strain"])
def test_pressed_adds_what_tabulation_errs_by(quantity) -> None:
    there = case(Flat(30), 1.5)
    mesh = get("solid").error(there, quantity)[0]
    tabulation = tabulation_error.error(there, quantity)
    assert get("pressed").error(there, quantity)[0] == pytest.approx(np.hypot(mesh, tabulation))


@pytest.mark.parametrize("name", ["layered", "condensed", "linear"])
@pytest.mark.parametrize("object_", ["flat-60", "grating", "bar"])
def test_on_published_tissue_small_strain_has_the_error_of_the_same_object(name, object_) -> None:
    row = ROWS[f"maeno1998/{object_}"]
    label = name if name == "layered" else f"{name} standard"
    finger = Finger.subject("a.h.", tissue="maeno1998", resolution="standard")
    depth = row["depth_mm"][5]
    there = Scene(
        finger=finger, indenter=pressed_objects.objects()[object_], motion=Ramp(60, depth, corner=0)
    )
    found, _ = get(name).error(Situation.of(there), "area")
    if label not in row["errors"]:
        assert np.isnan(found)
        return
    parts, curve = np.array(row["depth_mm"]), row["errors"][label]["area"]
    edged = object_ != "flat-60"
    about = depth * np.linspace(0.8, 1.25, 9) if edged else np.array([depth])
    known = np.interp(about, parts, curve).max()
    tabulation = tabulation_error.error(Situation.of(there), "area", table=False)
    of_steps = read(TIME_STEPS)["rows"].get(name, {}).get("area", 0.0)
    of_mesh = press_mesh.error(Candidate("solid", "standard"), Situation.of(there), "area").error
    least = of_mesh if name != "layered" else 0.0
    both = max(np.hypot(known, tabulation), least)
    assert found == pytest.approx(np.hypot(both, of_steps), rel=1e-2)


@pytest.mark.parametrize("mesh", ["coarse", "standard"])
def test_on_another_finger_of_published_tissue_small_strain_has_a_margin_of_its_mesh(mesh) -> None:
    part, errors = 0.07, []
    for subject in ("a.h.", "d.s."):
        finger = Finger.subject(subject, tissue="maeno1998", resolution=mesh)
        motion = Ramp(60, part * finger.thickness, corner=0)
        there = Situation.of(Scene(finger=finger, indenter=GRATING, motion=motion))
        errors.append(press_mesh.error(Candidate("linear", mesh), there).error)
    more = np.quantile(on_other_fingers(f"solid {mesh}", "force", part), 0.95)
    assert more > 0
    of_mesh = in_press("d.s./grating", f"solid {mesh}", part)
    assert errors[1] - errors[0] == pytest.approx(more * of_mesh, rel=0.05)


def test_errors_of_the_report_shrink_with_the_mesh() -> None:
    for label, row in ROWS.items():
        if "refused" in row:
            continue
        for quantity in ("force", "pressure", "area", "strain"):
            coarse, standard, fine = (
                np.array(row["errors"][f"solid {mesh}"][quantity])
                for mesh in ("coarse", "standard", "fine")
            )
            if row["tissue"] is None:  # that mesh is a morph, and not better
                assert (fine >= standard).all(), label
            else:
                assert (fine < standard).all(), label
            assert (standard < coarse).all(), label


def test_a_candidate_that_was_not_compared_has_no_error() -> None:
    assert np.isnan(press_mesh.error(Candidate("hertz"), case(GRATING)).error)


def test_a_finger_whose_bone_ends_elsewhere_is_none_that_was_measured() -> None:
    for tissue, measured in (
        ("maeno1998", measured_tissue.published),
        ("calibrated_ah", measured_tissue.calibrated),
    ):
        finger = Finger.subject("a.h.", tissue=tissue)
        assert measured(finger)
        assert not measured(replace(finger, tip_tissue=3.8))


@pytest.mark.parametrize("quantity", ["pressure", "area"])
@pytest.mark.parametrize("mesh", ["coarse", "standard"])
def test_fingers_scatter_more_at_light_touch_than_in_deep_presses(mesh, quantity) -> None:
    excess = press_mesh.other_fingers(Candidate("solid", mesh), quantity)
    parts, values = excess
    light, deep = (press_mesh.margin(excess, part) for part in (0.02, 0.12))
    assert light > 3 * deep
    for part, margin in ((0.02, light), (0.12, deep)):
        near = values[(parts > part / 2) & (parts < 2 * part)]
        assert np.mean(near <= margin) == pytest.approx(0.95, abs=0.02)
