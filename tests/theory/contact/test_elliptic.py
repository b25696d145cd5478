"""Elliptic contact against Hertz, its own gap by quadrature, and the printed approximations."""

import math

import numpy as np
import pytest
from oracles.loads import point_stress
from scipy.special import ellipe, ellipk

from fefinger.theory.contact.elliptic import Elliptic
from fefinger.theory.contact.hertz import Hertz


RATIOS = pytest.mark.parametrize("ratio", [1.0, 1.0 + 1e-9, 1.2, 2.0, 5.0, 40.0])
STIFF = 34.0 / (1 - 0.45**2)


def contact(ratio, depth=0.3):
    return Elliptic(8.0 * ratio, 8.0, depth, modulus=34.0, poisson=0.45)


def test_equal_radii_are_hertz_and_nearly_equal_ones_nearly_so():
    h = Hertz(8.0, 0.3, modulus=34.0, poisson=0.45)
    circle = contact(1.0)
    assert circle.semi_axes == pytest.approx((h.contact_radius, h.contact_radius), rel=1e-14)
    assert (circle.force, circle.peak_pressure) == pytest.approx((h.force, h.peak_pressure))
    near = contact(1 + 1e-7)
    assert near.force == pytest.approx(h.force, rel=1e-7)
    assert near.axis_ratio == pytest.approx(1 - 2e-7 / 3, abs=1e-10)


@pytest.mark.parametrize("ratio", [1.2, 2.0, 5.0, 40.0])
def test_the_printed_equations_hold(ratio):
    """Recomputed B2 in Legendre's integrals, as printed."""
    c = contact(ratio)
    a, b = c.semi_axes
    m = 1 - (b / a) ** 2
    big_e, big_k = ellipe(m), ellipk(m)
    assert (big_e / (1 - m) - big_k) / (big_k - big_e) == pytest.approx(ratio, rel=1e-10)
    size = 3 * c.force * math.sqrt(ratio) * 8.0 / (math.pi * STIFF * m)
    size *= math.sqrt((big_e / (1 - m) - big_k) * (big_k - big_e))
    assert a**3 == pytest.approx(size, rel=1e-10)
    assert c.depth == pytest.approx(3 * c.force / (2 * math.pi * a * STIFF) * big_k, rel=1e-12)


@pytest.mark.parametrize("ratio", [1.2, 2.0, 5.0])
def test_printed_approximations(ratio):
    """Recomputed B2: b/a within 1.2 %; the circle of R_e as printed, at equal force."""
    c = contact(ratio)
    assert c.axis_ratio == pytest.approx(ratio ** (-2 / 3), rel=0.012)
    circle = Hertz.under_force(8.0 * math.sqrt(ratio), c.force, modulus=34.0, poisson=0.45)
    assert math.sqrt(math.prod(c.semi_axes)) == pytest.approx(circle.contact_radius, rel=0.0335)
    assert c.depth == pytest.approx(circle.depth, rel=0.0345)
    assert c.peak_pressure == pytest.approx(circle.peak_pressure, rel=0.0705)


@RATIOS
def test_force_is_inverted_and_is_the_volume_of_the_pressure(ratio):
    c = contact(ratio)
    back = Elliptic.under_force(8.0 * ratio, 8.0, force=c.force, modulus=34.0, poisson=0.45)
    assert back.depth == pytest.approx(c.depth, rel=1e-12)
    a, b = c.semi_axes
    nodes, weights = np.polynomial.legendre.leggauss(60)
    turn = np.pi / 4 * (nodes + 1)
    angle = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    s = np.sin(turn)[:, None]
    cell = (np.sin(turn) * np.cos(turn) * weights)[:, None] * np.pi / 4 * 2 * np.pi / 32 * a * b
    total = np.sum(c.pressure(a * s * np.cos(angle), b * s * np.sin(angle)) * cell)
    assert total == pytest.approx(c.force, rel=1e-12)
    assert not c.pressure([1.001 * a, 0.0], [0.0, 1.001 * b]).any()


