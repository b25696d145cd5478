"""What the planner reads of `solid`: small strain is as wrong as the report says at that depth."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fefinger.validation.evidence import cost, cost_table
from fefinger.validation.evidence.small_strain_cost import costs as measured_costs
from fefinger.validation.problems import published

import fefinger as ff
from fefinger.mechanics import condensed, linear, solid
from fefinger.mechanics.evidence import costs, vibration
from fefinger.mechanics.evidence.presses import EVIDENCE, read
from fefinger.mechanics.press.time_steps import moving, time_grid
from fefinger.mechanics.situation import Situation
from fefinger.mesh.build import SETTINGS
from fefinger.scene import builtin
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support import machine


def scene(**changes: Any) -> Scene:
    return published.load("flat-press", {key.replace("__", "."): v for key, v in changes.items()})


def at(depth: float) -> Scene:
    return scene(motion__depth=depth, motion__corner=0.0)


def test_facets_are_as_long_as_the_mesher_is_asked_to_make_them() -> None:
    assert linear.FACETS == {name: each.pad for name, each in SETTINGS.items()}


@pytest.mark.usefixtures("few_steps")
@pytest.mark.parametrize(
    "changes",
    [
        {"finger.skin.modulus": 30.0},
        {"finger.tissue": "saal2017", "indenter": {"kind": "bar", "width": 2, "corner": 1}},
    ],
    ids=str,
)
def test_the_error_on_other_tissue_holds_what_small_strain_is_off(changes: dict[str, Any]) -> None:
    ask = {"ask.spikes": [], "ask.fields": False, "ask.pressure": False, "ask.strain": False}
    motion = {"motion": {"kind": "ramp", "speed": 60.0, "depth": 0.6, "corner": 0.0}}
    pressed = published.load("flat-press", {"finger.resolution": "coarse"} | ask | motion | changes)
    small, finite = (each.respond(pressed).force for each in (linear, solid))
    stated, source = linear.error(Situation.of(pressed))
    assert np.abs(small - finite).max() / finite.max() < stated < 1
    assert EVIDENCE in source


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


@pytest.mark.parametrize("row", read(cost_table.SOLID)["rows"], ids=pressed_to)
def test_the_expected_seconds_of_solid_are_those_that_a_press_took(row: dict[str, Any]) -> None:
    kinds = {"flat": ff.Flat, "sphere": ff.Sphere, "bar": ff.Bar}
    indenter = kinds[row["kind"]](**row["indenter"])
    named = (row["mesh"], row["subject"], row["tissue"])
    pressed = cost.scene(*named, indenter, row["depth_mm"])
    here = machine.slowness(read(cost_table.SOLID))
    built = costs.mesh_seconds(Situation.of(pressed))
    assert 1 / 1.4 < (solid.cost(Situation.of(pressed)) - built) / (here * row["seconds"]) < 1.4


@pytest.mark.parametrize("mechanics", [linear, condensed])
def test_what_is_measured_of_flat_press_is_what_is_expected_of_it(
    mechanics: Any, monkeypatch: pytest.MonkeyPatch, operators: Path
) -> None:
    named = scene(finger__resolution="coarse")
    response = mechanics.respond(named)
    whole, case = sum(response.seconds.values()), Situation.of(named)
    label = f"{mechanics.__name__.rpartition('.')[2]} coarse"
    stages = {key.removesuffix("_seconds"): x for key, x in measured_costs(response, whole).items()}
    stages["area"] = response.seconds["pressure"] / case.changes
    table = read(EVIDENCE)["costs"]["seconds"]
    monkeypatch.setitem(table, label, table[label] | stages)
    assert mechanics.cost(case) == pytest.approx(machine.slowness({}) * whole, rel=0.01)


def test_areas_are_expected_to_be_read_where_contact_changes_and_fields_where_asked() -> None:
    row = read(EVIDENCE)["costs"]["seconds"]["linear coarse"]
    short = replace(at(1.0), motion=Ramp(60.0, 1.0, corner=0.0))
    short = replace(short, finger=replace(short.finger, resolution="coarse"))
    held = replace(short, motion=ff.RampHold(60.0, 1.0, hold=1.0, corner=0.0))
    alone = replace(short, ask=replace(short.ask, pressure=False, fields=False))
    here = machine.slowness({})
    steps = [len(time_grid(each.motion, fast=True)) for each in (short, held)]
    assert linear.cost(Situation.of(held)) - linear.cost(Situation.of(short)) == pytest.approx(
        here * (steps[1] - steps[0]) * row["step"]
    )
    assert linear.cost(Situation.of(short)) - linear.cost(Situation.of(alone)) == pytest.approx(
        here * ((steps[0] - 1) * row["area"] + row["fields"])
    )
    crept = replace(held, motion=ff.RampHold(loading_rate=5.0, force=0.2, hold=1.0))
    creeps = time_grid(crept.motion, fast=True)
    assert moving(crept.motion, creeps) == len(creeps)
    slide = ff.Slide(30.0, 0.5, distance=6.0)
    path = time_grid(slide, fast=True)
    along = np.count_nonzero(path > slide.recorded_from)
    assert along > len(path) // 2
    assert moving(slide, path) == along + np.count_nonzero(np.diff(slide.value(path)))


@pytest.mark.parametrize("name", ["linear", "condensed", "pressed", "modal", "solid"])
def test_every_stage_costs_more_on_a_finer_mesh(name: str) -> None:
    table = read(EVIDENCE)["costs"]["seconds"]
    rows = [table[f"{name} {mesh}"] for mesh in ("coarse", "standard", "fine")]
    for stage in rows[0]:
        seconds = [row[stage] for row in rows]
        assert seconds == sorted(seconds), stage


@pytest.mark.parametrize("text", [True, False])
def test_a_fast_slide_states_the_inertia_that_it_leaves_out(text: bool) -> None:
    fast = builtin.load("slide-braille", {"motion.speed": 2000.0})
    if not text:  # a smooth plate moves no skin up or down
        fast = replace(fast, indenter=ff.Flat(30))
    error, source = vibration.left_out(Situation.of(fast))
    assert (error > 0.3) == text
    assert ("speed along the skin / wave speed = 2 / 3.39 m/s" in source) == text
