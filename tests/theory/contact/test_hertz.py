"""Hertz and Huber against printed values, differentiation, quadrature and their own limits."""

import math

import numpy as np
import pytest
from oracles.differences import divergence, gradient
from scipy.optimize import minimize_scalar

from fefinger.theory.contact.hertz import Hertz


POISSON = pytest.mark.parametrize("poisson", [0.0, 0.3, 0.45, 0.5])


def unit(poisson, radius=1e3):
    """Return a contact with a = 1 mm, p0 = 1 kPa and E = 1 kPa in the units of the tables."""
    contact = Hertz(radius, 1 / radius, modulus=1.0, poisson=poisson)
    return contact, contact.peak_pressure


def test_the_closed_forms_agree_with_each_other():
    h = Hertz(radius=10.0, depth=0.4, modulus=34.0, poisson=0.5)
    assert h.plane_modulus == pytest.approx(4 * 34.0 / 3)
    assert h.contact_radius == pytest.approx((0.75 * h.force * 10.0 / h.plane_modulus) ** (1 / 3))
    assert h.peak_pressure == pytest.approx(1.5 * h.force / (math.pi * h.contact_radius**2))


def test_pressure_integrates_to_the_force_and_vanishes_outside():
    h = Hertz(radius=10.0, depth=0.4, modulus=34.0, poisson=0.45)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    # r = a sin(s) takes the root singularity of the edge away.
    s = np.pi / 4 * (nodes + 1)
    r = h.contact_radius * np.sin(s)
    ring = 2 * np.pi * r * h.contact_radius * np.cos(s) * np.pi / 4 * weights
    assert h.pressure(r) @ ring == pytest.approx(h.force, rel=1e-12)
    assert not h.pressure([2.0, 2.01, 50.0]).any()


@pytest.mark.parametrize(
    ("poisson", "shear", "at_shear", "axial", "at_axial"),
    [
        (0.3, 0.3100, 0.481, 0.715, 0.349),
        (0.45, 0.2768, 0.531, 0.577, 0.497),
        (0.49, 0.2684, 0.5445, None, None),
        (0.5, 0.2663, 0.548, 0.533, 0.548),
    ],
)
def test_printed_maxima_on_the_axis(poisson, shear, at_shear, axial, at_axial):
    """Recomputed; tolerance: half a digit of the last printed place."""
    h, p0 = unit(poisson)

    def largest(value):
        optimum = minimize_scalar(lambda z: -value(z), bounds=(0.1, 1.0), options={"xatol": 1e-7})
        return -optimum.fun / p0, optimum.x

    def half_difference(z):
        stress = h.stress(0.0, z)
        return (stress[0] - stress[2]) / 2

    top, place = largest(half_difference)
    assert (top, place) == (pytest.approx(shear, abs=6e-5), pytest.approx(at_shear, abs=6e-4))
    if axial is not None:
        top, place = largest(lambda z: -h.strain(0.0, z)[2])
        assert (top, place) == (pytest.approx(axial, abs=6e-4), pytest.approx(at_axial, abs=6e-4))


AXIS = {
    **{0.1: (-0.7843, -0.9901, -0.2058, 0.0212), 0.2: (-0.6072, -0.9615, -0.3543, 0.0628)},
    **{0.3: (-0.4656, -0.9174, -0.4518, 0.1021), 0.5: (-0.2696, -0.8000, -0.5304, 0.1406)},
    **{0.8: (-0.1199, -0.6098, -0.4899, 0.1200), 1.0: (-0.0719, -0.5, -0.4281, 0.0916)},
    2.0: (-0.0091, -0.2, -0.1909, 0.0182),
}


