"""Bodies and measures of the suites against closed forms: grids, patterns, preloads, waves."""

import numpy as np
import pytest
from fefinger.validation.afferents.patterns import Pad, solved
from fefinger.validation.human.preload import shear_speed
from fefinger.validation.oracles.layer import paraboloid_at
from fefinger.validation.problems.grids import quarter
from fefinger.validation.waves import bodies, drawings, finger
from scipy import special

from fefinger.contact.grid_solver import GridSolver
from fefinger.contact.stepper import Target
from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.hyperelastic.material import material_of
from fefinger.scene.cautions import DENSITY
from fefinger.support.checks import ConvergenceError
from fefinger.theory.contact import indentation
from fefinger.theory.contact.stack import Layer, Stack
from fefinger.view.figures import style


LINES = np.array([0.0, 0.7, 1.5])
SECTORS = 3


@pytest.fixture(scope="module")
def space():
    def size(r, z):
        return 0.2 + 0.5 * np.hypot(r - 1, z)

    return quarter(LINES, LINES, size, SECTORS, interfaces=(0.7,))


def volumes(space):
    corners = space.points[space.cells]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6


def test_the_cells_fill_the_polygon_once(space):
    sides = 4 * SECTORS
    area = sides / 2 * np.sin(2 * np.pi / sides) * LINES[-1] ** 2
    assert np.abs(volumes(space)).sum() == pytest.approx(area * LINES[-1] / 4)
    assert np.abs(volumes(space)).min() > 1e-6


def test_faces_fit_and_the_outer_ones_lie_on_flat_sides(space):
    faces = space.cells[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3)
    found, count = np.unique(np.sort(faces, axis=1), axis=0, return_counts=True)
    assert count.max() == 2
    corners = space.points[found[count == 1]]
    flat = [(corners[:, :, axis] == 0).all(axis=1) for axis in range(3)]
    bottom = (corners[:, :, 2] == LINES[-1]).all(axis=1)
    side = np.isclose(np.hypot(*corners.T[:2]).T, LINES[-1]).all(axis=1)
    assert np.any([*flat, bottom, side], axis=0).all()


def test_the_mesh_is_as_fine_as_asked_and_coarser_elsewhere(space):
    r, z = np.hypot(*space.points.T[:2]), space.points[:, 2]
    near = np.hypot(r - 1, z) < 0.3
    assert near.mean() > 0.2
    assert len(space.points) < 500


def test_tissues_change_at_the_interface(space):
    depth = space.points[space.cells][:, :, 2]
    assert (depth[space.tissue == 1] <= 0.7).all()
    assert (depth[space.tissue == 2] >= 0.7).all()
    assert set(space.tissue) == {1, 2}


LAYERS = Stack((Layer(1.0, 100.0, 0.48), Layer(3.0, 34.0, 0.48)))
PAD = Pad(LAYERS, radius=8.0, points=192, spacing=0.16)


def plate(at):
    """Return the heights of a plate."""
    return np.zeros(at.shape[:-1])


@pytest.fixture(scope="module")
def pressed():
    """Return the pressure under a plate 0.4 mm deep, and the exact contact."""
    return PAD.pressure(plate, 0.4), paraboloid_at(LAYERS, 8.0, depth=0.4)


def test_the_force_of_a_plate_is_that_of_the_exact_contact(pressed):
    pressure, exact = pressed
    assert pressure.sum() * PAD.spacing**2 == pytest.approx(exact.force, rel=0.005)
    assert pressure.min() >= 0.0
    assert pressure.max() == pytest.approx(float(exact.pressure([0.0])[0]), rel=0.005)


def test_the_strain_below_a_plate_is_that_of_hankel_transforms(pressed):
    pressure, exact = pressed
    r = np.array([0.0, 0.8, 1.6])
    places = np.column_stack([np.zeros(3), r])
    strain = PAD.strain(pressure, 0.6, places)
    field = indentation.subsurface_field(LAYERS, [exact], r, z=np.full(3, 0.6))
    radial, hoop, axial, shear = field.strain[0]
    scale = np.abs(axial).max()
    parts = (strain[:, 1, 1], strain[:, 0, 0], strain[:, 2, 2], strain[:, 1, 2])
    for part, expected in zip(parts, (radial, hoop, axial, shear), strict=True):
        assert part == pytest.approx(expected, abs=0.02 * scale)


