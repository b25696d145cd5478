"""A family of afferents of a user's own: in a scene, seeded; spikes that cannot be are refused."""

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.neural.variation import Variation
from fefinger.support.checks import InputError


TIME = np.linspace(0.0, 1.0, 11)

pytestmark = pytest.mark.usefixtures("own_registry")


class Rising(ff.Family):
    """A spike where the input passes a half, and one at a random time."""

    name = "rising"

    def simulate(self, time, x_in, units):
        passed = [np.interp([0.5], x, time) for x in x_in.T]
        drawn = [random.uniform(time[0], time[-1], 1) for random in units.random]
        return [np.unique([*a, *b]) for a, b in zip(passed, drawn, strict=True)]


def test_units_take_the_largest_input_of_their_end_organs():
    drive = np.column_stack([0.4 * TIME, TIME, 0.8 * TIME])
    trains = Rising().fire(TIME, drive, types=("SAI", "FAI"), unit=[0, 0, 1])
    np.testing.assert_array_equal(trains.x_in, drive[:, 1:])  # exact: the input itself, in part
    assert np.min(np.abs(trains.times[0] - 0.5)) < 1e-12
    assert np.min(np.abs(trains.times[1] - 0.625)) < 1e-12
    assert trains.family == "rising"


def test_noise_is_that_of_seed_trial_and_unit():
    def drawn(types, **choices):
        trains = Rising().fire(
            TIME, 0 * TIME[:, None].repeat(len(types), 1), types=types,
            variation=Variation(seed=1, noise=None, **choices),
        )  # fmt: skip
        return [each[0] for each in trains.times]

    assert drawn(("SAI", "SAI")) == drawn(("SAI", "SAI"))  # exact: one seed, twice
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
        (5, "failed with TypeError"),
    ],
)
def test_spikes_that_cannot_be_are_refused(monkeypatch, spikes, sentence):
    monkeypatch.setattr(Rising, "simulate", lambda *_: spikes)
    with pytest.raises(InputError, match=sentence):
        Rising().fire(TIME, TIME[:, None], types=("SAI",))


def test_drives_of_another_type_are_an_error_of_the_family(monkeypatch):
    monkeypatch.setattr(Rising, "drives", 5)
    with pytest.raises(InputError, match="family 'rising' failed with TypeError"):
        Rising().x_in(np.zeros((2, 1, 3, 3)), np.ones((1, 3)), ("SAI",), None, {})


def test_names_that_are_unknown_or_taken_are_refused(monkeypatch):
    with refused("ask.afferents"):
        ff.Ask(afferents="rising")
    monkeypatch.setattr(Rising, "name", "thesis")
    with refused("family.name"):
        ff.register(Rising)


class Counting(ff.Family):
    """A spike whenever the integral of the input passes a whole number."""

    name, limit = "counting", 0.01

    def simulate(self, time, x_in, units):
        dt = np.diff(time, prepend=time[0])
        area = np.cumsum((x_in + np.vstack([x_in[:1], x_in[:-1]])) / 2 * dt[:, None], axis=0)
        passed = np.diff(np.floor(area / self.limit), axis=0, prepend=0) > 0
        return [time[unit] for unit in passed.T]

    def stepper(self, units):
        return Sum(len(units.types), self.limit)


class Sum:
    """Integrals of the inputs."""

    def __init__(self, count, limit):
        self.count, self.limit = count, limit
        self.reset()

    def reset(self):
        self.area, self.last = np.zeros(self.count), np.zeros(self.count)

    def step(self, x_in, dt):
        before = self.area.copy()
        self.area += (x_in + self.last) / 2 * dt
        self.last = x_in
        passed = np.floor(self.area / self.limit) > np.floor(before / self.limit)
        return [(i, dt) for i in np.flatnonzero(passed)]


def stepped(family, types, unit=None, **options):
    normals = np.tile([0.0, 0.0, -1.0], (len(types), 1))
    return family.stepped(types, normals, unit=unit, reference=None, **options)


def test_stepped_units_fire_as_simulated_ones_on_the_same_strain():
    """Three end organs of two units, under strain that grows at different rates."""
    time = np.linspace(0.0, 1.0, 201)
    strain = np.zeros((len(time), 3, 6))
    # Rates whose last impulse is not at the end, where rounding would decide of it.
    strain[:, :, 2] = -np.array([0.1, 0.31, 0.21]) * time[:, None]
    strain[:, :, 0] = 0.5 * strain[:, :, 2]
    loop, found = stepped(Counting(), ("SAI", "SAI", "FAI"), unit=np.array([0, 0, 1])), []
    for before, now, row in zip(time[:-1], time[1:], strain[1:], strict=True):
        count = loop.step(row, now - before)
        assert count == len(loop.fired())
        found += loop.fired()
    drive = -strain[:, :, 2]
    whole = Counting().fire(time, drive, types=("SAI", "FAI"), unit=[0, 0, 1])
    for unit, times in enumerate(whole.times):
        assert len(times) > 5
        each = np.array([at for number, at in found if number == unit])
        np.testing.assert_allclose(each, times, rtol=1e-9)
    loop.reset()
    assert loop.step(strain[1], 0.0) == 0


def test_stepped_units_refuse_strain_that_is_none_and_spikes_beyond_the_step(monkeypatch):
    loop = stepped(Counting(), ("SAI",))
    with refused("strain"):
        loop.step(np.full((1, 6), np.nan), 1e-3)
    for spike, limit in (((1, 0.0), "unit 1"), ((0, 2.0), "after 2.0 s")):
        monkeypatch.setattr(loop.stepper, "step", lambda *_, spike=spike: [spike])
        with pytest.raises(InputError, match=limit):
            loop.step(np.zeros((1, 6)), 1e-3)
    with pytest.raises(InputError, match="'rising', which has none"):
        stepped(Rising(), ("SAI",))


def test_a_loop_and_a_series_take_the_family_by_name(operators):
    ff.register(Counting)
    loop = ff.Loop(
        ff.Finger(width=14, thickness=11, resolution="coarse", tissue="maeno1998"),
        ff.Sphere(5.0),
        mechanics="condensed",
        deepest=0.5,
    )
    units = loop.afferents(family="counting")
    fired = sum(units.step(loop.step(0.05, depth=0.5 * k / 10).strain, 0.05) for k in range(11))
    assert fired > 0
    trains = ff.spikes(TIME, 0.1 * TIME, types=("SAI",), family="counting", corners=True)
    assert len(trains.times[0]) == 5
    with refused("generator"):
        ff.spikes(TIME, TIME, types=("SAI",), family="counting", generator="linear")


def test_a_scene_refuses_what_the_family_leaves_no_choice_of():
    ff.register(Counting)
    with refused("ask.generator"):
        ff.Ask(afferents="counting", generator="linear")
    with refused("ask.population.rule"):
        ff.Ask(spikes=("SAI",), afferents="counting", population=ff.Scatter(rule="first"))
    assert ff.Ask(afferents="counting", drives={"SAI": "energy"}).drives["SAI"] == "energy"
