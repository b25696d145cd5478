"""Loads on a half-space against superposition, differentiation, balance and each other."""

import numpy as np
import pytest
from fefinger.validation.oracles.point_force import point_displacement
from oracles import loads
from oracles.differences import derivative, divergence, gradient

from fefinger.theory.contact import elastic


POISSON = pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)


def cloud(seed):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.3, 2.0, 50), rng.uniform(0.3, 2.0, 50)


@POISSON
def test_a_point_force_is_in_equilibrium_and_hookes(poisson):
    r, z = cloud(1)

    def stress(r, z):
        return loads.point_stress(r, z, force=2.0, poisson=poisson)

    def moved(r, z):
        return point_displacement(r, z, force=2.0, modulus=3.0, poisson=poisson)

    np.testing.assert_allclose(divergence(stress, r, z), 0, atol=1e-7)
    strain = elastic.strain(stress(r, z), 3.0, poisson)
    np.testing.assert_allclose(strain, gradient(moved, r, z), atol=1e-8)


@POISSON
def test_a_point_force_is_carried_at_any_depth_and_regular_on_the_axis(poisson):
    s = np.pi / 4 * (NODES + 1)
    r = 0.7 * np.tan(s)
    ring = 2 * np.pi * r * 0.7 / np.cos(s) ** 2 * np.pi / 4 * WEIGHTS
    axial = loads.point_stress(r, 0.7, force=2.0, poisson=poisson)[2]
    assert axial @ ring == pytest.approx(-2.0, rel=1e-12)
    on, near = (loads.point_stress(r, 0.7, force=2.0, poisson=poisson) for r in (0.0, 1e-9))
    np.testing.assert_allclose(on, near, atol=1e-8)
    assert on[0] == pytest.approx(2.0 / (4 * np.pi) * (1 - 2 * poisson) / 0.49)


@POISSON
def test_a_line_is_a_row_of_points(poisson):
    x, z = 0.8, 0.5
    s = np.pi / 2 * NODES
    y = np.hypot(x, z) * np.tan(s)
    step = np.hypot(x, z) / np.cos(s) ** 2 * np.pi / 2 * WEIGHTS
    r = np.hypot(x, y)
    radial, hoop, axial, shear = loads.point_stress(r, z, force=1.0, poisson=poisson) * step
    row = [np.sum(radial * (x / r) ** 2 + hoop * (y / r) ** 2), axial.sum(), np.sum(shear * x / r)]
    np.testing.assert_allclose(loads.line_stress(x, z, line_force=1.0), row, rtol=1e-10)


@POISSON
def test_a_line_displaces_as_hooke_says_in_plane_strain(poisson):
    x, z = cloud(2)

    def moved(x, z):
        return loads.line_displacement(
            x, z, reference=4.0, line_force=1.0, modulus=3.0, poisson=poisson
        )

    by_x, by_z = derivative(lambda s: moved(s, z), x), derivative(lambda s: moved(x, s), z)
    across, down, shear = loads.line_stress(x, z, line_force=1.0)
    grow = 1 + poisson
    expected = [
        grow * ((1 - poisson) * across - poisson * down) / 3,
        grow * ((1 - poisson) * down - poisson * across) / 3,
        grow * shear / 3,
    ]
    found = [by_x[0], by_z[1], (by_z[0] + by_x[1]) / 2]
    np.testing.assert_allclose(found, expected, atol=1e-8)
    assert moved(4.0, 1e-12)[1] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("place", [(0.0, 0.4), (1.0, 0.4), (-1.3, 0.6), (3.0, 1.0)])
def test_a_strip_is_lines_side_by_side(place):
    x, z = place
    source, step = 0.9 * NODES, 0.9 * WEIGHTS
    lines = loads.line_stress(x - source, z, line_force=5.0) @ step
    strip = loads.strip_stress(x, z, half_width=0.9, pressure=5.0)
    np.testing.assert_allclose(strip, lines, rtol=1e-9, atol=1e-12)


def test_a_flat_strip_carries_its_force_and_flattens_the_surface():
    turn = np.pi / 2 * np.polynomial.legendre.leggauss(400)[0]
    weights = np.polynomial.legendre.leggauss(400)[1] * np.pi / 2
    source = 0.9 * np.sin(turn)
    load = weights * 0.9 * np.cos(turn)
    load *= loads.flat_strip_pressure(source, half_width=0.9, line_force=5.0)
    assert load.sum() == pytest.approx(5.0, rel=1e-10)
    moved = [
        loads.line_displacement(
            x - source, 1e-9, reference=4.0, line_force=1.0, modulus=3.0, poisson=0.3
        )[1]
        @ load
        for x in (0.0, 0.2, 0.5)
    ]
    # The logarithm at the point itself costs the quadrature one part in its 400 nodes.
    np.testing.assert_allclose(moved, moved[0], rtol=4e-3)
    assert loads.flat_strip_pressure(1.0, half_width=0.9, line_force=5.0) == 0


