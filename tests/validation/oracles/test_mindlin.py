"""Mindlin's contact against its limits, and squares against quadrature and point forces."""

import numpy as np
import pytest
from fefinger.validation.oracles import squares
from fefinger.validation.oracles.coulomb import projected
from fefinger.validation.oracles.mindlin import Mindlin, cerruti
from scipy.integrate import quad


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
