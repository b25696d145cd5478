"""The meshes that come with the package: what a mechanics takes for granted about them."""

import numpy as np
import pytest
from fefinger.validation.calibration.report import rows
from oracles.solids import assert_closed, enclosed, section_volume

from fefinger.geometry.finger_mesh import BONE, FingerMesh, faces, volumes
from fefinger.mesh import mesh_record
from fefinger.mesh.finger_shape import PATCH_RADIUS, PLATE_NORMAL, Shape, touch_point
from fefinger.mesh.mesh_record import (
    MIN_DIHEDRAL,
    STRICT,
    dihedral_angles,
    gate,
    measured_radii,
)
from fefinger.mesh.parametric import parametric, radii
from fefinger.mesh.recipe import Recipe, data_folder
from fefinger.support.arrays import Integers


NAMES = sorted(path.stem for path in data_folder().glob("*.vtu"))


@pytest.fixture(scope="module", params=NAMES)
def mesh(request: pytest.FixtureRequest) -> FingerMesh:
    """Return each shipped mesh."""
    return mesh_record.read(data_folder() / f"{request.param}.vtu")


@pytest.fixture(scope="module")
def shape(mesh: FingerMesh) -> Shape:
    """Return the smooth shape that a shipped mesh was made from."""
    return parametric(Recipe(**mesh.recipe))


def test_subjects_have_coarse_and_standard_meshes_and_one_has_a_fine_one() -> None:
    """The mesher is not deterministic: what is measured on them is measured on these."""
    subjects = ("ah", "dp", "ds", "pw")
    wanted = {f"{subject}-{mesh}" for subject in subjects for mesh in ("coarse", "standard")}
    assert wanted | {"ah-fine"} <= set(NAMES)


@pytest.mark.parametrize("subject", ["ah", "dp", "ds", "pw"])
def test_calibrated_fingers_have_the_meshes_they_were_fitted_on(subject: str) -> None:
    report = rows()[f"{subject[0]}.{subject[1]}."]["calibration"]["finger"]
    for mesh in ("coarse", "standard"):
        recipe = mesh_record.read(data_folder() / f"{subject}-calibrated-{mesh}.vtu").recipe
        assert recipe["pad_radius"] == report["pad_radius"]


def test_cells_are_good_and_share_all_vertices_and_faces(mesh: FingerMesh) -> None:
    assert volumes(mesh.points, mesh.cells).min() > 0
    assert dihedral_angles(mesh.points, mesh.cells).min() >= MIN_DIHEDRAL
    gate(mesh.quality)
    assert np.array_equal(np.unique(mesh.cells), np.arange(len(mesh.points)))
    assert_closed(mesh, "bone")


def numbered(triangles: Integers, count: int) -> Integers:
    """Return one number for every triple of vertices (n, 3) among `count`, in its order."""
    assert count**3 < np.iinfo(np.int64).max
    return np.asarray(triangles.astype(np.int64) @ [count**2, count, 1])


def from_least(triangles: Integers) -> Integers:
    """Return the triangles (n, 3) turned so that their least vertex comes first."""
    turns = (triangles.argmin(axis=1)[:, None] + np.arange(3)) % 3
    return np.take_along_axis(triangles, turns, axis=1)


def test_bone_facets_are_the_faces_between_bone_and_soft_tissue(mesh: FingerMesh) -> None:
    def sides(triangles: Integers) -> Integers:
        return numbered(np.sort(triangles.reshape(-1, 3), axis=1), len(mesh.points))

    soft, bone = (sides(faces(mesh.cells[(mesh.region == BONE) == hard])) for hard in (False, True))
    found = sides(mesh.facets["bone"])
    assert len(found) > 0
    assert np.array_equal(np.unique(found), np.intersect1d(soft, bone))


def test_facets_point_out_of_the_soft_tissue_and_close_it(mesh: FingerMesh) -> None:
    soft = mesh.cells[mesh.region != BONE]
    outward = numbered(from_least(faces(soft).reshape(-1, 3)), len(mesh.points))
    for name in ("pad", "nail", "cut", "bone"):
        found = numbered(from_least(mesh.facets[name]), len(mesh.points))
        assert np.isin(found, outward).all(), name
    # Without the soft part of y = 0, where x.n = 0.
    soft = volumes(mesh.points, mesh.cells[mesh.region != BONE]).sum()
    assert enclosed(mesh, "pad", "nail", "cut", "bone") == pytest.approx(soft, rel=1e-9)


