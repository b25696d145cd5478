"""The rule of stated errors, worked out anew from the report, and what it was derived from."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from fefinger.validation.evidence import derive
from fefinger.validation.tradeoff import scenes as drawn

import fefinger as ff
from fefinger import plan
from fefinger.mechanics import get, linear
from fefinger.mechanics.evidence import presses, stated_errors
from fefinger.mechanics.evidence.presses import DEGREES, EVIDENCE, LOGARITHM, read
from fefinger.mechanics.evidence.stated_errors import STATED, Estimate, estimate
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene.textured import Dots, Grating, Relief


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")

FINE = np.arange(-4, 4.05, 0.1)

CREST = Relief.of(lambda x, y: 0.2 * np.cos(6 * x) + 0 * y, FINE, FINE)


def case(indenter, depth=1.0, mesh="standard", subject="a.h.", **changes) -> Situation:
    finger = replace(ff.Finger.subject(subject, resolution=mesh), **changes)
    motion = ff.Ramp(60, depth, corner=0)
    return Situation.of(ff.Scene(finger=finger, indenter=indenter, motion=motion))


def nearest_by_hand(there: Situation, part: float, label: str, quantity: str) -> float:
    """Return the weighted mean from the columns of the report, on tissue of the same law."""
    rows = [
        row
        for row in read(EVIDENCE)["presses"].values()
        if row["features"]["law"] == there.features.law
        and not row["features"]["raised"]
        and label in row["errors"]
        and part <= 1.06 * row["part"][-1]
    ]
    numbers = np.array([row["features"]["numbers"] for row in rows])
    unlike = [row["features"]["kind"] != there.features.kind for row in rows]
    square = ((numbers - there.features.numbers) ** 2).sum(axis=1) + unlike
    finite = label.startswith("solid")
    means, weights = [], []
    for at in np.argsort(square)[: stated_errors.NEAREST]:
        stiff = there.features.exponent / rows[at]["features"]["exponent"]
        depth = part if finite else part * np.sqrt(stiff)
        errors = np.array(rows[at]["errors"][label][quantity], dtype=float)
        value = np.interp(np.log(depth), np.log(rows[at]["part"]), np.log(errors))
        means.append(math.exp(value))
        weights.append(1 / (square[at] + stated_errors.SAME))
    return float(np.average(means, weights=weights))


@pytest.mark.parametrize("quantity", STATED)
@pytest.mark.parametrize("label", ["linear coarse", "solid standard", "solid fine", "layered"])
def test_it_is_the_weighted_mean_of_the_nearest_presses_times_the_factor(label, quantity) -> None:
    candidate = Candidate.of(label)
    mesh = candidate.resolution or "standard"
    there = case(ff.Flat(33), 1.1, mesh)
    found, source = get(candidate.mechanics).error(there, quantity)
    factor = read(EVIDENCE)["factors"][candidate.mechanics][quantity]
    assert found == pytest.approx(nearest_by_hand(there, 0.11, label, quantity) * factor, rel=2e-3)
    assert source.startswith(f"reports/{EVIDENCE}, a.h./flat-30 and 4 more")


def test_what_was_measured_counts_most_and_a_distance_is_in_marked_differences() -> None:
    features = case(ff.Flat(30)).features
    distance, press = presses.nearest(features)[0]
    assert (press.name, distance) == ("a.h./flat-30", pytest.approx(0.0, abs=1e-3))
    assert features.distance(case(ff.Flat(45)).features) == pytest.approx(15 / DEGREES)
    ball = case(ff.Sphere(5)).features
    smaller = case(ff.Sphere(2.5)).features
    both = math.sqrt(2) * math.log((1 + 10 / 2.5) / (1 + 10 / 5)) / LOGARITHM
    assert ball.distance(smaller) == pytest.approx(both)
    assert case(ff.Bar(2, 1)).features.distance(case(ff.Pin(2)).features) >= 1
    assert features.distance(replace_tissue(features)) == pytest.approx(1.0)


def replace_tissue(features):
    return features._replace(law="another")


@pytest.mark.parametrize("mesh", ["coarse", "standard"])
def test_shallower_than_measured_the_error_of_a_mesh_grows_as_the_inverse_of_the_depth(
    mesh,
) -> None:
    near, far = (get("solid").error(case(ff.Flat(30), depth, mesh))[0] for depth in (0.02, 0.01))
    assert far == pytest.approx(2 * near)
    formula = [get("layered").error(case(ff.Flat(30), depth))[0] for depth in (0.02, 0.01)]
    assert formula[0] == pytest.approx(formula[1])


def test_at_no_depth_there_is_a_large_error_of_a_mesh_and_no_failure() -> None:
    features = Situation.of(pressed(ff.Flat(30), 0.1)).features
    assert estimate(Candidate("linear", "coarse"), "force", features, 0.0).error > 10


@pytest.mark.parametrize(
    ("indenter", "depth", "reason"),
    [
        (ff.Flat(30, tilt=45), 0.7, "another tilt"),
        (ff.Sphere(5, at=(10.0, 0.0)), 0.7, "another place"),
        (CREST, 0.7, "no press like it was measured"),
        (ff.Flat(30), 3.0, "goes to 0.3 of the finger's thickness"),
    ],
    ids=["tilt", "place", "relief", "deep"],
)
def test_far_from_all_presses_or_deeper_no_error_is_stated(indenter, depth, reason) -> None:
    found, source = get("pressed").error(case(indenter, depth))
    assert math.isnan(found)
    assert source.startswith("not known: ")
    assert reason in source


def test_small_strain_is_known_on_tissue_of_the_same_law_alone() -> None:
    for candidate in ("linear coarse", "hertz"):
        features = case(ff.Flat(30)).features
        found = estimate(Candidate.of(candidate), "force", features, 0.1)
        assert isinstance(found, Estimate)
        assert {press.features.law for press in found.presses} == {"demiray"}
        assert isinstance(
            estimate(Candidate.of(candidate), "force", replace_tissue(features), 0.1), str
        )


def test_tissue_of_a_larger_exponent_errs_as_much_less_deep() -> None:
    """Demiray's law stiffens by b (I1 - 3), and I1 - 3 grows as the square of the depth."""
    soft = case(ff.Flat(30)).features
    (press,) = (each for each in presses.presses() if each.name == "a.h./flat-30")
    assert stated_errors.stiffer(soft, press.features) == pytest.approx(1.0)
    steep = soft._replace(exponent=4 * soft.exponent)
    assert stated_errors.stiffer(steep, press.features) == pytest.approx(2.0)
    candidate = Candidate("linear", "standard")
    found = estimate(candidate, "force", steep, 0.06)
    assert isinstance(found, Estimate)
    assert found.error == pytest.approx(estimate(candidate, "force", soft, 0.12).error, rel=1e-6)


