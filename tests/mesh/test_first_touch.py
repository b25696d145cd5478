"""First touch on the smooth skin, and the curvature there."""

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.fem.body import solid
from fefinger.geometry.profiles import directions, frame
from fefinger.mechanics.press import placement
from fefinger.mesh.extend import _shape, first_touch
from fefinger.mesh.finger_shape import palm
from fefinger.mesh.recipe import Recipe
from fefinger.mesh.store import load_or_build, mesh_problem
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


@pytest.mark.parametrize(
    "pressed",
    [ff.Pin(6, at=(0, 8)), ff.Sphere(10, at=(-2, -9)), ff.Bar(6, 1, roll=90, at=(0, 8))],
    ids=lambda each: each.kind,
)
def test_an_object_beside_the_pad_touches_what_it_covers_of_it(pressed: ff.Indenter) -> None:
    """It moves along z; where, is found on a grid of the smooth skin."""
    finger = ff.Finger.subject("a.h.", resolution="standard", tissue="maeno1998")
    body = solid(load_or_build(finger, half=False, touch=None), (1, 2))
    touch = placement.obstacle(pressed, body)
    x, y = np.meshgrid(np.linspace(-12, 4, 81), np.linspace(-6.5, 6.5, 66))
    skin = palm(_shape(RECIPE).skin, x.ravel(), y.ravel())
    turn = frame(np.array([0.0, 0.0, 1.0]), pressed.turn)[:2, :2]
    travel = skin[:, 2] + pressed.profile.rise((skin[:, :2] - pressed.place) @ turn.T)
    assert touch.axis == pytest.approx([0, 0, 1])
    assert touch.origin[:2] == pytest.approx(pressed.place)
    assert touch.origin[2] == pytest.approx(travel.min(), abs=0.06)
    first = skin[np.argmin(travel)]
    assert touch.first_touch[1] == pytest.approx(first[1], abs=0.6)
    assert touch.first_touch[1] * pressed.place[1] > 0


def test_an_object_that_misses_the_pad_is_refused() -> None:
    finger = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
    body = solid(load_or_build(finger, half=True, touch=None), (1, 2))
    with refused("indenter.at"):
        placement.obstacle(ff.Sphere(5, at=(12, 0)), body)


def test_a_place_is_so_near_the_pad_that_its_object_covers_a_part_of_it() -> None:
    finger = ff.Finger.subject("a.h.")
    for place, reach, fits in (
        ((9.0, 0.0), 3, False),
        ((8.0, 0.0), 3, True),
        ((0.0, 8.0), 3, True),
    ):
        reason = mesh_problem(finger, (4.0, 0.0), place, reach)
        assert (reason == "") == fits
    assert "within 8 mm of (0, 0)" in mesh_problem(finger, (4.0, 0.0), (9.0, 0.0), 3)
    # Nothing is looked for where no pad is: 90,000 steps from there took minutes.
    assert mesh_problem(finger, (4.0, 0.0), (0.0, 9e3), np.inf) == ""
    with refused("indenter.at"):
        ff.Scene(finger=finger, indenter=ff.Pin(6, at=(0, 10)), motion=ff.Ramp(10, 1))
    assert ff.Scene(finger=finger, indenter=ff.Bar(6, 1, at=(0, 99)), motion=ff.Ramp(10, 1))
