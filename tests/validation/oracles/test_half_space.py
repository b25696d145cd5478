"""Closed forms on a half-space: cone, punch, sphere, Mindlin; loaded squares; Coulomb's law."""

import math

import numpy as np
import pytest
from fefinger.validation.oracles import squares
from fefinger.validation.oracles.coulomb import projected
from fefinger.validation.oracles.mindlin import Mindlin, cerruti
from fefinger.validation.oracles.punch import Cone, FlatPunch
from fefinger.validation.oracles.sphere import Sphere
from scipy.integrate import quad
from scipy.special import ellipk

from fefinger.theory.contact.hertz import Hertz


PLANE = 34.0 / (1 - 0.45**2)


def press(ratio):
    """Return a rigid sphere whose contact radius is a part of its radius."""
    return Sphere(radius=5.0, contact_radius=5.0 * ratio, modulus=34.0, poisson=0.45)


CONTACTS = {
    "cone": Cone(half_angle=70.0, depth=0.5, modulus=34.0, poisson=0.45),
    "punch": FlatPunch(contact_radius=1.5, depth=0.3, modulus=34.0, poisson=0.45),
    **{f"sphere, {ratio}": press(ratio) for ratio in (0.02, 0.3, 0.6, 0.9)},
}
CONTACT = pytest.mark.parametrize("contact", CONTACTS.values(), ids=CONTACTS)
CONE, PUNCH = CONTACTS["cone"], CONTACTS["punch"]


@CONTACT
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


@CONTACT
def test_the_pressure_displaces_the_surface_onto_the_indenter(contact):
    """The complete elliptic kernel of a ring load, integrated."""
    a = contact.contact_radius

    def drawn(r):
        def ring(s):
            q = a * math.sin(s)
            kernel = ellipk(4 * r * q / (r + q) ** 2) / (r + q)
            return 4 * q * a * math.cos(s) * float(contact.pressure(q)) * kernel

        cuts = [math.asin(r / a)] if r < a else None
        return quad(ring, 1e-9, math.pi / 2 - 1e-9, points=cuts, limit=200)[0] / (math.pi * PLANE)

    for r in (0.2 * a, 0.7 * a, 1.3 * a, 3.0 * a):
        assert drawn(r) == pytest.approx(float(contact.displacement(r)), rel=2e-6)


def test_the_cone_has_its_slope_and_a_punch_for_tangent():
    r = np.linspace(0.1, 0.9, 5) * CONE.contact_radius
    slope = np.diff(CONE.displacement(r)) / np.diff(r)
    np.testing.assert_allclose(slope, -1 / math.tan(math.radians(70.0)), rtol=1e-12)
    step = 1e-6
    more, less = (Cone(70.0, 0.5 + s, modulus=34.0, poisson=0.45).force for s in (step, -step))
    assert (more - less) / (2 * step) == pytest.approx(2 * PLANE * CONE.contact_radius, rel=1e-8)


def test_the_tip_and_the_edge_are_infinite_and_the_punch_is_flat():
    assert np.isinf(CONE.pressure(0.0))
    assert np.isinf(PUNCH.pressure(1.5))
    np.testing.assert_allclose(PUNCH.displacement([0.0, 0.7, 1.5]), 0.3)


@pytest.mark.parametrize("ratio", [0.02, 0.3, 0.6, 0.9])
def test_a_deeper_sphere_is_a_flat_punch_for_tangent_and_its_depth_is_inverted(ratio):
    step = 1e-5 * ratio
    more, less = press(ratio - step), press(ratio - 2 * step)
    work = 2 * PLANE * press(ratio - 1.5 * step).contact_radius * (more.depth - less.depth)
    assert more.force - less.force == pytest.approx(work, rel=1e-6)
    back = Sphere.at_depth(5.0, press(ratio).depth, modulus=34.0, poisson=0.45)
    assert back.contact_radius == pytest.approx(5.0 * ratio, rel=1e-12)


def test_a_small_sphere_is_hertz_with_an_error_of_second_order():
    def errors(ratio):
        s = press(ratio)
        h = Hertz(5.0, s.depth, modulus=34.0, poisson=0.45)
        peak = float(s.pressure(0.0)) / h.peak_pressure
        return np.array([s.force / h.force, s.contact_radius / h.contact_radius, peak]) - 1

    coarse, fine = errors(0.02), errors(0.01)
    np.testing.assert_allclose(coarse / fine, 4, rtol=1e-3)
    assert np.abs(fine).max() < 1e-4


def test_a_sphere_deeper_than_linear_theory_reaches_is_refused():
    with pytest.raises(ValueError, match=r"at most 1\.32 R"):
        Sphere.at_depth(5.0, 7.0, modulus=34.0, poisson=0.45)


