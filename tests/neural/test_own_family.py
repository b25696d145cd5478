"""A family of afferents of a user's own: in a scene, seeded; spikes that cannot be are refused."""

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.neural.family import fire
from fefinger.neural.variation import Variation
from fefinger.support import registry
from fefinger.support.checks import InputError


TIME = np.linspace(0.0, 1.0, 11)


@pytest.fixture(autouse=True)
def own_registry(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry.AFFERENTS, "_things", dict(registry.AFFERENTS._things))


class Rising(ff.Family):
    """A spike where the input passes a half, and one at a random time."""

    name = "rising"

    def simulate(self, time, x_in, units):
        passed = [np.interp([0.5], x, time) for x in x_in.T]
        drawn = [random.uniform(time[0], time[-1], 1) for random in units.random]
        return [np.unique([*a, *b]) for a, b in zip(passed, drawn, strict=True)]


def test_units_take_the_largest_input_of_their_end_organs():
    drive = np.column_stack([0.4 * TIME, TIME, 0.8 * TIME])
    trains = fire(Rising(), TIME, drive, types=("SAI", "FAI"), unit=[0, 0, 1])
    np.testing.assert_array_equal(trains.x_in, drive[:, 1:])
    assert np.min(np.abs(trains.times[0] - 0.5)) < 1e-12
    assert np.min(np.abs(trains.times[1] - 0.625)) < 1e-12
    assert trains.family == "rising"


def test_noise_is_that_of_seed_trial_and_unit():
    def drawn(types, **choices):
        trains = fire(
            Rising(), TIME, 0 * TIME[:, None].repeat(len(types), 1), types=types,
            variation=Variation(seed=1, noise=None, **choices),
        )  # fmt: skip
        return [each[0] for each in trains.times]

    assert drawn(("SAI", "SAI")) == drawn(("SAI", "SAI"))
    assert drawn(("SAI", "SAI"))[0] != drawn(("SAI", "SAI"))[1]
    assert drawn(("SAI",)) != drawn(("SAI",), trial=1)


def test_a_scene_has_its_spikes():
    ff.register(Rising)
    scene = {"ask.afferents": "rising", "ask.spikes": ["SAI"], "ask.fields": False}
    result = ff.run("flat-press", changes=scene, mechanics="hertz")
    assert result.spikes.family == "rising"
    assert len(result.spikes.times[0]) == 2
    assert any("rising" in note for note in result.spikes.notes)


@pytest.mark.parametrize(
    ("spikes", "sentence"),
    [
        ([[0.1, np.nan]], "expected ascending spike times"),
        ([[0.3, 0.2]], "expected ascending spike times"),
        ([[0.3, 0.3]], "expected ascending spike times"),
        ([[0.3, 1.2]], "expected ascending spike times"),
        ([[[0.3]]], "expected ascending spike times"),
        ([], "expected spikes of 1 units, received 0"),
    ],
)
def test_spikes_that_cannot_be_are_refused(monkeypatch, spikes, sentence):
    monkeypatch.setattr(Rising, "simulate", lambda *_: spikes)
    with pytest.raises(InputError, match=sentence):
        fire(Rising(), TIME, TIME[:, None], types=("SAI",))


def test_names_that_are_unknown_or_taken_are_refused(monkeypatch):
    with refused("ask.afferents"):
        ff.Ask(afferents="rising")
    monkeypatch.setattr(Rising, "name", "thesis")
    with pytest.raises(InputError, match="'thesis' is the name of the package"):
        ff.register(Rising)
