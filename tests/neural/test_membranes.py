"""Hodgkin-Huxley against published numbers and an adaptive integrator."""

import numpy as np
import pytest
from refusals import refused

from fefinger.neural.membranes import HodgkinHuxley
from fefinger.support.checks import InputError


STANDARD, SLOWED = HodgkinHuxley(rate_divisor=1.0), HodgkinHuxley(rate_divisor=6.0)


def hold(membrane, current, seconds, **options):
    return membrane.fire([0.0, seconds], [current, current], **options)


def printed_slope(t, y, current, divisor):
    """Eq. B.1 to B.10 with the signs of Hodgkin & Huxley (1952), written out without care."""
    v, n, m, h = y
    a_n = 0.01 * (10 - v) / (np.exp((10 - v) / 10) - 1)
    b_n = 0.125 * np.exp(-v / 80)
    a_m = 0.1 * (25 - v) / (np.exp((25 - v) / 10) - 1)
    b_m = 4 * np.exp(-v / 18)
    a_h = 0.07 * np.exp(-v / 20)
    b_h = 1 / (np.exp((30 - v) / 10) + 1)
    ionic = 36 * n**4 * (v + 12) + 120 * m**3 * h * (v - 115) + 0.3 * (v - 10.613)
    return [
        current(t) - ionic,
        (a_n * (1 - n) - b_n * n) / divisor,
        (a_m * (1 - m) - b_m * m) / divisor,
        (a_h * (1 - h) - b_h * h) / divisor,
    ]


def test_rest_has_the_known_gates_and_stays():
    v, *gates = STANDARD.rest()
    assert v == pytest.approx(0.0036, abs=5e-5)
    assert gates == pytest.approx([0.3177, 0.0529, 0.5961], abs=1.5e-4)
    np.testing.assert_allclose(hold(STANDARD, 0.0, 0.5).final[0], STANDARD.rest(), atol=1e-12)


@pytest.mark.parametrize("v", [10.0, 25.0])
def test_rates_are_smooth_where_the_printed_ones_are_undefined(v):
    from fefinger.neural.membranes.equations import rates

    def curve(x):
        return np.array(rates(x))

    for width in (1e-2, 1e-3, 1e-6):
        around = 0.5 * (curve(v - width) + curve(v + width))
        np.testing.assert_allclose(curve(v), around, rtol=1e-3 * width + 1e-11)


@pytest.mark.parametrize("membrane", [STANDARD, SLOWED], ids=["standard", "slowed"])
def test_block_is_reported_where_spikes_fail_and_only_there(membrane):
    for current in (2.0, 5.0, 9.0, 50.0, 110.0):
        assert hold(membrane, current, 1.0).block_seconds[0] == 0.0
    for current in (115.0, 120.0, 150.0, 1000.0):
        firing = hold(membrane, current, 1.0)
        assert 0.8 < firing.block_seconds[0] < 1.0
        assert len(firing.times[0]) <= 4


def test_the_current_that_carries_the_potential_itself_is_counted_apart():
    time = np.linspace(0, 0.5, 20_001)
    swing = 200.0 * (1 - np.cos(2 * np.pi * 50 * time))
    firing = SLOWED.fire(time, np.column_stack([swing, np.full_like(time, 20.0)]))
    assert firing.stimulus_driven[0] > 20
    assert firing.stimulus_driven[1] == 0


@pytest.mark.parametrize(
    ("divisor", "seconds"), [(1.0, 0.2), (6.0, 0.3)], ids=["standard", "slowed"]
)
def test_spikes_agree_with_an_adaptive_integrator_of_the_printed_equations(divisor, seconds):
    from scipy.integrate import solve_ivp

    def current(t):
        return 20.0 * min(t / (500.0 * seconds), 1.0)

    def spike(t, y, *_):
        return y[0] - 40.0

    spike.direction = 1.0
    membrane = HodgkinHuxley(divisor)
    truth = solve_ivp(
        lambda t, y: printed_slope(t, y, current, divisor),
        (0.0, 1e3 * seconds),
        membrane.rest(),
        method="DOP853",
        rtol=1e-10,
        atol=1e-11,
        max_step=5.0,
        events=spike,
    )
    firing = membrane.fire([0, seconds / 2, seconds], [0, 20, 20])
    assert len(truth.t_events[0]) > 2
    np.testing.assert_allclose(firing.times[0], 1e-3 * truth.t_events[0], atol=2e-6)
    np.testing.assert_allclose(firing.final[0], truth.y[:, -1], atol=2e-2)


@pytest.mark.parametrize(
    ("time", "current", "message"),
    [
        ([0, 1], [0, 1, 2], "expected \\(n_t,\\)"),
        ([0], [0], "two samples"),
        ([0, 1, 0.5], [0, 1, 2], "never decrease"),
        ([0, np.nan], [0, 1], "finite times"),
        ([0, 1], [0, np.nan], "current: expected at most"),
    ],
)
def test_unusable_input_is_refused(time, current, message):
    with pytest.raises(InputError, match=message):
        SLOWED.fire(time, current)


@pytest.mark.parametrize("divisor", [0.0, 0.5, np.nan, "6"])
def test_impossible_divisors_are_refused(divisor):
    with refused("rate_divisor"):
        HodgkinHuxley(divisor)