@pytest.mark.parametrize(("z", "printed"), AXIS.items())
def test_printed_values_on_the_axis_of_an_incompressible_body(z, printed):
    h, p0 = unit(0.5)
    stress = h.stress(0.0, z)
    energy = stress @ (h.strain(0.0, z) * [1, 1, 1, 2]) / 2 / p0**2
    actual = (stress[0] / p0, stress[2] / p0, h.strain(0.0, z)[2] / p0, energy)
    assert actual == pytest.approx(printed, abs=6e-5)
    assert stress[1] == pytest.approx(stress[0], rel=1e-12)
    assert stress[3] == 0


OFF_AXIS = {
    (0.5, 0.5): (-0.24431, -0.20804, -0.65085, -0.15365, 0.87559, 0.11977),
    (1.0, 0.25): (-0.27631, -0.11596, -0.20576, -0.18164, 0.59855, 0.12507),
    (1.0, 0.5): (-0.21910, -0.07484, -0.23664, -0.18476, 0.58523, 0.15303),
    (1.5, 0.5): (-0.12836, -0.01429, -0.03267, -0.06105, 0.36886, 0.09934),
    (2.0, 1.0): (-0.07113, -0.00399, -0.02565, -0.04150, 0.27560, 0.08880),
}


@pytest.mark.parametrize(("place", "printed"), OFF_AXIS.items())
def test_printed_values_off_the_axis(place, printed):
    h, p0 = unit(0.5)
    outward, inward = h.displacement(*place)
    actual = np.array([*h.stress(*place), inward, outward]) / p0
    assert actual == pytest.approx(printed, abs=6e-6)


@POISSON
def test_surface_limits(poisson):
    h, p0 = unit(poisson)
    assert h.stress(0.0, 0.0) / p0 == pytest.approx(
        [-(1 + 2 * poisson) / 2, -(1 + 2 * poisson) / 2, -1, 0], abs=1e-12
    )
    edge = (1 - 2 * poisson) / 3
    assert h.stress(1.0, 0.0) / p0 == pytest.approx([edge, -edge, 0, 0], abs=1e-6)
    r = np.array([0.0, 0.2, 0.7, 0.99, 1.01, 1.4, 6.0])
    np.testing.assert_allclose(-h.stress(r, 0.0)[2], h.pressure(r), atol=1e-12 * p0)
    np.testing.assert_allclose(h.stress(r, 1e-9), h.stress(r, 0.0), atol=1e-7 * p0)
    outward, inward = h.displacement(r, 0.0)
    inside = r < 1
    flat = h.depth - r**2 / (2 * h.radius)
    np.testing.assert_allclose(inward[inside], flat[inside], rtol=1e-12)
    far = r[~inside]
    free = (2 - far**2) * np.arcsin(1 / far) + far * np.sqrt(1 - far**-2)
    np.testing.assert_allclose(inward[~inside], p0 / 2 * (1 - poisson**2) * free, rtol=1e-9)
    drawn = -(1 - 2 * poisson) * (1 + poisson) / 3 * p0 / np.maximum(r, 1e-9)
    drawn *= 1 - np.maximum(1 - r**2, 0) ** 1.5
    np.testing.assert_allclose(outward, drawn, atol=1e-12 * p0)


def test_an_incompressible_surface_is_not_sheared():
    """A receptor just under a flat contact sees pressure only."""
    h, p0 = unit(0.5)
    np.testing.assert_allclose(h.strain(np.linspace(0, 0.95, 20), 0.0), 0, atol=1e-12 * p0)


def random_points(seed):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.02, 3.0, 300), rng.uniform(0.02, 3.0, 300)


@POISSON
def test_the_field_is_in_equilibrium(poisson):
    h, p0 = unit(poisson)
    np.testing.assert_allclose(divergence(h.stress, *random_points(1)), 0, atol=2e-6 * p0)


@POISSON
def test_strain_is_the_gradient_of_displacement(poisson):
    h, p0 = unit(poisson)
    r, z = random_points(2)
    np.testing.assert_allclose(h.strain(r, z), gradient(h.displacement, r, z), atol=1e-6 * p0)