def test_raised_parts_have_the_error_of_their_mesh_and_of_a_plate() -> None:
    dots = case(Dots(3.0), 0.7, "coarse", tissue="maeno1998")
    plate = case(ff.Flat(30), 0.7, "coarse", tissue="maeno1998")
    errors = [
        estimate(Candidate("linear", "coarse"), "force", each.features, 0.07)
        for each in (dots, plate)
    ]
    assert errors[0].error > derive.RAISED["coarse"]
    assert errors[0].presses[0].name.endswith("/dots")
    assert math.isnan(linear.error(dots, "strain")[0])


@pytest.mark.parametrize("quantity", STATED)
def test_the_factors_hold_in_95_of_100_scenes_of_development(quantity) -> None:
    """Actual errors of the report against what is stated, scene by scene."""
    actual = read("held-out.json")["errors"]
    held: dict[str, list[bool]] = {}
    for key, scene in drawn.development().items():
        there = Situation.of(scene)
        for label, row in actual[key].items():
            candidate = Candidate.of(label)
            if quantity in row and derive.judged(candidate, there):
                mesh = there.on(candidate.resolution or "standard")
                stated = stated_errors.stated(candidate, mesh, quantity).error
                if math.isfinite(stated):
                    held.setdefault(candidate.mechanics, []).append(row[quantity] <= stated)
    assert len(held) >= 5
    for mechanics, each in held.items():
        assert len(each) > 17, mechanics
        assert np.mean(each) >= derive.QUANTILE - 0.01, mechanics
        from_presses = mechanics in derive.FORMULAS and quantity in derive.BY_TISSUE
        some = np.mean(each) < 1 or mechanics == "lumped" or from_presses
        assert some, "a margin that nothing exceeds is none"


