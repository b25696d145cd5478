"""Exact layers on a periodic grid against the axisymmetric solutions, by Hankel transform."""

import numpy as np
import pytest
from fefinger.validation.oracles.mindlin import cerruti

import fefinger as ff
from fefinger.contact.active_set import DONE
from fefinger.contact.grid_coulomb import GridCoulomb
from fefinger.contact.gridded import GridContact
from fefinger.contact.stepper import Target
from fefinger.mechanics import layered
from fefinger.mechanics.press.layer_grid import LayerGrid, StrainProbe
from fefinger.theory.contact.contact_table import tabulate_to
from fefinger.theory.contact.indentation import paraboloid, subsurface_field
from fefinger.theory.contact.stack import Layer, Stack


STACK = layered.stack(ff.Finger.subject("a.h.", tissue="maeno1998"))
ELASTIC = np.zeros(0), np.zeros(0)
RADIUS, WIDE = 10.0, 2.0  # mm, of a paraboloid and its contact


@pytest.fixture(scope="module")
def ball():
    """Press a paraboloid on the layers: the grid, the contact and the exact one."""
    exact = paraboloid(STACK, RADIUS, contact_radius=WIDE)
    grid = LayerGrid(STACK, 120, 0.1, width=WIDE / 2)
    gap = np.sum(grid.places**2, axis=-1) / (2 * RADIUS)
    press = GridContact(grid.compliance, (120, 120), 0.1, lambda shift: gap, ELASTIC)
    assert press.advance(0.0, Target(exact.depth)) == DONE
    return grid, press, exact


def test_a_paraboloid_has_the_force_and_pressure_of_the_exact_layers(ball):
    grid, press, exact = ball
    assert press.force == pytest.approx(exact.force, rel=2e-3)
    r = np.hypot(*np.moveaxis(grid.places, -1, 0))
    apart = np.abs(press.pressure.reshape(r.shape) - exact.pressure(r))
    assert apart.mean() < 2e-3 * exact.pressure(0.0)


def test_without_the_mean_of_the_images_the_force_is_wrong(ball):
    """And what they leave is below what `images` states."""
    grid, press, exact = ball
    shape = (grid.points, grid.points)
    left = grid.images(press.pressure.reshape(shape), press.solver.moved.reshape(shape))
    assert 1e-5 * exact.depth < left < 5e-3 * exact.depth
    plain = press.solver.moved - press.pressure.mean() * grid.compliance[0, 0]
    off = np.abs(plain - press.solver.moved)
    assert off.max() > 5 * left


