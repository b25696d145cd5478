"""Cone, flat punch and cylinder against quadrature, energy and printed maxima."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from scipy.special import ellipk

from fefinger.theory.contact.punch import Cone, Cylinder, FlatPunch


STIFF = 34.0 / (1 - 0.45**2)
CONE = Cone(half_angle=70.0, depth=0.5, modulus=34.0, poisson=0.45)
PUNCH = FlatPunch(contact_radius=1.5, depth=0.3, modulus=34.0, poisson=0.45)
CYLINDER = Cylinder(radius=10.0, line_force=20.0, modulus=34.0, poisson=0.45)
ROUND = pytest.mark.parametrize("contact", [CONE, PUNCH], ids=["cone", "punch"])


@ROUND
def test_the_pressure_integrates_to_the_force(contact):
    a = contact.contact_radius
    # r = a sin(s) takes the edge of the punch away, and quad the logarithm at the tip.
    total = quad(
        lambda s: float(contact.pressure(a * math.sin(s))) * a**2 * math.sin(s) * math.cos(s),
        0,
        math.pi / 2 * (1 - 1e-9),
    )[0]
    assert 2 * math.pi * total == pytest.approx(contact.force, rel=1e-7)
    assert float(contact.pressure(1.01 * a)) == 0


@ROUND
def test_the_pressure_displaces_the_surface_onto_the_indenter(contact):
    """The complete elliptic kernel of a ring load, integrated."""
    a = contact.contact_radius

    def drawn(r):
        def ring(s):
            q = a * math.sin(s)
            kernel = ellipk(4 * r * q / (r + q) ** 2) / (r + q)
            return 4 * q * a * math.cos(s) * float(contact.pressure(q)) * kernel

        cuts = [math.asin(r / a)] if r < a else None
        return quad(ring, 1e-9, math.pi / 2 - 1e-9, points=cuts, limit=200)[0] / (math.pi * STIFF)

    for r in (0.2 * a, 0.7 * a, 1.3 * a, 3.0 * a):
        assert drawn(r) == pytest.approx(float(contact.displacement(r)), rel=2e-6)


def test_the_cone_has_its_slope_and_a_punch_for_tangent():
    r = np.linspace(0.1, 0.9, 5) * CONE.contact_radius
    slope = np.diff(CONE.displacement(r)) / np.diff(r)
    np.testing.assert_allclose(slope, -1 / math.tan(math.radians(70.0)), rtol=1e-12)
    step = 1e-6
    more, less = (Cone(70.0, 0.5 + s, modulus=34.0, poisson=0.45).force for s in (step, -step))
    assert (more - less) / (2 * step) == pytest.approx(2 * STIFF * CONE.contact_radius, rel=1e-8)


def test_the_tip_and_the_edge_are_infinite_and_the_punch_is_flat():
    assert np.isinf(CONE.pressure(0.0))
    assert np.isinf(PUNCH.pressure(1.5))
    np.testing.assert_allclose(PUNCH.displacement([0.0, 0.7, 1.5]), 0.3)


def test_a_cylinder_carries_its_force_and_is_sheared_most_at_the_printed_place():
    """Recomputed: .30 p0 at z = .78 b."""
    b, p0 = CYLINDER.half_width, CYLINDER.peak_pressure
    assert p0 * math.pi * b / 2 == pytest.approx(CYLINDER.line_force, rel=1e-14)
    assert float(CYLINDER.pressure(0.0)) == p0
    assert b == pytest.approx(2 * p0 * 10.0 / STIFF, rel=1e-14)

    def shear(z):
        across, down, _ = CYLINDER.stress(0.0, z)
        return -(across - down) / 2

    optimum = minimize_scalar(shear, bounds=(0.3 * b, 2 * b))
    assert -optimum.fun / p0 == pytest.approx(0.30, abs=5e-3)
    assert optimum.x / b == pytest.approx(0.78, abs=7e-3)


@pytest.mark.parametrize("place", [(0.3, 0.5), (-0.3, 0.5), (4.0, 0.4), (-4.0, 1.0), (0.0, 1.0)])
def test_the_field_below_a_cylinder_is_flamant_integrated(place):
    x, z = place
    nodes, weights = np.polynomial.legendre.leggauss(200)
    turn = np.pi / 2 * nodes
    b = CYLINDER.half_width
    source = b * np.sin(turn)
    load = weights * np.pi / 2 * b * np.cos(turn) * CYLINDER.pressure(source)
    gap = x - source
    shared = -2 / np.pi * load * z / (gap**2 + z**2) ** 2
    expected = [np.sum(shared * part) for part in (gap**2, z**2, gap * z)]
    np.testing.assert_allclose(CYLINDER.stress(x, z), expected, rtol=1e-9, atol=1e-12)


def test_below_a_cylinder_at_the_surface_both_normal_stresses_are_the_pressure():
    x = np.linspace(-0.9, 0.9, 7) * CYLINDER.half_width
    across, down, shear = CYLINDER.stress(x, 0.0)
    np.testing.assert_allclose(-down, CYLINDER.pressure(x), rtol=1e-12)
    np.testing.assert_allclose(across, down, rtol=1e-12)
    np.testing.assert_allclose(shear, 0, atol=1e-12)
    np.testing.assert_allclose(CYLINDER.stress(4.0, 0.0), 0, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Cone(30.0, 0.5, modulus=34.0, poisson=0.45), "45 to below 90 degrees"),
        (lambda: Cone(70.0, 0.0, modulus=34.0, poisson=0.45), "depth above 0"),
        (lambda: FlatPunch(1.5, 1.6, modulus=34.0, poisson=0.45), "contact radius 1.5 mm"),
        (lambda: Cylinder(10.0, 400.0, modulus=34.0, poisson=0.45), "half width"),
        (lambda: Cylinder(10.0, 20.0, modulus=34.0, poisson=0.6), "0 to 0.5"),
    ],
)
def test_what_is_out_of_range_is_refused(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()
