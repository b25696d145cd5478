"""Elliptic contact against Hertz, its own gap by quadrature, and the printed approximations."""

import math

import numpy as np
import pytest
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
    radius = 8.0 * math.sqrt(ratio)
    depth = (9 * c.force**2 / (16 * radius * STIFF**2)) ** (1 / 3)
    circle = Hertz(radius, depth, modulus=34.0, poisson=0.45)
    assert math.sqrt(math.prod(c.semi_axes)) == pytest.approx(circle.contact_radius, rel=0.0335)
    assert c.depth == pytest.approx(circle.depth, rel=0.0345)
    assert c.peak_pressure == pytest.approx(circle.peak_pressure, rel=0.0705)


@RATIOS
def test_force_is_the_volume_of_the_pressure(ratio):
    c = contact(ratio)
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
