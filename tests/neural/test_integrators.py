"""The integrators of the Hodgkin-Huxley membrane against each other and against their orders."""

import numpy as np
import pytest

from fefinger.neural.membranes import METHODS, HodgkinHuxley
from fefinger.support.checks import InputError


STANDARD, SLOWED, WARM = HodgkinHuxley(1.0), HodgkinHuxley(6.0), HodgkinHuxley(1.0, 16.3)
SPEEDS = pytest.mark.parametrize(
    "membrane", [STANDARD, SLOWED, WARM], ids=["standard", "slowed", "warm"]
)

RAMP = np.array([0.0, 0.05, 0.2])
LEVELS = np.outer([0.0, 1.0, 1.0], [0.0, 3.0, 8.0, 15.0, 30.0, 55.0])


@pytest.fixture(scope="module")
def truths():
    return {
        membrane: membrane.fire(RAMP, LEVELS, method="adaptive", stimulus_driven=False)
        for membrane in (STANDARD, SLOWED, WARM)
    }


@pytest.mark.parametrize("tolerance", [2e-4, 5e-5, 1e-5, 1e-7, 1e-9])
@SPEEDS
def test_spike_times_are_as_good_as_was_asked(truths, membrane, tolerance):
    firing = membrane.fire(RAMP, LEVELS, tolerance=tolerance, stimulus_driven=False)
    counts = [len(times) for times in truths[membrane].times]
    assert [len(times) for times in firing.times] == counts
    assert sum(counts) > 10
    errors = np.abs(np.concatenate(firing.times) - np.concatenate(truths[membrane].times))
    assert np.quantile(errors, 0.95) < tolerance


def test_a_finer_tolerance_never_takes_a_coarser_way():
    for membrane in (STANDARD, SLOWED):
        chosen = [membrane.integrator(t) for t in np.geomspace(1e-2, 1e-15, 60)]
        ranks = [METHODS.index(method) for method, _ in chosen]
        assert ranks == sorted(ranks)
        assert set(ranks) == {0, 1, 2}
        for name in METHODS[:2]:
            steps = [dt for method, dt in chosen if method == name]
            assert steps == sorted(steps, reverse=True)


@pytest.mark.parametrize(
    ("method", "order", "largest"), [("splitting", 2, 0.03), ("runge-kutta", 4, 1e-3)]
)
def test_the_error_falls_with_the_order_also_on_uneven_samples(method, order, largest):
    time = np.array([0.0, 0.31e-3, 2e-3, 2e-3, 2.05e-3, 4.3e-3, 12e-3])
    current = np.array([15.0, 22.0, 15.0, 3.0, 3.0, -2.0, 4.0])
    (truth,) = STANDARD.fire(time, current, method="adaptive").final
    steps = np.array([5e-5, 2.5e-5, 1.25e-5])
    errors = [
        np.abs(STANDARD.fire(time, current, method=method, dt=dt).final[0] - truth).max()
        for dt in steps
    ]
    slopes = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert np.all(np.abs(slopes - order) < 0.3), (slopes, errors)
    assert errors[0] < largest


@pytest.mark.parametrize("edge", [0.0, 1e-12, 1e-9])
def test_the_adaptive_method_bends_beside_the_steepest_edge(edge):
    """Where the edge has no width it is given by two neighboring numbers."""
    before = 0.1 - edge if edge else np.nextafter(0.1, 0)
    bent, current = [0.2, 0.25, 0.3], [20.0, 0.0, 0.0]
    steep = STANDARD.fire([0, before, 0.1, *bent], [0, 0, 20, *current], method="adaptive")
    jump = STANDARD.fire([0, 0.1, 0.1, *bent], [0, 0, 20, *current], method="adaptive")
    assert len(jump.times[0]) > 10
    np.testing.assert_allclose(steep.times[0], jump.times[0], atol=max(1e-9, 10 * edge))