SPHERE = Mindlin(1.2, 900.0, 35.0, 0.4, 0.3)


def test_force_and_displacement_are_inverse_and_begin_with_the_stiffness():
    force = np.linspace(0, SPHERE.most, 50)
    assert SPHERE.force_at(SPHERE.displacement(force)) == pytest.approx(force)
    small = 1e-7 * SPHERE.most
    assert small / SPHERE.displacement(small) == pytest.approx(SPHERE.stiffness, rel=1e-6)
    assert SPHERE.force_at(10.0) == SPHERE.most


@pytest.mark.parametrize("part", [0.2, 0.6, 0.95])
def test_the_traction_adds_up_to_the_force_and_ends_stick_at_mu_p(part):
    force = part * SPHERE.most
    total = quad(lambda r: 2 * np.pi * r * float(SPHERE.traction(r, force)), 0, 1.2, limit=200)[0]
    assert total == pytest.approx(force, rel=1e-4)
    pressure = 1.5 * SPHERE.force / (np.pi * 1.2**3) * np.sqrt(1.2**2 - 1.19**2)
    assert SPHERE.traction(1.19, force) == pytest.approx(0.3 * pressure)
    assert SPHERE.stick_radius(force) == pytest.approx(1.2 * (1 - part) ** (1 / 3))


def test_the_loop_is_that_of_mindlin_and_deresiewicz():
    peak, most = 0.7 * SPHERE.most, SPHERE.most
    part = peak / most
    # Mindlin and Deresiewicz (1953) for one elastic body: 9 (mu P)² (2 - nu) / (10 G a).
    bracket = 1 - (1 - part) ** (5 / 3) - 5 / 6 * part * (1 + (1 - part) ** (2 / 3))
    closed = 9 * most**2 / (10 * 1.2) * (2 - 0.4) / 35.0 * bracket
    assert SPHERE.loop(peak) == pytest.approx(closed, rel=1e-6)
    assert SPHERE.back(-peak, peak) == pytest.approx(-SPHERE.displacement(peak))


@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_far_squares_are_point_forces(poisson):
    places = np.array([[0.0, 0.0], [30.0, -20.0]])
    matrix = squares.flexibility(places, 1.0, shear=10.0, poisson=poisson).reshape(3, 2, 3, 2)
    x, y = places[1]
    along = cerruti(x, y, 0.0, shear=10.0, poisson=poisson)
    assert matrix[1, 1, 1, 0] == pytest.approx(along[0], rel=1e-3)
    assert matrix[2, 1, 1, 0] == pytest.approx(along[1], rel=1e-3)
    assert matrix[0, 1, 1, 0] == pytest.approx(along[2], rel=1e-3, abs=1e-12)
    normal = (1 - poisson) / (2 * np.pi * 10.0 * np.hypot(x, y))
    assert matrix[0, 1, 0, 0] == pytest.approx(normal, rel=1e-3)
    flat = matrix.reshape(6, 6)
    assert flat == pytest.approx(flat.T, abs=1e-15)
    assert np.linalg.eigvalsh(flat)[0] > 0


@pytest.mark.parametrize(
    ("kernel", "integrand"),
    [
        (squares._inverse, lambda x, y, r: 1 / r),
        (squares._xx, lambda x, y, r: x**2 / r**3),
        (squares._xy, lambda x, y, r: x * y / r**3),
        (squares._odd, lambda x, y, r: x / r**2),
    ],
    ids=("1/r", "xx", "xy", "x"),
)
def test_integrals_over_a_square_are_those_of_quadrature(kernel, integrand):
    nodes, weights = np.polynomial.legendre.leggauss(40)
    x, y = np.meshgrid(0.7 + 0.25 * nodes, -1.1 + 0.25 * nodes, indexing="ij")
    total = 0.25**2 * np.sum(np.outer(weights, weights) * integrand(x, y, np.hypot(x, y)))
    assert squares._square(kernel, np.array(0.7), np.array(-1.1), 0.25) == pytest.approx(total)


def test_projected_gradients_satisfy_the_law_on_one_vertex():
    matrix, mu = np.diag([2.0, 1.0, 1.0]), 0.4
    stuck = projected(matrix, np.array([-2.0, -0.3, 0.0]), mu)
    assert stuck == pytest.approx([1.0, 0.3, 0.0])
    slid = projected(matrix, np.array([-2.0, -3.0, 4.0]), mu)
    assert slid == pytest.approx([1.0, 0.24, -0.32])
    assert projected(matrix, np.array([1.0, 1.0, 1.0]), mu) == pytest.approx([0, 0, 0])
