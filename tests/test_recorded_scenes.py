"""Scenes whose afferents are of the family `recorded`: what they ask, and what they get."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.afferents import fire
from fefinger.commands.run import fired_record
from fefinger.mechanics import get
from fefinger.neural.drives import DRIVE_BY_NAME
from fefinger.neural.recorded import fitted
from fefinger.neural.statistics import psth
from fefinger.neural.trains import SpikeTrains
from fefinger.scene import builtin
from fefinger.scene.motions import Vibration
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import FAMILIES, TYPES


FINGER = ff.Finger.subject("a.h.", resolution="coarse")
PRESS = ff.Trapezoid(speed=20, depth=0.6, hold=0.2, corner=0.01)
BARE = {"fields": False, "pressure": False}


@pytest.fixture(scope="module")
def pressed():
    """Return a scene of the family, and the response to it."""
    ask = ff.Ask(spikes=TYPES, afferents="recorded", **BARE)
    scene = ff.Scene(finger=FINGER, motion=PRESS, ask=ask)
    return scene, get("hertz").respond(scene)


def test_a_scene_says_its_family_and_keeps_it_in_toml():
    scene = ff.Scene(finger=FINGER, motion=PRESS, ask=ff.Ask(spikes=("SAI",), afferents="recorded"))
    assert ff.Scene.from_toml(scene.to_toml()) == scene  # exact: TOML has every digit
    assert ff.Ask().afferents == FAMILIES[0]
    with refused("ask.afferents"):
        ff.Ask(afferents="recordd")


@pytest.mark.parametrize(
    ("options", "field", "value"),
    [
        ({"drives": {"SAI": "energy"}}, "ask.drives", "'energy'"),
        ({"generator": "linear"}, "ask.generator", "'linear'"),
        ({"population": ff.Scatter(rule="first")}, "ask.population.rule", "'first'"),
    ],
)
def test_choices_of_the_thesis_alone_are_refused(options, field, value):
    with pytest.raises(InputError, match=f"{field}: expected the default .* received .*{value}"):
        ff.Ask(spikes=("SAI",), afferents="recorded", **options)
    ff.Ask(spikes=("SAI",), afferents="thesis", **options)


def test_the_input_of_a_unit_is_the_length_of_its_type_times_its_drive(pressed):
    scene, response = pressed
    trains = fire(scene.ask, response, check=False)
    assert trains.family == "recorded"
    assert "family recorded" in trains.notes[0]
    for i, kind in enumerate(trains.types):
        unit = fitted()[kind]
        drive = DRIVE_BY_NAME[unit.drive](response.strain, response.sites.normals)[:, i]
        assert trains.x_in[:, i] == pytest.approx(unit.length * drive)
    thesis = fire(replace(scene.ask, afferents="thesis"), response, check=False)
    assert thesis.family == "thesis"


@pytest.mark.usefixtures("plain_report")
@pytest.mark.parametrize("layout", [None, ff.Line(start=(0, -1), stop=(0, 1), count=2, seed=3)])
def test_trials_are_of_the_same_units_and_need_no_other_solution(layout, tmp_path):
    ask = ff.Ask(spikes=("SAI", "FAI"), population=layout, **BARE)
    scene = ff.Scene(finger=FINGER, motion=PRESS, ask=ask)
    result = ff.run(scene, mechanics="hertz")
    third = ff.run(replace(scene, ask=replace(ask, trial=3)), mechanics="hertz").spikes
    result.save(tmp_path)
    for each in (result, ff.load(tmp_path)):
        for trial, expected in ((0, result.spikes), (3, third)):
            found = each.fire(trial=trial)
            assert (found.trial, found.seed) == (trial, expected.seed)
            assert found.names == expected.names
            # exact: one seed, twice, from one strain
            assert all(map(np.array_equal, found.times, expected.times))
    np.testing.assert_allclose(third.x_in, result.spikes.x_in, rtol=1e-12)
    np.testing.assert_allclose(third.current, result.spikes.current, rtol=1e-12)
    assert not any(map(np.array_equal, third.times, result.spikes.times))
    trials = [result.fire(trial=k).times[0] for k in range(5)]
    rate = psth(trials, np.linspace(0, result.time[-1], 11))
    assert rate.sum() * result.time[-1] / 10 == pytest.approx(np.mean([len(t) for t in trials]))


def test_trials_without_noise_are_noted_and_without_strain_refused(pressed):
    scene, response = pressed
    for changes in (
        {"afferents": "thesis"},
        {"population": ff.Line(start=(0, -1), stop=(0, 1), noise=0.0)},
    ):
        ask = replace(scene.ask, trial=2, **changes)
        found = get("hertz").respond(replace(scene, ask=ask))
        assert any("every trial is the same" in note for note in fire(ask, found).notes)
    assert not any("trial" in note for note in fire(replace(scene.ask, trial=2), response).notes)
    bare = replace(scene, ask=replace(scene.ask, strain=False))
    assert ff.run(bare, mechanics="hertz").fire(trial=1).trial == 1  # from the input of its units
    with refused("ask.strain"):
        squid = replace(bare, ask=replace(bare.ask, afferents="thesis"))
        ff.run(squid, mechanics="hertz").fire(trial=1)
    with refused("ask.trial"):
        replace(scene.ask, trial=-1)
    assert "trial" not in scene.to_toml()
    other = replace(scene, ask=replace(scene.ask, trial=2))
    assert ff.Scene.from_toml(other.to_toml()) == other  # exact: TOML has every digit


def test_spikes_before_a_time_do_not_count(pressed):
    scene, response = pressed
    whole = fire(scene.ask, response, check=False)
    late = fire(scene.ask, response, since=0.05, check=False)
    assert late.t_start == 0.05
    for all_times, times in zip(whole.times, late.times, strict=True):
        # exact: the same spikes, some left out
        assert np.array_equal(times, all_times[all_times >= 0.05])
    record = fired_record(late)
    span = late.t_stop - late.t_start
    assert record["afferents"] == "recorded"
    assert record["spikes"] == dict(zip(TYPES, late.count().tolist(), strict=True))
    assert record["rates_Hz"]["SAI"] == pytest.approx(len(late.times[0]) / span)


def test_units_of_a_population_differ_by_default_and_not_when_told(pressed):
    scene = replace(pressed[0], motion=replace(PRESS, depth=1.5))  # every unit fires
    line = ff.Line(start=(0, 0), stop=(0, 1e-3), count=4)
    trains = []
    for layout in (line, replace(line, spread=0.0, noise=0.0), replace(line, seed=1)):
        ask = replace(scene.ask, spikes=("SAII",), population=layout)
        response = get("hertz").respond(replace(scene, ask=ask))
        trains.append(fire(ask, response, check=False))
    drawn, alike, other = (len({tuple(np.round(t, 4)) for t in each.times}) for each in trains)
    assert (drawn, alike, other) == (4, 1, 4)
    assert not np.array_equal(trains[0].times[0], trains[2].times[0])


def test_the_family_is_in_files_and_on_the_page(pressed, tmp_path, monkeypatch):
    monkeypatch.setattr("fefinger.pages.page.svg", lambda drawn: "data:,")
    scene, response = pressed
    trains = fire(scene.ask, response, check=False)
    trains.to_npz(tmp_path / "spikes.npz")
    assert SpikeTrains.from_npz(tmp_path / "spikes.npz").family == "recorded"
    result = ff.run(scene, mechanics="hertz")
    result.save(tmp_path / "out")
    assert ff.load(tmp_path / "out").spikes.family == "recorded"
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "family recorded" in page


@pytest.mark.parametrize("name", ["probe-vibration", "pin-hold", "curved-hold"])
def test_the_experiments_are_scenes_of_the_family(name):
    scene = builtin.load(name, {})
    assert scene.ask.afferents == "recorded"
    assert not [kind for kind in scene.ask.spikes if kind not in TYPES]


def test_a_vibration_counts_from_its_start_and_follows_its_settings():
    scene = builtin.load("probe-vibration", {"motion.frequency": 300, "motion.amplitude": 0.02})
    assert isinstance(scene.motion, Vibration)
    assert scene.motion.duration - scene.motion.recorded_from == pytest.approx(1.0)
    assert scene.motion.recorded_from == pytest.approx(120.0, abs=0.1)


def test_a_stored_scene_that_is_older_than_the_families_is_of_the_thesis():
    scene = ff.Scene(finger=FINGER, motion=PRESS, ask=ff.Ask(spikes=("SAI",)))
    assert ff.Scene.from_stored(scene.to_toml()) == scene  # exact: TOML has every digit
    older = "\n".join(line for line in scene.to_toml().splitlines() if "afferents" not in line)
    assert ff.Scene.from_stored(older).ask.afferents == "thesis"
