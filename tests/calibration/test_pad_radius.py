"""Pad radius by the fit of the thesis, on simulated frames of the array."""

from dataclasses import replace

import numpy as np
import pytest

import fefinger as ff
from fefinger.calibration import pad_radius
from fefinger.calibration.array_sensor import ArraySensor, Frames
from fefinger.calibration.slow_press import array_pressure, pressed
from fefinger.mechanics import hertz


def test_the_thesis_finds_its_own_half_space(formula):
    """t(u) of the thesis on Hertz's pressures is the finger that its fit is of."""
    x = np.linspace(0, 1.8, 401)[1:]
    one = formula(0.0, count=400)
    t = np.expm1(1.5 * x) / 1.5
    scale = 8e-3 / 3 * 3.0 * np.sqrt(14.0) * x**1.5 * t / one.force
    own = replace(one, force=scale * one.force, array_pressure=scale[:, None] * one.array_pressure)
    frames = Frames(
        np.repeat(x[20::20, None], 64, 1),
        own.array_pressure[20::20],
        np.hypot(*ArraySensor().positions.T),
    )
    found = pad_radius.thesis_fit(frames)
    assert (found.radius, found.m, found.c0_b) == pytest.approx((14.0, 1.5, 3.0), rel=0.02)


def test_a_radius_is_found_where_the_fit_has_the_wanted_one():
    radius, power = pad_radius.radius_for(13.0, (10.0, 14.0), (12.0, 18.0))
    assert power == pytest.approx(np.log(18 / 12) / np.log(1.4))
    assert 12 * (radius / 10) ** power == pytest.approx(13.0)


def test_a_radius_on_which_the_fit_hardly_depends_remains():
    radius, power = pad_radius.radius_for(14.6, (14.0, 13.0), (14.3, 14.5))
    assert radius == 14.0
    assert power < pad_radius.DETERMINED


def test_the_next_radius_is_between_those_that_hold_the_wanted_r_or_beyond_the_nearest():
    """Fitted R that grow with the square of the pad radius are found at once."""
    between = pad_radius.nearer(12.0, (14.0, 10.0, 30.0), (14.0**2 / 10, 10.0, 90.0))
    assert between == pytest.approx(np.sqrt(120.0))
    assert pad_radius.nearer(11.0, (12.0, 10.0), (8.0, 10.0), 2.0) == pytest.approx(10 * 1.1**0.5)
    assert pad_radius.nearer(9.0, (12.0, 10.0), (14.0, 10.0), 0.3) == pytest.approx(9.0)
    assert pad_radius.nearer(20.0, (12.0, 10.0), (14.0, 10.0)) == pytest.approx(
        12.0 * pad_radius.WITHIN
    )


def test_the_array_feels_the_whole_force_and_hertz(hertzian):
    scene = pressed(ff.Finger.subject("a.h.", tissue="maeno1998"), 0.08)
    response = hertz.respond(scene)
    read = array_pressure(scene, response)
    assert read[-1].sum() * 4 == pytest.approx(1e3 * response.force[-1], rel=0.03)
    want = response.force[-1] * hertzian(14.0 * response.depth[-1])
    np.testing.assert_allclose(read[-1], want, atol=0.03 * want.max())
