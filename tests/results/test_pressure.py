"""Pressure between the points of the pad: forces, moments and means do not depend on the points."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from fefinger.calibration import array_sensor
from fefinger.calibration.array_sensor import ArraySensor
from fefinger.results import pressure as pressures
from fefinger.results.records import Pad


def disk(seed, n=900):
    """Return a flat round pad of radius 4 mm with points at random."""
    rng = np.random.default_rng(seed)
    r, angle = 4 * np.sqrt(rng.uniform(0, 1, n)), rng.uniform(0, 2 * np.pi, n)
    rim = np.linspace(0, 2 * np.pi, 80, endpoint=False)
    flat = np.concatenate(
        [
            np.column_stack([r * np.cos(angle), r * np.sin(angle)]),
            4 * np.column_stack([np.cos(rim), np.sin(rim)]),
        ]
    )
    triangles = Delaunay(flat).simplices.astype(np.int64)
    one, two = (flat[triangles[:, i]] - flat[triangles[:, 0]] for i in (1, 2))
    size = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]) / 2
    areas = np.bincount(triangles.ravel(), np.repeat(size / 3, 3), minlength=len(flat))
    points = np.column_stack([flat, np.zeros(len(flat))])
    return Pad(points, areas, np.tile([0.0, 0.0, -1.0], (len(flat), 1)), triangles)


def bump(pad):
    """Return a smooth pressure in kPa: a Gaussian of 40 kPa and 1 mm off the middle."""
    off = pad.points[:, :2] - [0.3, -0.2]
    return 40 * np.exp(-(off**2).sum(axis=1) / 2)


def test_every_point_keeps_its_force():
    pad = disk(1)
    _, loads = pressures.net(pad, 4)
    assert np.asarray(loads.sum(axis=0)).ravel() == pytest.approx(pad.areas, rel=1e-12)


@pytest.mark.parametrize("parts", [1, 2, 5])
def test_a_linear_pressure_has_its_exact_moment(parts):
    """One triangle: the moment of a linear pressure is A/12 (sum p sum x + sum p x)."""
    corners = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    area, p = 3.0, np.array([1.0, 5.0, 2.0])
    pad = Pad(corners, np.full(3, area / 3), np.zeros((3, 3)), np.array([[0, 1, 2]]))
    between, loads = pressures.net(pad, parts)
    found = (loads @ p) @ (between @ corners[:, :2])
    exact = area / 12 * (p.sum() * corners[:, :2].sum(axis=0) + p @ corners[:, :2])
    # The middles of the parts leave 1 / parts² of what the corners' own moment is off by.
    lumped = area / 9 * p.sum() * corners[:, :2].sum(axis=0)
    assert found - exact == pytest.approx((lumped - exact) / parts**2, abs=1e-12)


def test_the_highest_pressure_is_that_of_a_convolution_with_1_mm2():
    """Gaussians convolve: 40 kPa of variance 1 mm² and one of 1 / (2 pi) mm²."""
    exact = 40 / (1 + pressures.SPREAD**2)
    pad = disk(0, 3000)
    found, place = pressures.highest(pad, bump(pad)[None])
    assert found == pytest.approx(exact, rel=0.015)
    assert place == pytest.approx([0.3, -0.2, 0.0], abs=0.3)  # points are 0.13 mm apart


@pytest.mark.parametrize("apart", [0.0, 0.5, 3.0])
def test_the_highest_pressure_is_the_largest_peak_however_it_moves(apart):
    """One bump that grows as it stays, or as it moves on from where most passes through time."""
    pad = disk(3)
    at = np.linspace(-apart, apart, 7)[:, None] * [1.0, 0.4]
    away = ((pad.points[:, :2] - at[:, None]) ** 2).sum(axis=2)
    pressure = np.linspace(20, 21, 7)[:, None] * np.maximum(1 - away, 0.0)
    assert pressures.highest(pad, pressure)[0] == pytest.approx(
        pressures.peaks(pad, pressure).max(), rel=1e-12
    )


def test_a_pressure_at_one_point_counts_with_its_area():
    pad = disk(2)
    pressure = np.zeros((3, len(pad.points)))
    at = int(np.argmin((pad.points**2).sum(axis=1)))
    pressure[1, at] = 100.0
    share = 100.0 * pad.areas[at]
    value, place = pressures.highest(pad, pressure)
    assert 0.7 * share < value < share
    assert place == pytest.approx(pad.points[at])
    assert pressures.highest(pad, 0 * pressure)[0] == 0.0


def test_an_array_feels_a_pressure_that_is_linear_between_coarse_points():
    """Against the same integral over the disk in polar coordinates; points alone miss it."""
    sensor = ArraySensor()
    nodes, weights = np.polynomial.legendre.leggauss(60)
    r, angle = 2 * (nodes[:, None] + 1), np.linspace(0, 2 * np.pi, 240, endpoint=False)
    x, y = r * np.cos(angle), r * np.sin(angle)
    forces = (20 + 2 * x + 3 * y) * (2 * weights[:, None] * r * 2 * np.pi / 240)
    square = ((sensor.positions[:, :, None, None] - np.stack([x, y])) ** 2).sum(axis=1)
    kernel = np.exp(-square / (2 * sensor.sigma**2)) / (2 * np.pi * sensor.sigma**2)
    exact = (kernel * forces).sum(axis=(1, 2))
    by_points, between = [], []
    for seed in range(6):
        pad = disk(seed, 200)
        places = pad.points[:, :2]
        pressure = 20 + places @ [2.0, 3.0]
        felt = array_sensor.reading_matrix(sensor, pad, places) @ pressure
        between.append(np.abs(felt - exact).max() / exact.max())
        lumped = sensor.weights(places, pad.areas) @ pressure
        by_points.append(np.abs(lumped - exact).max() / exact.max())
    assert max(between) < 0.01
    assert min(by_points) > 2 * max(between)