@pytest.mark.parametrize(("at", "current"), [(0.1, 9000.0), (100.0, 20.0)])
def test_the_adaptive_method_passes_jumps_narrower_than_its_steps(at, current):
    """The two differ by the charge of the jump's own width, below 1e-9 mV, and by rounding."""
    levels, after = [0.0, 0.0, current, current], [at, at + 0.01]
    trains = STANDARD.fire([at - 0.1, np.nextafter(at, 0), *after], levels, method="adaptive")
    jump = STANDARD.fire([at - 0.1, at, *after], levels, method="adaptive")
    assert len(jump.times[0]) > 0
    np.testing.assert_allclose(trains.times[0], jump.times[0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(trains.final, jump.final, rtol=0, atol=1e-7)


def test_time_between_neighboring_numbers_is_not_lost():
    from fefinger.neural.membranes.adaptive import _straight

    time = 1e3 + np.spacing(1e3) * np.arange(21.0)
    pieces = _straight(time, np.arange(21.0) % 2)
    assert sum(stop - start for start, stop, *_ in pieces) >= 0.9 * np.ptp(time)


def test_a_current_of_too_many_pieces_for_the_adaptive_method_is_refused():
    from fefinger.neural.membranes.adaptive import MOST

    time = np.linspace(0.0, 1.0, MOST + 1)
    with pytest.raises(InputError, match="fewer than 1000000 straight pieces"):
        STANDARD.fire(time, np.arange(MOST + 1) % 2, method="adaptive")


def test_the_vector_form_of_the_equations_is_that_with_library_exponentials():
    from fefinger.neural.membranes import equations, vectorized

    rng = np.random.default_rng(7)
    for v in [*np.linspace(-60.0, 140.0, 401), 10.0, 25.0, 10.0 + 1e-7, 25.0 - 1e-9]:
        gates = rng.uniform(size=3)
        exact = equations.slope(v, *gates, 5.0, 0.5, 1.0)
        np.testing.assert_allclose(vectorized._slope(v, *gates, 5.0, 0.5, 0.5), exact, 1e-10, 1e-9)


@pytest.mark.parametrize("method", METHODS[:2])
def test_a_unit_with_current_fires_the_same_wherever_it_stands(method):
    time = np.linspace(0, 0.06, 31)
    currents = np.outer(np.sin(60 * time) ** 2, np.linspace(1.0, 60.0, 35))
    # 8 lanes and 16 may be compiled to different instructions, which round differently.
    together = SLOWED.fire(time, currents, method=method)
    for i in (0, 1, 15, 16, 33, 34):
        alone = SLOWED.fire(time, currents[:, i], method=method)
        np.testing.assert_allclose(together.times[i], alone.times[0], rtol=0, atol=1e-12)
        np.testing.assert_allclose(together.final[i], alone.final[0], rtol=0, atol=1e-9)
        assert together.peak_mV[i] == pytest.approx(alone.peak_mV[0], abs=1e-9)


def test_units_come_back_in_their_order_whenever_they_begin():
    time = np.linspace(0.0, 0.06, 7)
    currents = np.where(time[:, None] > np.arange(40) % 5 / 100, np.arange(40) + 5.0, 0.0)
    currents[:, 7] = currents[:, 23] = 0.0
    together = SLOWED.fire(time, currents, stimulus_driven=False)
    for i in range(40):
        (alone,) = SLOWED.fire(time, currents[:, i], stimulus_driven=False).times
        assert (len(alone) == 0) == (i in (7, 23))
        np.testing.assert_allclose(together.times[i], alone, atol=1e-9)


@pytest.mark.parametrize("method", METHODS[:2])
def test_skipping_silence_changes_nothing(method):
    time = np.array([0.0, 0.2, 0.2, 0.203, 0.203, 0.8, 1.4, 1.4, 1.403])
    pulses = np.array([0.0, 0.0, 40.0, 40.0, 0.0, 0.0, 0.0, 40.0, 40.0])
    skipped = STANDARD.fire(time, pulses, method=method)
    never_silent = STANDARD.fire(time, np.column_stack([pulses, pulses + 1e-9]), method=method)
    assert len(skipped.times[0]) == 2
    np.testing.assert_allclose(skipped.times[0], never_silent.times[0], atol=1e-9)
    np.testing.assert_allclose(skipped.final[0], never_silent.final[0], atol=1e-4)


@pytest.mark.parametrize("current", [2.0, 50.0, 120.0])
def test_every_method_finds_the_same_block_peak_and_driven_crossings(current):
    firings = [SLOWED.fire([0.0, 0.5], [current] * 2, method=method) for method in METHODS]
    for firing in firings[:2]:
        assert firing.block_seconds[0] == pytest.approx(firings[2].block_seconds[0], abs=2e-3)
        assert firing.peak_mV[0] == pytest.approx(firings[2].peak_mV[0], abs=0.5)
        assert firing.stimulus_driven[0] == firings[2].stimulus_driven[0]
    assert (firings[2].block_seconds[0] > 0.2) == (current > 111)


def test_ten_degrees_treble_the_rates():
    warm, plain = HodgkinHuxley(6.0, temperature=16.3), HodgkinHuxley(2.0)
    assert warm.speed == pytest.approx(0.5, rel=1e-12)
    a, b = (m.fire([0.0, 0.3], [20.0, 20.0]).times[0] for m in (warm, plain))
    assert len(a) > 5
    np.testing.assert_allclose(a, b, rtol=1e-9)


def test_a_warm_membrane_is_stepped_finely_enough():
    warm = HodgkinHuxley(1.0, temperature=20.0)
    exact = warm.fire([0.0, 0.1], [30.0, 30.0], method="adaptive")
    firing = warm.fire([0.0, 0.1], [30.0, 30.0])
    assert len(firing.times[0]) > 5
    np.testing.assert_allclose(firing.times[0], exact.times[0], atol=1e-6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"tolerance": 1e-5, "dt": 1e-5}, "received both"),
        ({"tolerance": 1e-5, "method": "splitting"}, "received both"),
        ({"tolerance": 0.0}, "tolerance: expected"),
        ({"method": "rk4"}, "method: expected one of"),
        ({"dt": 0.0}, "dt: expected"),
    ],
)
def test_unusable_options_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        SLOWED.fire([0.0, 1.0], [0.0, 1.0], **options)


@pytest.mark.parametrize("temperature", [-1.0, 41.0, np.inf])
def test_impossible_temperatures_are_refused(temperature):
    with pytest.raises(InputError, match="temperature"):
        HodgkinHuxley(temperature=temperature)


def test_no_unit_is_refused():
    with pytest.raises(InputError, match="one unit or more"):
        SLOWED.fire([0.0, 1.0], np.empty((2, 0)))
