"""Goodwin's spheres and the friction torque of a contact, against Hertz and quadrature."""

import math
from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.oracles import goodwin
from scipy.integrate import quad

from fefinger.theory.contact.hertz import Hertz, relative_radius


SPHERES = np.array([0.0, 80.6, 172.0, 340.0, 694.0]) * 1e-3  # 1/mm


@pytest.mark.parametrize(
    ("force", "wanted"),
    [
        (20, (0.196, 0.333, 0.459, 0.655, 0.995)),
        (15, 0.909 * np.array([0.196, 0.333, 0.459, 0.655, 0.995])),
        (10, 0.794 * np.array([0.196, 0.333, 0.459, 0.655, 0.995])),
    ],
)
def test_pressure_under_spheres_is_that_of_the_reference(force, wanted):
    assert goodwin.peak_at_force(SPHERES, force) == pytest.approx(
        wanted, abs=1e-3
    )  # printed to 3 decimals


def test_the_printed_value_at_zero_curvature_needs_another_reading():
    """Eq. 3.23 gives .196 at 20 and .156 at 10 gf; .3 comes from any of three other readings."""
    assert goodwin.peak_at_force(0.0, 20) == pytest.approx(0.196, abs=5e-4)
    assert goodwin.peak_at_force(0.0, 10) == pytest.approx(0.156, abs=5e-4)
    assert goodwin.peak_at_depth(0.0) == pytest.approx(0.295, abs=5e-4)
    for other in (
        goodwin.peak_at_depth(0.0),
        goodwin.peak_at_force(0.0, 20, finger=7.4),
        goodwin.peak_at_force(0.0, 20, reference=(0.34, 20.0)),
    ):
        assert other == pytest.approx(0.3, abs=0.006)  # as printed in section 3.6


def test_contact_radius_under_spheres_is_that_of_the_reference():
    wanted = (1, 0.768, 0.654, 0.547, 0.444)
    assert goodwin.contact_radius(SPHERES) == pytest.approx(wanted, abs=6e-4)


def test_the_ratios_are_those_of_hertz_contacts_at_fixed_force_and_fixed_depth():
    def contacts(force):
        radii = [relative_radius(15.0, 1 / c if c else math.inf) for c in (*SPHERES.tolist(), 0.7)]
        depths = [(9 * force**2 / (16 * r * 160.0**2)) ** (1 / 3) for r in radii]
        return [Hertz(r, d, modulus=120.0, poisson=0.5) for r, d in zip(radii, depths, strict=True)]

    limit = contacts(200.0)[-1]
    for i, forced in enumerate(contacts(150.0)[:-1]):
        ratio = forced.peak_pressure / limit.peak_pressure
        assert goodwin.peak_at_force(SPHERES[i], 15, reference=(0.7, 20.0)) == pytest.approx(ratio)
        wide = forced.contact_radius / contacts(150.0)[0].contact_radius
        assert goodwin.contact_radius(SPHERES[i]) == pytest.approx(wide)
        moved, edge = replace(forced, depth=0.1), replace(limit, depth=0.1)
        assert goodwin.peak_at_depth(SPHERES[i]) == pytest.approx(
            moved.peak_pressure / edge.peak_pressure
        )


def test_torque_is_the_integral_of_the_friction_over_the_contact():
    hertz = Hertz(14.0, 0.8, 100.0, 0.5)
    a = hertz.contact_radius
    torque, _ = quad(lambda r: 0.4 * hertz.pressure(r) * r * 2 * np.pi * r, 0, a)
    assert goodwin.torsional_friction(0.4, hertz.force, a) == pytest.approx(torque, rel=1e-6)
    twice = goodwin.torsional_friction(0.4, hertz.force, 2 * a)
    assert twice == pytest.approx(2 * torque, rel=1e-6)
