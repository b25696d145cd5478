"""The report that the planner cites, read again.

What the planner states has to follow from it, and it from itself.
"""

import numpy as np
import pytest
from fefinger.validation.tradeoff import scenes as tradeoff_scenes
from fefinger.validation.tradeoff import suite
from fefinger.validation.tradeoff.held_out import REPORT as HELD_OUT
from fefinger.validation.tradeoff.held_out import summary

from fefinger import plan
from fefinger.mechanics.evidence.presses import read
from fefinger.mechanics.evidence.stated_errors import STATED
from fefinger.results.records import Rung
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.scene.textured import Relief


def on(indenter, depth, resolution="standard"):
    finger = Finger.subject("a.h.", resolution=resolution, tissue="maeno1998")
    return Scene(
        finger=finger,
        indenter=indenter,
        motion=Ramp(60, depth, corner=0.0),
        ask=Ask(fields=False, strain=False, pressure=False),
    )


def leaves(table, path=()):
    """Yield the values in nested tables by their paths."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from leaves(value, (*path, key))
        else:
            yield (*path, key), value


def test_what_a_mechanics_does_not_give_or_no_press_was_like_has_no_error():
    lumped, *_, solid = plan.rungs(on(Flat(30), 0.7))
    assert (lumped.mechanics, lumped.errors) == ("lumped", {})
    assert set(solid.errors) == {"pressure", "area", "strain"}
    fine = np.arange(-4, 4.05, 0.1)
    relief = Relief.of(lambda x, y: 0.2 * np.cos(6 * x) + 0 * y, fine, fine)
    assert plan.rungs(on(relief, 0.7))[-1].errors == {}


def test_the_summary_is_that_of_the_held_out_scenes_of_the_report():
    held = read(HELD_OUT)
    found, kept = (dict(leaves(each)) for each in (summary(held["scenes"]), held["summary"]))
    assert found == pytest.approx(
        kept, rel=1e-9
    )  # a mean of logarithms rounds as the processor does
    assert held["summary"]["scenes"] + held["development"]["scenes"] >= 60


def test_the_planner_states_today_what_the_report_says_that_it_states():
    held, drawn = read(HELD_OUT)["scenes"], tradeoff_scenes.held_out()
    assert held.keys() <= drawn.keys()
    for key in list(held)[::6]:  # the suite states them for all
        stated = {rung.candidate.label: rung for rung in plan.rungs(drawn[key])}
        for name, row in held[key]["candidates"].items():
            told = {"force": stated[name].error, **stated[name].errors}
            known = {
                key: np.inf if value is None else value
                for key, value in row["stated"].items()
                if key in STATED  # strains of a type are stated where its spikes are asked
            }
            said = {key: told.get(key, np.inf) for key in known}
            assert {k: np.inf if np.isnan(v) else v for k, v in said.items()} == pytest.approx(
                known, rel=1e-3
            )
            assert (not _of_error(stated[name])) == row["willing"]


def _of_error(rung: Rung) -> list[str]:
    return [refusal.reason for refusal in rung.refusals]


def test_the_quick_cases_are_read_from_the_report():
    values = {case.name: case.measure() for case in suite.cases(quick=True)}
    kept = read(HELD_OUT)["summary"]["stated_kept"]["force"]
    # exact: handed on
    assert values["stated error kept by the planner's choices: force"] == kept
