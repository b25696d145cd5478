"""Signed distances of objects, and rays to them."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.contact.signed_distance import distances, rays
from fefinger.shapes import Shape, packed
from fefinger.support.checks import InputError


SHAPES: dict[str, Shape] = {
    "plane": ff.shapes.Plane(),
    "sphere": ff.shapes.Sphere(3.0),
    "box": ff.shapes.Box(4.0, 6.0, 3.0, edge=0.4),
    "sharp box": ff.shapes.Box(4.0, 6.0, 3.0, edge=0.0),
    "capsule": ff.shapes.Capsule(2.0, 5.0),
    "cylinder": ff.shapes.Cylinder(2.5, 6.0, edge=0.3),
    "ellipsoid": ff.shapes.Ellipsoid(2.0, 3.0, 4.0),
}
EXACT = [name for name in SHAPES if name != "ellipsoid"]


def places(seed: int, count: int = 200) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-6.0, 6.0, (count, 3))


@cache
def surface_of(name: str) -> np.ndarray:
    """Points of the surface of an object: random ones, walked along the gradient."""
    only, points = packed([SHAPES[name]]), places(7, 6000)
    for _ in range(60):
        found = distances(only, 0, points)
        points -= found[:, :1] * found[:, 1:]
    return points


@pytest.mark.parametrize("name", EXACT)
def test_the_distance_is_that_of_the_nearest_point_of_the_surface(name: str) -> None:
    shape, points = SHAPES[name], places(1, 40)
    nearest = np.array([np.linalg.norm(surface_of(name) - each, axis=1).min() for each in points])
    if name == "plane":  # its surface is sampled on a part of it alone
        nearest = np.abs(points[:, 2])
    assert np.abs(np.abs(shape.distance(points)) - nearest).max() < 0.12
    assert (np.abs(shape.distance(points)) <= nearest + 1e-9).all()


@pytest.mark.parametrize("name", SHAPES)
def test_the_gradient_is_that_of_the_distance_and_of_length_one(name: str) -> None:
    only, h = packed([SHAPES[name]]), 1e-6
    points = surface_of(name)[:100] if name == "ellipsoid" else places(2)
    gradient = distances(only, 0, points)[:, 1:]
    assert np.allclose(np.linalg.norm(gradient, axis=1), 1.0, atol=1e-12)
    ends = [
        [distances(only, 0, points + side * h * e)[:, 0] for side in (1, -1)] for e in np.eye(3)
    ]
    slope = np.array([(high - low) / (2 * h) for high, low in ends]).T
    smooth = np.linalg.norm(slope, axis=1) > 0.999  # elsewhere two parts are equally near
    assert smooth.mean() > 0.9
    assert np.allclose(slope[smooth], gradient[smooth], atol=1e-5)


@pytest.mark.parametrize("name", SHAPES)
def test_inside_is_negative(name: str) -> None:
    assert SHAPES[name].distance([[0.0, 0.0, -0.01]])[0] < 0.0
    assert SHAPES[name].distance([[0.0, 0.0, 20.0]])[0] > 0.0


@pytest.mark.parametrize("name", SHAPES)
def test_a_ray_ends_on_the_surface_where_it_faces_the_skin(name: str) -> None:
    only, rng = packed([SHAPES[name]]), np.random.default_rng(3)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    place, hits, found = np.array([0.5, -1.0, 2.0]), 0, np.empty((1, 4))
    on = surface_of(name)[:200]
    for point, gradient in zip(on, distances(only, 0, on)[:, 1:], strict=True):
        facing = gradient + 0.2 * rng.normal(size=3)
        normal = -turn @ facing / np.linalg.norm(facing)
        start = turn @ (point + 0.3 * rng.uniform(-1, 1) * gradient) + place
        rays(only, 0, turn[None], place[None], start[None], normal[None], 2.0, found)
        far, *seen = found[0]
        if far > 2.0:
            continue
        hits += 1
        local = turn.T @ (start + far * normal - place)
        d, *outward = distances(only, 0, local[None])[0]
        assert abs(d) < (1e-3 if "sharp" in name else 1e-4)  # the last step may cross an edge
        if "sharp" not in name and -np.dot(seen, normal) > 0.3:  # where Newton's method goes on
            assert abs(d) < 1e-6
            assert np.allclose(seen, turn @ outward, atol=1e-3)
        assert -np.dot(seen, normal) > 0.1
    assert hits > 100


def test_a_ray_beside_an_object_or_too_far_from_it_misses() -> None:
    only, turn, place = packed([SHAPES["sphere"]]), np.eye(3)[None], np.zeros((1, 3))
    starts, found = np.array([[0.0, 0.0, 3.5], [3.1, 0.0, 3.5]]), np.empty((2, 4))
    down = np.array([[0.0, 0.0, -1.0]] * 2)
    rays(only, 0, turn, place, starts, down, 1.0, found)
    assert found[:, 0] == pytest.approx([0.5, np.inf])
    rays(only, 0, turn, place, starts, down, 0.4, found)
    assert np.isinf(found[0, 0])


@pytest.mark.parametrize(("pitch", "most"), [(0.5, 0.02), (0.25, 0.005), (0.125, 0.00125)])
def test_sampled_distances_converge_with_the_square_of_the_pitch(pitch: float, most: float) -> None:
    ball = SHAPES["sphere"]
    grid = ff.shapes.function(ball.distance, [-4] * 3, [4] * 3, pitch=pitch)
    on = surface_of("sphere")[:300]
    assert np.abs(grid.distance(on)).max() < 2 * most


def test_beyond_a_grid_the_distance_grows() -> None:
    grid = ff.shapes.function(SHAPES["sphere"].distance, [-4] * 3, [4] * 3, pitch=0.25)
    far = grid.distance([[0.0, 0.0, 9.0]])[0]
    assert far == pytest.approx(6.0, abs=0.05)


@pytest.mark.parametrize(
    "make",
    [
        lambda: ff.shapes.Sphere(0.0),
        lambda: ff.shapes.Box(1.0, 1.0, 1.0, edge=0.6),
        lambda: ff.shapes.Cylinder(1.0, np.nan),
        lambda: ff.shapes.sampled(np.ones((4, 4, 4)), (0, 0, 0), 0.5),
        lambda: ff.shapes.sampled(np.full((4, 4, 4), np.nan), (0, 0, 0), 0.5),
        lambda: ff.shapes.sampled(np.zeros((4, 4)), (0, 0, 0), 0.5),
        lambda: ff.shapes.function(lambda p: 5 * np.ones(len(p)), [-1] * 3, [1] * 3),
        lambda: ff.shapes.function(lambda p: 9 * (p[:, 2] - 0.1), [-1] * 3, [1] * 3),
        lambda: ff.shapes.function(lambda p: p[:3, 2], [-1] * 3, [1] * 3),
        lambda: ff.shapes.function(lambda p: p[:, 2], [1] * 3, [-1] * 3),
        lambda: ff.shapes.function(lambda p: p[:, 2], [-100] * 3, [100] * 3, pitch=0.01),
    ],
)
def test_what_is_no_object_is_refused(make: Callable[[], object]) -> None:
    with pytest.raises(InputError):
        make()


def test_a_surface_from_a_file_is_that_object(tmp_path: Path) -> None:
    import trimesh

    box = trimesh.creation.box((4.0, 6.0, 3.0))
    box.export(tmp_path / "box.stl")
    read, exact = ff.shapes.mesh(tmp_path / "box.stl", pitch=0.2), SHAPES["sharp box"]
    near = surface_of("sharp box")[:200] + 0.1
    assert np.abs(read.distance(near) - exact.distance(near)).max() < 0.12
    inside_out, half = box.copy(), box.copy()
    inside_out.invert()
    half.update_faces(np.arange(12) < 9)
    for name, mesh in {"inside_out": inside_out, "open": half}.items():
        mesh.export(tmp_path / f"{name}.stl")
        with refused("mesh"):
            ff.shapes.mesh(tmp_path / f"{name}.stl")
    (tmp_path / "text.stl").write_text("no surface")
    for name in ("text.stl", "none.stl"):
        with refused("mesh"):
            ff.shapes.mesh(tmp_path / name)
