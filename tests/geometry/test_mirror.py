"""Mirror images: where points of a whole body are in its half, and wholes made of halves."""

import numpy as np
import pytest

from fefinger.geometry.finger_mesh import (
    TENSOR_SIGNS,
    VOIGT_SIGNS,
    Halves,
    from_half,
    image,
    to_half,
    volumes,
)


RNG = np.random.default_rng(0)
POINTS = np.array([[0, 0, 0], [2, 0, 0], [0, 0, 2], [0, 1, 0], [0.5, 2, 1.5]], dtype=float)
CELLS = np.array([[0, 2, 1, 3], [1, 2, 4, 3]])
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def gradient(points):
    """Return a gradient (n, 3, 3) that is its own mirror image: u_x, u_z even, u_y odd in y."""
    x, y, z = points.T
    rows = [[x, y * z, x * z], [x * y, z**2, y * x], [1 + z, y**3, x + z]]
    return np.moveaxis(np.array([[0.0 * x + c for c in row] for row in rows]), -1, 0)


def six(tensors):
    return np.stack([(tensors[..., i, j] + tensors[..., j, i]) / 2 for i, j in PAIRS], axis=-1)


def test_an_image_of_an_image_is_the_point_itself():
    points = RNG.normal(size=(4, 5, 3))
    mirrored = image(points)
    assert np.array_equal(mirrored[..., 1], -points[..., 1])  # exact: a change of sign
    assert np.array_equal(image(mirrored), points)  # exact: two changes of sign


def test_a_place_in_the_half_is_the_nearer_side_and_rounding_lies_on_the_plane():
    points = np.array([[1.0, -2.0, 3.0], [1.0, 2.0, 3.0], [5.0, -1e-12, 0.0]])
    half = to_half(points)
    assert half.tolist() == [[1, 2, 3], [1, 2, 3], [5, 0, 0]]
    assert points[2, 1] == -1e-12  # the given points stay as they are
    assert len(to_half(np.empty((0, 3)))) == 0


def test_tensors_of_the_half_are_those_of_the_whole_at_the_places_themselves():
    points = RNG.normal(size=(20, 3))
    whole = gradient(points)
    assert from_half(gradient(to_half(points)), points) == pytest.approx(whole)
    in_time = np.stack([whole, 2 * whole])
    halves = np.stack([gradient(to_half(points)), 2 * gradient(to_half(points))])
    assert from_half(halves, points) == pytest.approx(in_time)


def test_the_signs_of_six_components_are_those_of_the_tensor():
    assert np.array_equal(VOIGT_SIGNS, [TENSOR_SIGNS[pair] for pair in PAIRS])


def test_a_whole_shares_the_points_of_the_plane():
    halves = Halves.of(POINTS)
    points = halves.vectors(POINTS)
    assert halves.twin.tolist() == [0, 1, 2, 5, 6]
    assert halves.origin.tolist() == [0, 1, 2, 3, 4, 3, 4]
    assert np.array_equal(points[halves.twin], image(POINTS))
    assert len(np.unique(points, axis=0)) == len(points)
    assert halves.values(np.arange(5.0)).tolist() == [0, 1, 2, 3, 4, 3, 4]


def test_a_whole_has_twice_the_volume_and_its_cells_and_triangles_keep_their_turn():
    halves = Halves.of(POINTS)
    points = halves.vectors(POINTS)
    inside, whole = volumes(POINTS, CELLS), volumes(points, halves.cells(CELLS))
    assert (inside > 0).all()
    assert whole == pytest.approx(np.tile(inside, 2))
    a, b, c = np.moveaxis(points[halves.triangles(np.array([[1, 4, 3]]))], 1, 0)
    normals = np.cross(b - a, c - a)
    assert normals[1] == pytest.approx(image(normals[0]))


def test_fields_of_the_whole_are_those_of_the_half_on_either_side():
    halves, points = Halves.of(POINTS), Halves.of(POINTS).vectors(POINTS)
    shift = np.stack([POINTS, 2 * POINTS])  # a field (n_t, n, 3) that is the place itself
    assert halves.vectors(shift) == pytest.approx(np.stack([points, 2 * points]))
    assert halves.voigt(six(gradient(POINTS))) == pytest.approx(six(gradient(points)))
    pressure = np.stack([POINTS[:, 1] ** 2, POINTS[:, 0]])
    assert np.array_equal(halves.values(pressure, axis=1), [points[:, 1] ** 2, points[:, 0]])


def test_shares_add_up_to_twice_those_of_the_half():
    shares = RNG.uniform(size=5)
    whole = Halves.of(POINTS).shares(shares)
    assert whole.sum() == pytest.approx(2 * shares.sum())
    assert whole[:3] == pytest.approx(2 * shares[:3])
    assert whole[3:5] == pytest.approx(shares[3:])


def test_points_up_to_the_tolerance_count_as_on_the_plane():
    points = np.array([[0, 0.0, 0], [1, 1e-9, 0], [0, 1, 0]])
    assert Halves.of(points).aside.tolist() == [1, 2]
    assert Halves.of(points, tolerance=1e-8).aside.tolist() == [2]
