"""A whole finger is two halves, welded."""

import numpy as np
import pytest
from oracles.solids import assert_closed, enclosed
from refusals import refused

from fefinger.geometry.finger_mesh import FingerMesh, volumes, whole
from fefinger.mesh import mesh_record
from fefinger.mesh.recipe import data_folder


@pytest.fixture(scope="module")
def half() -> FingerMesh:
    """Return the smallest shipped half."""
    return mesh_record.read(data_folder() / "ah-coarse.vtu")


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
    assert_closed(both, "bone", "medial")


def test_mirroring_the_whole_gives_the_same_vertices_and_normals(half: FingerMesh) -> None:
    both = whole(half)
    rows = np.column_stack([both.points, both.pad_normals])
    mirrored = rows * [1, -1, 1, 1, -1, 1] + 0.0
    # exact: a change of sign
    assert np.array_equal(np.unique(rows + 0.0, axis=0), np.unique(mirrored, axis=0))


def test_facets_keep_pointing_outward(half: FingerMesh) -> None:
    both = whole(half)
    everything = volumes(both.points, both.cells).sum()
    assert enclosed(both, "pad", "nail", "cut", "bone-cut") == pytest.approx(everything, rel=1e-9)


def test_whole_finger_is_refused(half: FingerMesh) -> None:
    with refused("mesh"):
        whole(whole(half))
