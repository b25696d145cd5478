"""What the pictures show: mirror images, cuts and indenters."""

import dataclasses

import numpy as np
import pytest

from fefinger.geometry import section
from fefinger.geometry.profiles import Ellipsoid as Ball
from fefinger.geometry.voigt import tensor_from_voigt
from fefinger.result import Result
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Ellipsoid, Flat, Sphere
from fefinger.support.arrays import Array, Integers
from fefinger.view import frames, indenter_pose


def test_the_whole_finger_is_the_half_and_its_mirror_image(synthetic: Result) -> None:
    half = synthetic.fields
    assert half is not None
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
def test_a_cut_has_the_area_of_the_section_and_keeps_linear_fields(
    synthetic: Result, mirrored: bool
) -> None:
    fields = synthetic.fields
    assert fields is not None
    face = fields.cells[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3)
    medial = face[(fields.points[face][:, :, 1] == 0).all(axis=1)]
    if mirrored:
        fields = frames.whole(fields)
    cut = section.cut(fields.points, fields.cells, fields.region)
    places = cut.at(fields.points)
    assert np.abs(places[:, 1]).max() < 1e-3
    assert area(places, cut.triangles) == pytest.approx(area(fields.points, medial), rel=1e-3)
    slope = np.array([0.3, 0.0, -0.7])
    np.testing.assert_allclose(cut.at(fields.points @ slope), places @ slope, atol=1e-9)


def area(points: Array, triangles: Integers) -> float:
    a, b, c = points[triangles].transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


@pytest.mark.parametrize(
    "indenter",
    [Flat(0.0), Flat(30.0), Flat(45.0), Sphere(5.0), Ellipsoid((4.0, 3.0, 6.0))],
)
def test_an_indenter_reaches_its_depth_and_no_farther(
    synthetic: Result, indenter: Indenter
) -> None:
    scene = dataclasses.replace(synthetic.scene, indenter=indenter)
    result = dataclasses.replace(synthetic, scene=scene)
    first, pressed = indenter_pose.pose(result, 0.0), indenter_pose.pose(result, 1.5)
    assert pressed.origin - first.origin == pytest.approx(1.5 * first.axis)
    outline = first.outline(20.0)
    ahead = outline @ first.axis[[0, 2]]
    assert ahead.max() == pytest.approx(first.origin @ first.axis, abs=1e-9)
    assert synthetic.fields is not None
    if indenter.flat is not None:
        clearance = synthetic.fields.points @ first.axis - first.origin @ first.axis
        assert clearance.min() == pytest.approx(0.0, abs=0.2)


def test_a_sphere_beside_the_medial_plane_shows_a_smaller_circle(synthetic: Result) -> None:
    scene = dataclasses.replace(synthetic.scene, indenter=Sphere(5.0, at=(-3.0, 2.0)))
    pose = indenter_pose.pose(dataclasses.replace(synthetic, scene=scene), 0.0)
    outline = pose.outline(20.0)
    center = pose.origin - 5.0 * pose.axis
    radius = np.linalg.norm(outline - center[[0, 2]], axis=1)
    assert radius == pytest.approx(np.sqrt(25 - center[1] ** 2))
    far = pose._replace(origin=pose.origin + np.array([0.0, 20.0, 0.0]))
    assert len(far.outline(20.0)) == 0


def test_a_ball_has_no_place_beside_it() -> None:
    ball = indenter_pose.Pose(np.zeros(3), np.array([0.0, 0.0, 1.0]), Ball((2.0, 2.0, 2.0)))
    places = ball.places(np.array([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]]))
    np.testing.assert_allclose(places[:2, 2], [0.0, np.sqrt(3) - 2])
    assert np.isinf(places[2]).all()
