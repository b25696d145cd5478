"""Quarters of bodies of revolution: fit together, fill their polygon, and keep their interfaces."""

import numpy as np
import pytest
from fefinger.validation.problems.grids import quarter

from fefinger.fem.elements.spaces import Space


LINES = np.array([0.0, 0.7, 1.5])
SECTORS = 3


@pytest.fixture(scope="module")
def space() -> Space:
    def size(r: np.ndarray, z: np.ndarray) -> np.ndarray:
        return 0.2 + 0.5 * np.hypot(r - 1, z)

    return quarter(LINES, LINES, size, SECTORS, interfaces=(0.7,))


def volumes(space: Space) -> np.ndarray:
    corners = space.points[space.cells]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6


def test_the_cells_fill_the_polygon_once(space: Space) -> None:
    sides = 4 * SECTORS
    area = sides / 2 * np.sin(2 * np.pi / sides) * LINES[-1] ** 2
    assert np.abs(volumes(space)).sum() == pytest.approx(area * LINES[-1] / 4)
    assert np.abs(volumes(space)).min() > 1e-6


def test_faces_fit_and_the_outer_ones_lie_on_flat_sides(space: Space) -> None:
    faces = space.cells[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3)
    found, count = np.unique(np.sort(faces, axis=1), axis=0, return_counts=True)
    assert count.max() == 2
    corners = space.points[found[count == 1]]
    flat = [(corners[:, :, axis] == 0).all(axis=1) for axis in range(3)]
    bottom = (corners[:, :, 2] == LINES[-1]).all(axis=1)
    side = np.isclose(np.hypot(*corners.T[:2]).T, LINES[-1]).all(axis=1)
    assert np.any([*flat, bottom, side], axis=0).all()


def test_the_mesh_is_as_fine_as_asked_and_coarser_elsewhere(space: Space) -> None:
    r, z = np.hypot(*space.points.T[:2]), space.points[:, 2]
    near = np.hypot(r - 1, z) < 0.3
    assert near.mean() > 0.2
    assert len(space.points) < 500


def test_tissues_change_at_the_interface(space: Space) -> None:
    depth = space.points[space.cells][:, :, 2]
    assert (depth[space.tissue == 1] <= 0.7).all()
    assert (depth[space.tissue == 2] >= 0.7).all()
    assert set(space.tissue) == {1, 2}
