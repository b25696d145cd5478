"""Spring, damper and second derivative against closed forms."""

import numpy as np
import pytest

from fefinger.neural.preliminary import Derivative, derivative, spring
from fefinger.support.checks import InputError


def test_three_springs_share_by_their_compliances():
    k_s, k_e, k_n = 2.0, 0.3, 0.7
    share = spring(k_s, k_e, k_n)
    assert share.gain == pytest.approx((1 / k_n) / (1 / k_s + 1 / k_e + 1 / k_n))
    np.testing.assert_allclose(share.respond([0, 1, 2], [0, 3, -1]), share.gain * np.r_[0, 3, -1])


def test_the_printed_ratio_is_the_limit_of_a_stiff_nerve():
    printed = [2 * 0.3 / (k_n * 2.3) for k_n in (10.0, 100.0, 1000.0)]
    exact = [spring(2.0, 0.3, k_n).gain for k_n in (10.0, 100.0, 1000.0)]
    errors = np.array(printed) / exact - 1
    np.testing.assert_allclose(errors, 2 * 0.3 / 2.3 / np.array([10.0, 100.0, 1000.0]))
    assert 2 * 0.3 / (0.2 * 2.3) > 1 > spring(2.0, 0.3, 0.2).gain


@pytest.mark.parametrize("poles", [(200.0,), (200.0, 300.0)])
def test_below_its_poles_the_filter_is_a_derivative(poles):
    pure = Derivative(len(poles)).frequency_response([0.5, 2.0])
    found = derivative(*poles).frequency_response([0.5, 2.0])
    np.testing.assert_allclose(found, pure, rtol=0.02)
    assert derivative(*poles).frequency_response(0.0) == 0.0


@pytest.mark.parametrize("order", [1, 2])
def test_derivatives_of_polynomials_of_one_degree_more_are_exact_on_uneven_times(order):
    time = np.cumsum(np.random.default_rng(1).uniform(0.1, 1.0, 30))
    power = np.polynomial.Polynomial(np.arange(1.0, 3.0 + order))
    means = np.convolve(time, np.full(order + 1, 1 / (order + 1)), "valid")
    both = np.column_stack([power(time), 2 * power(time)])
    found = Derivative(order).respond(time, both, at=means)
    expected = power.deriv(order)(means)
    np.testing.assert_allclose(found, np.column_stack([expected, 2 * expected]), rtol=1e-9)


def test_derivatives_of_a_sinusoid_converge_with_the_square_of_the_step():
    errors, w = [], 2 * np.pi
    for n in (200, 400):
        time = np.linspace(0, 1, n + 1)
        velocity, acceleration = (Derivative(k).respond(time, np.sin(w * time)) for k in (1, 2))
        off = [velocity / w - np.cos(w * time), acceleration / w**2 + np.sin(w * time)]
        errors.append([np.abs(each)[2:-2].max() for each in off])
    np.testing.assert_allclose(np.divide(*errors), 4.0, rtol=0.02)
    assert np.max(errors) < 1e-3


def test_a_jump_has_no_derivative():
    with pytest.raises(InputError, match="times that increase"):
        Derivative(1).respond([0.0, 1.0, 1.0, 2.0], np.zeros(4))
    with pytest.raises(InputError, match="order: expected 1 or 2"):
        Derivative(3)
