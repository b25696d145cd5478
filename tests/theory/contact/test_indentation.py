"""The contact solver against closed forms of the half-space, energy, and pressure by rings."""

import math

import numpy as np
import pytest
from fefinger.validation.oracles.layer import Sheet, paraboloid_at
from fefinger.validation.oracles.punch import FlatPunch
from oracles.solved_contact import load_within, surface_displacement
from scipy.integrate import quad
from scipy.special import ellipe, ellipkm1, j0, j1

from fefinger.theory.contact.hertz import Hertz
from fefinger.theory.contact.indentation import flat_punch, paraboloid
from fefinger.theory.contact.stack import Layer, Stack


HALF_SPACE = Stack((Layer(math.inf, 34.0, 0.45),))
BONDED = Sheet(2.0, modulus=34.0, poisson=0.5)
SLIDING = Sheet(2.0, modulus=34.0, poisson=0.3, base="sliding")
FINGER = Stack((Layer(1.0, 100.0, 0.49), Layer(4.0, 34.0, 0.48)))
SOFT_TOP = Stack((Layer(0.5, 10.0, 0.5), Layer(math.inf, 80.0, 0.4)))
BODIES = pytest.mark.parametrize(
    "body", [BONDED, SLIDING, FINGER, SOFT_TOP], ids=["bonded", "sliding", "finger", "soft top"]
)


def test_a_half_space_is_hertz():
    contact = paraboloid_at(HALF_SPACE, 10.0, depth=0.4)
    h = Hertz(10.0, 0.4, modulus=34.0, poisson=0.45)
    assert contact.contact_radius == pytest.approx(h.contact_radius, rel=1e-12)
    assert contact.force == pytest.approx(h.force, rel=1e-12)
    r = np.array([0.0, 0.5, 1.9, 1.9999, 2.0, 2.5])
    np.testing.assert_allclose(contact.pressure(r), h.pressure(r), rtol=1e-9, atol=1e-6)
    away = np.array([0.0, 1.0, 2.1, 5.0])
    np.testing.assert_allclose(
        surface_displacement(contact, away), h.displacement(away, 0.0)[1], rtol=1e-10
    )


def test_a_half_space_is_sneddons_punch():
    contact = flat_punch(HALF_SPACE, 1.5, depth=0.3)
    punch = FlatPunch(1.5, 0.3, modulus=34.0, poisson=0.45)
    assert contact.force == pytest.approx(punch.force, rel=1e-13)
    r = np.array([0.0, 0.7, 1.4, 1.5, 1.6])
    np.testing.assert_allclose(contact.pressure(r), punch.pressure(r), rtol=1e-12)
    np.testing.assert_allclose(surface_displacement(contact, r), punch.displacement(r), rtol=1e-12)


@BODIES
@pytest.mark.parametrize("wide", [0.3, 2.0, 6.0])
def test_the_pressure_displaces_the_surface_onto_the_indenter(body, wide):
    contact = paraboloid(body, 40.0, contact_radius=wide)
    r = np.array([0.0, 0.2, 0.55, 0.9, 1.0]) * wide
    np.testing.assert_allclose(
        surface_displacement(contact, r), contact.depth - r**2 / 80.0, atol=1e-10 * contact.depth
    )
    outside = np.array([1.01, 1.3, 3.0]) * wide
    assert np.all(surface_displacement(contact, outside) > contact.depth - outside**2 / 80.0)
    inside = contact.pressure(np.linspace(0, 0.999, 50) * wide)
    assert np.all(inside > 0)
    punch = flat_punch(body, wide, depth=0.1)
    np.testing.assert_allclose(surface_displacement(punch, r[:4]), 0.1, rtol=1e-9)


@BODIES
@pytest.mark.parametrize("kind", ["paraboloid", "punch"])
def test_force_and_transform_are_those_of_the_pressure(body, kind):
    solved = {
        "paraboloid": lambda: paraboloid(body, 10.0, contact_radius=2.0),
        "punch": lambda: flat_punch(body, 2.0, depth=0.1),
    }
    actual = solved[kind]()
    nodes, weights = np.polynomial.legendre.leggauss(120)
    s = np.pi / 4 * (nodes + 1)
    r = 2.0 * np.sin(s)
    ring = actual.pressure(r) * r * 2.0 * np.cos(s) * np.pi / 4 * weights
    assert 2 * np.pi * ring.sum() == pytest.approx(actual.force, rel=1e-11)
    part = load_within(actual, np.array([0.0, 1.2, 2.0, 5.0]))
    assert part[[0, 2, 3]] == pytest.approx(
        [0, actual.force, actual.force], abs=1e-11 * actual.force
    )
    for xi in (0.1, 1.0, 5.0, 20.0):
        expected = j0(xi * r) @ ring
        assert actual.transform(xi) == pytest.approx(expected, abs=1e-11 * ring.sum())