def test_the_strain_below_is_that_of_the_hankel_integrals(ball):
    grid, press, exact = ball
    r, z = np.array([0.0, 0.63, 1.27, 2.6, 0.35, 1.9]), np.array([0.7, 0.7, 0.7, 0.7, 2.1, 2.1])
    turn = np.array([0.3, 1.1, 2.0, 4.0, 5.0, 0.0])
    places = r[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    got = StrainProbe(grid, places, z).strain(press.pressure)
    radial, around, down, slanted = subsurface_field(STACK, [exact], r, z=z).strain[0]
    c, s = np.cos(turn), np.sin(turn)
    out = np.stack([c, s, 0 * c], axis=-1)
    side, deep = np.stack([-s, c, 0 * c], axis=-1), np.array([0.0, 0.0, 1.0])

    def dyad(value, one, two):
        return value[:, None, None] * (one[..., :, None] * two[..., None, :])

    wanted = dyad(radial, out, out) + dyad(around, side, side)
    wanted = wanted + dyad(down, deep + 0 * out, deep + 0 * out)
    wanted = wanted + dyad(slanted, out, deep + 0 * out) + dyad(slanted, deep + 0 * out, out)
    assert got == pytest.approx(wanted, abs=5e-3 * np.abs(wanted).max())


def test_the_strain_of_a_wave_is_that_at_every_place():
    """A pressure of one wave, moved by parts of a grid point, strains what it is moved over."""
    grid = LayerGrid(STACK, 64, 0.1)
    k = 2 * np.pi / grid.period * 5
    x = np.linspace(-1.0, 1.0, 7)
    probe = StrainProbe(grid, np.column_stack([x, 0.37 + 0 * x]), np.full(7, 1.0))
    here = probe.strain(np.cos(k * grid.places[..., 0]))
    middle = StrainProbe(grid, np.zeros((1, 2)), np.ones(1))
    moved = np.array([middle.strain(np.cos(k * (grid.places[..., 0] + each)))[0] for each in x])
    assert here == pytest.approx(moved, abs=1e-3 * np.abs(moved).max())


def test_depths_below_a_plate_agree_with_the_table_of_contacts():
    """What `layered` answers with for round objects, at a depth that no contact of it has."""
    table = tabulate_to(STACK, RADIUS, depth=0.5)
    grid = LayerGrid(STACK, 120, 0.1)
    gap = np.sum(grid.places**2, axis=-1) / (2 * RADIUS)
    press = GridContact(grid.compliance, (120, 120), 0.1, lambda shift: gap, ELASTIC)
    press.advance(0.0, Target(0.333))
    assert press.force == pytest.approx(float(table.force(np.array([0.333]))[0]), rel=3e-3)


@pytest.mark.parametrize("axis", [0, 1])
def test_the_strain_below_tractions_is_that_of_cerruti(axis):
    """On a layer so thick that it is a half-space; no force and no moment, so no image counts."""
    poisson, shear = 0.3, 20.0
    thick = Stack((Layer(60.0, 2 * shear * (1 + poisson), poisson),))
    grid = LayerGrid(thick, 96, 0.125)
    x, y = np.moveaxis(grid.places, -1, 0)
    traction = np.zeros((3, 96, 96))
    for middle, part in ((-0.9, 1.0), (0.0, -2.0), (0.9, 1.0)):
        traction[1 + axis] += part * np.exp(-2 * ((x - middle) ** 2 + (y - 0.3) ** 2))
    at = np.array([[0.9, 0.4], [-0.3, 0.9], [1.8, -0.7]])
    got = StrainProbe(grid, at, np.full(3, 1.1), friction=True).strain(traction)

    def moved(place):
        apart = [place[k] - grid.places[..., k] for k in (0, 1)]
        u = cerruti(*apart[:: 1 - 2 * axis], place[2], shear=shear, poisson=poisson)
        u = u[[1, 0, 2]] if axis else u
        return np.sum(u * traction[1 + axis], axis=(1, 2)) * grid.spacing**2

    for place, strain in zip(at, got, strict=True):
        here, h = np.append(place, 1.1), 1e-3
        slope = np.array([(moved(here + e) - moved(here - e)) / (2 * h) for e in h * np.eye(3)]).T
        wanted = (slope + slope.T) / 2
        assert strain == pytest.approx(wanted, abs=0.01 * np.abs(wanted).max())


@pytest.mark.parametrize("axis", [0, 1])
def test_tractions_on_thick_layers_move_the_skin_as_those_of_cerruti(axis):
    """Along, across and down, beside the tractions; no force and no moment, so no image counts."""
    poisson, shear, n = 0.3, 20.0, 128
    thick = Stack((Layer(60.0, 2 * shear * (1 + poisson), poisson),))
    grid = LayerGrid(thick, n, 0.2)
    body = GridCoulomb(grid.flexibility, (n, n), 0.5)
    x, y = np.moveaxis(grid.places, -1, 0)
    traction = np.zeros((3, n, n))
    for middle, part in ((-0.8, 1.0), (0.0, -2.0), (0.8, 1.0)):
        traction[1 + axis] += part * np.exp(-6 * ((x - middle) ** 2 + y**2))
    moved = body.displacement(traction.ravel()).reshape(3, n, n)
    for at in ((64, 74), (73, 74), (78, 66), (52, 68)):
        apart = [grid.lines[at[0]] - x, grid.lines[at[1]] - y]
        apart[0] = np.where(np.hypot(*apart) == 0, 1.0, apart[0])  # exact: the point itself
        u = cerruti(*apart[:: 1 - 2 * axis], 0.0, shear=shear, poisson=poisson)
        u = u[[2, 1, 0]] if axis else u[[2, 0, 1]]
        wanted = np.sum(u * traction[1 + axis], axis=(1, 2)) * grid.spacing**2
        found = moved[:, at[0], at[1]]
        assert found == pytest.approx(wanted, abs=0.03 * np.abs(wanted).max())


def test_the_flexibility_of_layers_is_symmetric_and_stiff_in_every_wave():
    """Pressure moves along what traction moves down, and no stress does negative work."""
    grid = LayerGrid(STACK, 12, 0.5, width=1.0)
    body = GridCoulomb(grid.flexibility, (12, 12), 0.5)
    matrix = np.array([body.displacement(unit) for unit in np.eye(3 * 144)])
    assert matrix == pytest.approx(matrix.T, abs=1e-12 * np.abs(matrix).max())
    assert np.abs(matrix[:144, 144:]).max() > 0.02 * matrix.max()
    own = np.diag(matrix)[[0, 144, 288]]
    assert body.own == pytest.approx(own[1], rel=1e-5)
    # But the mean, from which images are taken away.
    assert np.sort(np.linalg.eigvalsh(matrix))[3] > 0.0
