"""Prony relaxation against independent values, closed forms and quadrature."""

import itertools
import math

import numpy as np
import pytest

from fefinger.theory.relaxation import Prony, hereditary_integral


AH = Prony(c=(0.25, 0.40, 0.19, 0.16), v=(224, 14, 0.63))
MEANS_2_1 = Prony(c=(0.26, 0.41, 0.18, 0.15), v=(231, 15, 0.69))
MEANS_3_1 = Prony(c=(0.31, 0.45, 0.14, 0.09), v=(212, 10.0, 0.64))
SETS = pytest.mark.parametrize("prony", [AH, MEANS_2_1, MEANS_3_1], ids=["ah", "t21", "t31"])


def compliance(prony, t):
    j_inf, k, lam = prony.creep()
    return j_inf - np.exp(-np.multiply.outer(np.asarray(t, float), lam)) @ k


@pytest.mark.parametrize(
    ("prony", "lam", "k", "j_inf"),
    [
        (MEANS_3_1, [116.941, 7.3702, 0.4929], [0.7924, 0.6521, 0.7490], 3.1935),
        (AH, [136.370, 9.5188, 0.3805], [0.6188, 0.7743, 1.6070], 4.0),
        (MEANS_2_1, [138.386, 10.3565, 0.4337], [0.6438, 0.7527, 1.4496], 3.8462),
    ],
)
def test_creep_is_the_independently_computed_inversion(prony, lam, k, j_inf):
    got_inf, got_k, got_lam = prony.creep()
    assert got_inf == pytest.approx(j_inf, abs=5e-5)
    np.testing.assert_allclose(got_lam[::-1], lam, rtol=1e-4)
    np.testing.assert_allclose(got_k[::-1], k, atol=6e-5)


@SETS
def test_creep_starts_at_one_and_its_rates_interlace(prony):
    _, _, lam = prony.creep()
    assert compliance(prony, 0.0) == pytest.approx(1.0, abs=1e-12)
    merged = np.sort(np.concatenate([lam, prony.v]))
    np.testing.assert_array_equal(merged[::2], lam)  # exact: the same numbers, sorted


@SETS
@pytest.mark.parametrize("t", [0.003, 0.1, 4.0])
def test_relaxation_of_creep_is_one_by_quadrature(prony, t):
    """Integral of G(t - s) dJ(s), with the jump J(0) = 1, by Gauss-Legendre on a graded split."""
    _, k, lam = prony.creep()
    nodes, gauss = np.polynomial.legendre.leggauss(20)
    edges = np.concatenate([[0.0], np.geomspace(1e-4 * t, 0.5 * t, 40)])
    edges = np.unique(np.concatenate([edges, t - edges]))
    total = float(prony.relaxation(t))
    for a, b in itertools.pairwise(edges):
        s = 0.5 * (a + b) + 0.5 * (b - a) * nodes
        rate = np.exp(-np.outer(s, lam)) @ (k * lam)
        total += 0.5 * (b - a) * gauss @ (prony.relaxation(t - s) * rate)
    assert total == pytest.approx(1.0, abs=1e-9)


def test_creep_tolerates_equal_rates_and_zero_weights():
    plain = Prony(c=(0.4, 0.6), v=(10.0,))
    split = Prony(c=(0.4, 0.2, 0.4, 0.0), v=(10.0, 10.0, 3.0))
    np.testing.assert_allclose(compliance(split, [0, 0.05, 1]), compliance(plain, [0, 0.05, 1]))


def test_weights_are_normalized():
    assert sum(MEANS_3_1.weights) == pytest.approx(1.0, abs=1e-15)
    assert MEANS_3_1.long_time == pytest.approx(0.31 / 0.99)
    assert float(MEANS_3_1.relaxation(0.0)) == pytest.approx(1.0, abs=1e-15)
    assert float(MEANS_3_1.relaxation(1e6)) == pytest.approx(0.31 / 0.99)
    assert MEANS_3_1.relaxation(np.zeros((2, 3))).shape == (2, 3)