def displaced(c, x, y):
    """Surface displacement by Boussinesq's kernel in polar coordinates around the point."""
    a, b = c.semi_axes
    nodes, weights = np.polynomial.legendre.leggauss(64)
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    along, across = np.cos(angle), np.sin(angle)
    square = (along / a) ** 2 + (across / b) ** 2
    half = (x * along / a**2 + y * across / b**2) / square
    room = (1 - (x / a) ** 2 - (y / b) ** 2) / square
    # Along a ray the pressure is a half circle: middle -half, radius sqrt(half² + room).
    size = np.sqrt(half**2 + room)
    start = np.arcsin(half / size)
    s = start[:, None] + (np.pi / 2 - start)[:, None] * (nodes + 1) / 2
    ray = np.cos(s) ** 2 @ weights * (np.pi / 2 - start) / 2 * size**2 * np.sqrt(square)
    return c.peak_pressure * ray.sum() * 2 * np.pi / 400 / (np.pi * STIFF)


@pytest.mark.parametrize("ratio", [1.0, 2.0, 5.0])
@pytest.mark.parametrize("place", [(0.0, 0.0), (0.5, 0.0), (0.0, 0.7), (0.4, -0.6)])
def test_the_pressure_displaces_the_surface_onto_the_indenter(ratio, place):
    c = contact(ratio)
    a, b = c.semi_axes
    x, y = place[0] * a, place[1] * b
    gap = x**2 / (16 * ratio) + y**2 / 16
    assert displaced(c, x, y) == pytest.approx(c.depth - gap, rel=1e-9)


# The field below


POISSON = pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])


def below(poisson, ratio=5.0):
    return Elliptic(8.0 * ratio, 8.0, 0.3, modulus=34.0, poisson=poisson)


def random_places(count=60, seed=3):
    rng = np.random.default_rng(seed)
    return rng.uniform([-5, -3, 0.05], [5, 3, 4], (count, 3))


def gradient(field, place, step=1e-3):
    """Fourth-order central differences of a field along x, y and z, on the last axis."""
    moves = step * np.eye(3)
    near = [field(place + d) - field(place - d) for d in moves]
    far = [field(place + 2 * d) - field(place - 2 * d) for d in moves]
    return np.stack([(8 * n - f) / (12 * step) for n, f in zip(near, far, strict=True)], axis=-1)


@POISSON
def test_a_round_contact_has_hubers_field(poisson):
    c, h = below(poisson, 1.0), Hertz(8.0, 0.3, modulus=34.0, poisson=poisson)
    places = np.vstack([random_places(), [[0, 0, 0.5], [1.0, 0, 1e-4]]])
    x, y, z = places.T
    r = np.hypot(x, y)
    cosine, sine = np.where(r > 0, x / np.maximum(r, 1e-99), 1), y / np.maximum(r, 1e-99)
    radial, hoop, axial, shear = h.stress(r, z)
    want = np.array(
        [
            [radial * cosine**2 + hoop * sine**2, (radial - hoop) * cosine * sine, shear * cosine],
            [(radial - hoop) * cosine * sine, radial * sine**2 + hoop * cosine**2, shear * sine],
            [shear * cosine, shear * sine, axial],
        ]
    )
    np.testing.assert_allclose(
        c.stress(places), np.moveaxis(want, 2, 0), atol=1e-11 * h.peak_pressure
    )
    outward, inward = h.displacement(r, z)
    moved = c.displacement(places)
    np.testing.assert_allclose(moved[:, 0], outward * cosine, atol=1e-11)
    np.testing.assert_allclose(moved[:, 2], inward, rtol=1e-11)