def test_the_gap_closes_in_contact_and_nothing_pulls(pressed):
    pressure, _ = pressed
    displacement = GridSolver(PAD.grid.compliance, pressure.shape).displacement(pressure.ravel())
    rest = displacement.reshape(pressure.shape) + PAD.gap(plate) - 0.4
    assert np.abs(rest[pressure > 0]).max() < 1e-6
    assert rest[pressure == 0].min() > -1e-6


def test_a_force_that_is_given_ends_in_the_pressure_of_its_depth(pressed):
    pressure, _ = pressed
    force = pressure.sum() * PAD.spacing**2
    contact = PAD.contact(lambda shift: PAD.gap(plate))
    solved(contact, Target(force, by_force=True))
    assert contact.force == pytest.approx(force, rel=1e-12)
    assert contact.pressure == pytest.approx(pressure.ravel(), abs=1e-3 * pressure.max())


def test_what_does_not_converge_says_so(monkeypatch):
    monkeypatch.setattr("fefinger.contact.grid_solver.ITERATIONS", 2)
    with pytest.raises(ConvergenceError):
        PAD.pressure(plate, 0.4)


X, Y = np.eye(3)[:2]


def stretched(stretch):
    return np.diag([stretch, stretch**-0.5, stretch**-0.5]) - np.eye(3)


@pytest.mark.parametrize("stretch", [0.6, 1.0, 1.4])
def test_a_stretched_neo_hookean_body_has_the_closed_form(stretch):
    material = material_of(Elastic(30.0, 0.48))
    speed = shear_speed(material, stretched(stretch), X, Y, 1.0)
    assert speed == pytest.approx(np.sqrt(material.shear * stretch**2 / DENSITY) / 1e3, rel=1e-9)


@pytest.mark.parametrize("stretch", [0.7, 1.3])
def test_a_stretched_exponential_body_has_the_closed_form(stretch):
    material = material_of(Elastic(30.0, 0.48), "demiray", exponent=2.0)
    rise = np.exp(2.0 * (stretch**2 + 2 / stretch - 3))
    exact = np.sqrt(material.shear * rise * stretch**2 / DENSITY) / 1e3
    assert shear_speed(material, stretched(stretch), X, Y, 1.0) == pytest.approx(exact, rel=1e-9)


def test_relaxation_raises_the_moduli_and_not_the_stress_of_the_preload():
    material = material_of(Elastic(30.0, 0.48))
    slow, fast = (shear_speed(material, stretched(1.0), X, Y, g) for g in (1.0, 4.0))
    assert fast == pytest.approx(2 * slow, rel=1e-12)
    slow, fast = (shear_speed(material, stretched(1.4), X, Y, g) for g in (1.0, 4.0))
    assert slow < fast < 2 * slow


def test_the_roots_of_a_ball_are_those_of_its_equations():
    x = bodies.torsional_root()
    assert special.spherical_jn(2, x) == pytest.approx(x * special.spherical_jn(3, x))
    assert x == pytest.approx(2.501, abs=1e-3)
    # Between those of nu = 1/3, 2.65 (Love), and higher ones of stiffer balls.
    assert 2.64 < bodies.spheroidal_root() < 2.69


def test_lambs_integral_is_that_of_statics_at_rest():
    nu, modulus = bodies.PULP.poisson, bodies.PULP.modulus
    static = 16 * (1 - nu**2) * bodies.DISC / (3 * np.pi * modulus)
    assert bodies.half_space_exact(1e-2).real == pytest.approx(static, rel=1e-4)


def test_a_wave_in_the_half_space_takes_energy_away():
    assert all(bodies.half_space_exact(f).imag < 0 for f in (1.0, 100.0, 1000.0))


@pytest.mark.usefixtures("operators")
def test_the_lowest_modes_are_drawn(monkeypatch):
    """Only the whole suite draws them otherwise."""
    monkeypatch.setattr(finger, "MESH", "coarse")
    finger.finger.cache_clear()
    with style():
        drawn = drawings._shapes()
    finger.finger.cache_clear()
    assert len(drawn.axes) == 2 * (drawings.SHAPES // 2)
    assert all(axis.get_title("left").endswith(" Hz") for axis in drawn.axes)
