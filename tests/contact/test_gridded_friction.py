"""Coulomb friction on a periodic grid: against a dense matrix, Mindlin, squares, and energy."""

import numpy as np
import pytest
from fefinger.validation.oracles import squares
from fefinger.validation.oracles.mindlin import Mindlin

from fefinger.contact.active_set import DONE, ENDLESS
from fefinger.contact.frictional import FrictionalContact
from fefinger.contact.grid_coulomb import Flexibility, GridCoulomb
from fefinger.contact.gridded import GridContact, GridFriction
from fefinger.contact.stepper import Target


SHEAR, RADIUS = 100.0 / 3, 10.0  # kPa and mm
ELASTIC = np.zeros(0), np.zeros(0)
BRANCHES = np.array([0.8, 0.5]), np.array([30.0, 2.0])
IMAGES = 3.900264920001956
"""Sum of 1 / |n| over the square lattice without its middle, against the mean, negative."""


def half_space(n, side, poisson):
    """Flexibility of a half-space; its means take away what images add in the middle."""
    k = 2 * np.pi / side * n
    x, y = np.meshgrid(np.fft.fftfreq(n) * k, np.fft.rfftfreq(n) * k, indexing="ij")
    xi = np.hypot(x, y)
    xi[0, 0] = 1.0
    c, s = x / xi, y / xi
    normal, aside = (1 - poisson) / (SHEAR * xi), 1 / (SHEAR * xi)
    one, two = c**2 * normal + s**2 * aside, s**2 * normal + c**2 * aside
    mean = IMAGES * side / (2 * np.pi * SHEAR)
    normal[0, 0] = mean * (1 - poisson)
    one[0, 0] = two[0, 0] = mean * (2 - poisson) / 2
    aside[0, 0] = normal[0, 0]
    c[n // 2], s[:, -1] = 0.0, 0.0
    slide = -(1 - 2 * poisson) / (2 * SHEAR * xi)
    tangential = [one, two, c * s * (normal - aside)]
    return Flexibility(normal, np.stack([c * slide, s * slide]), np.stack(tangential))


def places(n, side):
    lines = side / n * (np.arange(n) - n // 2)
    return np.stack(np.meshgrid(lines, lines, indexing="ij"), axis=-1)


def ball(n, side, radius=RADIUS):
    at = places(n, side)
    gap = np.sum(at**2, axis=-1) / (2 * radius)
    return lambda shift: gap


def waves(n, side):
    """Gap of a ball with waves that moves over the body."""
    at = places(n, side)

    def gap(shift):
        moved = at - np.array(shift)
        return np.sum(at**2, axis=-1) / 20 + 0.03 * (1 - np.cos(4.0 * moved[..., 0]))

    return gap


def gripped(n, side, gap, mu, poisson=0.5, branches=ELASTIC, **options):
    body = half_space(n, side, poisson)
    return GridFriction(body, (n, n), mu, side / n, gap, branches, **options)


def test_it_is_the_solution_of_the_matrix_of_the_same_grid():
    """Stick, part and full slip, relaxing and at mu_k < mu_s, with pressure moved by traction."""
    n, side, mu = 10, 4.0, (0.5, 0.4)
    grid = gripped(n, side, ball(n, side, 4.0), mu, 0.3, BRANCHES, tolerance=1e-10)
    body = GridCoulomb(half_space(n, side, 0.3), (n, n), 0.5)
    matrix = np.array([body.displacement(unit) for unit in np.eye(3 * n * n)]).T
    assert matrix == pytest.approx(matrix.T, abs=1e-12 * matrix.max())
    area, gap = np.full(n * n, grid.area), ball(n, side, 4.0)(0).ravel()
    dense = FrictionalContact(
        matrix * grid.area, mu, gap * grid.area, area, (BRANCHES[0], BRANCHES[1])
    )
    for depth, x in ((0.2, 0.0), (0.3, 0.02), (0.3, 0.1), (0.25, 0.3), (0.25, 0.1)):
        target = Target(depth, shift=(x, -x / 3))
        assert grid.advance(0.01, target) == DONE
        assert dense.advance(0.01, target) == DONE
        close = 1e-6 * dense.pressure.max()
        assert grid.pressure == pytest.approx(dense.pressure, abs=close)
        assert grid.traction == pytest.approx(dense.traction, abs=close)
    assert grid.lost == pytest.approx(float(dense.lost[0]), rel=1e-6)
    assert grid.slip == pytest.approx(dense.slip, abs=1e-6 * np.abs(dense.slip).max())


@pytest.fixture(scope="module")
def sheared():
    """Press a ball to a contact radius of 1 mm, and shear it until all slides."""
    n, side, mu = 80, 8.0, 0.3
    contact = gripped(n, side, ball(n, side), (mu, mu))
    assert contact.advance(0.0, Target(0.1)) == DONE
    theory = Mindlin(1.0, contact.force, SHEAR, 0.5, mu)
    path = 1.5 * theory.most / theory.stiffness * np.array([0.3, 0.6, 0.9, 1.25])
    rows = []
    for x in path:
        assert contact.advance(0.0, Target(0.1, shift=(x, 0.0))) == DONE
        rows.append((contact.traction.copy(), contact.sticking.copy()))
    return contact, theory, path, rows


def test_cattaneo_and_mindlin_give_the_force_the_stick_and_the_traction(sheared):
    contact, theory, path, rows = sheared
    force = np.array([traction[0].sum() for traction, _ in rows]) * contact.area
    assert force == pytest.approx(theory.force_at(path), abs=0.01 * theory.most)
    half = rows[1]
    r = np.hypot(*np.moveaxis(places(80, 8.0), -1, 0)).ravel()
    exact = theory.traction(r, float(force[1]))
    assert np.abs(half[0][0] - exact).mean() < 0.06 * exact.mean()
    stick = np.sqrt(half[1].sum() * contact.area / np.pi)
    assert stick == pytest.approx(float(theory.stick_radius(force[1])), abs=0.04)


def test_in_full_slip_the_traction_is_mu_p_along_the_slide(sheared):
    contact, _, _, rows = sheared
    size = np.hypot(*rows[-1][0])
    assert size == pytest.approx(0.3 * contact.pressure, abs=1e-4 * contact.pressure.max())
    assert not rows[-1][1].any()


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_wave_that_slides_in_full_contact_has_the_pressure_of_its_transform(way):
    """Displacements A p + i B t with t = mu p: friction moves the pressure, and makes it less.

    The waves of a half-space, Johnson, Contact Mechanics (1985), 2.6 and 13.2.
    """
    n, side, delta, mu, poisson = 32, 2.0, 0.02, 0.6, 0.2
    x = places(n, side)[..., 0]
    k = 2 * np.pi / side
    contact = gripped(n, side, lambda shift: delta * (1 - np.cos(k * x)), (mu, mu), poisson)
    mean = 60.0
    for step in range(3):
        target = Target(mean * side**2, by_force=True, shift=(way * step, 0.0))
        assert contact.advance(0.0, target) == DONE
    normal = (1 - poisson) / (SHEAR * k)
    coupled = -(1 - 2 * poisson) / (2 * SHEAR * k)
    wave = delta / (normal + 1j * coupled * mu * way)
    wanted = mean + np.real(wave * np.exp(1j * k * x))
    assert contact.pressure == pytest.approx(wanted.ravel(), abs=1e-4 * mean)
    assert contact.traction[0] == pytest.approx(way * mu * wanted.ravel(), abs=1e-4 * mean)
    assert abs(np.angle(wave)) > 0.15


def test_squares_of_a_boundary_element_method_agree():
    """At nu = 0.3, where traction moves the contact, in part slip; squares are not waves."""
    n, side, count, mu = 128, 8.0, 22, 0.5
    grid = gripped(n, side, ball(n, side), (mu, mu), 0.3)
    line = side / n * 2 * (np.arange(count) - (count - 1) / 2)
    at = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2)
    area = np.full(len(at), (2 * side / n) ** 2)
    matrix = squares.flexibility(at, 2 * side / n, shear=SHEAR, poisson=0.3)
    gap = area * np.sum(at**2, axis=1) / (2 * RADIUS)
    dense = FrictionalContact(matrix, (mu, mu), gap, area, ELASTIC)
    for x in (0.0, 0.02):
        target = Target(0.1, shift=(x, 0.0))
        assert grid.advance(0.0, target) == DONE
        assert dense.advance(0.0, target) == DONE
    # Eight squares along a radius leave 3 % of the force, and so of mu times it.
    force = dense.pressure @ area
    assert grid.force == pytest.approx(force, rel=0.04)
    pulled = grid.traction[0].sum() * grid.area / grid.force
    assert pulled == pytest.approx(dense.traction[0] @ area / force, rel=0.03)
    ahead = grid.pressure @ places(n, side)[..., 0].ravel() * grid.area / grid.force
    assert ahead == pytest.approx(dense.pressure @ (at[:, 0] * area) / force, rel=0.1)
    assert abs(ahead) > 0.005


def test_without_friction_it_is_the_contact_without():
    n, side = 32, 4.0
    grid = gripped(n, side, ball(n, side), (0.0, 0.0), 0.3)
    plain = GridContact(half_space(n, side, 0.3).normal, (n, n), side / n, ball(n, side), ELASTIC)
    target = Target(40.0, by_force=True, shift=(0.1, 0.0))
    assert grid.advance(0.0, target) == DONE
    assert plain.advance(0.0, target) == DONE
    assert grid.pressure == pytest.approx(plain.pressure, abs=1e-5 * plain.pressure.max())
    assert not grid.traction.any()


@pytest.mark.parametrize("branches", [ELASTIC, BRANCHES], ids=["elastic", "relaxing"])
def test_no_energy_is_gained_along_a_closed_path_with_friction(branches):
    """What the object does is stored, lost by friction, or by relaxation; never more."""
    n, side, count = 16, 4.0, 40
    gap = waves(n, side)
    press = gripped(n, side, gap, (0.4, 0.4), 0.3, branches, tolerance=1e-7)
    turn = 2 * np.pi * np.arange(2 * count + 1) / count
    depth, x = 0.1 + 0.03 * np.sin(turn), 0.15 * (1 - np.cos(turn))
    press.advance(0.0, Target(depth[0]))
    started, work = press.energy(), 0.0
    stress, at = press.coulomb.x.copy(), np.zeros(3 * n * n)
    at[: n * n] = gap((0.0, 0.0)).ravel() - depth[0]
    for k in range(1, len(turn)):
        assert press.advance(0.01, Target(depth[k], shift=(x[k], 0.0))) == DONE
        here = np.zeros_like(at)
        here[: n * n] = gap((x[k], 0.0)).ravel() - depth[k]
        here[n * n : 2 * n * n] = -x[k]
        work += press.area * float((press.coulomb.x + stress) / 2 @ (at - here))
        stress, at = press.coulomb.x.copy(), here
    rest = work - (press.energy() - started) - press.lost
    assert press.lost > 0.0
    if branches is ELASTIC:
        assert abs(rest) < 0.03 * press.lost
    else:
        assert rest > 0.03 * press.lost


def test_a_state_returns_and_a_friction_without_solution_is_told(monkeypatch):
    n, side = 24, 4.0
    press = gripped(n, side, waves(n, side), (0.4, 0.3), 0.3, BRANCHES)
    press.advance(0.01, Target(0.1))
    kept = press.state()
    press.advance(0.01, Target(0.12, shift=(0.1, 0.0)))
    after = press.coulomb.x.copy()
    press.restore(kept)
    with monkeypatch.context() as few:
        few.setattr("fefinger.contact.grid_coulomb.ROUNDS", 1)
        assert press.advance(0.01, Target(0.12, shift=(0.1, 0.0))) == ENDLESS
    assert "indenter.friction = 0.4" in press.failures[ENDLESS]
    assert press.advance(0.01, Target(0.12, shift=(0.1, 0.0))) == DONE
    assert press.coulomb.x == pytest.approx(after, abs=1e-4 * after.max())
    press.reset()
    assert not press.coulomb.x.any()
