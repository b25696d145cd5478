"""Stated errors where the force is prescribed, against the inverse of what was measured."""

from dataclasses import replace

import numpy as np
import pytest

import fefinger as ff
from fefinger import plan
from fefinger.mechanics import linear
from fefinger.mechanics.evidence import stated_errors
from fefinger.mechanics.evidence.table import PRESS_MESH, read
from fefinger.mechanics.situation import Situation


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
PRESSES = {
    "flat-30": ff.Flat(30),
    "flat-15": ff.Flat(15),
    "flat-0": ff.Flat(0),
    "sphere-10": ff.Sphere(10),
    "sphere-5": ff.Sphere(5),
}


def pressed(name: str, force: float, **parts: object) -> ff.Scene:
    motion = ff.Ramp(loading_rate=40.0, force=force, corner=0.0)
    return ff.Scene(finger=FINGER, indenter=PRESSES[name], motion=motion, **parts)


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("name", PRESSES)
def test_the_depth_is_as_wrong_as_the_inverse_of_a_wrong_force_or_less(
    name: str, sign: int
) -> None:
    row = read(PRESS_MESH)["rows"][f"maeno1998/{name}"]
    forces, depths = np.log(row["force_N"]), np.log(row["depth_mm"])
    for force in forces[3:-2]:
        for error in (0.01, 0.06):
            wrong = np.interp(force, forces + np.log1p(sign * error), depths)
            actual = abs(np.expm1(wrong - np.interp(force, forces, depths)))
            case = Situation.of(pressed(name, np.exp(force)))
            stated = stated_errors.at_force({}, error, case)["depth"]
            assert 0.6 * stated < actual < 1.001 * stated
            assert stated < 0.9 * error


def test_of_a_scene_like_no_press_the_depth_is_as_wrong_as_the_force() -> None:
    strange = replace(pressed("flat-30", 0.5), indenter=ff.Bar(3.0, 1.0))
    assert stated_errors.steepness(Situation.of(strange)) == 1.0
    found = stated_errors.at_force({"area": 0.1}, 0.2, Situation.of(strange))
    assert found == {"depth": pytest.approx(0.25), "area": pytest.approx(0.3)}
    assert stated_errors.at_force({}, 1.0, Situation.of(strange))["depth"] == np.inf


def test_at_a_force_all_else_is_as_wrong_as_at_its_depth_and_as_the_force() -> None:
    by_force = pressed("flat-30", 0.5, ask=ff.Ask(rel_error=0.9))
    case, found = Situation.of(by_force), plan.choose(by_force, "linear").chosen
    for name in ("pressure", "area", "strain"):
        assert found.errors[name] == pytest.approx(linear.error(case, name)[0] + found.error)
    assert 0 < found.errors["depth"] < found.error
    depth = case.depth_over_thickness * FINGER.thickness
    by_depth = replace(by_force, motion=ff.Ramp(60.0, depth, corner=0.0))
    assert found.error < plan.choose(by_depth, "linear").chosen.error  # which grows on the way


def test_depths_of_two_meshes_under_a_force_differ_by_less_than_is_stated() -> None:
    coarse = pressed("flat-30", 0.6, ask=ff.Ask(fields=False, strain=False))
    standard = replace(coarse, finger=replace(FINGER, resolution="standard"))
    depths = [float(linear.respond(scene).depth[-1]) for scene in (coarse, standard)]
    stated = plan.choose(coarse, "linear").chosen.errors["depth"]
    assert abs(depths[0] / depths[1] - 1) < stated < 0.1
