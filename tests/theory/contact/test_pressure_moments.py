"""Moments of pressures on triangles against closed forms."""

import numpy as np
import pytest

from fefinger.results.pressure import moments


def grid(count=81, reach=3.0):
    """Return places, triangles and areas of a square of triangles."""
    line = np.linspace(-reach, reach, count)
    places = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    corner = np.arange(count * count).reshape(count, count)
    a, b, c, d = (corner[i, j].ravel() for i, j in SLICES)
    triangles = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    return places, triangles, np.full(len(triangles), (line[1] - line[0]) ** 2 / 2)


SLICES = [
    (slice(None, -1), slice(None, -1)),
    (slice(None, -1), slice(1, None)),
    (slice(1, None), slice(None, -1)),
    (slice(1, None), slice(1, None)),
]


def hertz(places, a, b, center=(0.0, 0.0), turn=0.0):
    """Return Hertz's pressure on an ellipse that is turned by degrees."""
    x, y = (places - center).T
    cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    u, v = cos * x + sin * y, cos * y - sin * x
    return np.sqrt(np.maximum(1 - (u / a) ** 2 - (v / b) ** 2, 0))


@pytest.mark.parametrize("shift", [-0.7, 0.0, 0.31, 1.2])
def test_asymmetry_of_hertz_is_that_of_a_cut_ball(shift):
    places, triangles, areas = grid()
    actual = moments(places, triangles, areas, hertz(places, 1.6, 1.1, (shift, 0.4)))
    s = shift / 1.6  # the part of a ball beyond a plane is (2 + 3 s - s^3) / 4
    assert actual.asymmetry == pytest.approx((3 * s - s**3) / 2, abs=2e-3)
    assert actual.center == pytest.approx([shift, 0.4], abs=2e-3)
    assert actual.force == pytest.approx(2 / 3 * np.pi * 1.6 * 1.1, rel=3e-3)


@pytest.mark.parametrize("turn", [0, 25, -60, 90])
def test_ellipticity_and_direction_of_hertz(turn):
    places, triangles, areas = grid()
    actual = moments(places, triangles, areas, hertz(places, 2.0, 1.2, (0.3, -0.2), turn))
    assert actual.ellipticity == pytest.approx(1 - 1.2 / 2.0, abs=3e-3)
    assert abs((actual.long_axis - turn + 90) % 180 - 90) < 0.5


def test_a_linear_pressure_is_cut_exactly_wherever_the_line_runs():
    triangle = np.array([[-1.0, 0.0], [2.0, 0.5], [0.5, 3.0]])
    pressure = np.array([1.0, 4.0, 2.0])
    rng = np.random.default_rng(0)
    weights = rng.dirichlet([1, 1, 1], 400_000)
    values = weights @ pressure
    for cut in (-0.6, 0.2, 0.5, 1.4):
        actual = moments(triangle - [cut, 0], [[0, 1, 2]], [2.0], pressure)
        ahead = (weights @ triangle)[:, 0] > cut
        drawn = 2 * values[ahead].sum() / values.sum() - 1
        assert actual.asymmetry == pytest.approx(drawn, abs=4e-3)
        assert actual.force == pytest.approx(2.0 * 7 / 3)


def test_nothing_has_no_moments():
    places, triangles, areas = grid(5)
    with pytest.raises(ValueError, match="above 0, received 0 mN"):
        moments(places, triangles, areas, np.zeros(25))
