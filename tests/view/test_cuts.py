"""What pictures show: mirror images, the finger in closed pieces, cuts and indenters."""

import dataclasses

import numpy as np
import pytest

from fefinger.geometry.profiles import Ellipsoid as Ball
from fefinger.scene.indenters import Ellipsoid, Flat, Sphere
from fefinger.support.tensors import tensor_from_voigt
from fefinger.view import frames, surfaces


def test_the_whole_finger_is_the_half_and_its_mirror_image(synthetic):
    half = synthetic.fields
    both = frames.whole(half)
    on_plane = int((half.points[:, 1] == 0).sum())
    assert len(both.points) == 2 * len(half.points) - on_plane
    assert frames.whole(both) is both
    # The made-up displacement is a closed form, so the mirrored strain has one too.
    u = both.displacement[1]
    gradient = -2 * u[:, :, None] * both.points[:, None, :] / 25
    expected = (gradient + gradient.transpose(0, 2, 1)) / 2
    np.testing.assert_allclose(tensor_from_voigt(both.strain[1]), expected, atol=1e-12)
    a, b, c, d = both.points[both.cells].transpose(1, 0, 2)
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) > 0).all()


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_cut_has_the_area_of_the_section_and_keeps_linear_fields(synthetic, mirrored):
    fields = synthetic.fields
    face = fields.cells[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3)
    medial = face[(fields.points[face][:, :, 1] == 0).all(axis=1)]
    if mirrored:
        fields = frames.whole(fields)
    cut = frames.cut(fields.points, fields.cells, fields.region)
    places = cut.at(fields.points)
    assert np.abs(places[:, 1]).max() < 1e-3
    assert area(places, cut.triangles) == pytest.approx(area(fields.points, medial), rel=1e-3)
    slope = np.array([0.3, 0.0, -0.7])
    np.testing.assert_allclose(cut.at(fields.points @ slope), places @ slope, atol=1e-9)


def area(points, triangles):
    a, b, c = points[triangles].transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


@pytest.mark.parametrize(
    "indenter", [Flat(0.0), Flat(30.0), Flat(45.0), Sphere(5.0), Ellipsoid((4.0, 3.0, 6.0))]
)
def test_an_indenter_reaches_its_depth_and_no_farther(synthetic, indenter):
    scene = dataclasses.replace(synthetic.scene, indenter=indenter)
    result = dataclasses.replace(synthetic, scene=scene)
    first, pressed = frames.pose(result, 0.0), frames.pose(result, 1.5)
    assert pressed.origin - first.origin == pytest.approx(1.5 * first.axis)
    outline = first.outline(20.0)
    ahead = outline @ first.axis[[0, 2]]
    assert ahead.max() == pytest.approx(first.origin @ first.axis, abs=1e-9)
    if indenter.flat is not None:
        clearance = synthetic.fields.points @ first.axis - first.origin @ first.axis
        assert clearance.min() == pytest.approx(0.0, abs=0.2)


def test_a_sphere_beside_the_medial_plane_shows_a_smaller_circle(synthetic):
    scene = dataclasses.replace(synthetic.scene, indenter=Sphere(5.0, at=(-3.0, 2.0)))
    pose = frames.pose(dataclasses.replace(synthetic, scene=scene), 0.0)
    outline = pose.outline(20.0)
    center = pose.origin - 5.0 * pose.axis
    radius = np.linalg.norm(outline - center[[0, 2]], axis=1)
    assert radius == pytest.approx(np.sqrt(25 - center[1] ** 2))
    far = pose._replace(origin=pose.origin + np.array([0.0, 20.0, 0.0]))
    assert len(far.outline(20.0)) == 0


def test_a_ball_has_no_place_beside_it():
    ball = frames.Pose(np.zeros(3), np.array([0.0, 0.0, 1.0]), Ball((2.0, 2.0, 2.0)))
    places = ball.places(np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]]))
    np.testing.assert_allclose(places[:2, 2], [0.0, np.sqrt(3) - 2])
    assert np.isinf(places[2]).all()


