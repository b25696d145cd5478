"""Springs in series and derivatives against closed forms."""

import numpy as np
import pytest
from fefinger.validation.neural.preliminary import derivative, spring
from fefinger.validation.neural.sweep import Derivative


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
    response = derivative(*poles).frequency_response([0.5, 2.0])
    np.testing.assert_allclose(response, pure, rtol=0.02)
    assert derivative(*poles).frequency_response(0.0) == 0.0