def test_regions_pad_and_volumes_are_those_of_the_smooth_shapes(
    mesh: FingerMesh, shape: Shape
) -> None:
    for cells, region in ((mesh.cells[mesh.region == k], k) for k in (1, 2, 3)):
        used = mesh.points[np.unique(cells)]
        inside, outside = shape.shells[region - 1], shape.shells[region:][:1]
        assert inside.level(used).max() < 0.06
        for shell in outside:
            assert shell.level(used).min() > -0.06
    pad = mesh.points[np.unique(mesh.facets["pad"])]
    assert np.abs(shape.skin.level(pad)).max() < 1e-6
    # Independent of the surfaces that the mesher got: sections integrated along the finger.
    inside = [section_volume(shell) for shell in shape.shells]
    own = [inside[0] - inside[1], inside[1] - inside[2], inside[2]]
    volume = volumes(mesh.points, mesh.cells)
    found = [volume[mesh.region == k].sum() for k in (1, 2, 3)]
    assert found == pytest.approx(own, rel=STRICT.volume)


def test_measured_radii_are_those_of_the_design(mesh: FingerMesh) -> None:
    wanted = radii(Recipe(**mesh.recipe))
    assert measured_radii(mesh) == pytest.approx(wanted, rel=STRICT.radius)


def test_planes_and_first_touch_are_exact(mesh: FingerMesh, shape: Shape) -> None:
    medial = np.unique(mesh.facets["medial"])
    assert np.all(mesh.points[medial, 1] == 0.0)
    assert np.all(np.delete(mesh.points[:, 1], medial) > 0.0)
    ends = np.unique(np.concatenate([mesh.facets["cut"], mesh.facets["bone-cut"]]))
    # exact: one plane, as it is stored
    assert np.all(mesh.points[ends, 0] == mesh.points[:, 0].min())
    assert mesh.points[:, 0].min() == pytest.approx(shape.skin.cut)
    pad = mesh.points[np.unique(mesh.facets["pad"])]
    heights = pad @ PLATE_NORMAL
    assert heights.max() == pytest.approx(0.0, abs=1e-6)
    assert np.all(pad[np.argmax(np.isclose(heights, heights.max(), atol=1e-9))] == 0.0)


def test_pad_normals_are_unit_smooth_and_point_outward(mesh: FingerMesh) -> None:
    pad = np.unique(mesh.facets["pad"])
    length = np.linalg.norm(mesh.pad_normals, axis=1)
    assert length[pad] == pytest.approx(np.ones(len(pad)), abs=1e-12)
    assert np.all(np.delete(length, pad) == 0.0)
    origin = pad[np.all(mesh.points[pad] == 0.0, axis=1)]
    assert mesh.pad_normals[origin[0]] == pytest.approx(PLATE_NORMAL, abs=1e-6)
    a, b, c = (mesh.points[mesh.facets["pad"][:, i]] for i in range(3))
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1)[:, None]
    smooth = mesh.pad_normals[mesh.facets["pad"]].mean(axis=1)
    assert np.einsum("ij,ij->i", flat, smooth).min() > 0.7


def test_contact_patch_is_finer_than_the_rest(mesh: FingerMesh, shape: Shape) -> None:
    limit = {"coarse": 1.0, "standard": 0.5, "fine": 0.36}[mesh.recipe["resolution"]]
    touch = mesh.recipe.get("touch")
    if touch is None:
        assert mesh.quality["pad_edge_mean"] < limit
        return
    corners = mesh.points[mesh.facets["pad"]]
    near = np.linalg.norm(corners.mean(axis=1) - touch_point(shape, touch), axis=1) < PATCH_RADIUS
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert edges[near].mean() < limit
    assert edges[near].mean() < 0.7 * edges[~near].mean()


def test_pulp_is_about_half_the_thickness(mesh: FingerMesh) -> None:
    """More in d.s. calibrated, since its plate touches ahead of the end of its bone."""
    most = 0.58 if mesh.name.startswith("ds-calibrated") else 0.5
    assert 0.44 < mesh.quality["pulp_thickness"] / mesh.recipe["thickness"] < most
