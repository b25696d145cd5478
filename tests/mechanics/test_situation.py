"""Situations: what is computed of a scene, once, and shared by the mechanics on a mesh."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from fefinger.validation.problems import published

from fefinger import mechanics, plan
from fefinger.mechanics import situation
from fefinger.mechanics.evidence.presses import Features
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.mechanics.situation import Situation
from fefinger.scene import builtin
from fefinger.scene.finger import RESOLUTIONS
from fefinger.scene.scene import Scene
from fefinger.support.checks import InputError


def pressed(**changes: Any) -> Scene:
    return published.load("flat-press", {key.replace("__", "."): v for key, v in changes.items()})


def counted(monkeypatch: pytest.MonkeyPatch, owner: Any, name: str) -> list[int]:
    """Count the calls of a function of a module or class from here on."""
    calls: list[int] = []
    original: Callable[..., Any] = getattr(owner, name)

    def counting(*arguments: Any, **named: Any) -> Any:
        calls.append(1)
        return original(*arguments, **named)

    monkeypatch.setattr(owner, name, counting)
    return calls


def test_the_meshes_are_those_that_the_scene_leaves_open() -> None:
    free = Situation.of(pressed(ask__spikes=[]))
    assert [case.mesh for case in free.meshes] == ["coarse", "standard", "fine"]
    spiking = Situation.of(pressed(ask__spikes=["SAI"]))
    assert [case.mesh for case in spiking.meshes] == ["standard", "fine"]
    stated = Situation.of(pressed(finger__resolution="coarse"))
    assert stated.meshes == (stated,)
    assert free.on("fine") is free.meshes[2]


def test_a_situation_holds_the_times_and_the_presses_next_to_its_scene() -> None:
    scene = pressed(ask__spikes=["FAII"])
    case = Situation.of(scene)
    np.testing.assert_allclose(case.times, time_grid(scene.motion, fast=True), rtol=1e-12)
    assert case.half == scene.indenter.mirrored
    # exact: one formula, twice in a process
    assert case.features == Features.of(scene.finger, scene.indenter)
    expected = scene.motion.peak / scene.finger.thickness
    assert case.depth_over_thickness == pytest.approx(expected)


def test_a_plan_builds_no_scene_again_and_counts_time_steps_once_per_mesh(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = pressed(ask__spikes=[])
    scenes = counted(monkeypatch, Scene, "__post_init__")
    grids = counted(monkeypatch, situation, "time_grid")
    plan.rungs(scene)
    assert not scenes
    assert len(grids) == len(RESOLUTIONS)


FIELDS: list[tuple[dict[str, Any], str, str]] = [
    ({"finger__skin__modulus": 1e6}, "linear", "finger.skin.modulus"),
    ({"ask__pressure": True}, "lumped", "ask.pressure"),
    ({"finger__nail": "free"}, "condensed", "finger.nail"),
]


@pytest.mark.parametrize(("changes", "name", "field"), FIELDS)
def test_a_refusal_names_the_field_that_it_is_about(
    changes: dict[str, Any], name: str, field: str
) -> None:
    refusals = mechanics.get(name).refuse(Situation.of(pressed(ask__fields=False, **changes)))
    assert field in {refusal.field for refusal in refusals}


def test_a_vibration_of_more_steps_than_memory_holds_is_refused_before_they_are_made() -> None:
    changes = {"motion.frequency": 1e9, "ask.spikes": []}
    with pytest.raises(InputError, match="expected one of at most 5000000 time steps"):
        plan.explain(builtin.load("vibration-200Hz", changes))
