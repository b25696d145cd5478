"""Curvature and compliance: Goodwin's spheres, series moduli, torsional friction."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from fefinger.theory.contact.curvature import (
    HertzContact,
    at_depth,
    equivalent_radius,
    goodwin,
    goodwin_at_depth,
    goodwin_radius,
    relative_radius,
    series_modulus,
    torsional_friction,
)
from fefinger.theory.contact.hertz import Hertz


SPHERES = np.array([0.0, 80.6, 172.0, 340.0, 694.0]) * 1e-3  # 1/mm


def at_force(force, radius, plane_modulus):
    """Return the contact under a force in mN (Eq. 3.22 and 3.24); radius in mm, E* in kPa."""
    a = np.cbrt(3 * force * radius / (4 * plane_modulus))
    peak = np.cbrt(6 * force * plane_modulus**2 / (np.pi**3 * radius**2))
    return HertzContact(a, peak, a**2 / radius, force)


@pytest.mark.parametrize(
    ("force", "wanted"),
    [
        (20, (0.196, 0.333, 0.459, 0.655, 0.995)),
        (15, 0.909 * np.array([0.196, 0.333, 0.459, 0.655, 0.995])),
        (10, 0.794 * np.array([0.196, 0.333, 0.459, 0.655, 0.995])),
    ],
)
def test_pressure_under_spheres_is_that_of_the_reference(force, wanted):
    assert goodwin(SPHERES, force) == pytest.approx(wanted, abs=1e-3)  # printed to 3 decimals


def test_the_printed_value_at_zero_curvature_needs_another_reading():
    """Eq. 3.23 gives .196 at 20 and .156 at 10 gf; .3 comes from any of three other readings."""
    assert goodwin(0.0, 20) == pytest.approx(0.196, abs=5e-4)
    assert goodwin(0.0, 10) == pytest.approx(0.156, abs=5e-4)
    assert goodwin_at_depth(0.0) == pytest.approx(0.295, abs=5e-4)
    for other in (
        goodwin_at_depth(0.0),
        goodwin(0.0, 20, finger=7.4),
        goodwin(0.0, 20, reference=(0.34, 20.0)),
    ):
        assert other == pytest.approx(0.3, abs=0.006)  # as printed in section 3.6


def test_contact_radius_under_spheres_is_that_of_the_reference():
    wanted = (1, 0.768, 0.654, 0.547, 0.444)
    assert goodwin_radius(SPHERES) == pytest.approx(wanted, abs=6e-4)


def test_the_ratios_are_those_of_contacts_at_fixed_force_and_fixed_depth():
    radii = np.array([relative_radius(15.0, 1 / c if c else math.inf) for c in SPHERES])
    edge = relative_radius(15.0, 1 / 0.7)
    forced, limit = at_force(150.0, radii, 120.0), at_force(200.0, edge, 120.0)
    assert goodwin(SPHERES, 15) == pytest.approx(forced.peak_pressure / limit.peak_pressure)
    assert goodwin_radius(SPHERES) == pytest.approx(forced.radius / forced.radius[0])
    moved, limit = at_depth(0.3, radii, 120.0), at_depth(0.3, edge, 120.0)
    assert goodwin_at_depth(SPHERES) == pytest.approx(moved.peak_pressure / limit.peak_pressure)


@pytest.mark.parametrize(("depth", "radius"), [(0.1, 14.0), (0.6, 3.0)])
def test_contacts_agree_with_hertz_by_depth_and_by_force(depth, radius):
    hertz = Hertz(radius, depth, 90.0, 0.5)
    by_depth = at_depth(depth, radius, hertz.plane_modulus)
    by_force = at_force(hertz.force, radius, hertz.plane_modulus)
    for found in (by_depth, by_force):
        assert found.radius == pytest.approx(hertz.contact_radius)
        assert found.peak_pressure == pytest.approx(hertz.peak_pressure)
        assert found.depth == pytest.approx(depth)
        assert found.force == pytest.approx(hertz.force)


def test_at_fixed_depth_compliance_changes_the_pressure_alone_and_curvature_both():
    """Section 3.5 of the thesis."""
    stiff, soft = at_depth(0.5, 14.0, 160.0), at_depth(0.5, 14.0, 80.0)
    assert soft.radius == stiff.radius
    assert soft.peak_pressure == pytest.approx(stiff.peak_pressure / 2)
    sharp = at_depth(0.5, 7.0, 160.0)
    assert sharp.radius < stiff.radius
    assert sharp.peak_pressure > stiff.peak_pressure


def test_radii_and_compliances_add_in_series():
    assert relative_radius(14.0, math.inf) == 14.0
    assert relative_radius(10.0, 10.0) == 5.0
    assert relative_radius(10.0, -20.0) == 20.0
    assert equivalent_radius(4.0, 9.0) == 6.0
    assert series_modulus((540.0, 0.5), (math.inf, 0.5)) == pytest.approx(720.0)
    assert series_modulus((540.0, 0.5), (1000.0, 0.5)) == pytest.approx(467.5, abs=0.05)
    assert series_modulus((50.0, 0.3), (50.0, 0.3)) == pytest.approx(25.0 / 0.91)


def test_torque_is_the_integral_of_the_friction_over_the_contact():
    hertz = Hertz(14.0, 0.8, 100.0, 0.5)
    a = hertz.contact_radius
    torque, _ = quad(lambda r: 0.4 * hertz.pressure(r) * r * 2 * np.pi * r, 0, a)
    assert torsional_friction(0.4, hertz.force, a) == pytest.approx(torque, rel=1e-6)
    twice = torsional_friction(0.4, hertz.force, 2 * a)
    assert twice == pytest.approx(2 * torque, rel=1e-6)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: relative_radius(10.0, 0.0), "other than 0"),
        (lambda: relative_radius(10.0, -8.0), "touch in a point"),
        (lambda: series_modulus((math.inf, 0.5)), "at least one that deforms"),
        (lambda: series_modulus((-1.0, 0.5)), "E > 0 kPa"),
    ],
)
def test_what_cannot_be_used_gets_a_sentence(call, message):
    with pytest.raises(ValueError, match=message):
        call()
