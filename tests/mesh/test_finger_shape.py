"""The parametric fingertip before it is meshed."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.solids import section_volume
from refusals import refused
from scipy.spatial import cKDTree

from fefinger.mesh import shell as surface
from fefinger.mesh.finger_shape import ALONG, PLATE_NORMAL, Shape, fitted_radii
from fefinger.mesh.parametric import parametric, patch_points, radii
from fefinger.mesh.recipe import Recipe
from fefinger.scene.finger import Finger
from fefinger.support.checks import InputError


SUBJECTS = {"d.p.": (12, 9.5, 15), "d.s.": (14, 11.5, 12), "a.h.": (14, 10, 14)}
SUBJECTS["p.w."] = (17, 13, 17)


@pytest.fixture(scope="module", params=SUBJECTS.values(), ids=SUBJECTS)
def recipe(request: pytest.FixtureRequest) -> Recipe:
    """Return the dimensions of each subject of the thesis."""
    return Recipe(*request.param)


@pytest.fixture(scope="module")
def shape(recipe: Recipe) -> Shape:
    """Return each subject's fingertip."""
    return parametric(recipe)


def test_radii_follow_from_width_thickness_and_pad_radius() -> None:
    assert radii(Recipe(14, 10, 14)) == pytest.approx((20.0, 9.8))


def test_radii_fitted_at_first_touch_are_the_wanted_ones(shape: Shape) -> None:
    assert fitted_radii(patch_points(shape.skin)) == pytest.approx(shape.radii, rel=2e-3)


def test_curvatures_at_first_touch_are_near_the_fitted_ones(shape: Shape) -> None:
    # Second differences along the two principal directions: exact curvature, no fit.
    step = 0.05
    for direction, wanted in zip((ALONG, np.array([0.0, 1.0, 0.0])), shape.radii, strict=True):
        points = np.array([-step, 0.0, step])[:, None] * direction
        normals = shape.skin.normals(shape.skin.project(points))
        curvature = (normals[2] - normals[0]) @ direction / (2 * step)
        assert 1 / curvature == pytest.approx(wanted, rel=0.05)


def test_first_touch_of_a_30_degree_plate_is_the_origin(shape: Shape) -> None:
    assert shape.skin.level(np.zeros((1, 3))) == pytest.approx(0.0, abs=1e-6)
    assert shape.skin.normals(np.zeros((1, 3)))[0] == pytest.approx(PLATE_NORMAL, abs=1e-6)
    assert (surface.half(shape.skin, 0.3)[0] @ PLATE_NORMAL).max() < 1e-6


def test_size_is_the_given_one(shape: Shape, recipe: Recipe) -> None:
    x = np.linspace(shape.skin.cut, shape.skin.tip, 2000)
    wide, low, high = shape.skin.heights(x)
    assert 2 * wide.max() == pytest.approx(recipe.width, rel=1e-6)
    assert low.max() + high.max() == pytest.approx(recipe.thickness, rel=1e-6)
    assert 20 <= shape.skin.tip - shape.skin.cut <= 25.1


def test_pad_gets_sharper_towards_the_tip(shape: Shape) -> None:
    x = np.linspace(0.0, shape.skin.tip - 0.3, 400)
    low = shape.skin.heights(x)[1]
    slope = -np.gradient(low, x)
    curvature = np.gradient(np.arctan(slope), x) * np.cos(np.arctan(slope))
    assert np.all(np.diff(curvature[5:-5]) > -2e-3 * curvature[5:-5].max())


def test_skin_is_equally_thick(shape: Shape, recipe: Recipe) -> None:
    points = surface.half(shape.subcutaneous, 0.5)[0]
    points = points[(shape.subcutaneous.level(points) > -0.01) & (points[:, 0] < shape.skin.tip)]
    points = points[points[:, 0] > shape.skin.cut + 1.5]
    outer = surface.half(shape.skin, 0.1)[0]
    outer = outer[np.abs(shape.skin.level(outer)) < 1e-6]
    outer = np.concatenate([outer, outer * [1, -1, 1]])
    distance = cKDTree(outer).query(points)[0]
    # The flat finger of d.p. has an edge along its side that is sharper than its skin is thick.
    assert distance.min() > 0.75 * recipe.skin_thickness
    assert distance.max() < 1.1 * recipe.skin_thickness
    palmar = points[:, 2] < shape.skin.middle - 1.0
    assert distance[palmar].min() > 0.9 * recipe.skin_thickness


def test_shells_are_nested_with_room_for_an_element(shape: Shape) -> None:
    for outer, inner in zip(shape.shells, shape.shells[1:], strict=False):
        points = surface.half(inner, 0.5)[0]
        assert outer.level(points).max() < -0.4


@pytest.mark.parametrize("ahead", [3.8, 6.0, 10.0])
def test_the_bone_ends_where_it_is_told_to_and_stays_inside(recipe: Recipe, ahead: float) -> None:
    shape, plain = parametric(replace(recipe, tip_tissue=ahead)), parametric(recipe)
    assert shape.skin.tip - shape.bone.tip == pytest.approx(ahead, abs=1e-9)
    expected = (plain.skin.tip, plain.skin.cut)
    assert (shape.skin.tip, shape.skin.cut) == pytest.approx(expected, rel=1e-12)
    bone = surface.half(shape.bone, 0.5)[0]
    assert shape.subcutaneous.level(bone).max() < -0.2
    # A longer bone has more volume, taken from the subcutaneous tissue.
    longer = ahead < plain.skin.tip - plain.bone.tip
    assert (shape.volumes["bone"] > plain.volumes["bone"]) == longer
    assert sum(shape.volumes.values()) == pytest.approx(sum(plain.volumes.values()), rel=1e-9)


