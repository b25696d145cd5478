"""The morph of a shipped mesh: exact where the answer is known, as good as a mesh made anew."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.solids import section_volume
from scipy.spatial import cKDTree

from fefinger.geometry.finger_mesh import BONE, FingerMesh, volumes
from fefinger.mesh import build, mesh_record, morph, smooth
from fefinger.mesh import shell as surface
from fefinger.mesh.finger_shape import Shape
from fefinger.mesh.mesh_record import MIN_DIHEDRAL, dihedral_angles
from fefinger.mesh.parametric import parametric
from fefinger.mesh.recipe import Recipe, data_folder, has_template, shipped_path
from fefinger.mesh.smooth import supports
from fefinger.mesh.store import load_or_build
from fefinger.support.checks import ConvergenceError


TEMPLATES = ("ah-coarse", "ah-at-0-coarse", "pw-standard")
NEW = {
    "wide": Recipe(15.3, 11.2, 15.6, resolution="coarse"),
    "narrow": Recipe(12.7, 9.7, 13.4, skin_thickness=0.8, resolution="coarse"),
    "thick skin": Recipe(16.4, 12.7, 17.5, skin_thickness=1.3, resolution="coarse"),
    "long bone": Recipe(14.0, 10.0, 17.14, resolution="coarse", tip_tissue=3.8),
    "round tip": Recipe(14.0, 10.0, 14.0, resolution="coarse", tip_tissue=6.0, tip_radius=2.5),
    "along a plate": Recipe(13.2, 10.1, 14.0, resolution="coarse", touch=0.0),
}


def shipped(name: str) -> tuple[FingerMesh, Shape]:
    mesh = mesh_record.read(data_folder() / f"{name}.vtu")
    return mesh, parametric(Recipe(**mesh.recipe))


@pytest.fixture(scope="module", params=[*NEW][1:])
def new(request: pytest.FixtureRequest) -> tuple[FingerMesh, Shape]:
    """Return the mesh of a finger that is not shipped, and its smooth shape."""
    recipe = NEW[request.param]
    assert shipped_path(recipe) is None
    return build.build(recipe), parametric(recipe)


@pytest.mark.parametrize("name", TEMPLATES)
def test_the_template_comes_back_for_its_own_recipe(name: str) -> None:
    mesh, shape = shipped(name)
    same = morph.finished(morph.draft(mesh, shape, shape), shape, Recipe(**mesh.recipe))
    assert same.points == pytest.approx(mesh.points, abs=1e-7)  # projections stop there
    assert np.array_equal(same.cells, mesh.cells)
    assert same.pad_normals == pytest.approx(mesh.pad_normals, abs=1e-7)


def test_the_extension_of_an_affine_map_is_affine() -> None:
    mesh, shape = shipped("ah-coarse")
    moves = mesh.points * [0.2, -0.1, 0.3] + [1.0, 0.0, -2.0]
    held = supports(shape, len(mesh.points), morph._facets(mesh))
    fixed = ~held.free | (held.surface >= 0)[:, None]
    inside = np.flatnonzero(~fixed.any(axis=1))
    assert len(inside) > 50
    given = np.where(fixed, moves, np.nan)
    assert morph.extension(mesh.points, mesh.cells, given, fixed) == pytest.approx(moves, abs=1e-9)


def test_an_ellipsoidal_map_of_a_shell_is_exact() -> None:
    """Profiles stretched by three factors: every point of the shell moves by these factors."""
    mesh, shape = shipped("ah-coarse")
    a, b, c = factors = np.array([1.15, 0.9, 1.2])
    shell = shape.skin
    spline = type(shell.palmar)
    knots = shell.palmar.x

    def stretched(squares, factor):
        return spline(a * knots, factor * squares(knots))

    other = replace(
        shell,
        cut=a * shell.cut,
        tip=a * shell.tip,
        middle=c * shell.middle,
        palmar=stretched(shell.palmar, c**2),
        dorsal=stretched(shell.dorsal, c**2),
        palmar_ratio=stretched(shell.palmar_ratio, (c / b) ** 2),
        dorsal_ratio=stretched(shell.dorsal_ratio, (c / b) ** 2),
    )
    pad = mesh.points[np.unique(mesh.facets["pad"])]
    there = morph.mapped(pad, shell, other, lambda x, _: a * x)
    assert there == pytest.approx(factors * pad, abs=1e-6)


def test_a_new_finger_is_a_morph(new: tuple[FingerMesh, Shape]) -> None:
    mesh, _ = new
    assert mesh.quality["template"] in {path.stem for path in data_folder().glob("*.vtu")}


def test_a_morph_is_the_same_each_time() -> None:
    one, other = (build.build(NEW["along a plate"]).fingerprint for _ in range(2))
    assert one == other


def test_a_new_finger_has_the_smooth_surfaces_and_layers_asked(
    new: tuple[FingerMesh, Shape],
) -> None:
    mesh, shape = new
    pad = mesh.points[np.unique(np.concatenate([mesh.facets["pad"], mesh.facets["nail"]]))]
    assert np.abs(shape.skin.level(pad)).max() < 1e-6
    layer = mesh.points[np.unique(morph._facets(mesh)["skin-subcutaneous"])]
    assert np.abs(shape.subcutaneous.level(layer)).max() < 1e-6
    bone = mesh.points[np.unique(mesh.facets["bone"])]
    assert np.abs(shape.bone.level(bone)).max() < 0.12  # offset, for the volume


def test_a_new_finger_has_the_skin_thickness_under_the_pad(new: tuple[FingerMesh, Shape]) -> None:
    """Measured from the vertices of the interface to the nearest of the points of the skin."""
    mesh, shape = new
    layer = mesh.points[np.unique(morph._facets(mesh)["skin-subcutaneous"])]
    near = layer[np.linalg.norm(layer, axis=1) < 2.5]
    assert len(near) > 5
    skin = surface.half(shape.skin, 0.08)[0]
    thickness = cKDTree(skin).query(near)[0]
    assert thickness == pytest.approx(mesh.recipe["skin_thickness"], rel=0.02)


def test_volumes_of_a_new_finger_are_those_of_sections_integrated_along_it(
    new: tuple[FingerMesh, Shape],
) -> None:
    mesh, shape = new
    inside = [section_volume(shell) for shell in shape.sections]
    expected = [inside[0] - inside[1], inside[1] - inside[2], inside[2]]
    volume = volumes(mesh.points, mesh.cells)
    found = [volume[mesh.region == k].sum() for k in (1, 2, BONE)]
    assert found == pytest.approx(expected, rel=0.02)


def test_cells_of_a_new_finger_are_as_good_as_a_made_mesh(new: tuple[FingerMesh, Shape]) -> None:
    mesh, _ = new
    assert volumes(mesh.points, mesh.cells).min() > 0
    assert dihedral_angles(mesh.points, mesh.cells).min() > MIN_DIHEDRAL
    medial = np.unique(mesh.facets["medial"])
    assert np.all(mesh.points[medial, 1] == 0.0)
    assert np.sum(np.all(mesh.points == 0.0, axis=1)) == 1


def test_the_nail_of_a_new_finger_has_the_size_of_its_outline(
    new: tuple[FingerMesh, Shape],
) -> None:
    mesh, shape = new
    x, y = shape.nail.edge(400)
    nail = mesh.points[np.unique(mesh.facets["nail"])]
    facet = np.sqrt(mesh.quality["nail_area"] / len(mesh.facets["nail"]))
    assert nail[:, 0].min() == pytest.approx(x.min(), abs=facet / 2)
    assert nail[:, 0].max() == pytest.approx(x.max(), abs=facet / 2)
    assert nail[:, 1].max() == pytest.approx(y.max(), abs=facet / 2)


def test_a_template_that_would_be_too_coarse_is_refused() -> None:
    mesh, shape = shipped("ah-coarse")
    wide = Recipe(19, 14, 19, resolution="coarse")
    made = morph.draft(mesh, shape, parametric(wide))
    with pytest.raises(ConvergenceError, match="ah-coarse would be stretched 1"):
        morph.finished(made, parametric(wide), wide)


def test_a_shipped_mesh_is_no_morph() -> None:
    """Evidence was measured on them: their files are used as they are."""
    mesh, _ = shipped("ah-coarse")
    assert load_or_build(Recipe(**mesh.recipe), half=True).fingerprint == mesh.fingerprint


def test_the_mesher_takes_over_where_no_template_is_near(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def attempt(*arguments: object, **_: object) -> FingerMesh:
        calls.append(arguments)
        return shipped("ah-coarse")[0]

    monkeypatch.setattr(build, "_attempt", attempt)
    build.build(
        Recipe(14, 10, 14, resolution="coarse", touch=(4.0, 2.0))
    )  # no template is fine there
    build.build(Recipe(30, 22, 30, resolution="coarse"))
    assert len(calls) == 2


def test_smoothing_leaves_a_mesh_that_is_good_enough_alone() -> None:
    mesh, shape = shipped("ah-coarse")
    held = supports(shape, len(mesh.points), morph._facets(mesh))
    least = morph._wanted(mesh)
    moved = smooth.improve(mesh.points, mesh.cells, held, wanted=least, pinned=np.array([], int))
    assert np.array_equal(moved, mesh.points)  # exact: left as they were


@pytest.mark.parametrize(
    ("recipe", "expected"),
    [
        *((recipe, True) for recipe in NEW.values()),
        (Recipe(10, 11, 10, resolution="coarse"), True),
        (Recipe(10, 12.5, 10, resolution="coarse"), False),
        (Recipe(14, 19.6, 14), False),
        (Recipe(25, 19, 25), False),
        (Recipe(14.2, 10.1, 14.0, touch=(4.0, 2.0)), False),
        (Recipe(14.2, 10.1, 14.0, touch=75.0), False),
        (Recipe(17, 13, 17, resolution="fine"), False),
    ],
)
def test_whether_a_morph_is_expected_follows_from_size_and_touch(
    recipe: Recipe, expected: bool
) -> None:
    assert has_template(recipe) is expected