@BODIES
def test_the_force_is_the_derivative_of_the_energy(body):
    """At a fixed contact circle the body is a flat punch: dP / d(depth) is the punch's P."""
    middle = flat_punch(body, 2.0, depth=1.0).force
    more, less = (paraboloid(body, 10.0, contact_radius=2.0 + s) for s in (1e-4, -1e-4))
    slope = (more.force - less.force) / (more.depth - less.depth)
    assert slope == pytest.approx(middle, rel=1e-7)


@BODIES
@pytest.mark.parametrize("depth", [1e-4, 0.02, 0.5])
def test_the_depth_is_reached(body, depth):
    contact = paraboloid_at(body, 10.0, depth=depth)
    assert contact.depth == pytest.approx(depth, rel=1e-11)


def on_a_circle(x):
    """Displacement at x radii by a unit pressure on a circle, over radius / E* (Johnson 3.4.2)."""
    inverse = 1 / np.maximum(x, 1.0)
    rest = np.maximum(1 - inverse**2, 1e-300)  # times K it tends to 0 at the edge
    far = ellipe(inverse**2) - rest * ellipkm1(rest)
    return 4 / np.pi * np.where(x <= 1, ellipe(np.minimum(x, 1.0) ** 2), x * far)


def influence(body, edges, places):
    """Surface displacement at `places` of unit pressures on the circles of radius `edges`.

    The half-space part in closed form, the rest by adaptive quadrature of the kernel: nothing of
    the integral equation.
    """
    modulus, poisson = body.surface
    nodes, weights = np.polynomial.legendre.leggauss(24)
    cuts = np.concatenate([[0.0], np.geomspace(1e-3, 25 / body.scales[0], 60)])
    half = np.diff(cuts)[:, None] / 2
    xi, step = (cuts[:-1, None] + half * (nodes + 1)).ravel(), (half * weights).ravel()
    extra = step * (body.compliance(xi) - 1) * 2 * (1 - poisson**2) / modulus / xi
    apart = edges * on_a_circle(places[:, None] / edges) * (1 - poisson**2) / modulus
    return apart + j0(np.outer(places, xi)) * extra @ (j1(np.outer(xi, edges)) * edges)


@BODIES
def test_rings_of_uniform_pressure_find_the_same_force(body):
    """Second method: collocation with piecewise constant rings, of first order in their width."""

    def rings(count):
        edges = 2.0 * np.sin(np.linspace(0, np.pi / 2, count + 1)[1:])
        inner = np.concatenate([[0.0], edges[:-1]])
        places = (edges + inner) / 2
        circles = influence(body, edges, places)
        matrix = circles - np.concatenate([np.zeros((count, 1)), circles[:, :-1]], axis=1)
        loads = np.linalg.solve(matrix, np.full(count, 0.1))
        return np.pi * np.sum(loads * (edges**2 - inner**2))

    punch = flat_punch(body, 2.0, depth=0.1).force
    coarse, fine = abs(rings(20) / punch - 1), abs(rings(40) / punch - 1)
    assert fine < 2e-3
    assert fine < 0.6 * coarse


def test_what_is_out_of_range_is_refused():
    with pytest.raises(ValueError, match="at most the radius 10 mm"):
        paraboloid(BONDED, 10.0, contact_radius=10.1)
    with pytest.raises(ValueError, match="contact is at most as wide as the radius"):
        paraboloid_at(HALF_SPACE, 10.0, depth=10.5)
    with pytest.raises(ValueError, match="at most 200 thicknesses"):
        flat_punch(Sheet(0.01, 34.0, 0.5), 3.0, depth=0.1)
    with pytest.raises(ValueError, match="depth above 0"):
        flat_punch(BONDED, 3.0, depth=0.0)


def test_the_kernel_is_integrated_to_rounding():
    """The slope of the finger's kernel against adaptive quadrature."""
    from fefinger.theory.contact.indentation import spectrum

    xi, weight = spectrum(FINGER, 12.0)
    for y in (0.0, 3.0, 12.0):
        expected = quad(
            lambda x, y=y: (1 - FINGER.compliance([x])[0]) * math.cos(x * y),
            1e-12,
            20.0,
            limit=400,
            epsabs=1e-10,
        )[0]
        assert np.cos(xi * y) @ weight == pytest.approx(expected, abs=1e-8)