@pytest.mark.parametrize("radius", [1.8, 2.0, 2.5])
def test_the_tip_has_the_radius_that_is_given(radius: float) -> None:
    finger = Recipe(14, 10, 14, tip_radius=radius)
    shape, plain = parametric(finger), parametric(replace(finger, tip_radius=None))
    # At the tip the palmar depth b of a profile of radius r obeys b^2 = 2 r (tip - x), about.
    slope = float(shape.skin.palmar(shape.skin.tip, 1))
    assert -slope / 2.0 == pytest.approx(radius, rel=1e-3)
    # Behind first touch the pads are the same, within what the fit of their radii leaves.
    behind = np.linspace(-8.0, 0.0, 30)
    palms = [each.skin.middle - each.skin.heights(behind)[1] for each in (shape, plain)]
    assert palms[0] == pytest.approx(palms[1], abs=0.1)
    assert fitted_radii(patch_points(shape.skin)) == pytest.approx(radii(finger), rel=0.01)


@pytest.mark.parametrize(
    ("radius", "message"),
    [
        (1e-9, r"finger\.skin\.thickness: expected less than some 7e-10 mm"),
        (21.0, r"finger\.tip_radius: expected at most 20 mm, the radius of the pad along"),
        (6.0, r"finger\.pad_radius: .*, or a smaller finger\.tip_radius"),
        (0.5, r"finger\.skin\.thickness: expected less than some 0\.35 mm"),
    ],
)
def test_a_tip_that_does_not_fit_the_finger_is_refused(radius: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parametric(Recipe(14, 10, 14, tip_radius=radius))


def test_the_largest_skin_that_a_message_names_is_meshed() -> None:
    child = Recipe.of(Finger(8, 6))
    with refused("finger.skin.thickness"):
        parametric(child)
    parametric(replace(child, skin_thickness=0.92))


def test_a_bone_that_leaves_the_pulp_or_has_no_base_is_refused() -> None:
    finger = Recipe(14, 10, 14)
    with refused("finger.tip_tissue"):
        parametric(replace(finger, tip_tissue=0.3))
    with refused("finger.tip_tissue"):
        parametric(replace(finger, tip_tissue=25.0))


@pytest.mark.parametrize("step", [0.8, 0.4])
def test_half_surfaces_are_closed_and_point_outward(shape: Shape, step: float) -> None:
    for shell in shape.shells:
        points, faces = surface.half(shell, step)
        sides = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        there, back = (np.sort(sides @ [a, b]) for a, b in ((len(points), 1), (1, len(points))))
        assert np.diff(there).min() > 0
        assert np.array_equal(there, back)
        exact = section_volume(shell)
        assert surface.volume((points, faces)) == pytest.approx(exact, rel=0.02)


def test_projection_lands_on_the_surface_and_keeps_what_is_held(shape: Shape) -> None:
    random = np.random.default_rng(3)
    points = surface.half(shape.skin, 1.0)[0]
    points = points[np.abs(shape.skin.level(points)) < 1e-6]
    moved = points + random.uniform(-0.1, 0.1, points.shape)
    free = np.tile([True, False, True], (len(points), 1))
    there = shape.skin.project(moved)
    held = shape.skin.project(moved, free=free)
    assert np.abs(shape.skin.level(there)).max() < 1e-9
    assert np.array_equal(held[:, 1], moved[:, 1])  # exact: it is not free
    assert np.linalg.norm(there - moved, axis=1).max() < 0.25


def test_nail_is_a_patch_of_the_back(shape: Shape, recipe: Recipe) -> None:
    x, y = shape.nail.edge(200)
    skin = surface.half(shape.skin, 0.2)[0]
    covered = skin[shape.nail.covers(skin) & (np.abs(shape.skin.level(skin)) < 1e-6)]
    assert np.all(covered[:, 2] > shape.skin.middle)
    assert x.min() <= covered[:, 0].min() < covered[:, 0].max() <= x.max()
    assert 10 < np.ptp(x) < 15
    assert y.max() == pytest.approx(0.375 * recipe.width, rel=0.02)


@pytest.mark.parametrize(
    ("sizes", "message"),
    [
        ((14, 10, 30), "pad_radius: expected a pad that rises at most 9.0 mm"),
        ((20, 8, 6), "pad_radius: expected at least 11.0 mm"),
        ((3, 10, 14), "width: expected a finite number in mm at least 5"),
        ((14, float("nan"), 14), "thickness: expected a finite number"),
        ((14.4, 12.0, 15.2, 2.83), "finger.skin.thickness: expected less than some 1.7 mm"),
    ],
)
def test_impossible_fingers_get_a_sentence(sizes: tuple[float, ...], message: str) -> None:
    with pytest.raises(InputError, match=message):
        parametric(Recipe(*sizes))


def test_unknown_resolution_gets_the_nearest_name() -> None:
    with refused("finger.resolution"):
        Recipe(14, 10, 14, resolution="course")
