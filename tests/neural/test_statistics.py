"""Numbers of spike trains against their definitions."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from refusals import refused

from fefinger.neural import (
    interval_variation,
    intervals,
    locking,
    mean_rates,
    per_cycle,
    psth,
    van_rossum,
    victor_purpura,
)
from fefinger.neural.trains import SpikeTrains
from fefinger.support.checks import InputError


RNG = np.random.default_rng(4)
PAIRS = [
    (np.sort(RNG.uniform(0, 1, n)), np.sort(RNG.uniform(0, 1, m)))
    for n, m in [(0, 0), (0, 3), (1, 1), (4, 3), (5, 5)]
]
EVERY_PAIR = pytest.mark.parametrize(("a", "b"), PAIRS)


def test_rates_count_the_spikes_of_a_window():
    trains = SpikeTrains(
        types=("SAI", "FAI"),
        names=("SAI", "FAI"),
        times=(np.array([0.1, 0.5, 0.9, 1.0]), np.zeros(0)),
        t_start=0.0,
        t_stop=1.0,
        time=np.array([0.0, 1.0]),
        x_in=np.zeros((2, 2)),
        current=np.zeros((2, 2)),
        peak_mV=np.zeros(2),
        block_seconds=np.zeros(2),
        stimulus_driven=np.zeros(2, np.int64),
    )
    np.testing.assert_allclose(mean_rates(trains, 0.5, 1.0), [4.0, 0.0])
    np.testing.assert_allclose(mean_rates(trains), [3.0, 0.0])
    np.testing.assert_allclose(mean_rates(trains, stop=0.5), [2.0, 0.0])
    np.testing.assert_allclose(mean_rates(trains, 0.5, 1.0 + 1e-12), [4.0, 0.0])
    counted = replace(trains, t_start=0.4, times=(trains.times[0][1:], trains.times[1]))
    np.testing.assert_allclose(mean_rates(counted), [2 / 0.6, 0.0])
    for window in ((100.0, 101.0), (-0.1, 0.5), (0.5, 1.1)):
        with pytest.raises(InputError, match=r"start, stop: expected times from 0 to 1 s"):
            mean_rates(trains, *window)
    with pytest.raises(InputError, match=r"from 0.4 to 1 s.* received 0 to 1 s"):
        mean_rates(counted, 0.0, 1.0)
    with refused("stop"):
        mean_rates(trains, 1.0, 1.0)


def test_intervals_and_their_variation():
    np.testing.assert_allclose(intervals([0.1, 0.3, 0.6]), [0.2, 0.3])
    assert interval_variation(np.arange(5.0)) == 0.0
    assert np.isnan(interval_variation([0.0, 1.0]))
    random = np.cumsum(np.random.default_rng(0).exponential(size=20_000))
    assert interval_variation(random) == pytest.approx(1.0, abs=0.03)


def test_a_histogram_over_trials_integrates_to_the_mean_count():
    trials, edges = [[0.1, 0.2], [0.25], []], np.array([0.0, 0.15, 0.3, 1.0])
    rate = psth(trials, edges)
    np.testing.assert_allclose(rate, np.array([1, 2, 0]) / (3 * np.diff(edges)))
    assert rate @ np.diff(edges) == pytest.approx(1.0)
    array = np.array([[0.1, 0.2], [0.25, 0.26]])
    np.testing.assert_allclose(psth(array, edges), psth(array.tolist(), edges), rtol=1e-12)


@pytest.mark.parametrize("phase", [0.0, 90.0, 250.0])
def test_spikes_at_one_phase_lock_wholly(phase):
    times = 0.5 + (np.arange(20) + phase / 360) / 8.0
    actual = locking(times, 8.0, start=0.5)
    assert actual.strength == pytest.approx(1.0)
    assert (actual.phase - phase + 180) % 360 == pytest.approx(180.0)
    assert actual.chance < 1e-8


def test_spikes_at_opposite_phases_cancel_and_no_spikes_say_nothing():
    assert locking([0.0, 0.5], 1.0).strength == pytest.approx(0.0, abs=1e-15)
    silent = locking([], 1.0)
    assert silent.spikes == 0
    assert np.isnan([silent.strength, silent.phase, silent.chance]).all()


def test_the_chance_of_locking_is_that_of_random_phases():
    rng = np.random.default_rng(7)
    trials = [locking(np.sort(rng.uniform(0, 1, 20)), 1.0).chance for _ in range(4000)]
    for level in (0.05, 0.2, 0.5):
        error = 4 * np.sqrt(level * (1 - level) / 4000)
        assert np.mean(np.array(trials) < level) == pytest.approx(level, abs=error)


def test_impulses_per_cycle():
    assert per_cycle([0.1, 0.2, 1.1, 1.2, 2.0], 1.0, 0.0, 2.0) == 2.0
    assert per_cycle([0.1, 0.2], 4.0, 0.0, 1.0) == 0.5
    assert per_cycle([0.1, 1.1, 1.2, 1.3], 2.0, 1.0, 1.5) == 3.0


@EVERY_PAIR
@pytest.mark.parametrize("tau", [0.01, 0.3])
def test_van_rossum_is_its_integral(a, b, tau):
    """Exact between spikes: the difference decays as exp(-t / tau) there."""
    times = np.sort(np.concatenate([a, b]))
    total = 0.0
    for i, start in enumerate(times):
        level = np.sum(np.exp(-(start - a[a <= start]) / tau))  # exact: start is one of the times
        # exact: start is one of the times
        level -= np.sum(np.exp(-(start - b[b <= start]) / tau))
        stop = times[i + 1] if i + 1 < len(times) else np.inf
        total += level**2 / 2 * -np.expm1(-2 * (stop - start) / tau)
    assert van_rossum(a, b, tau) == pytest.approx(np.sqrt(total), abs=1e-7)


@EVERY_PAIR
@pytest.mark.parametrize("cost", [0.0, 3.0, 1e6])
def test_victor_purpura_is_the_cheapest_of_all_matchings(a, b, cost):
    """All ways to pair k spikes of one with k of the other, in order."""
    best = np.inf
    for k in range(min(len(a), len(b)) + 1):
        for i in combinations(a, k):
            for j in combinations(b, k):
                moved = cost * np.abs(np.subtract(i, j)).sum()
                best = min(best, len(a) + len(b) - 2 * k + moved)
    assert victor_purpura(a, b, cost) == pytest.approx(best)


@EVERY_PAIR
def test_distances_are_symmetric_and_zero_to_oneself(a, b):
    assert victor_purpura(a, b, 5.0) == pytest.approx(victor_purpura(b, a, 5.0))
    assert van_rossum(a, b, 0.1) == pytest.approx(van_rossum(b, a, 0.1), abs=1e-7)
    assert victor_purpura(a, a, 5.0) == 0.0
    assert van_rossum(a, a, 0.1) == pytest.approx(0.0, abs=1e-7)


def test_one_more_spike_costs_what_the_definitions_say():
    assert van_rossum([0.5], [], 0.1) == pytest.approx(np.sqrt(0.5))
    assert victor_purpura([0.5], [], 10.0) == 1.0


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda: intervals([1.0, 0.5]), "times"),
        (lambda: intervals("0.1 0.2"), "times"),
        (lambda: intervals([[0.1, 0.2], [0.3]]), "times"),
        (lambda: psth([], [0.0, 1.0]), "trials"),
        (lambda: psth(np.empty((0, 3)), [0.0, 1.0]), "trials"),
        (lambda: psth([[0.5]], [1.0, 0.0]), "edges"),
        (lambda: psth([[0.5]], [0.0, np.inf]), "edges"),
        (lambda: locking([0.5], 0.0), "frequency"),
        (lambda: locking([0.5], 1.0, start=np.nan), "start"),
        (lambda: van_rossum([], [], 0.0), "tau"),
        (lambda: victor_purpura([], [], -1.0), "cost"),
    ],
)
def test_unusable_input_is_refused(call, field):
    with refused(field):
        call()
