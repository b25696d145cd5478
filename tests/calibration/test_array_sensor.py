"""The tactile array: blur, skew, noise, isobars, profiles, deconvolution, and the fits from it."""

import numpy as np
import pytest
from fefinger.validation.oracles.fingerpad import Fingerpad, series_modulus
from fefinger.validation.thesis.array import Reading, scan, triangles
from fefinger.validation.thesis.ball import fit_ball
from fefinger.validation.thesis.claims import two_pole

from fefinger.calibration.array_sensor import (
    ArraySensor,
    BlurredCap,
    blurred,
    fit_fingerpad,
)
from fefinger.results.pressure import isobar
from fefinger.scene import library
from fefinger.theory.contact.hertz import Hertz


SENSOR = ArraySensor()
PLANE = series_modulus((570.0, 0.5), (1000.0, 0.5))
BALL = Hertz(32.6, 0.59, PLANE, 0.0)  # the fitted ball on the compliant array
DISTANCE = np.hypot(*SENSOR.positions.T)


def grid(step, half=8.0):
    line = np.arange(-half + step / 2, half, step)
    points = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    return points, np.full(len(points), step**2), np.hypot(*points.T)


def readings(time, points, areas, pressure, seed=None) -> Reading:
    return scan(SENSOR, time, pressure @ SENSOR.weights(points, areas).T, seed=seed)


# Elements


def test_elements_are_where_the_thesis_has_them():
    assert SENSOR.positions.shape == (64, 2)
    assert np.unique(SENSOR.positions).tolist() == [-7, -5, -3, -1, 1, 3, 5, 7]
    assert SENSOR.delays[-1] == pytest.approx(4.9e-3, abs=0.03e-3)  # "about 5 ms"


def test_an_even_pressure_is_read_as_it_is_and_blur_conserves_the_force():
    points, areas, r = grid(0.5, half=12.0)
    element_pressure = SENSOR.weights(points, areas) @ np.full(len(points), 7.0)
    assert element_pressure == pytest.approx(7.0, rel=1e-6)
    x, weight = np.polynomial.legendre.leggauss(60)
    around = 6.0 * (x + 1)
    ring = 2 * np.pi * around * blurred(BALL.pressure, BALL.contact_radius, around)
    assert 6.0 * weight @ ring == pytest.approx(BALL.force, rel=1e-6)
    element_pressure = SENSOR.weights(points, areas) @ BALL.pressure(r)
    alias = 2 * np.exp(-2 * np.pi**2 * (SENSOR.sigma / SENSOR.pitch) ** 2)
    assert element_pressure.sum() * SENSOR.pitch**2 == pytest.approx(BALL.force, rel=alias)
    assert alias < 0.025


def test_the_radial_convolution_equals_the_plane_one():
    points, areas, r = grid(0.05)
    plane = SENSOR.weights(points, areas) @ BALL.pressure(r)
    assert blurred(BALL.pressure, BALL.contact_radius, DISTANCE) == pytest.approx(plane, abs=3e-3)


def test_without_blur_the_pressure_is_what_it_was():
    r = np.array([0.0, 1.0, 3.0])
    sharp = blurred(lambda s: 5.0 - 0.1 * s**2, 7.0, r, sigma=0.2)
    assert sharp == pytest.approx(5.0 - 0.1 * (r**2 + 2 * 0.2**2), abs=1e-9)


# Scan and noise


def test_each_element_reads_the_pressure_of_its_own_moment():
    points, areas, _ = grid(1.0, half=12.0)
    time = np.linspace(0.0, 0.1, 21)
    ramp = np.outer(30.0 * time, np.ones(len(points)))
    reading = readings(time, points, areas, ramp)
    assert reading.pressure == pytest.approx(30.0 * reading.time, abs=1e-5)
    assert reading.time[1] - reading.time[0] == pytest.approx(1 / 200)
    assert reading.time.max() <= 0.1 < reading.time.max() + 1 / 200
    within = np.diff(reading.time[0])
    assert within == pytest.approx(1 / 12800)


def test_noise_is_seeded_and_as_large_as_told():
    points, areas, _ = grid(1.0)
    time, still = np.array([0.0, 1.0]), np.zeros((2, len(points)))
    first, same, other = (readings(time, points, areas, still, seed=s) for s in (1, 1, 2))
    assert (first.pressure == same.pressure).all()  # exact: one call, made twice
    assert (first.pressure != other.pressure).any()
    assert first.pressure.std() == pytest.approx(0.5, rel=0.02)  # 12 736 readings
    assert not readings(time, points, areas, still).pressure.any()
    on_one = 0.5 * SENSOR.pitch**2 / 9.80665  # gram weight: the thesis says 1.2
    assert on_one == pytest.approx(0.20, abs=5e-3)


# Descriptors


def test_isobars_of_a_cone_are_circles_and_close():
    fine = ArraySensor(elements=80, pitch=0.2)
    heights = 20 - 2 * np.hypot(*fine.positions.T)
    line = isobar(fine.positions, triangles(fine), heights, 8.0)
    assert np.hypot(*line.reshape(-1, 2).T) == pytest.approx(6.0, abs=2e-3)
    length = np.linalg.norm(line[:, 1] - line[:, 0], axis=1).sum()
    assert length == pytest.approx(12 * np.pi, rel=1e-3)
    ends = np.round(line.reshape(-1, 2), 9)
    _, count = np.unique(ends, axis=0, return_counts=True)
    assert (count % 2 == 0).all()
    assert isobar(fine.positions, triangles(fine), heights, 99.0).shape == (0, 2, 2)


