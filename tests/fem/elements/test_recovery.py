"""Strain by recovery: exact for cubics, of higher order than that of the cells, one tissue only."""

from collections.abc import Callable

import numpy as np
import pytest
from fefinger.validation.problems.grids import box

from fefinger.fem.elements.probe import (
    POWERS,
    recovered_gradient_at,
    recovered_strain_at,
    strain_at,
)
from fefinger.fem.elements.spaces import Space


def grid(cells: int) -> Space:
    """Return a cube of uneven cells."""
    even = box(*3 * (np.linspace(0.0, 1.0, cells + 1),))
    inside = ((even.points > 0) & (even.points < 1)).all(axis=1)
    shift = np.random.default_rng(1).uniform(-0.2, 0.2, even.points.shape) / cells
    return Space(even.points + shift * inside[:, None], even.cells, even.tissue)


def unknowns(space: Space, moved: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    values = np.zeros(space.n_unknowns)
    values[: space.n_displacements] = moved(space.node_points).ravel()
    return values


SITES = np.array([[0.5, 0.5, 0.5], [0.21, 0.33, 0.04], [0.0, 0.4, 0.7], [1.0, 1.0, 1.0]])


def test_the_strain_of_a_cubic_displacement_is_exact():
    space = grid(4)
    weights = np.random.default_rng(2).normal(size=(len(POWERS), 3))

    def moved(x: np.ndarray) -> np.ndarray:
        return np.prod(x[:, None, :] ** POWERS, axis=2) @ weights

    h = 1e-6
    steps = [(moved(SITES + h * e) - moved(SITES - h * e)) / (2 * h) for e in np.eye(3)]
    gradient = np.stack(steps, axis=2)
    strain = (gradient + gradient.transpose(0, 2, 1)) / 2
    found = (recovered_strain_at(space, SITES) @ unknowns(space, moved)).reshape(-1, 6)
    exact = strain[:, [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    assert found == pytest.approx(exact, abs=1e-8 * np.abs(exact).max())


def waves(x: np.ndarray) -> np.ndarray:
    return np.stack([np.sin(2 * x[:, 1]), np.sin(2 * x[:, 2]), np.cos(2 * x[:, 0])], axis=1)


def waves_strain(x: np.ndarray) -> np.ndarray:
    out = np.zeros((len(x), 6))
    out[:, 3], out[:, 4] = np.cos(2 * x[:, 1]), np.cos(2 * x[:, 2])
    out[:, 5] = -np.sin(2 * x[:, 0])
    return out


def test_it_converges_faster_than_the_strain_of_the_cells():
    points = np.random.default_rng(3).uniform(0.1, 0.9, (20, 3))
    errors = []
    for cells in (4, 8):
        space = grid(cells)
        values = unknowns(space, waves)
        errors.append(
            [
                np.abs((rows @ values).reshape(-1, 6) - waves_strain(points)).max()
                for rows in (strain_at(space, points), recovered_strain_at(space, points))
            ]
        )
    (cell, found), (cell_fine, found_fine) = errors
    assert found < cell
    assert found_fine < 0.2 * cell_fine
    assert np.log2(found / found_fine) > 2.5


def test_mirror_planes_stand_for_the_missing_half():
    half, point = grid(6), np.array([[0.0, 0.5, 0.5]])
    values = unknowns(half, lambda x: np.stack([x[:, 0] ** 3, x[:, 0] ** 2, x[:, 0] ** 4], axis=1))
    strain = recovered_strain_at(half, point, planes=(0,)) @ values
    assert strain[[3, 5]] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_it_does_not_look_into_the_next_tissue():
    space = grid(6)
    centers = space.points[space.cells].mean(axis=1)
    two = Space(space.points, space.cells, np.where(centers[:, 2] < 0.5, 1, 2).astype(np.int8))
    point = np.array([[0.51, 0.47, 0.4]])
    rows = recovered_strain_at(two, point)
    used = np.unique(rows.indices // 3)
    assert two.node_points[used, 2].max() < 0.62


def lonely() -> Space:
    """Return a cube in which every cell is a tissue of its own."""
    space = grid(2)
    return Space(space.points, space.cells, np.arange(1, len(space.cells) + 1, dtype=np.int8))


def test_a_point_with_too_little_around_it_takes_the_strain_of_its_cell():
    space, point = lonely(), np.array([[0.3, 0.3, 0.3]])
    values = unknowns(space, waves)
    assert recovered_strain_at(space, point) @ values == pytest.approx(
        strain_at(space, point) @ values, rel=1e-12
    )


@pytest.mark.parametrize("axis", range(3))
def test_a_point_with_too_little_around_it_keeps_to_the_mirror(axis):
    space, point = lonely(), np.array([[0.3, 0.2, 0.1]])
    point[0, axis] = 0.0
    values = unknowns(space, waves)
    found, own = (recovered_gradient_at(space, point, p) @ values for p in ((axis,), ()))
    across = np.arange(3) == axis
    mixed = (across[:, None] != across).ravel()
    assert np.abs(own[mixed]).max() > 0.1
    assert found == pytest.approx(np.where(mixed, 0.0, own), rel=1e-12, abs=0)


def test_half_a_body_and_its_mirror_images_give_what_the_whole_gives():
    half = grid(4)
    beyond = half.points[:, 0] > 0
    number = np.arange(len(half.points))
    number[beyond] = len(half.points) + np.arange(beyond.sum())
    mirrored = number[half.cells][:, [0, 2, 1, 3]]
    space = Space(
        np.concatenate([half.points, half.points[beyond] * [-1, 1, 1]]),
        np.concatenate([half.cells, mirrored]),
        np.concatenate([half.tissue, half.tissue]),
    )
    points = np.array([[0.0, 0.5, 0.5], [0.07, 0.31, 0.42], [0.4, 0.9, 0.1]])

    def even(x: np.ndarray) -> np.ndarray:
        a, b, c = x.T
        return np.stack([np.sin(a) * np.cos(b), np.cos(a) * c**4, np.cosh(a) * b**4], axis=1)

    found = recovered_gradient_at(half, points, planes=(0,)) @ unknowns(half, even)
    expected = recovered_gradient_at(space, points) @ unknowns(space, even)
    assert found == pytest.approx(expected, abs=1e-12)