@POISSON
def test_the_axis_is_the_limit_of_its_neighborhood(poisson):
    h, p0 = unit(poisson)
    z = np.array([0.05, 0.5, 2.0])
    np.testing.assert_allclose(h.stress(1e-7, z), h.stress(0.0, z), atol=2e-6 * p0)
    axis = 0.5 / (1 + z**2) - (1 + poisson) * (1 - z * np.arctan(1 / z))
    np.testing.assert_allclose(h.stress(0.0, z)[0], p0 * axis, rtol=1e-12)
    np.testing.assert_allclose(h.stress(0.0, z)[2], -p0 / (1 + z**2), rtol=1e-12)


@pytest.mark.parametrize("place", [(0.0, 0.3), (0.6, 0.4), (1.7, 0.5), (1.0, 2.0)])
def test_axial_stress_and_displacement_are_boussinesq_integrals(place):
    h, p0 = unit(0.3)
    r, z = place
    nodes, weights = np.polynomial.legendre.leggauss(60)
    s = np.pi / 4 * (nodes + 1)
    source = np.sin(s)[:, None]
    turn = np.linspace(0, 2 * np.pi, 256, endpoint=False)
    distance = np.sqrt(r**2 + source**2 - 2 * r * source * np.cos(turn) + z**2)
    cell = p0 * np.cos(s) * np.sin(s) * np.cos(s) * np.pi / 4 * weights * 2 * np.pi / 256
    axial = -3 * z**3 / (2 * np.pi) * np.sum(cell[:, None] / distance**5)
    assert h.stress(r, z)[2] == pytest.approx(axial, rel=1e-10)
    shear = 1 / (2 * 1.3)
    kernel = z**2 / distance**3 + 1.4 / distance
    inward = np.sum(cell[:, None] * kernel) / (4 * np.pi * shear)
    assert h.displacement(r, z)[1] == pytest.approx(inward, rel=1e-10)


def test_the_far_field_is_that_of_a_point_force():
    h, _ = unit(0.45)
    r, z = 120.0, 160.0
    point = -3 * h.force * z**3 / (2 * np.pi * 200.0**5)
    assert h.stress(r, z)[2] == pytest.approx(point, rel=1e-4)
    drawn = h.force * (1.45 / (2 * np.pi)) * (z**2 / 200.0**3 + 1.1 / 200.0)
    assert h.displacement(r, z)[1] == pytest.approx(drawn, rel=1e-4)


def test_first_touch_presses_and_strains_nothing():
    touch = Hertz(10.0, 0.0, modulus=34.0, poisson=0.45)
    r, z = np.array([0.0, 1.0, 0.5]), np.array([0.0, 0.0, 2.0])
    assert touch.force == touch.contact_radius == touch.peak_pressure == 0
    assert not touch.pressure(r).any()
    assert not touch.stress(r, z).any()
    assert not touch.displacement(r, z).any()


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"radius": 0.0}, "radius above 0"),
        ({"depth": float("nan")}, "depth of 0 or above"),
        ({"depth": -0.1}, "depth of 0 or above"),
        ({"depth": 11.0}, "at most the radius 10 mm"),
        ({"modulus": -1.0}, "modulus above 0"),
        ({"poisson": 0.51}, "0 to 0.5"),
    ],
)
def test_what_is_out_of_range_is_refused(change, sentence):
    values = {"radius": 10.0, "depth": 0.4, "modulus": 34.0, "poisson": 0.5}
    with pytest.raises(ValueError, match=sentence):
        Hertz(**(values | change))


@pytest.mark.parametrize("place", [(-0.1, 1.0), (1.0, -0.1), (float("nan"), 1.0)])
@pytest.mark.parametrize("field", ["stress", "strain", "displacement"])
def test_points_outside_the_body_are_refused(field, place):
    with pytest.raises(ValueError, match="z points into the body"):
        getattr(unit(0.3)[0], field)(*place)
