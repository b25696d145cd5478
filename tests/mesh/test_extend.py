"""The continuation of a finger behind its cut: one closed mesh, and the old one inside it."""

import numpy as np
import pytest
from oracles.solids import assert_closed, enclosed
from refusals import refused

from fefinger.geometry.finger_mesh import FingerMesh, parts, volumes, whole
from fefinger.mesh import extend, mesh_record
from fefinger.mesh.mesh_record import dihedral_angles
from fefinger.mesh.recipe import data_folder


@pytest.fixture(scope="module", params=["dp-coarse", "ah-at-0-coarse", "pw-calibrated-standard"])
def pair(request: pytest.FixtureRequest) -> tuple[FingerMesh, FingerMesh]:
    """Return a shipped mesh and the continued one."""
    mesh = mesh_record.read(data_folder() / f"{request.param}.vtu")
    return mesh, extend.extended(mesh)


def test_the_mesh_is_inside_the_continued_one(pair: tuple[FingerMesh, FingerMesh]) -> None:
    mesh, longer = pair
    n, m = len(mesh.points), len(mesh.cells)
    assert np.array_equal(longer.points[:n], mesh.points)  # exact: left as they were
    assert np.array_equal(longer.cells[:m], mesh.cells)
    assert np.array_equal(longer.region[:m], mesh.region)
    assert np.array_equal(longer.pad_normals[:n], mesh.pad_normals)  # exact: left as they were
    for name in ("pad", "nail", "medial", "bone"):
        kept = mesh.facets[name]
        assert np.array_equal(longer.facets[name][: len(kept)], kept)


def test_the_continued_finger_is_closed_and_in_one_part(
    pair: tuple[FingerMesh, FingerMesh],
) -> None:
    _, longer = pair
    assert_closed(longer, "bone")
    assert [parts(longer.cells[longer.region == k]) for k in (1, 2, 3)] == [1, 1, 1]


def test_the_continuation_has_the_volume_of_the_extruded_section(
    pair: tuple[FingerMesh, FingerMesh],
) -> None:
    """Layers are moved against each other in their planes, which keeps the volume."""
    mesh, longer = pair
    section = mesh.points[np.concatenate([mesh.facets["cut"], mesh.facets["bone-cut"]])][:, :, 1:]
    sides = section[:, 1:] - section[:, :1]
    area = np.abs(np.linalg.det(sides)).sum() / 2.0
    added = volumes(longer.points, longer.cells[len(mesh.cells) :])
    assert added.min() > 0.0
    assert added.sum() == pytest.approx(area * extend.LENGTH, rel=1e-9)


def test_facets_of_the_continuation_point_out_of_the_soft_tissue(
    pair: tuple[FingerMesh, FingerMesh],
) -> None:
    _, longer = pair
    soft = volumes(longer.points, longer.cells[longer.region != 3]).sum()
    assert enclosed(longer, "pad", "nail", "cut", "bone") == pytest.approx(soft, rel=1e-9)


def test_smooth_normals_go_on_behind_the_cut(pair: tuple[FingerMesh, FingerMesh]) -> None:
    mesh, longer = pair
    new = np.setdiff1d(np.unique(longer.facets["pad"]), np.arange(len(mesh.points)))
    normals = longer.pad_normals
    assert np.linalg.norm(normals[new], axis=1) == pytest.approx(np.ones(len(new)), abs=1e-12)
    medial = new[longer.points[new, 1] == 0.0]
    assert np.all(normals[medial, 1] == 0.0)
    a, b, c = (longer.points[longer.facets["pad"][:, i]] for i in range(3))
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1)[:, None]
    smooth = normals[longer.facets["pad"]].mean(axis=1)
    assert np.einsum("ij,ij->i", flat, smooth).min() > 0.7


def test_the_palm_bends_away_along_an_arc(pair: tuple[FingerMesh, FingerMesh]) -> None:
    """Chords between the lowest vertices of the layers have the slopes of the arc."""
    mesh, longer = pair
    pad = np.unique(longer.facets["pad"])
    x = longer.points[pad, 0]
    # exact: points of one mesh in the other
    low = [
        longer.points[pad[np.isclose(x, each)], 2].min()
        for each in sorted(set(x[x <= mesh.points[:, 0].min()]))
    ]
    slopes = -np.diff(low) * extend.LAYERS / extend.LENGTH
    step = extend.LENGTH / extend.LAYERS / extend.RADIUS
    assert len(slopes) == extend.LAYERS
    assert np.diff(slopes) == pytest.approx(np.full(extend.LAYERS - 1, -step), rel=1e-9)
    assert 0.0 < slopes[-1] < 0.3


def test_no_cell_of_the_continuation_is_flat(pair: tuple[FingerMesh, FingerMesh]) -> None:
    mesh, longer = pair
    angles = dihedral_angles(longer.points, longer.cells[len(mesh.cells) :]).min(axis=1)
    assert angles.min() > 2.0
    assert np.percentile(angles, 5) > 5.0


def test_a_whole_finger_is_continued_as_its_halves(pair: tuple[FingerMesh, FingerMesh]) -> None:
    mesh, longer = pair
    both = volumes(whole(longer).points, whole(longer).cells)
    assert both.sum() == pytest.approx(2.0 * volumes(longer.points, longer.cells).sum())
    with refused("mesh"):
        extend.extended(whole(mesh))


def test_its_source_differs_from_that_of_the_mesh(pair: tuple[FingerMesh, FingerMesh]) -> None:
    mesh, longer = pair
    assert longer.source_sha256 == extend.continuation_source(mesh.source_sha256)
    assert longer.source_sha256 != mesh.source_sha256
    assert longer.fingerprint != mesh.fingerprint