@cache
def of_presses() -> list:
    return list(derive.of_presses())


@pytest.mark.parametrize("quantity", [*stated_errors.STRAINS, *derive.BY_TISSUE])
def test_errors_hold_in_presses_that_are_left_out(quantity) -> None:
    held = []
    for (candidate, name), _, residual in of_presses():
        if name == quantity:
            factor = read(EVIDENCE)["factors"][candidate.mechanics][quantity]
            held.append(math.exp(residual) <= factor * 1.01)
    assert len(held) > 500
    assert 0.94 <= np.mean(held) < 0.99


def test_the_strain_that_is_stated_is_that_of_the_worst_type_that_is_asked() -> None:
    scene = ff.Scene(
        finger=FINGER,
        indenter=ff.Flat(0),
        motion=ff.Ramp(60, 0.6),
        ask=ff.Ask(rel_error=0.9, spikes=("SAI", "FAI"), fields=False),
    )
    errors = plan.choose(scene, "condensed").chosen.errors
    larger = max(errors["strain SAI"], errors["strain FAI"])
    assert errors["strain"] == pytest.approx(larger)
    assert errors["strain FAI"] != errors["strain SAI"]
    unasked = replace(scene, ask=replace(scene.ask, spikes=()))
    assert set(plan.choose(unasked, "condensed").chosen.errors) == {"pressure", "area", "strain"}


def pressed(indenter: ff.Flat, force: float, **parts: object) -> ff.Scene:
    motion = ff.Ramp(loading_rate=40.0, force=force, corner=0.0)
    return ff.Scene(finger=FINGER, indenter=indenter, motion=motion, **parts)


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("name", ["flat-30", "flat-15", "flat-0"])
def test_the_depth_is_as_wrong_as_the_inverse_of_a_wrong_force_or_less(
    name: str, sign: int
) -> None:
    row = read(EVIDENCE)["presses"][f"maeno1998/{name}"]
    forces, parts = np.log(row["force_N"]), np.log(row["part"])
    for force in forces[3:-2]:
        for error in (0.01, 0.06):
            wrong = np.interp(force, forces + np.log1p(sign * error), parts)
            actual = abs(np.expm1(wrong - np.interp(force, forces, parts)))
            there = Situation.of(pressed(ff.Flat(float(name[5:])), np.exp(force)))
            stated = stated_errors.at_force({}, error, there)["depth"]
            assert 0.6 * stated < actual < 1.001 * stated
            assert stated < 0.9 * error


def test_at_a_force_all_else_is_as_wrong_as_at_its_depth_and_as_the_force() -> None:
    by_force = pressed(ff.Flat(30), 0.5, ask=ff.Ask(rel_error=0.9))
    there, found = Situation.of(by_force), plan.choose(by_force, "linear").chosen
    for name in ("pressure", "area", "strain"):
        assert found.errors[name] == pytest.approx(linear.error(there, name)[0] + found.error)
    assert 0 < found.errors["depth"] < found.error
    assert stated_errors.at_force({}, 1.0, there)["depth"] == np.inf


def test_a_grating_between_two_measured_ones_has_an_error() -> None:
    found, source = get("solid").error(case(Grating(5.0, 2.4, 0.6, angle=20.0), 0.7))
    assert 0 < found < 0.3
    assert "grating" in source