@pytest.fixture
def half(synthetic):
    assert synthetic.fields is not None
    return synthetic.fields


@pytest.fixture
def shifted(half):
    """Return a whole finger whose mesh has no points in the medial plane."""
    both = frames.whole(half)
    return dataclasses.replace(both, points=both.points + np.array([0.0, 0.137, 0.0]))


def volume(points, triangles):
    """Volume inside closed outward surfaces, by the divergence theorem."""
    a, b, c = points[triangles].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def cells_volume(fields, region):
    a, b, c, d = fields.points[fields.cells[fields.region == region]].transpose(1, 0, 2)
    return float(np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)).sum() / 6)


def enclosed(fields, *names):
    return sum(
        volume(piece.at(fields.points), piece.triangles)
        for piece in surfaces.cut_open(fields)
        if piece.name in names
    )


def test_the_pieces_of_each_tissue_enclose_its_volume(half):
    names = {piece.name for piece in surfaces.cut_open(half)}
    assert names == {"skin", "pad", "subcutaneous tissue"}
    assert enclosed(half, "skin", "pad") == pytest.approx(cells_volume(half, 1), rel=1e-4)
    assert enclosed(half, "subcutaneous tissue") == pytest.approx(cells_volume(half, 2), rel=1e-4)


def test_a_whole_finger_is_cut_through_its_cells(shifted):
    """The halves on both sides of the cut add up to the volume of the cells."""
    other = dataclasses.replace(shifted, points=shifted.points * [1.0, -1.0, 1.0])
    for names, region in ((("skin", "pad"), 1), (("subcutaneous tissue",), 2)):
        parts = enclosed(shifted, *names), enclosed(other, *names)
        assert min(parts) > 0
        assert sum(parts) == pytest.approx(cells_volume(shifted, region), rel=1e-4)
    for piece in surfaces.cut_open(shifted):
        y = piece.at(shifted.points)[:, 1]
        assert y.min() >= -1e-3
        assert not piece.flat or y.max() <= 1e-3


def test_the_pad_is_the_skin_that_is_ever_touched(half):
    pad = next(piece for piece in surfaces.cut_open(half) if piece.name == "pad")
    touched = pad.at(half.pressure.max(axis=0))[pad.triangles].max(axis=1)
    assert (touched > 0).all()
    skin = next(piece for piece in surfaces.cut_open(half) if piece.name == "skin")
    assert (skin.at(half.pressure.max(axis=0))[skin.triangles].max(axis=1) == 0).any()


def test_the_entire_finger_encloses_all_of_it(half):
    both = frames.whole(half)
    (skin,) = surfaces.entire(both)
    expected = 2 * (cells_volume(half, 1) + cells_volume(half, 2))
    assert volume(skin.at(both.points), skin.triangles) == pytest.approx(expected)


def test_outlines_lie_on_the_cut(half):
    lines = surfaces.outlines(half)
    assert lines.triangles.shape[1] == 2
    assert np.abs(lines.at(half.points)[:, 1]).max() < 1e-3


def test_points_follow_a_linear_displacement_exactly_on_both_sides(half):
    rng = np.random.default_rng(5)
    slope = rng.normal(size=(3, 3)) * [1.0, 0.0, 1.0]
    slope[:, 1] = [0.0, 0.3, 0.0]  # no displacement across the plane of symmetry
    corners = half.points[half.cells[rng.integers(len(half.cells), size=20)]]
    inside = np.einsum("nk,nkj->nj", rng.dirichlet(np.ones(4), 20), corners)
    mirrored = inside * [1.0, -1.0, 1.0]
    followed = surfaces.follow(half, np.concatenate([inside, mirrored]))
    moved = followed.moved(half.points @ slope)
    expected = inside + inside @ slope
    np.testing.assert_allclose(moved[:20], expected, atol=1e-9)
    np.testing.assert_allclose(moved[20:], expected * [1.0, -1.0, 1.0], atol=1e-9)
