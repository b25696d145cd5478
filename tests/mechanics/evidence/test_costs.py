"""Expected wall times: CPU seconds of finite strain are shared by the cores, all others are not."""

import pytest

from fefinger import plan
from fefinger.mechanics.evidence import costs
from fefinger.mechanics.situation import Situation
from fefinger.results.plan_text import expected_time
from fefinger.scene import builtin


@pytest.fixture
def rungs(monkeypatch):
    """Return the ladder of a scene by candidate, with so many threads."""

    def ladder(threads: int, **ask):
        monkeypatch.setattr(costs, "threads", lambda: threads)
        monkeypatch.setattr("fefinger.results.plan_text.threads", lambda: threads)
        scene = builtin.load("flat-press", {f"ask.{key}": value for key, value in ask.items()})
        return {rung.candidate.label: rung for rung in plan.rungs(scene)}

    return ladder


def test_threads_share_finite_strain_alone_and_rank_nothing(rungs) -> None:
    one, two = rungs(1), rungs(2)
    assert {name: rung.seconds for name, rung in one.items()} == pytest.approx(
        {name: rung.seconds for name, rung in two.items()}, nan_ok=True
    )
    assert one["solid standard"].wall == pytest.approx(one["solid standard"].seconds, rel=1e-12)
    shared = 1 - two["solid standard"].wall / two["solid standard"].seconds
    assert shared == pytest.approx(costs.coefficients()["shared"] / 2)
    assert two["linear standard"].wall == two["linear standard"].seconds
    assert expected_time(two["solid standard"]).endswith(" s on 2 cores")
    assert "cores" not in expected_time(two["linear standard"])


def test_of_a_press_to_be_built_the_threads_share_the_building(rungs) -> None:
    fine = rungs(4)["pressed fine"]
    shared = costs.coefficients()["shared"]
    assert 1 - shared < fine.wall / fine.seconds < 1 - 0.7 * shared


@pytest.mark.parametrize(("tissue", "shares"), [("maeno1998", False), ("calibrated_means", True)])
def test_threads_share_modal_only_where_tissue_stiffens(monkeypatch, tissue, shares) -> None:
    monkeypatch.setattr(costs, "threads", lambda: 2)
    changes = {"finger.tissue": tissue, "finger.resolution": "fine"}
    case = Situation.of(builtin.load("flat-press", changes))
    assert (costs.wall("modal", case, 100.0) < 100.0) == shares


def test_a_limit_of_seconds_is_one_of_wall_time(rungs) -> None:
    seconds = rungs(1)["solid standard"].seconds
    limit = 0.9 * seconds
    refused = [rung.field for rung in rungs(1, seconds=limit)["solid standard"].refusals]
    assert refused == ["ask.seconds"]
    assert not rungs(2, seconds=limit)["solid standard"].refusals
