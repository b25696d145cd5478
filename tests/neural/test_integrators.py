"""The integrators of the Hodgkin-Huxley membrane against each other and against their orders."""

import numpy as np
import pytest
from fefinger.validation.oracles.membrane import exact, slope
from refusals import refused

from fefinger.neural.membranes import METHODS, HodgkinHuxley
from fefinger.support.checks import InputError


STANDARD, SLOWED, WARM = HodgkinHuxley(1.0), HodgkinHuxley(6.0), HodgkinHuxley(1.0, 16.3)
SPEEDS = pytest.mark.parametrize(
    "membrane", [STANDARD, SLOWED, WARM], ids=["standard", "slowed", "warm"]
)

LEVELS = np.outer([0.0, 1.0, 1.0], [0.0, 3.0, 8.0, 15.0, 30.0, 55.0])
RAMPS = {
    membrane: np.array([0.0, 0.05, 0.2]) / (1 if membrane is SLOWED else 2)
    for membrane in (STANDARD, SLOWED, WARM)
}


@pytest.fixture(scope="module")
def truths():
    return {membrane: exact(membrane, ramp, LEVELS) for membrane, ramp in RAMPS.items()}


@pytest.mark.parametrize("tolerance", [2e-4, 5e-5, 1e-5, 1e-7, 1e-9])
@SPEEDS
def test_spike_times_are_as_good_as_was_asked(truths, membrane, tolerance):
    firing = membrane.fire(RAMPS[membrane], LEVELS, tolerance=tolerance, stimulus_driven=False)
    truth = [each.times for each in truths[membrane]]
    counts = [len(times) for times in truth]
    assert [len(times) for times in firing.times] == counts
    assert sum(counts) > 10
    errors = np.abs(np.concatenate(firing.times) - np.concatenate(truth))
    assert np.quantile(errors, 0.95) < tolerance


def test_a_finer_tolerance_never_takes_a_coarser_way():
    for membrane in (STANDARD, SLOWED):
        chosen = [membrane.integrator(t) for t in np.geomspace(1e-2, 1e-9, 60)]
        ranks = [METHODS.index(method) for method, _ in chosen]
        assert ranks == sorted(ranks)
        assert set(ranks) == {0, 1}
        for name in METHODS:
            steps = [dt for method, dt in chosen if method == name]
            assert steps == sorted(steps, reverse=True)


@pytest.mark.parametrize(
    ("method", "order", "largest"), [("splitting", 2, 0.03), ("runge-kutta", 4, 1e-3)]
)
def test_the_error_falls_with_the_order_also_on_uneven_samples(method, order, largest):
    time = np.array([0.0, 0.31e-3, 2e-3, 2e-3, 2.05e-3, 4.3e-3, 12e-3])
    current = np.array([15.0, 22.0, 15.0, 3.0, 3.0, -2.0, 4.0])
    truth = exact(STANDARD, time, current)[0].final
    steps = np.array([5e-5, 2.5e-5, 1.25e-5])
    errors = [
        np.abs(STANDARD.fire(time, current, method=method, dt=dt).final[0] - truth).max()
        for dt in steps
    ]
    slopes = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert np.all(np.abs(slopes - order) < 0.3), (slopes, errors)
    assert errors[0] < largest


@pytest.mark.parametrize("speed", [1.0, 0.4])
def test_the_reference_solves_the_equations_of_the_compiled_membrane(speed):
    from fefinger.neural.membranes import equations

    for state in np.random.default_rng(3).uniform([-60, 0, 0, 0], [140, 1, 1, 1], (200, 4)):
        compiled = equations.slope(*state, 5.0, speed, 1.0)
        np.testing.assert_allclose(slope(state, 5.0, speed), compiled, 1e-10, 1e-10)


@pytest.mark.parametrize(("seconds", "least"), [(0.2, 1e-9), (50.0, 5e-8)])
def test_a_tolerance_below_rounding_is_refused(seconds, least):
    assert STANDARD.integrator(1.01 * least, seconds)[0] == "runge-kutta"
    with refused("tolerance"):
        STANDARD.integrator(0.99 * least, seconds)


def test_the_vector_form_of_the_equations_is_that_with_library_exponentials():
    from fefinger.neural.membranes import equations, vectorized

    rng = np.random.default_rng(7)
    for v in [*np.linspace(-60.0, 140.0, 401), 10.0, 25.0, 10.0 + 1e-7, 25.0 - 1e-9]:
        gates = rng.uniform(size=3)
        plain = equations.slope(v, *gates, 5.0, 0.5, 1.0)
        np.testing.assert_allclose(vectorized._slope(v, *gates, 5.0, 0.5, 0.5), plain, 1e-10, 1e-9)


@pytest.mark.parametrize("method", METHODS)
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


@pytest.mark.parametrize("method", METHODS)
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
    (truth,) = exact(SLOWED, [0.0, 0.5], [current] * 2)
    firings = [SLOWED.fire([0.0, 0.5], [current] * 2, method=method) for method in METHODS]
    for firing in firings:
        assert firing.block_seconds[0] == pytest.approx(truth.block_seconds, abs=2e-3)
        assert firing.peak_mV[0] == pytest.approx(truth.peak_mV, abs=0.5)
    assert firings[0].stimulus_driven[0] == firings[1].stimulus_driven[0]
    assert (truth.block_seconds > 0.2) == (current > 111)


def test_ten_degrees_treble_the_rates():
    warm, plain = HodgkinHuxley(6.0, temperature=16.3), HodgkinHuxley(2.0)
    assert warm.speed == pytest.approx(0.5, rel=1e-12)
    a, b = (m.fire([0.0, 0.3], [20.0, 20.0]).times[0] for m in (warm, plain))
    assert len(a) > 5
    np.testing.assert_allclose(a, b, rtol=1e-9)


def test_a_warm_membrane_is_stepped_finely_enough():
    warm = HodgkinHuxley(1.0, temperature=20.0)
    (truth,) = exact(warm, [0.0, 0.1], [30.0, 30.0])
    firing = warm.fire([0.0, 0.1], [30.0, 30.0])
    assert len(firing.times[0]) > 5
    np.testing.assert_allclose(firing.times[0], truth.times, atol=1e-6)


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"tolerance": 1e-5, "dt": 1e-5}, "tolerance"),
        ({"tolerance": 1e-5, "method": "splitting"}, "tolerance"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"method": "rk4"}, "method"),
        ({"dt": 0.0}, "dt"),
    ],
)
def test_unusable_options_are_refused(options, field):
    with refused(field):
        SLOWED.fire([0.0, 1.0], [0.0, 1.0], **options)


@pytest.mark.parametrize("temperature", [-1.0, 41.0, np.inf])
def test_impossible_temperatures_are_refused(temperature):
    with refused("temperature"):
        HodgkinHuxley(temperature=temperature)


def test_no_unit_is_refused():
    with pytest.raises(InputError, match="one unit or more"):
        SLOWED.fire([0.0, 1.0], np.empty((2, 0)))
