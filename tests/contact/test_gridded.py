"""Contact on a periodic grid: against closed forms of half-spaces and what stays the same."""

import numpy as np
import pytest
from fefinger.validation.oracles.march import march as plain
from scipy.integrate import quad

from fefinger.contact.active_set import DONE, ENDLESS, TURNED
from fefinger.contact.grid_solver import GridSolver
from fefinger.contact.gridded import GridContact
from fefinger.contact.prony_history import Relaxation
from fefinger.contact.stepper import Prescribed, Target, march


STIFF = 50.0
"""Plane modulus E / (1 - nu²) in kPa of the half-space."""

IMAGES = 3.900264920001956
"""Sum of 1 / |n| over the square lattice without its middle, against the mean, negative."""

BRANCHES = np.array([0.8, 0.5]), np.array([30.0, 2.0])
ELASTIC = np.zeros(0), np.zeros(0)


def waves(n, side):
    k = 2 * np.pi / side * n
    return np.hypot(*np.meshgrid(np.fft.fftfreq(n) * k, np.fft.rfftfreq(n) * k, indexing="ij"))


def half_space(n, side):
    """Compliance of a half-space; its mean takes away what images add in the middle."""
    k = waves(n, side)
    with np.errstate(divide="ignore"):
        compliance = 2 / (STIFF * k)
    compliance[0, 0] = IMAGES * side / (np.pi * STIFF)
    return compliance


