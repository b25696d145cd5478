"""What the planner reads of `solid`: small strain is as wrong as the report says at that depth."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fefinger.validation.evidence import cost
from fefinger.validation.evidence.linear import costs
from fefinger.validation.problems import published

import fefinger as ff
from fefinger.mechanics import condensed, linear, solid
from fefinger.mechanics.evidence import machine, reports, table
from fefinger.mechanics.press.time_steps import moving, time_grid
from fefinger.mechanics.situation import Situation
from fefinger.mesh.build import SETTINGS
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Tissue
from fefinger.support.text import percent


def scene(**changes: Any) -> Scene:
    return published.load("flat-press", {key.replace("__", "."): v for key, v in changes.items()})


def at(depth: float) -> Scene:
    return scene(motion__depth=depth, motion__corner=0.0)


def test_facets_are_as_long_as_the_mesher_is_asked_to_make_them() -> None:
    assert reports.FACETS == {name: each.pad for name, each in SETTINGS.items()}


def test_the_error_of_linear_is_that_of_its_mesh_and_of_small_strain() -> None:
    row = table.read(table.SOLID)["rows"]["a.h./flat-30"]
    last = row["depth_mm"][-1]
    error, source = reports.linear_error(Situation.of(at(last)))
    small, finite = (row["relaxing_N"][name][-1] for name in ("linear", "solid"))
    mesh, _ = reports.linear_mesh_error(Situation.of(at(last)))
    assert error == pytest.approx(mesh + 1 - small / finite, rel=1e-12)
    assert "of the mesh" in source
    assert f"flat-30: {percent(1 - small / finite)} of small strain" in source


def test_small_strain_errs_by_depth_over_thickness_and_not_at_first_touch() -> None:
    assert reports.small_strain_error(
        Situation.of(replace(at(1.0), motion=Ramp(60.0, 1e-9, corner=0.0)))
    ) == pytest.approx(0.0, abs=1e-8)
    errors = [reports.small_strain_error(Situation.of(at(depth))) for depth in (0.8, 1.2, 1.6, 2.0)]
    assert errors == sorted(errors)
    larger = replace(at(2.4), finger=replace(at(1.0).finger, thickness=20.0))
    assert reports.small_strain_error(Situation.of(larger)) == pytest.approx(errors[1], rel=1e-12)


def test_a_force_is_turned_into_the_depth_of_the_finger_that_has_crept() -> None:
    row = table.read(table.SOLID)["rows"]["a.h./flat-30"]
    force, depth = row["force_N"]["solid"][7], row["depth_mm"][7]
    motion = {"kind": "force-ramp-hold", "loading_rate": 1.0, "force": force, "hold": 1.0}
    pressed = scene(motion=motion)
    assert reports.small_strain_part(Situation.of(pressed)) == pytest.approx(
        depth / row["thickness_mm"]
    )
    motion["force"] = 4 * force
    twice = replace(pressed.finger, width=28.0, thickness=2 * row["thickness_mm"])
    larger = replace(scene(motion=motion), finger=twice)
    assert reports.small_strain_part(Situation.of(larger)) == pytest.approx(
        depth / row["thickness_mm"]
    )


def test_linear_refuses_what_small_strain_was_not_measured_at() -> None:
    assert not [r for r in linear.refuse(Situation.of(at(2.0))) if "small strain" in r.reason]
    (refusal,) = linear.refuse(Situation.of(at(2.1)))
    assert refusal.about == "accuracy"
    assert refusal.reason == "depth / thickness = 0.21 > 0.2: small strain is not measured there"
    (forced,) = linear.refuse(
        Situation.of(scene(motion={"kind": "force-ramp", "loading_rate": 9.0, "force": 9.0}))
    )
    assert "depth / thickness = 0.48 > 0.2" in forced.reason
    stiffening = Tissue(34.0, 0.48, law="demiray", exponent=3.0)
    (lawful,) = linear.refuse(
        Situation.of(replace(at(1.0), finger=replace(at(1.0).finger, subcutaneous=stiffening)))
    )
    assert "finger.subcutaneous.law = 'demiray'" in lawful.reason


def test_a_ball_is_judged_by_the_next_blunter_one_that_went_as_deep() -> None:
    ball = {"kind": "sphere", "radius": 1.5}
    assert (
        reports.solid_press(
            Situation.of(scene(indenter=ball, motion__depth=0.5, motion__corner=0.0))
        )
        == "sphere-2"
    )
    assert reports.solid_press(Situation.of(scene(indenter=ball, motion__depth=1.0))) == "sphere-5"
    assert reports.solid_press(Situation.of(scene(indenter=ball, motion__depth=2.2))) == "flat-30"
    assert reports.solid_press(Situation.of(published.load("edge-press"))) == "flat-30"


def pressed_to(row: dict[str, Any]) -> str:
    return f"{row['mesh']}, {row['tissue']} {row['kind']} to {row['depth_mm']}"


def test_the_cost_of_solid_grows_with_the_mesh_the_depth_and_the_spikes() -> None:
    asked = scene(motion={"kind": "ramp", "speed": 60.0, "depth": 1.0, "corner": 0.0})
    meshes = [
        replace(asked, finger=replace(asked.finger, resolution=resolution))
        for resolution in ("coarse", "standard", "fine")
    ]
    seconds = [solid.cost(Situation.of(each)) for each in meshes]
    assert seconds == sorted(seconds)
    assert solid.cost(Situation.of(at(1.5))) > solid.cost(Situation.of(at(0.5)))
    unfelt = replace(asked, ask=replace(asked.ask, spikes=()))
    assert solid.cost(Situation.of(unfelt)) < solid.cost(
        Situation.of(replace(unfelt, ask=replace(unfelt.ask, spikes=("SAI",))))
    )


@pytest.mark.parametrize("row", table.read(table.SOLID_COST)["rows"], ids=pressed_to)
def test_the_expected_seconds_of_solid_are_those_that_a_press_took(row: dict[str, Any]) -> None:
    kinds = {"flat": ff.Flat, "sphere": ff.Sphere, "bar": ff.Bar}
    indenter = kinds[row["kind"]](**row["indenter"])
    named = (row["mesh"], row["subject"], row["tissue"])
    pressed = cost.scene(*named, indenter, row["depth_mm"])
    here = machine.slowness(table.read(table.SOLID_COST))
    built = reports.mesh_seconds(Situation.of(pressed))
    assert 1 / 1.4 < (solid.cost(Situation.of(pressed)) - built) / (here * row["seconds"]) < 1.4


@pytest.mark.parametrize(
    ("mechanics", "name"),
    [(linear, table.LINEAR), (condensed, table.CONDENSED)],
)
def test_what_is_measured_of_flat_press_is_what_is_expected_of_it(
    mechanics: Any, name: str, monkeypatch: pytest.MonkeyPatch, operators: Path
) -> None:
    named = scene(finger__resolution="coarse")
    response = mechanics.respond(named)
    report, whole = table.read(name), sum(response.seconds.values())
    row = report["resolutions"]["coarse"] | costs(response, whole)
    monkeypatch.setitem(report["resolutions"], "coarse", row)
    measured = table.table.__wrapped__()
    monkeypatch.setattr(table, "table", lambda: measured)
    assert mechanics.cost(Situation.of(named)) == pytest.approx(
        machine.slowness(report) * whole, rel=0.01
    )


def test_areas_are_expected_to_be_read_where_contact_changes_and_fields_where_asked() -> None:
    row = table.read(table.LINEAR)["resolutions"]["coarse"]
    short = replace(at(1.0), motion=Ramp(60.0, 1.0, corner=0.0))
    short = replace(short, finger=replace(short.finger, resolution="coarse"))
    held = replace(short, motion=ff.RampHold(60.0, 1.0, hold=1.0, corner=0.0))
    alone = replace(short, ask=replace(short.ask, pressure=False, fields=False))
    here = machine.slowness(table.read(table.LINEAR))
    steps = [len(time_grid(each.motion, fast=True)) for each in (short, held)]
    assert linear.cost(Situation.of(held)) - linear.cost(Situation.of(short)) == pytest.approx(
        here * (steps[1] - steps[0]) * row["step_seconds"]
    )
    assert linear.cost(Situation.of(short)) - linear.cost(Situation.of(alone)) == pytest.approx(
        here * ((steps[0] - 1) * row["area_seconds"] + row["fields_seconds"])
    )
    crept = replace(held, motion=ff.ForceRampHold(5.0, 0.2, hold=1.0))
    creeps = time_grid(crept.motion, fast=True)
    assert moving(crept.motion, creeps) == len(creeps)
