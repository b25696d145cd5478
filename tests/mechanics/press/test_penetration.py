"""How far vertices lie inside the indenter, against the displacements that are saved."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fefinger.validation.problems import published

import fefinger as ff
from fefinger.mechanics import Mechanics, linear, solid
from fefinger.mechanics import pressed as tabulated
from fefinger.mechanics.press.response import deepest_penetration
from fefinger.plan import choose
from fefinger.result import Result
from fefinger.results.records import Response


AXIS = np.array([-0.5, 0.0, np.sqrt(0.75)])
"""Travel of a plate at 30 degrees, which passes the origin at first touch, to a micrometer."""


def pressed(depth: float, *, fields: bool = True) -> ff.Scene:
    finger = replace(published.load("flat-press").finger, resolution="coarse")
    ask = ff.Ask(strain=False, fields=fields, rel_error=0.5)
    return ff.Scene(
        finger=finger, indenter=ff.Flat(30), motion=ff.Ramp(60, depth, corner=0), ask=ask
    )


def deepest(response: Response) -> float:
    """Return by how much the plate has passed a point of the deformed mesh at most, in mm."""
    fields, pad, gap = response.fields, response.pad, response.gap
    assert fields is not None
    assert pad is not None
    assert gap is not None
    start = float((pad.points @ AXIS - gap[0]).mean())
    assert abs(start) < 1e-3
    depth = start + np.interp(fields.times, response.time, response.depth)
    ahead = (fields.points + fields.displacement) @ AXIS
    return float((depth[:, None] - ahead).max())


@pytest.mark.usefixtures("few_steps")
@pytest.mark.parametrize("mechanics", [linear, solid], ids=["linear", "solid"])
def test_what_lies_inside_is_told_as_the_saved_displacements_have_it(mechanics: Mechanics) -> None:
    response = mechanics.respond(pressed(0.5))
    told = response.numbers["penetration_mm"]
    assert 0.01 < told < 0.1
    assert told == pytest.approx(deepest(response), rel=1e-6)
    assert f"weighted gaps; vertices lie up to {told:.2g} mm inside" in response.status
    assert any("as weighted means over the facets" in note for note in response.notes)


def test_a_finer_mesh_lets_less_in() -> None:
    """By the presses that are shipped."""
    told = [
        tabulated.respond(
            replace(pressed(0.5), finger=ff.Finger.subject("a.h.", resolution=mesh))
        ).numbers["penetration_mm"]
        for mesh in ("coarse", "standard")
    ]
    assert told[1] < 0.75 * told[0]


def test_a_gap_that_is_open_everywhere_lets_nothing_in() -> None:
    assert deepest_penetration(np.array([[0.1, 1e3], [0.0, 2.0]])) == 0.0
    assert deepest_penetration(np.array([[0.1, -0.2], [-0.3, np.inf]])) == 0.3


@pytest.mark.usefixtures("plain_report")
def test_it_is_saved_and_results_without_it_load(tmp_path: Path) -> None:
    scene = pressed(0.1, fields=False)
    response = linear.respond(scene)
    older = replace(
        response, numbers={k: v for k, v in response.numbers.items() if k != "penetration_mm"}
    )
    for kept in (response, older):
        Result(scene, choose(scene, "linear"), kept, None, kept.status, {}, {}).save(tmp_path)
        assert ff.load(tmp_path).response.numbers == kept.numbers  # exact: a file keeps every bit