def places(n, side):
    lines = side / n * (np.arange(n) - n // 2)
    return np.stack(np.meshgrid(lines, lines, indexing="ij"), axis=-1)


def contact(n, side, gap, branches=ELASTIC, **options):
    return GridContact(half_space(n, side), (n, n), side / n, gap, branches, **options)


def ball(n, side, radius=8.0):
    at = places(n, side)
    return lambda shift: np.sum((at - shift) ** 2, axis=-1) / (2 * radius)


def bumps(n, side):
    """Gap of a ball with ridges, which moves over the body."""
    at = places(n, side)

    def gap(shift):
        moved = at - shift
        return np.sum(at**2, axis=-1) / 16 + 0.1 * (1 - np.cos(4.0 * moved[..., 0]))

    return gap


def test_a_ball_is_hertz_and_its_error_falls_with_the_grid():
    depth, radius = 0.2, 8.0
    a = np.sqrt(radius * depth)
    wanted = 4 / 3 * STIFF * np.sqrt(radius) * depth**1.5
    errors = []
    for n, close in ((32, 0.012), (64, 2e-3), (128, 1e-3)):
        press = contact(n, 16.0, ball(n, 16.0))
        assert press.advance(0.0, Target(depth)) == DONE
        exact = (
            2
            * STIFF
            * a
            / (np.pi * radius)
            * np.sqrt(np.maximum(1 - np.sum(places(n, 16.0) ** 2, axis=-1) / a**2, 0.0))
        )
        apart = press.pressure.reshape(n, n) - exact
        errors.append(np.abs(apart).mean())
        assert press.force == pytest.approx(wanted, rel=close)
    assert errors[1] < 0.6 * errors[0]
    assert errors[2] < 0.6 * errors[1]


def test_the_depth_of_a_force_is_that_of_hertz():
    n, side, radius, depth = 64, 16.0, 8.0, 0.2
    press = contact(n, side, ball(n, side))
    wanted = 4 / 3 * STIFF * np.sqrt(radius) * depth**1.5
    assert press.advance(0.0, Target(wanted, by_force=True)) == DONE
    assert press.depth == pytest.approx(depth, rel=1.5e-3)
    assert press.force == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("share", [0.1, 0.4, 0.8])
def test_a_wave_in_partial_contact_has_the_pressure_of_westergaard(share):
    """Johnson, Contact Mechanics (1985), 13.2: one-dimensional waves of a height of 2 delta."""
    n, side, delta = 128, 1.0, 0.02
    top = np.pi * STIFF * delta / side
    at = places(n, side)
    gap = delta * (1 - np.cos(2 * np.pi * at[..., 0] / side))
    press = contact(n, side, lambda shift: gap)
    assert press.advance(0.0, Target(share * top * side**2, by_force=True)) == DONE
    half = np.arcsin(np.sqrt(share))
    psi = np.pi * at[:, 0, 0] / side
    wanted = 2 * top * np.cos(psi) * np.sqrt(np.maximum(np.sin(half) ** 2 - np.sin(psi) ** 2, 0.0))
    got = press.pressure.reshape(n, n)
    assert got == pytest.approx(np.repeat(wanted[:, None], n, 1), abs=0.04 * wanted.max())
    assert np.mean(got[:, 0]) == pytest.approx(share * top, rel=1e-9)
    assert np.mean(np.abs(got[:, 0] - wanted)) < 0.004 * wanted.max()


def test_waves_in_full_contact_have_the_pressure_of_their_transform():
    """Johnson, Greenwood and Higginson 1985: p* = sqrt(2) pi E* delta / wavelength."""
    n, side, delta = 48, 2.0, 0.03
    x, y = np.moveaxis(places(n, side), -1, 0) * 2 * np.pi / side
    press = contact(n, side, lambda shift: delta * (1 - np.cos(x) * np.cos(y)))
    top = np.sqrt(2) * np.pi * STIFF * delta / side
    assert press.advance(0.0, Target(1.5 * top * side**2, by_force=True)) == DONE
    wanted = 1.5 * top + top * np.cos(x) * np.cos(y)
    assert press.pressure.reshape(n, n) == pytest.approx(wanted, rel=1e-4)


def test_a_punch_with_a_rounded_edge():
    """Sneddon's integrals of a flat end of radius b and an edge (r - b)² / 2R beyond it."""
    n, side, flat, edge, a = 160, 6.0, 0.5, 0.6, 0.8

    def g(t):
        return t * quad(lambda u: (t * np.sin(u) - flat) / edge, np.arcsin(flat / t), np.pi / 2)[0]

    depth = g(a)
    force = 2 * STIFF * (depth * a - quad(g, flat, a)[0])
    r = np.hypot(*np.moveaxis(places(n, side), -1, 0))
    gap = np.maximum(r - flat, 0.0) ** 2 / (2 * edge)
    press = contact(n, side, lambda shift: gap)
    assert press.advance(0.0, Target(depth)) == DONE
    assert press.force == pytest.approx(force, rel=4e-3)
    spread = np.sqrt(press.area * np.count_nonzero(press.pressure) / np.pi)
    assert spread == pytest.approx(a, abs=0.5 * side / n)


def test_a_part_of_a_grid_point_changes_nothing():
    n, side = 64, 8.0
    still, moved = (contact(n, side, ball(n, side)) for _ in range(2))
    still.advance(0.0, Target(0.2))
    moved.advance(0.0, Target(0.2, shift=(0.3 * side / n, -0.45 * side / n)))
    assert moved.force == pytest.approx(still.force, rel=3e-3)


@pytest.mark.parametrize("part", [0.3, 0.7])
def test_object_and_ridges_moved_together_by_a_part_of_a_point_are_the_same(part):
    """All of it moves over a flat body whose grid stays."""
    n, side = 96, 8.0
    at = places(n, side)

    def gap(shift):
        x, y = np.moveaxis(at - np.array(shift), -1, 0)
        return (x**2 + y**2) / 16 + 0.02 * (1 - np.cos(5.0 * x)) + 0.03 * (1 - np.cos(3.0 * y))

    press, moved = (contact(n, side, gap) for _ in range(2))
    assert press.advance(0.0, Target(0.2)) == DONE
    assert moved.advance(0.0, Target(0.2, shift=(part * side / n, -part * side / n))) == DONE
    assert moved.force == pytest.approx(press.force, rel=2e-3)
    center = moved.pressure @ at.reshape(-1, 2) / moved.pressure.sum()
    assert center == pytest.approx(part * side / n * np.array([1.0, -1.0]), abs=2e-3)


def test_ridges_moved_by_their_pitch_repeat():
    n, side = 64, 8.0
    pitch = 2 * np.pi / 4.0
    first, then = (
        contact(n, side, lambda shift: bumps(n, side)(np.array(shift))) for _ in range(2)
    )
    first.advance(0.0, Target(0.2))
    then.advance(0.0, Target(0.2, shift=(pitch, 0.0)))
    assert then.pressure == pytest.approx(first.pressure, abs=1e-4 * first.pressure.max())


def test_it_marches_as_a_solver_with_a_matrix_does():
    n, side = 8, 4.0
    body = GridSolver(half_space(n, side), (n, n))
    matrix = np.array([body.displacement(unit) for unit in np.eye(n * n)])
    gap = ball(n, side, 2.0)
    time = np.linspace(0.0, 0.3, 12)
    depth = 0.4 * np.sin(np.pi * time / 0.3)
    press = contact(n, side, gap, BRANCHES, tolerance=1e-9)
    mine = march(press, Prescribed("depth", time, depth))
    weights = np.append(1.0, BRANCHES[0]) / (1.0 + BRANCHES[0].sum())
    area = np.full(n * n, press.area)
    theirs = plain(
        matrix * press.area,
        gap(np.zeros(2)).ravel() * area,
        area,
        Relaxation(weights, BRANCHES[1], n * n),
        Prescribed("depth", time, depth),
    )
    assert mine.pressure == pytest.approx(theirs.pressure, abs=1e-6 * theirs.pressure.max())


def test_a_state_returns_and_a_step_that_fails_changes_nothing(monkeypatch):
    n, side = 32, 8.0
    press = contact(n, side, bumps(n, side), BRANCHES)
    press.advance(0.01, Target(0.2))
    kept = press.state()
    press.advance(0.01, Target(0.25, shift=(0.1, 0.0)))
    after = press.pressure.copy()
    press.restore(kept)
    with monkeypatch.context() as few:
        few.setattr("fefinger.contact.grid_solver.ITERATIONS", 2)
        assert press.advance(0.01, Target(0.25, shift=(0.1, 0.0))) == ENDLESS
    assert press.advance(0.01, Target(0.25, shift=(0.1, 0.0))) == DONE
    assert press.pressure == pytest.approx(after, abs=1e-4 * after.max())


def test_contact_at_the_end_of_an_object_is_told():
    n, side = 32, 8.0
    at, whole = places(n, side), ball(n, side)
    press = contact(
        n, side, lambda shift: np.where(at[..., 0] > 0.4 + shift[0], np.inf, whole(np.zeros(2)))
    )
    assert press.advance(0.0, Target(0.003)) == DONE
    assert press.advance(0.0, Target(0.4)) == TURNED


@pytest.mark.parametrize("branches", [ELASTIC, BRANCHES], ids=["elastic", "relaxing"])
def test_no_energy_is_gained_along_a_closed_path(branches):
    """The object is moved around over ridges: what its force does is stored or lost."""
    n, side, count = 32, 8.0, 60
    gap = bumps(n, side)
    press = contact(n, side, gap, branches, tolerance=1e-7)
    turn = 2 * np.pi * np.arange(count + 1) / count
    depth, x = 0.2 + 0.1 * np.sin(turn), 0.3 * (1 - np.cos(turn))
    press.advance(0.0, Target(depth[0]))
    started = work = press.energy()
    before = press.pressure.copy(), gap((x[0], 0.0)).ravel() - depth[0]
    for k in range(1, count + 1):
        assert press.advance(0.01, Target(depth[k], shift=(x[k], 0.0))) == DONE
        here = gap((x[k], 0.0)).ravel() - depth[k]
        work += press.area * float((press.pressure + before[0]) / 2 @ (before[1] - here))
        before = press.pressure.copy(), here
    lost = work - press.energy()
    scale = 0.1 * press.force
    if branches is ELASTIC:
        assert press.energy() == pytest.approx(started, rel=1e-5)
        assert abs(lost) < 0.01 * scale
    else:
        assert lost > 0.01 * scale
