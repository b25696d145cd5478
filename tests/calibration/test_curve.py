"""Curves of force against depth, and families of them, on presses that are a formula."""

from dataclasses import replace

import numpy as np
import pytest

from fefinger.calibration.curve import curve, family


@pytest.mark.parametrize("count", [24, 400])
def test_a_curve_is_the_press_and_its_slope_and_inverse_are_its_own(count, formula):
    one = formula(2.0, count=count)
    found, apart = curve(one)
    assert apart < 1e-4
    x = np.linspace(0.2, 1.7, 7)
    slope = (found.force(x + 1e-5) - found.force(x - 1e-5)) / 2e-5
    np.testing.assert_allclose(found.stiffness(x), slope, rtol=1e-6)
    np.testing.assert_allclose(found.depth(found.force(x)), x, rtol=1e-10)
    np.testing.assert_allclose(
        found.array_pressure(one.depth[10:11])[0], one.array_pressure[10], rtol=2e-2, atol=0.1
    )
    assert found.force([-1.0, 0.0]).tolist() == [0, 0]


@pytest.mark.parametrize("deepest", [1.2, 2.2])
def test_a_curve_is_a_layer_under_a_ball_however_deep_the_press_is(deepest, formula):
    """By Dimitriadis et al. (2002), bonded, 6 mm thick, under a ball of 14 mm: chi up to 0.9."""

    def force(x):
        chi = np.sqrt(14.0 * x) / 6.0
        more = 1 + 1.133 * chi + 1.283 * chi**2 + 0.769 * chi**3 + 0.0975 * chi**4
        return 0.1 * x**1.5 * more

    press = formula(deepest=deepest)
    found, apart = curve(replace(press, force=force(press.depth)))
    assert apart < 5e-4
    x = np.linspace(0.05, deepest, 60)
    np.testing.assert_allclose(found.force(x), force(x), rtol=5e-4)


def test_beyond_the_press_the_logarithm_goes_on_straight(formula):
    found, _ = curve(formula(2.0))
    end = found.deepest
    slope = np.log(found.force(end) / found.force(end - 1e-5)) / 1e-5
    x = end + np.array([0.1, 0.6])
    rise = np.log(found.force(x) / found.force(end))
    np.testing.assert_allclose(rise, slope * (x - end), rtol=1e-3)
    np.testing.assert_allclose(found.depth(found.force(x)), x, rtol=1e-10)


def test_a_growing_curve_is_t_times_the_linear_one(linear, formula):
    x, plain = np.array([0.3, 1.0, 1.7]), curve(formula(0.0, count=400))[0]
    for growth in (0.8, -1e-4):  # the differences about a growth of 0 go below it
        found = linear.at(growth, 14.0)
        grown = np.expm1(growth * x) / growth * plain.force(x)
        np.testing.assert_allclose(found.force(x), grown, rtol=1e-6)
    slope = (found.force(x + 1e-5) - found.force(x - 1e-5)) / 2e-5
    np.testing.assert_allclose(found.stiffness(x), slope, rtol=1e-5)


def test_a_family_has_the_presses_between_its_own(law, formula):
    x = np.linspace(0.2, 1.8, 9)
    for exponent in (0.7, 2.2, 4.0):
        between = curve(formula(exponent))[0].force(x)
        np.testing.assert_allclose(law.at(exponent, 14.0).force(x), between, rtol=2e-3)


def test_a_family_learns_radius_ratio_and_a_better_press(law, formula):
    x = np.linspace(0.2, 1.8, 9)
    wider = law.with_radius(formula(3.0, radius=11.2), 3.0, 11.2)
    np.testing.assert_allclose(
        wider.at(1.0, 12.6).force(x), curve(formula(1.0, 12.6))[0].force(x), rtol=2e-3
    )
    stiffer = law.with_ratio(formula(3.0, ratio=2.0), 3.0, 2.0)
    np.testing.assert_allclose(
        stiffer.at(1.0, 14.0, 1.5).force(x), curve(formula(1.0, ratio=1.5))[0].force(x), rtol=2e-3
    )
    better = replace(formula(2.0), force=1.1 * formula(2.0).force)
    np.testing.assert_allclose(
        law.corrected(better, 2.0, 14.0).at(2.0, 14.0).force(x),
        1.1 * curve(formula(2.0))[0].force(x),
        rtol=1e-4,
    )
    short = formula(2.0)
    part = {
        name: getattr(short, name)[:18] for name in ("depth", "force", "array_pressure", "area")
    }
    ended = law.corrected(replace(short, **part), 2.0, 14.0).at(2.0, 14.0)
    assert ended.deepest == part["depth"][-1] < law.deepest
    x = np.linspace(0.2, 1.0, 5) * ended.deepest
    whole = law.at(2.0, 14.0)
    np.testing.assert_allclose(ended.force(x), whole.force(x), rtol=1e-4)
    np.testing.assert_allclose(
        ended.array_pressure(x), whole.array_pressure(x), rtol=2e-2, atol=0.1
    )


def test_between_two_exponents_curves_are_joined_in_the_root(formula):
    joined = family((1.0, 4.0), 14.0, formula)
    low, high = (curve(formula(exponent))[0] for exponent in joined.shapes)
    middle = joined.at(1.5**2, 14.0)
    np.testing.assert_allclose(middle.q, (low.q + high.q) / 2, atol=1e-12)
