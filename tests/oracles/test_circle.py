"""A uniform pressure on a circle: equilibrium, compatibility, points side by side, and limits."""

import numpy as np
import pytest
from oracles import loads
from oracles.circle import NEAR, circle_stress
from oracles.differences import derivative, divergence

from fefinger.theory.contact import elastic


POISSON = pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])


def stress(r, z, poisson=0.3):
    return circle_stress(r, z, radius=1.5, pressure=7.0, poisson=poisson)


def random_points(seed=1):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.02, 4.0, 200), rng.uniform(0.1, 4.0, 200)


@POISSON
def test_the_field_is_in_equilibrium(poisson):
    force = divergence(lambda r, z: stress(r, z, poisson), *random_points())
    np.testing.assert_allclose(force, 0, atol=2e-5)


@POISSON
def test_its_strain_belongs_to_a_displacement(poisson):
    """Compatibility of u_r = r e_theta: e_r is its slope along r."""
    r, z = random_points(2)

    def strain(s):
        return elastic.strain(stress(s, z, poisson), 3.0, poisson)

    slope = derivative(lambda s: s * strain(s)[1], r)
    np.testing.assert_allclose(strain(r)[0], slope, atol=2e-5)


@POISSON
@pytest.mark.parametrize("place", [(0.0, 0.4), (0.7, 0.5), (1.5, 0.6), (2.2, 1.0), (1e-3, 2.0)])
def test_it_is_points_side_by_side(poisson, place):
    r, z = place
    nodes, weights = np.polynomial.legendre.leggauss(80)
    source, turn = 0.75 * (nodes + 1), (np.arange(256) + 0.5) * 2 * np.pi / 256
    x = r - source[:, None] * np.cos(turn)
    y = -source[:, None] * np.sin(turn)
    load = (7.0 * 0.75 * weights * source * 2 * np.pi / 256)[:, None]
    apart = np.hypot(x, y)
    radial, hoop, axial, shear = loads.point_stress(apart, z, force=1.0, poisson=poisson)
    c, s = x / apart, y / apart
    want = [
        np.sum(load * (radial * c**2 + hoop * s**2)),
        np.sum(load * (radial * s**2 + hoop * c**2)),
        np.sum(load * axial),
        np.sum(load * shear * c),
    ]
    np.testing.assert_allclose(stress(r, z, poisson), want, atol=1e-9)


@POISSON
def test_on_the_axis_and_beside_it(poisson):
    z = np.array([0.1, 0.5, 3.0])
    radial, axial = loads.circle_axis_stress(z, radius=1.5, pressure=7.0, poisson=poisson)
    want = np.array([radial, radial, axial, 0 * z])
    np.testing.assert_allclose(stress(0.0, z, poisson), want, atol=1e-13)
    np.testing.assert_allclose(stress(1e-7, z, poisson), want, atol=1e-5)
    # Across the border between the two ways to integrate.
    middle = 2 / NEAR - 1
    border = 1.5 * (middle - np.sqrt(middle**2 - 1 - (1.0 / 1.5) ** 2))
    near = stress(border * np.linspace(0.99, 1.01, 9), 1.0, poisson)
    assert np.abs(np.diff(near, 5)).max() < 1e-12 * 7.0


@POISSON
def test_just_below_the_surface_it_is_the_pressure_and_far_away_a_point(poisson):
    r = np.array([0.0, 0.7, 1.4, 1.6, 5.0])
    top = stress(r, 1e-7, poisson)
    np.testing.assert_allclose(top[2], np.where(r < 1.5, -7.0, 0.0), atol=1e-5)
    np.testing.assert_allclose(top[3], 0, atol=1e-5)
    np.testing.assert_allclose(top[:2, :3], -3.5 * (1 + 2 * poisson), atol=1e-5)
    force = 7.0 * np.pi * 1.5**2
    point = loads.point_stress(900.0, 1200.0, force=force, poisson=poisson)
    np.testing.assert_allclose(stress(900.0, 1200.0, poisson), point, atol=1e-5 * abs(point[2]))
