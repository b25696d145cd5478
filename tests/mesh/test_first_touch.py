"""First touch on the smooth skin, and the curvature there."""

import numpy as np
import pytest

import fefinger as ff
from fefinger.fem.body import solid
from fefinger.geometry.profiles import directions
from fefinger.mechanics.press import placement
from fefinger.mesh.first_touch import _shape, first_touch
from fefinger.mesh.recipe import Recipe
from fefinger.mesh.store import load_or_build
from fefinger.scene.indenter import direction


RECIPE = Recipe.of(ff.Finger.subject("a.h.", tissue="maeno1998"))


def test_the_standard_plate_touches_at_the_origin_with_the_radii_of_the_shape():
    touch = first_touch(RECIPE, direction(ff.Flat(30)))
    assert touch.point == pytest.approx([0, 0, 0], abs=2e-3)
    assert 1 / np.diag(touch.curvature) == pytest.approx(_shape(RECIPE).radii, rel=0.01)


@pytest.mark.parametrize(("angle", "tilt"), [(0, 0), (15, 20), (40, -10), (60, 0)])
def test_the_skin_faces_the_plate_where_it_touches_first(angle, tilt):
    axis = direction(ff.Flat(angle, tilt))
    touch = first_touch(RECIPE, axis)
    assert _shape(RECIPE).skin.normals(touch.point[None])[0] == pytest.approx(-axis, abs=2e-3)
    mirrored = first_touch(RECIPE, direction(ff.Flat(angle, -tilt)))
    assert mirrored.point == pytest.approx(touch.point * [1, -1, 1], abs=1e-3)
    flip = np.array([[1, -1], [-1, 1]])
    assert mirrored.curvature == pytest.approx(touch.curvature * flip, abs=2e-3)


def test_the_plane_of_a_plate_has_distal_and_sideways():
    across = directions(direction(ff.Flat(30)))
    assert across[0] == pytest.approx([np.sqrt(0.75), 0, 0.5])
    assert across[1] == pytest.approx([0, 1, 0])


@pytest.mark.parametrize("resolution", ["coarse", "standard"])
@pytest.mark.parametrize("angle", [5, 15, 33, 45])
def test_a_plate_meets_a_mesh_where_it_meets_the_smooth_skin(angle: float, resolution: str) -> None:
    """On the mesh of another plate; the foremost vertex is up to 1.4 mm away."""
    finger = ff.Finger.subject("a.h.", resolution=resolution, tissue="maeno1998")
    body = solid(load_or_build(finger, half=True, touch=None), (1, 2))
    touch = placement.obstacle(ff.Flat(angle), body)
    expected = first_touch(Recipe.of(finger), touch.axis).point
    assert touch.origin == pytest.approx(expected, abs=0.06)
    assert touch.origin[1] == 0
