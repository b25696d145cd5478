"""A whole finger is two halves, welded."""

import numpy as np
import pytest

from fefinger.geometry.finger_mesh import FACETS, FingerMesh, faces, volumes
from fefinger.mesh import vtu
from fefinger.mesh.shipped import data_folder
from fefinger.mesh.symmetric import whole
from fefinger.support.checks import InputError


@pytest.fixture(scope="module")
def half() -> FingerMesh:
    """Return the smallest shipped half."""
    return vtu.read(data_folder() / "ah-coarse.vtu")


def test_volume_doubles_in_every_region_and_cells_stay_positive(half: FingerMesh) -> None:
    both = whole(half)
    one, two = (volumes(mesh.points, mesh.cells) for mesh in (half, both))
    assert two.min() > 0
    for region in (1, 2, 3):
        expected = 2 * one[half.region == region].sum()
        assert two[both.region == region].sum() == pytest.approx(expected, rel=1e-12)


def test_medial_vertices_are_welded(half: FingerMesh) -> None:
    both = whole(half)
    assert len(np.unique(both.points, axis=0)) == len(both.points)
    assert len(both.points) == 2 * len(half.points) - np.sum(half.points[:, 1] == 0)
    assert "medial" not in both.facets
    assert not both.half


def test_boundary_is_closed_and_named(half: FingerMesh) -> None:
    both = whole(half)
    every = np.sort(faces(both.cells).reshape(-1, 3), axis=1)
    unique, count = np.unique(every, axis=0, return_counts=True)
    assert set(count) == {1, 2}
    named = np.concatenate([both.facets[n] for n in FACETS if n not in ("bone", "medial")])
    assert np.array_equal(np.unique(np.sort(named, axis=1), axis=0), unique[count == 1])
    sides = np.sort(named[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert set(np.unique(sides, axis=0, return_counts=True)[1]) == {2}


def test_mirroring_the_whole_gives_the_same_vertices_and_normals(half: FingerMesh) -> None:
    both = whole(half)
    rows = np.column_stack([both.points, both.pad_normals])
    mirrored = rows * [1, -1, 1, 1, -1, 1] + 0.0
    assert np.array_equal(np.unique(rows + 0.0, axis=0), np.unique(mirrored, axis=0))


def test_facets_keep_pointing_outward(half: FingerMesh) -> None:
    both = whole(half)
    total = 0.0
    for name in ("pad", "nail", "cut", "bone-cut"):
        a, b, c = (both.points[both.facets[name][:, i]] for i in range(3))
        total += np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert total == pytest.approx(volumes(both.points, both.cells).sum(), rel=1e-9)


def test_whole_finger_is_refused(half: FingerMesh) -> None:
    with pytest.raises(InputError, match="expected a half finger"):
        whole(whole(half))
