"""Contact on a periodic grid with an elastic object: closed forms, and the dense contact."""

import math

import numpy as np
import pytest

from fefinger.contact.active_set import DONE
from fefinger.contact.gridded import GridContact, SoftGridContact
from fefinger.contact.soft import SoftContact
from fefinger.contact.stepper import Stepper, Target
from fefinger.mechanics.press.layer_grid import LayerGrid, object_compliance
from fefinger.theory.contact.stack import Layer, Stack


MODULUS, POISSON = 40.0, 0.4
STIFF = MODULUS / (1 - POISSON**2)
BONDED = Stack((Layer(4.0, 20.0, 0.45),))
HALF_SPACE = Stack((Layer(math.inf, MODULUS, POISSON),))
ELASTIC = np.zeros(0), np.zeros(0)
BRANCHES = np.array([0.8, 0.5]), np.array([30.0, 2.0])


def grid(points: int, period: float) -> LayerGrid:
    return LayerGrid(BONDED, points, period / points)


def ball(of: LayerGrid, radius: float = 8.0):
    return lambda shift: ((of.places - shift) ** 2).sum(axis=-1) / (2 * radius)


def test_a_half_space_gives_way_by_the_closed_form_without_its_images() -> None:
    """Hertz's pressure, p0 (1 - r²/a²)^1/2, as wide as .4 of the period."""
    errors = []
    for points in (64, 128):
        of, a = grid(points, 10.0), 2.0
        r = np.hypot(*np.moveaxis(of.places, -1, 0))
        pressure = np.sqrt(np.maximum(1 - (r / a) ** 2, 0.0))
        waves = of.waves(pressure) * object_compliance(HALF_SPACE, of)
        moved = np.fft.irfft2(waves[0], pressure.shape)
        wanted = np.pi / (4 * a * STIFF) * (2 * a**2 - r**2)
        errors.append(np.abs(moved - wanted)[r < 0.9 * a].max() / wanted.max())
    assert errors[1] < 2e-3
    assert errors[1] < 0.5 * errors[0]


def test_two_half_spaces_press_as_hertz() -> None:
    of, radius, depth = grid(128, 10.0), 8.0, 0.2
    own = object_compliance(HALF_SPACE, of)
    press = SoftGridContact((own, ELASTIC), own, (128, 128), of.spacing, ball(of), ELASTIC)
    assert press.advance(0.0, Target(depth)) == DONE
    wanted = 4 / 3 * (STIFF / 2) * np.sqrt(radius) * depth**1.5
    assert press.force == pytest.approx(wanted, rel=5e-3)
    assert press.pressure.max() == pytest.approx(
        2 * (STIFF / 2) * math.sqrt(depth / radius) / np.pi, rel=0.01
    )
    half = press.force
    assert press.advance(0.0, Target(half, by_force=True)) == DONE
    assert press.depth == pytest.approx(depth, rel=1e-6)
    assert press.energy() == pytest.approx(0.4 * half * depth, rel=5e-3)  # of both, by F ~ d^1.5


@pytest.fixture(scope="module")
def small() -> LayerGrid:
    return grid(16, 12.0)


def dense(of: LayerGrid, compliance: np.ndarray) -> np.ndarray:
    """Return mm³/kPa: the displacement of the pressure of every point, times the area of one."""
    n = of.points
    units = np.eye(n * n).reshape(-1, n, n)
    moved = np.fft.irfft2(np.fft.rfft2(units) * compliance, (n, n))
    return moved.reshape(n * n, n * n) * of.spacing**2


@pytest.mark.parametrize(
    ("body", "branches"),
    [(HALF_SPACE, ELASTIC), (Stack((Layer(3.0, 25.0, 0.3),)), (np.array([1.5]), np.array([4.0])))],
    ids=["half", "3 mm, relaxing"],
)
def test_it_relaxes_as_the_dense_contact_with_a_soft_object_does(
    small: LayerGrid, body: Stack, branches: tuple[np.ndarray, np.ndarray]
) -> None:
    own, gap = object_compliance(body, small), ball(small)
    area = np.full(small.points**2, small.spacing**2)
    both: list[Stepper] = [
        SoftGridContact(
            (own, branches),
            small.compliance,
            (16, 16),
            small.spacing,
            gap,
            BRANCHES,
            tolerance=1e-8,
        ),
        SoftContact(
            (dense(small, own), branches),
            dense(small, small.compliance),
            gap(0.0).ravel() * area,
            area,
            BRANCHES,
        ),
    ]
    for dt, target in (
        (0.0, Target(0.3)),
        (0.02, Target(0.6)),
        (0.5, Target(0.6)),
        (0.01, Target(0.4)),
        (0.3, Target(30.0, by_force=True)),
    ):
        for each in both:
            assert each.advance(dt, target) == DONE
        found, wanted = both
        assert found.pressure == pytest.approx(wanted.pressure, abs=1e-5 * wanted.pressure.max())
        assert found.depth == pytest.approx(wanted.depth, rel=1e-5)


def test_a_hard_object_is_the_rigid_one(small: LayerGrid) -> None:
    hard = object_compliance(Stack((Layer(math.inf, 1e15, 0.5),)), small)
    parts = small.compliance, (16, 16), small.spacing, ball(small), BRANCHES
    contacts = SoftGridContact((hard, ELASTIC), *parts), GridContact(*parts)
    for dt, depth in ((0.0, 0.4), (0.1, 0.7), (1.0, 0.5)):
        for each in contacts:
            each.advance(dt, Target(depth))
        assert contacts[0].pressure == pytest.approx(contacts[1].pressure, rel=1e-6, abs=1e-6)
        assert contacts[0].energy() == pytest.approx(contacts[1].energy(), rel=1e-6)
