"""The rigid sphere against printed ratios, its Hertz limit, quadrature and its own shape."""

import math

import numpy as np
import pytest
from fefinger.validation.oracles.sphere import Sphere

from fefinger.theory.contact.hertz import Hertz


SIZES = pytest.mark.parametrize("ratio", [0.02, 0.3, 0.6, 0.9])


def press(ratio):
    return Sphere(radius=5.0, contact_radius=5.0 * ratio, modulus=34.0, poisson=0.45)


@pytest.mark.parametrize(
    ("ratio", "force", "contact"),
    [
        (0.1, 0.9990, 0.998),
        (0.2, 0.9959, 0.993),
        (0.3, 0.9907, 0.985),
        (0.4, 0.9830, 0.972),
        (0.5, 0.9725, 0.954),
    ],
)
def test_printed_departure_from_hertz(ratio, force, contact):
    """Recomputed; tolerance: half a digit of the last printed place."""
    s = press(ratio)
    h = Hertz(5.0, s.depth, modulus=34.0, poisson=0.45)
    assert s.force / h.force == pytest.approx(force, abs=6e-5)
    assert s.contact_radius / h.contact_radius == pytest.approx(contact, abs=6e-4)


def test_a_small_contact_is_hertz_with_an_error_of_second_order():
    def errors(ratio):
        s = press(ratio)
        h = Hertz(5.0, s.depth, modulus=34.0, poisson=0.45)
        peak = float(s.pressure(0.0)) / h.peak_pressure
        return np.array([s.force / h.force, s.contact_radius / h.contact_radius, peak]) - 1

    coarse, fine = errors(0.02), errors(0.01)
    np.testing.assert_allclose(coarse / fine, 4, rtol=1e-3)
    assert np.abs(fine).max() < 1e-4


@SIZES
def test_depth_is_inverted(ratio):
    s = press(ratio)
    back = Sphere.at_depth(5.0, s.depth, modulus=34.0, poisson=0.45)
    assert back.contact_radius == pytest.approx(s.contact_radius, rel=1e-12)


@SIZES
def test_force_is_the_integral_of_pressure_and_the_derivative_of_energy(ratio):
    s = press(ratio)
    nodes, weights = np.polynomial.legendre.leggauss(80)
    turn = np.pi / 4 * (nodes + 1)
    r = s.contact_radius * np.sin(turn)
    ring = 2 * np.pi * r * s.contact_radius * np.cos(turn) * np.pi / 4 * weights
    assert s.pressure(r) @ ring == pytest.approx(s.force, rel=1e-7)
    # At a fixed contact circle the body is a flat punch: dP = 2 E* a d(depth).
    step = 1e-5 * ratio
    more, less = press(ratio - step), press(ratio - 2 * step)
    middle = press(ratio - 1.5 * step).contact_radius
    stiff = 34.0 / (1 - 0.45**2)
    assert more.force - less.force == pytest.approx(
        2 * stiff * middle * (more.depth - less.depth), rel=1e-6
    )


def test_the_pressure_displaces_the_surface_onto_the_sphere():
    """Second method: the complete elliptic kernel of a ring load, integrated."""
    from scipy.integrate import quad
    from scipy.special import ellipk

    s = press(0.6)
    a, stiff = s.contact_radius, 34.0 / (1 - 0.45**2)

    def drawn(r):
        def ring(q):
            k = 4 * r * q / (r + q) ** 2
            return 4 * q * float(s.pressure(q)) * ellipk(k) / (r + q)

        cuts = [r] if r < a else None
        return quad(ring, 0, a, points=cuts, epsrel=1e-8, limit=200)[0] / (math.pi * stiff)

    for r in (0.3, 1.5, 2.6, 3.5, 8.0):
        assert drawn(r) == pytest.approx(float(s.displacement(r)), rel=1e-5)


def test_pressure_and_surface_at_the_axis_and_the_edge():
    s = press(0.5)
    assert float(s.pressure(s.contact_radius)) == 0
    assert float(s.pressure(4.0)) == 0
    assert float(s.displacement(0.0)) == pytest.approx(s.depth)
    a = s.contact_radius
    assert float(s.displacement(a * (1 + 1e-9))) == pytest.approx(float(s.displacement(a)))


def test_a_sphere_deeper_than_linear_theory_reaches_is_refused():
    with pytest.raises(ValueError, match=r"at most 1\.32 R"):
        Sphere.at_depth(5.0, 7.0, modulus=34.0, poisson=0.45)