@POISSON
def test_the_field_is_in_equilibrium_and_the_gradient_of_its_displacement(poisson):
    c, places = below(poisson), random_places()
    force = np.einsum("nijj->ni", gradient(c.stress, places))
    assert np.abs(force).max() < 2e-6 * c.peak_pressure
    moved = gradient(c.displacement, places)
    strain = (moved + np.swapaxes(moved, 1, 2)) / 2
    np.testing.assert_allclose(c.strain(places), strain, atol=1e-6 * np.abs(strain).max())
    np.testing.assert_array_equal(c.stress(places), np.swapaxes(c.stress(places), 1, 2))


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.4), (2.0, 0.5, 0.6), (3.0, -2.0, 1.0)])
def test_the_axial_stress_is_boussinesqs_integral(place):
    c = below(0.3)
    a, b = c.semi_axes
    nodes, weights = np.polynomial.legendre.leggauss(120)
    s = np.pi / 4 * (nodes + 1)
    turn = np.linspace(0, 2 * np.pi, 512, endpoint=False)
    x, y = a * np.outer(np.sin(s), np.cos(turn)), b * np.outer(np.sin(s), np.sin(turn))
    part = np.pi / 4 * weights * np.cos(s) ** 2 * np.sin(s) * a * b * 2 * np.pi / 512
    rho = np.sqrt((x - place[0]) ** 2 + (y - place[1]) ** 2 + place[2] ** 2)
    load = c.peak_pressure * part[:, None]
    axial = -3 * place[2] ** 3 / (2 * np.pi) * np.sum(load / rho**5)
    slanted = -3 * place[2] ** 2 / (2 * np.pi) * np.sum(load * (place[0] - x) / rho**5)
    stress = c.stress(place)
    assert stress[2, 2] == pytest.approx(axial, rel=1e-9)
    assert stress[0, 2] == pytest.approx(slanted, rel=1e-9, abs=1e-12)


@POISSON
def test_just_below_the_surface_it_bears_the_pressure_and_nothing_else(poisson):
    c = below(poisson)
    a, b = c.semi_axes
    x, y = (
        np.array([0.0, 0.5 * a, 0.0, 0.3 * a, 1.2 * a]),
        np.array([0.0, 0.0, 0.8 * b, 0.4 * b, b]),
    )
    stress = c.stress(np.stack([x, y, np.full(5, 1e-7)], axis=1))
    tiny = 1e-5 * c.peak_pressure
    np.testing.assert_allclose(-stress[:, 2, 2], c.pressure(x, y), atol=tiny)
    np.testing.assert_allclose(stress[:, :2, 2], 0, atol=tiny)
    sunk = c.displacement(np.stack([x, y, np.full(5, 1e-7)], axis=1))[:4, 2]
    gap = x[:4] ** 2 / (2 * c.long_radius) + y[:4] ** 2 / (2 * c.short_radius)
    np.testing.assert_allclose(sunk, c.depth - gap, rtol=1e-6)


@POISSON
def test_far_away_it_is_that_of_a_point_force(poisson):
    c = below(poisson)
    place = 3e3 * np.array([0.6, 0.0, 0.8])
    radial, hoop, axial, shear = point_stress(1.8e3, 2.4e3, force=c.force, poisson=poisson)
    want = np.array([[radial, 0, shear], [0, hoop, 0], [shear, 0, axial]])
    np.testing.assert_allclose(c.stress(place), want, atol=1e-5 * abs(axial))


@pytest.mark.parametrize(
    "place", [[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, np.nan, 1.0], [1.0, 1.0]]
)
def test_places_that_are_not_below_the_surface_are_refused(place):
    for field in (below(0.3).stress, below(0.3).strain, below(0.3).displacement):
        with pytest.raises(ValueError, match="below the surface, z > 0 mm"):
            field(place)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"long_radius": 7.0}, "in 1 to"),
        ({"depth": 9.0}, "at most the short radius 8 mm"),
        ({"short_radius": 0.0}, "short_radius above 0"),
        ({"poisson": -0.1}, "0 to 0.5"),
    ],
)
def test_what_is_out_of_range_is_refused(change, sentence):
    values = {"long_radius": 9.0, "short_radius": 8.0, "depth": 0.3}
    with pytest.raises(ValueError, match=sentence):
        Elliptic(**(values | {"modulus": 34.0, "poisson": 0.45} | change))
