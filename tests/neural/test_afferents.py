"""The chain from strain to spikes: invariances, the four types, notes and refusals."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from fefinger.neural.afferent_units import simulate_units
from fefinger.neural.checked_signals import count_changes
from fefinger.neural.drives import Reference, equivalent_displacements
from fefinger.neural.membranes import IntegrateAndFire
from fefinger.neural.recorded import simulate_recorded
from fefinger.neural.variation import Variation
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import TYPES


FLAT = np.diag([0.04, 0.05, -0.1])
UP = np.array([0.0, 0.0, 1.0])
REFERENCE = Reference(0.2, TYPES, np.array([UP] * 4), np.array([FLAT] * 4))


def press(speed=60.0, depth=1.5, hold=2.0, retract=0.0):
    """Ramp and hold with 10 ms corners, 0.2 ms apart while moving and growing to 50 ms in the hold.

    With `retract` (s) the plate returns at the same speed and stays away for that long.
    """
    corner = 0.01
    pieces = [(corner, 0, 1), (depth / speed - corner, 1, 1), (corner, 1, 0), (hold, 0, 0)]
    if retract:
        pieces += [(d, -a, -b) for d, a, b in pieces[:3]] + [(retract, 0, 0)]
    time, x = [np.zeros(1)], [np.zeros(1)]
    for length, v0, v1 in pieces:
        grown = np.cumsum(np.minimum(2e-4 * 1.3 ** np.arange(200), 0.05))
        moving = np.linspace(0, length, int(np.ceil(length / 2e-4)) + 1)[1:]
        s = moving if v0 or v1 else np.append(grown[grown < length], length)
        time.append(time[-1][-1] + s)
        x.append(x[-1][-1] + speed * (v0 * s + (v1 - v0) * s**2 / (2 * length)))
    return np.concatenate(time), np.concatenate(x)


def respond(time, x, types=TYPES, **options):
    return simulate_units(time, np.tile(x[:, None], len(types)), types=types, **options)


def test_a_press_fires_every_type_in_its_own_way():
    time, x = press(hold=5.0)
    trains = respond(time, x)
    sai, saii, fai, faii = trains.times
    assert trains.notes == ()
    for held, low, high in ((sai, 15, 25), (saii, 10, 20)):
        assert held[-1] > time[-1] - 0.1
        assert low < 1 / np.diff(held[held > 3.0]).mean() < high
    assert np.diff(sai)[:3].max() < np.diff(sai)[-3:].min()
    for fast in (fai, faii):
        assert 1 <= len(fast) < 5
        assert fast[-1] < 0.1


def test_fast_types_are_silent_in_the_hold_and_slow_ones_after_a_retraction():
    time, x = press(speed=32.0, depth=2.5, hold=1.0, retract=0.5)
    trains = respond(time, x)
    moved = 2.5 / 32 + 0.01
    for i, kind in enumerate(TYPES):
        if kind.startswith("FA"):
            assert not np.any((trains.times[i] > 0.2) & (trains.times[i] < moved + 1.0))
        else:
            assert not np.any(trains.times[i] > moved + 1.0 + 0.02)


def test_rates_in_the_ramp_grow_with_its_speed():
    first = []
    for speed in (2.0, 8.0, 32.0):
        trains = respond(*press(speed=speed, depth=2.5, hold=0.1), check=False)
        first.append([1 / np.diff(times)[0] for times in trains.times[:2]])
    assert np.all(np.diff(first, axis=0) > 0)


@pytest.mark.parametrize("generator", ["saturating", "linear"])
def test_sampling_the_same_signal_more_finely_gives_the_same_spikes(generator):
    time, x = press(hold=1.0)
    knots = np.unique(np.append(np.arange(0, len(time), 7), len(time) - 1))
    time, x = time[knots], x[knots]
    rng = np.random.default_rng(5)
    fine = np.unique(np.concatenate([time, rng.uniform(0, time[-1], 5000)]))
    a = respond(time, x, generator=generator, check=False)
    b = respond(fine, np.interp(fine, time, x), generator=generator, check=False)
    np.testing.assert_array_equal(a.count(), b.count())
    for one, other, blocked in zip(a.times, b.times, a.block_seconds, strict=True):
        # A membrane that leaves block does so at a time that the last digits decide.
        np.testing.assert_allclose(one, other, atol=5e-3 if blocked else 2e-5)


def test_a_flat_press_of_the_reference_gives_the_one_dimensional_case():
    time, x = press(hold=0.5)
    sites, unit = ("SAI", *TYPES, "FAI", "SAI"), [0, 0, 1, 2, 3, 2, 0]
    strain = (x / 0.2)[:, None, None, None] * np.array([FLAT] * 7)
    x_in = equivalent_displacements(strain, np.array([UP] * 7), sites, REFERENCE)
    np.testing.assert_allclose(x_in, np.tile(x[:, None], 7), rtol=1e-12, atol=1e-15)
    trains = simulate_units(time, x_in, types=TYPES, unit=unit)
    np.testing.assert_array_equal(trains.count(), respond(time, x).count())


def test_drives_can_be_chosen_per_type():
    _, x = press(hold=0.1)
    strain = (x / 0.2)[:, None, None, None] * np.diag([0.02, 0.0, -0.05])[None, None]
    x_in = equivalent_displacements(
        strain, UP[None], ("SAI",), REFERENCE, drives={"SAI": "tensile"}
    )
    np.testing.assert_allclose(x_in[:, 0], 0.02 / 0.05 * x, atol=1e-15)


def test_the_current_at_corners_is_that_of_the_filter_and_not_all_the_membrane_gets():
    time, x = np.array([0, 0.1, 0.35, 0.6]), np.array([[0.0], [0.0], [2.0], [2.0]])
    fine = np.union1d(time, np.linspace(0, 0.6, 601))
    few = simulate_units(time, x, types=["FAI"], check=False)
    many = simulate_units(fine, np.interp(fine, time, x[:, 0])[:, None], types=["FAI"], check=False)
    np.testing.assert_allclose(few.times[0], many.times[0], atol=1e-6)
    at = np.searchsorted(fine, time)
    np.testing.assert_allclose(few.current, many.current[at], atol=1e-9)
    lines = np.interp(fine, time, few.current[:, 0])
    assert np.abs(lines - many.current[:, 0]).max() > 1.0


def test_names_positions_and_signals_are_kept():
    time, x = press(hold=0.1)
    trains = respond(time, x, types=("FAI", "SAI", "FAI"), positions=np.eye(3), check=False)
    assert trains.names == ("FAI-1", "SAI", "FAI-2")
    np.testing.assert_array_equal(trains.positions, np.eye(3))
    assert trains.current.shape == trains.x_in.shape == (len(time), 3)
    assert (trains.t_start, trains.t_stop) == (time[0], time[-1])


def test_a_linear_generator_that_blocks_its_membrane_says_so():
    trains = respond(*press(depth=2.5, hold=1.0), types=("SAI",), generator="linear")
    assert trains.block_seconds[0] > 0.3
    assert any("depolarization block" in note for note in trains.notes)


def test_coarse_samples_of_a_moving_input_are_noted():
    time = np.linspace(0, 0.5, 501)
    wave = 0.1 * (1 - np.cos(2 * np.pi * 200 * time))
    notes = respond(time, wave).notes
    assert any("at samples more than 0.2 ms apart" in note for note in notes)
    assert any("every second sample" in note for note in notes)
    assert any("sodium activation frozen" in note for note in notes)


def test_counts_that_change_are_named():
    time, x = press(hold=0.3)
    a, b = respond(time, x, check=False), respond(time, 0.5 * x, check=False)
    sentences = count_changes(a.names, a.times, b.times, "the depth is halved")
    assert len(sentences) == int(np.sum(a.count() != b.count())) > 0
    assert sentences[0].startswith("SAI: the spike count changes from ")
    assert count_changes(a.names, a.times, a.times, "nothing is") == ()


@pytest.mark.parametrize("simulate", [simulate_units, simulate_recorded])
def test_spikes_that_do_not_count_change_no_count(simulate):
    """A vibration of which every second sample is nothing, and silence after it."""
    time = np.arange(200) * 5e-3
    x = np.where(time < 0.5, 0.5 * (np.arange(200) % 2), 0.0)
    given = {"types": ("SAI",), "delays": 0.02, "variation": Variation(seed=0)}
    whole = simulate(time, x[:, None], **given)
    assert any("SAI: the spike count changes" in note for note in whole.notes)
    late = simulate(time, x[:, None], since=0.8, **given)
    assert not any("spike count" in note for note in late.notes)
    assert late.t_start == 0.8
    assert late.count().tolist() == [0]
    last = whole.times[0][-1]
    only = simulate(time, x[:, None], since=last, **given).times[0]
    assert only.tolist() == pytest.approx([last], rel=1e-12)


@pytest.mark.parametrize(
    ("time", "drive", "options", "message"),
    [
        ([0, 1], np.zeros((2, 1)), {"types": ("SA1",)}, "Did you mean 'SAI'"),
        ([0, 1], np.zeros((2, 0)), {"types": ()}, "one afferent unit or more, received none"),
        ([0, 1], np.zeros((2, 2)), {"types": ("SAI",)}, "expected \\(n_t,\\)"),
        ([0, 0.5, 0.2], np.zeros((3, 1)), {"types": ("SAI",)}, "never decrease"),
        ([0, 1e6], np.zeros((2, 1)), {"types": ("SAI",)}, "at most 3600 s in one run"),
        ([0, 1], np.full((2, 1), np.nan), {"types": ("SAI",)}, "finite values"),
        ([0, np.nan], np.zeros((2, 1)), {"types": ("SAI",)}, "finite values"),
        ([0, 1], np.zeros((2, 1)), {"types": ("SAI",), "generator": "quadratic"}, "generator"),
        ([0, 1], np.zeros((2, 1)), {"types": ("SAI",), "names": ("a", "b")}, "names: .*received 2"),
        ([0, 1], np.zeros((2, 2)), {"types": ("SAI",) * 2, "names": ("a", "a")}, "received a more"),
        ([0, 1], np.zeros((2, 2)), {"types": ("SAI",) * 2, "names": "ab"}, "received 'ab'"),
        ([0, 1], np.zeros((2, 1)), {"types": ("SAI",), "dt": 0.0}, "dt: expected a finite"),
        ([0, 1], np.zeros((2, 1)), {"types": ("SAI",), "dt": np.nan}, "dt: expected a finite"),
        ([0, 1], np.zeros((2, 1)), {"types": ("SAI",), "dt": 1e-3}, "dt: .*at most 5e-05"),
        ([0, 1], np.zeros((2, 1)), {"types": ("SAI",), "lengths": [1, 2]}, "lengths: expected one"),
        (
            [0, 1],
            np.zeros((2, 1)),
            {"types": ("SAI",), "positions": [1.0, 2.0]},
            r"positions: expected \(1, 3\) mm for 1 units, received \(2,\)",
        ),
    ],
)
def test_unusable_signals_are_refused(time, drive, options, message):
    with pytest.raises(InputError, match=message):
        simulate_units(time, drive, **options)


@pytest.mark.parametrize(
    ("change", "drives", "message"),
    [
        ({"strain": np.zeros((4, 3, 3))}, {}, "clearly above zero"),
        ({"strain": np.array([-FLAT] * 4)}, {"SAI": "tangent"}, "above zero"),
        ({}, {"SAI": "stretch"}, "drives.SAI: expected one of"),
        ({}, {"SA": "tensile"}, "drives: expected one of"),
        ({"depth": 0.0}, {}, "reference.depth: expected a finite number in mm above 0"),
        ({"strain": FLAT}, {}, "reference.strain, reference.normals: expected"),
        (
            {
                "types": TYPES[1:],
                "strain": np.array([FLAT] * 3),
                "normals": np.array([UP] * 3),
            },
            {},
            "SAI is missing",
        ),
    ],
)
def test_unusable_references_are_refused(change, drives, message):
    reference, strain = replace(REFERENCE, **change), np.zeros((2, 1, 3, 3))
    with pytest.raises(InputError, match=message):
        equivalent_displacements(strain, UP[None], ("SAI",), reference, drives=drives)


def test_strain_of_the_wrong_shape_is_refused():
    with pytest.raises(InputError, match="expected \\(n_t, 1, 3, 3\\)"):
        equivalent_displacements(np.zeros((2, 3, 3)), UP[None], ("SAI",), REFERENCE)


def test_numba_is_imported_only_when_a_membrane_runs():
    code = (
        "import sys, fefinger.neural.drives, fefinger.neural.afferent_units;"
        "sys.exit(any(name in sys.modules for name in ('numba', 'scipy')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_requested_tolerance_is_kept_and_chooses_the_integrator():
    time, x = press(hold=1.0)
    exact = respond(time, x, check=False, dt=1e-5)
    for tolerance in (1e-3, 5e-5, 1e-6):
        response = respond(time, x, check=False, tolerance=tolerance)
        np.testing.assert_array_equal(response.count(), exact.count())
        errors = np.concatenate([a - b for a, b in zip(response.times, exact.times, strict=True)])
        assert np.quantile(np.abs(errors), 0.95) <= tolerance
    with refused("tolerance"):
        respond(time, x, tolerance=1e-3, membrane=IntegrateAndFire())


def test_many_units_are_fired_as_each_by_itself():
    time, x = press(hold=0.3)
    scale = np.linspace(0.2, 1.0, 37)
    types = tuple(np.tile(TYPES, 10)[:37])
    many = simulate_units(time, np.outer(x, scale), types=types, check=False)
    for i in (0, 5, 18, 35, 36):
        one = simulate_units(time, scale[i] * x[:, None], types=types[i : i + 1], check=False)
        np.testing.assert_allclose(many.times[i], one.times[0], atol=2e-6)


def test_many_sentences_of_a_kind_become_one():
    time, x = press(hold=0.3)
    trains = simulate_units(time, np.outer(x, np.ones(9)), types=("SAI",) * 9, generator="linear")
    assert any("(this or similar for 9 units)" in note for note in trains.notes)
    assert len(trains.notes) < 9


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (range(3, 12), "9 of 12 units change their spike count, by 11 at most, when it is"),
        ([4], "unit 4: the spike count changes from 0 to 4 when it is"),
    ],
)
def test_many_counts_that_change_become_one_sentence(changed, message):
    names = [f"unit {i}" for i in range(12)]
    before = [np.empty(0)] * 12
    after = [np.zeros(i if i in changed else 0) for i in range(12)]
    assert count_changes(names, before, after, "it is") == (message,)