# Fits by the procedure of the thesis


def press(pressure_at, depth_rate=0.2, deepest=2.3, seed=7):
    """Return the depth at each reading of a slow press and the reading, one frame in 40."""
    points, areas, r = grid(0.5)
    time = np.linspace(0, deepest / depth_rate, 200)
    reading = readings(time, points, areas, pressure_at(r, depth_rate * time), seed=seed)
    return depth_rate * reading.time[::40], reading.pressure[::40]


ROW = Fingerpad(14.0, 1.9, 1.9, library.relaxation()["a.h."])


@pytest.fixture(scope="module")
def slow():
    return press(lambda r, depth: ROW.relaxed_pressure(r, depth[:, None]))


@pytest.fixture(scope="module")
def right(slow):
    return fit_fingerpad(*slow, DISTANCE)


def test_the_tabulated_cap_is_the_convolution():
    cap = BlurredCap(8.0, 10.0)
    r = np.array([0.0, 1.3, 4.9])
    want = blurred(lambda s: np.sqrt(5.1**2 - s**2), 5.1, r)
    assert cap(np.full(3, 5.1), r) == pytest.approx(want, abs=2e-4)


def test_the_fit_returns_the_row_of_the_table_that_made_the_readings(slow, right):
    wanted = {"radius": 14.0, "c0_b": 1.9, "m": 1.9}
    assert right.parameters == pytest.approx(wanted, rel=0.015)  # noise and a kinked time grid
    assert right.error == pytest.approx(0.5**2 / slow[1].var(), rel=0.05)  # the noise alone


@pytest.mark.parametrize("offset", [0.08, -0.08])
def test_a_touch_found_80_um_off_moves_b_by_a_quarter_and_hides_in_the_error(slow, right, offset):
    depth, pressure = slow
    fit = fit_fingerpad(depth + offset, pressure, DISTANCE)
    assert fit.error < right.error + 2e-4
    change = fit.parameters["c0_b"] / right.parameters["c0_b"] - 1
    assert 0.2 < -np.sign(offset) * change < 0.3
    moved = fit.parameters["radius"] / right.parameters["radius"] - 1
    assert 0.025 < -np.sign(offset) * moved < 0.05
    assert abs(fit.parameters["m"] / right.parameters["m"] - 1) < 0.025


# The force filter


def test_the_filter_rests_on_a_constant_and_is_exact_for_any_step():
    time = np.array([0.0, 1e-4, 3e-3, 0.5])
    assert two_pole(time, np.full(4, 3.0)) == pytest.approx(3.0)
    ramp = two_pole(time, time)
    fine = np.unique(np.concatenate([time, np.linspace(0, 0.5, 3001)]))
    assert ramp == pytest.approx(two_pole(fine, fine)[np.searchsorted(fine, time)], abs=1e-12)
    assert ramp[-1] == pytest.approx(0.5 - np.sqrt(2) / (2 * np.pi * 1000))  # the delay of a ramp


BAD = [
    (lambda: ArraySensor(pitch=0.0), "pitch above 0"),
    (lambda: SENSOR.weights([[0.0, 0.0]], [4.0]), "sides up to 1.44 mm"),
    (lambda: SENSOR.weights([0.0, 0.0], [1.0]), "areas"),
    (lambda: readings([0, 1e-3], [[0, 0]], [1.0], np.zeros((2, 1))), "at least one frame"),
    (lambda: readings([0, 0], [[0, 0]], [1.0], np.zeros((2, 1))), "2 rising times"),
    (lambda: fit_ball(np.ones((2, 3)), np.ones((2, 4)), np.ones(4)), "shape of the pressure"),
]


@pytest.mark.parametrize(("call", "message"), BAD)
def test_what_cannot_be_used_gets_a_sentence(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_the_blur_makes_the_semi_ellipse_of_hertz_look_like_a_parabola():
    """The thesis calls its profiles parabolic; in Hertz it is the square of p that is."""
    r = np.linspace(0, 0.95 * BALL.contact_radius, 60)
    sharp, soft = BALL.pressure(r), blurred(BALL.pressure, BALL.contact_radius, r)

    def misfit(profile, power):
        line = np.polynomial.Polynomial.fit(r**2, profile**power, 1)
        return np.std(np.maximum(line(r**2), 0) ** (1 / power) - profile) / profile.max()

    assert misfit(sharp, 2) < 1e-9 < 0.02 < misfit(sharp, 1)
    assert misfit(soft, 1) < 0.5 * misfit(soft, 2)


def test_a_narrow_blur_leaves_a_wide_pressure_as_it_is():
    """At a hundredth of a mm the middle of a cap of 4 mm came out at half."""
    r = np.array([0.0, 1.0, 2.0, 3.0])
    for sigma in (0.1, 0.05, 0.01):
        actual = blurred(lambda s: 16.0 - s**2, 4.0, r, sigma)
        np.testing.assert_allclose(actual, 16.0 - r**2 - 2 * sigma**2, rtol=1e-9)
