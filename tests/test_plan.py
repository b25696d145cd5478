"""The planner: the cheapest mechanics that does not refuse, and what it says about the others."""

from types import SimpleNamespace

import pytest

from fefinger import mechanics, plan, scenes
from fefinger.checks import InputError
from fefinger.records import Refusal


def rung(name, *, seconds, error, refusals=()):
    def measured(scene):
        if any(refusal.about == "ability" for refusal in refusals):
            pytest.fail("the cost of what cannot be done was asked")
        return seconds

    return SimpleNamespace(
        name=name,
        refuse=lambda scene: refusals,
        cost=measured,
        error=lambda scene: (error, f"reports/{name}.json"),
    )


UNABLE = Refusal("lumped", "ability", "strain: asked, but it gives none")
THIN = Refusal("hertz", "accuracy", "contact radius / tissue thickness = 0.9 > 0.1")
LADDER = {
    "lumped": rung("lumped", seconds=1e-5, error=0.01, refusals=(UNABLE,)),
    "hertz": rung("hertz", seconds=1e-3, error=0.02, refusals=(THIN,)),
    "linear": rung("linear", seconds=30.0, error=0.03),
    "solid": rung("solid", seconds=600.0, error=0.001),
}


@pytest.fixture(autouse=True)
def _four_rungs(monkeypatch):
    monkeypatch.setattr(mechanics, "names", lambda: tuple(LADDER))
    monkeypatch.setattr(mechanics, "get", LADDER.__getitem__)


def scene(**changes):
    return scenes.load("flat-press", {f"ask.{name}": value for name, value in changes.items()})


def test_the_cheapest_that_does_not_refuse_is_chosen_and_all_are_listed():
    found = plan.explain(scene())
    assert found.mechanics == "linear"
    assert found.chosen.evidence == "reports/linear.json"
    assert [rung.mechanics for rung in found.rungs] == list(LADDER)
    assert [rung.refusals for rung in found.rungs] == [(UNABLE,), (THIN,), (), ()]
    assert "linear, the cheapest that does not refuse" in found.sentence
    assert "expected error 0.03 (reports/linear.json), about 30 s" in found.sentence


def test_a_smaller_error_costs_more():
    found = plan.explain(scene(rel_error=0.01))
    assert found.mechanics == "solid"
    assert found.rungs[2].refusals[0].reason == (
        "expected relative error = 0.03 > 0.01 (ask.rel_error)"
    )


def test_when_nobody_answers_the_reasons_are_listed_with_what_to_relax():
    with pytest.raises(InputError) as caught:
        plan.explain(scene(rel_error=0.01, seconds=60))
    message = str(caught.value)
    assert "lumped: ability: strain: asked, but it gives none" in message
    assert "hertz: accuracy: contact radius / tissue thickness = 0.9 > 0.1" in message
    assert "linear: accuracy: expected relative error = 0.03 > 0.01" in message
    assert "solid: time: expected time = 6e+02 s > 60 s (ask.seconds)" in message
    assert "Relax ask.rel_error or ask.seconds" in message


def test_a_named_mechanics_runs_in_spite_of_its_accuracy_which_is_recorded():
    found = plan.choose(scene(), "hertz")
    assert (found.mechanics, found.overridden) == ("hertz", (THIN,))
    assert "It would have refused: contact radius / tissue thickness" in found.sentence
    assert plan.choose(scene(), "solid").overridden == ()


def test_a_named_mechanics_does_not_run_beyond_its_ability():
    with pytest.raises(InputError, match="'lumped' cannot answer this scene\n  lumped: ability"):
        plan.choose(scene(), "lumped")


def test_an_unknown_mechanics_gets_the_nearest_name():
    with pytest.raises(InputError, match=r"mechanics: .*Did you mean 'linear'\?"):
        plan.choose(scene(), "liner")
