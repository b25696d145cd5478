"""Cone and flat punch against quadrature and energy."""

import math

import numpy as np
import pytest
from fefinger.validation.oracles.punch import Cone, FlatPunch
from scipy.integrate import quad
from scipy.special import ellipk


STIFF = 34.0 / (1 - 0.45**2)
CONE = Cone(half_angle=70.0, depth=0.5, modulus=34.0, poisson=0.45)
PUNCH = FlatPunch(contact_radius=1.5, depth=0.3, modulus=34.0, poisson=0.45)
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