@POISSON
def test_a_circle_on_its_axis_is_rings_of_points(poisson):
    r, step = 0.75 * (NODES + 1), 0.75 * WEIGHTS
    for z in (0.4, 1.0, 5.0):
        radial, hoop, axial, _ = loads.point_stress(r, z, force=1.0, poisson=poisson)
        ring = 2 * np.pi * r * step * 7.0
        found = loads.circle_axis_stress(z, radius=1.5, pressure=7.0, poisson=poisson)
        rings = [ring @ (radial + hoop) / 2, ring @ axial]
        np.testing.assert_allclose(found, rings, rtol=1e-6)
    surface = loads.circle_axis_stress(0.0, radius=1.5, pressure=7.0, poisson=poisson)
    np.testing.assert_allclose(surface, [-3.5 * (1 + 2 * poisson), -7.0])


@pytest.mark.parametrize("r", [0.0, 0.6, 1.49999, 1.50001, 2.0, 40.0])
def test_a_circle_displaces_the_surface_as_chords_say(r):
    """Second method: in polar coordinates around the point, u = p / (pi E*) times the chords."""
    angle = (np.arange(20000) + 0.5) * 2 * np.pi / 20000
    room = np.maximum(1.5**2 - (r * np.sin(angle)) ** 2, 0.0)
    far = np.maximum(-r * np.cos(angle) + np.sqrt(room), 0.0)
    near = np.maximum(-r * np.cos(angle) - np.sqrt(room), 0.0)
    chords = np.sum(np.where(room > 0, far - near, 0.0)) * 2 * np.pi / 20000
    found = loads.circle_displacement(r, radius=1.5, pressure=7.0, modulus=3.0, poisson=0.3)
    assert found == pytest.approx(7.0 * 0.91 / (3.0 * np.pi) * chords, rel=2e-4)


def test_a_circle_at_its_edge_and_far_away():
    def moved(r):
        return loads.circle_displacement(r, radius=1.5, pressure=7.0, modulus=3.0, poisson=0.3)

    assert moved(1.5) == pytest.approx(2 / np.pi * moved(0.0), rel=1e-12)
    point = 7.0 * np.pi * 1.5**2 * 0.91 / (np.pi * 3.0 * 300.0)
    assert moved(300.0) == pytest.approx(point, rel=1e-5)


def point_tensor(x, y, z, poisson):
    """Return the Cartesian stress (..., 3, 3) of a unit point force at the origin."""
    r = np.hypot(x, y)
    radial, hoop, axial, shear = loads.point_stress(r, z, force=1.0, poisson=poisson)
    c, s = x / r, y / r
    rows = [
        [radial * c**2 + hoop * s**2, (radial - hoop) * c * s, shear * c],
        [(radial - hoop) * c * s, radial * s**2 + hoop * c**2, shear * s],
        [shear * c, shear * s, axial],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


@POISSON
@pytest.mark.parametrize("place", [(0.1, 0.2, 0.5), (-1.2, 0.3, 0.4), (1.0, -0.6, 0.8), (4, 3, 2)])
def test_a_rectangle_is_made_of_points(poisson, place):
    x, y = np.meshgrid(1.0 * NODES, 0.6 * NODES, indexing="ij")
    weight = np.outer(WEIGHTS, 0.6 * WEIGHTS) * 7.0
    parts = point_tensor(place[0] - x, place[1] - y, place[2], poisson)
    expected = np.einsum("ij,ijkl->kl", weight, parts)
    found = loads.rectangle_stress(place, half_sides=(1.0, 0.6), pressure=7.0, poisson=poisson)
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-9)


def test_a_long_rectangle_is_a_strip_in_plane_strain():
    stress = loads.rectangle_stress(
        (0.5, 0.0, 0.7), half_sides=(0.9, 1e8), pressure=5.0, poisson=0.3
    )
    across, down, shear = loads.strip_stress(0.5, 0.7, half_width=0.9, pressure=5.0)
    found = [stress[0, 0], stress[2, 2], stress[0, 2], stress[1, 1]]
    np.testing.assert_allclose(found, [across, down, shear, 0.3 * (across + down)], rtol=1e-6)


def test_a_rectangle_displaces_the_surface_as_four_and_as_a_point():
    """Love's value at the middle, halves that add up, and the far field."""

    def moved(place, half_sides=(1.0, 0.6)):
        return loads.rectangle_displacement(
            place, half_sides=half_sides, pressure=7.0, modulus=3.0, poisson=0.3
        )

    middle = 4 * (np.arcsinh(0.6) + 0.6 * np.arcsinh(1 / 0.6)) * 7.0 * 0.91 / (np.pi * 3.0)
    assert moved((0.0, 0.0)) == pytest.approx(middle, rel=1e-13)
    place = np.array([0.3, 0.7])
    halves = sum(moved(place - [x, 0], (0.5, 0.6)) for x in (-0.5, 0.5))
    assert moved(place) == pytest.approx(halves, rel=1e-13)
    assert moved((300.0, 400.0)) == pytest.approx(7 * 2.4 * 0.91 / (np.pi * 3 * 500), rel=1e-5)
