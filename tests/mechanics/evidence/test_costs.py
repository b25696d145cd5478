"""Expected wall times: CPU seconds of finite strain are shared by the cores, all others are not."""

from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.evidence import afferent_cost, cost_table

import fefinger as ff
from fefinger import plan
from fefinger.mechanics import get
from fefinger.mechanics.evidence import costs
from fefinger.mechanics.evidence.presses import read
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.results.result_record import expected_time
from fefinger.scene import builtin
from fefinger.support.machine import REPORTED
from fefinger.support.vocabulary import FAMILIES, Control


@pytest.fixture
def rungs(monkeypatch):
    """Return the ladder of a scene by candidate, with so many threads."""

    def ladder(threads: int, **ask):
        monkeypatch.setattr(costs, "threads", lambda: threads)
        monkeypatch.setattr("fefinger.results.result_record.threads", lambda: threads)
        asked = {"spikes": []} | ask
        scene = builtin.load("flat-press", {f"ask.{key}": value for key, value in asked.items()})
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


ROWS = [row for row in read(cost_table.AFFERENTS)["rows"] if row["seconds"] > 0.05]


@pytest.mark.parametrize("label", {row["candidate"]: None for row in ROWS})
def test_answers_took_what_is_expected(label, monkeypatch) -> None:
    """Within a factor of two, for most; the scenes differ in end organs, steps, fields and length.

    The coefficients of small strain and of `solid` are from other scenes.
    """
    measured = read(cost_table.AFFERENTS)
    monkeypatch.setattr(costs, "slowness", lambda _: measured["machine_seconds"] / REPORTED)
    ratios, candidate = [], Candidate.of(label)
    mechanics = get(candidate.mechanics)
    for row in (row for row in ROWS if row["candidate"] == label):
        number = list(afferent_cost.VARIANTS).index(row["variant"])
        changes = afferent_cost.VARIANTS[row["variant"]]
        case = Situation.of(afferent_cost.scene(candidate, changes, number))
        expected = mechanics.cost(case) - mechanics.once(case) + costs.spike_seconds(case)
        ratios.append((row["seconds"] + row["spike_seconds"]) / expected)
    assert np.median(ratios) == pytest.approx(1.0, rel=0.5)
    assert max(ratios) < 2.5
    assert min(ratios) > 0.4


def test_the_check_of_spikes_on_a_coarser_mesh_is_expected_and_runs_beside_a_slow_answer(
    rungs, monkeypatch
) -> None:
    monkeypatch.setattr(costs, "BESIDE", 0.0)
    spikes = ["SAI"]
    silent = rungs(1)["linear standard"]
    one, two = (rungs(threads, spikes=spikes)["linear standard"] for threads in (1, 2))
    coarse = rungs(1, fields=False, pressure=False)["linear coarse"]
    assert one.seconds - silent.seconds == pytest.approx(coarse.seconds, rel=0.1)
    assert one.wall == pytest.approx(one.seconds, rel=1e-9)
    assert one.wall - two.wall == pytest.approx(coarse.seconds, rel=0.1)


LAYOUTS = {
    "scatter": (ff.Scatter(radius=4.0), 35 * 5.5 + 70 * 14.5),
    "grid": (ff.Grid(spacing=1.0, radius=2.0), 13 * 5.5 + 13 * 14.5),
    "line": (ff.Line(start=(0.0, 0.0), stop=(2.0, 0.0), count=5), 5 * 5.5 + 5 * 14.5),
    "places": (ff.Places(places=((0.0, 0.0), (1.0, 0.0))), 2 * 5.5 + 2 * 14.5),
}


@pytest.mark.parametrize("kind", LAYOUTS)
def test_end_organs_are_counted_before_they_are_placed(kind) -> None:
    layout, expected = LAYOUTS[kind]
    ask = ff.Ask(spikes=("SAI", "FAI"), population=layout)
    assert costs.organs(ask) == pytest.approx(expected, rel=0.02)
    assert costs.organs(replace(ask, population=None)) == pytest.approx(2)


@pytest.mark.parametrize(
    ("mechanics", "took"), [("pressed", 4.4), ("hertz", 2.4), ("layered", 2.7)]
)
def test_depths_under_a_force_are_sought_at_the_cost_they_took(monkeypatch, mechanics, took):
    """Seconds of 20,001 steps of a sine under a ball, on the coarse mesh."""
    monkeypatch.setattr(costs, "slowness", lambda _: 1.0)
    lean = {"spikes": [], "fields": False, "strain": False, "pressure": False}
    changes = {"finger.resolution": "coarse"} | {f"ask.{key}": no for key, no in lean.items()}
    scene = builtin.load("sphere-press", changes)
    motion = ff.Sinusoid(amplitude=0.003, frequency=5, cycles=100, control=Control.FORCE)
    case = Situation.of(replace(scene, motion=motion))
    found = get(mechanics)
    assert found.cost(case) - found.once(case) == pytest.approx(took, rel=0.5)


def test_a_grip_that_creeps_costs_as_many_steps_as_it_took(monkeypatch) -> None:
    """Under 0.5 N for 30 s with a coefficient of 1.5 (`linear`, coarse mesh) 1.3 s of contact.

    On a whole finger, under letters, 5.3 s (CPU seconds on the machine of the reports).
    """
    finger = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")
    motion = ff.Trapezoid(loading_rate=1.0, force=0.5, hold=30.0)
    monkeypatch.setattr(costs, "slowness", lambda _: 1.0)
    for half, took in ((True, 1.3), (False, 5.3)):
        seconds = []
        for friction in (0.0, 1.5):
            plate = ff.Flat(30, tilt=0 if half else 5, friction=friction)
            scene = ff.Scene(finger=finger, indenter=plate, motion=motion)
            case = Situation.of(scene)
            assert case.half == half
            seconds.append(costs.linear_seconds(case))
        assert took / 2 < seconds[1] - seconds[0] < 2 * took


@pytest.mark.parametrize(
    ("mesh", "depth", "took"),
    [("coarse", 3.0, 2.6), ("standard", 0.5, 6.8), ("standard", 1.5, 37.8)],
)
def test_a_press_in_which_skin_slips_costs_what_it_took(
    monkeypatch, mesh: str, depth: float, took: float
) -> None:
    """With a coefficient of 0.2 by `linear`, CPU seconds; without friction 0.4 and 2.9."""
    monkeypatch.setattr(costs, "slowness", lambda _: 1.0)
    finger = ff.Finger.subject("a.h.", tissue="maeno1998", resolution=mesh)
    motion = ff.RampHold(speed=20, depth=depth, hold=0.05)
    ask = ff.Ask(strain=False, fields=False)
    scene = ff.Scene(finger=finger, indenter=ff.Flat(30, friction=0.2), motion=motion, ask=ask)
    assert took / 2 < costs.linear_seconds(Situation.of(scene)) < 2 * took


@pytest.mark.parametrize("family", FAMILIES)
def test_spikes_of_a_long_hold_cost_as_it_lasts(family) -> None:
    def seconds(hold: float) -> float:
        changes = {"motion.hold": hold, "ask.afferents": family}
        return costs.spike_seconds(Situation.of(builtin.load("flat-press", changes)))

    assert seconds(100.0) - seconds(50.0) == pytest.approx(seconds(150.0) - seconds(100.0), rel=0.1)
    assert seconds(100.0) > 20 * seconds(0.5)