@pytest.mark.parametrize("dt", [1e-6, 1e-4, 1e-2, 1.0, 1e3])
def test_a_ramp_is_its_closed_form_at_any_step(dt):
    t = dt * np.arange(6)
    closed = AH.weights[0] * t + sum(
        w * -np.expm1(-v * t) / v for w, v in zip(AH.weights[1:], AH.v, strict=True)
    )
    np.testing.assert_allclose(hereditary_integral(AH, t, t), closed, rtol=1e-13)


def test_a_step_relaxes_as_g_and_a_repeated_time_is_a_jump():
    t = np.concatenate([[0.0, 0.2, 0.2], 0.2 + np.geomspace(1e-6, 1e3, 50)])
    signal = np.where(np.arange(len(t)) < 2, 0.0, 3.0)
    expected = 3.0 * AH.relaxation(t[2:] - 0.2)
    np.testing.assert_allclose(hereditary_integral(AH, t, signal)[2:], expected, rtol=1e-13)
    np.testing.assert_allclose(
        hereditary_integral(AH, t[2:], signal[2:]), expected, rtol=1e-13, err_msg="first value"
    )


def test_refining_a_piecewise_linear_signal_changes_nothing():
    rng = np.random.default_rng(3)
    knots = np.cumsum(rng.exponential(size=12) * rng.choice([1e-4, 1e-2, 1.0], size=12))
    values = rng.normal(size=12)
    fine = np.unique(np.concatenate([knots, rng.uniform(knots[0], knots[-1], 300)]))
    coarse = hereditary_integral(MEANS_2_1, knots, values)
    refined = hereditary_integral(MEANS_2_1, fine, np.interp(fine, knots, values))
    np.testing.assert_allclose(refined[np.searchsorted(fine, knots)], coarse, atol=1e-13)


def test_columns_are_independent_and_the_integral_is_linear():
    rng = np.random.default_rng(4)
    t, signal = np.cumsum(rng.exponential(size=40)), rng.normal(size=(40, 3))
    out = hereditary_integral(AH, t, signal)
    assert out.shape == (40, 3)
    for k in range(3):
        np.testing.assert_allclose(out[:, k], hereditary_integral(AH, t, signal[:, k]))
    mix = np.array([2.0, -0.5, 1.5])
    np.testing.assert_allclose(hereditary_integral(AH, t, signal @ mix), out @ mix, atol=1e-13)


@pytest.mark.parametrize(
    ("c", "v", "message"),
    [
        ((0.5, 0.5), (1.0, 2.0), "one weight more"),
        ((0.5, 0.6), (1.0,), "sum to 0.98 to 1.02"),
        ((0.5, 0.47), (1.0,), "sum to 0.98 to 1.02"),
        ((0.0, 1.0), (1.0,), "c0 above 0"),
        ((1.2, -0.2), (1.0,), "negative weight"),
        ((0.5, 0.5), (0.0,), "rates above 0"),
        ((0.5, math.nan), (1.0,), "finite"),
        ((0.5, "a"), (1.0,), "finite numbers, received 'a'"),
        (0.5, (1.0,), "list of numbers"),
        ("0.5", (1.0,), "list of numbers"),
        ((0.5, True), (1.0,), "finite numbers, received True"),
    ],
)
def test_impossible_parameters_are_refused(c, v, message):
    with pytest.raises(ValueError, match=message):
        Prony(c=c, v=v)


@pytest.mark.parametrize("c", [(0.48, 0.5), (0.52, 0.5)])
def test_sums_at_the_limits_are_accepted_and_lists_become_tuples(c):
    assert Prony(c=list(c), v=[1]).c == c


@pytest.mark.parametrize(
    ("time", "signal", "message"),
    [
        ([0, 1], [0, 1, 2], "expected time"),
        ([], [], "expected time"),
        ([0, 1, 0.5], [0, 1, 2], "never decrease"),
        ([0, math.nan], [0, 1], "finite"),
        ([0, 1], [0, math.inf], "finite"),
    ],
)
def test_unusable_signals_are_refused(time, signal, message):
    with pytest.raises(ValueError, match=message):
        hereditary_integral(AH, time, signal)


def test_negative_times_are_refused():
    with pytest.raises(ValueError, match="t >= 0"):
        AH.relaxation([-1.0])
