"""Points among triangles and tetrahedra: the simplex that holds them, and its weights."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from fefinger.geometry.finger_mesh import around, barycentric, inside_weights, locate


RNG = np.random.default_rng(2)


@pytest.mark.parametrize("dimension", [2, 3])
def test_weights_give_the_point_back_and_sum_to_one(dimension):
    corners = RNG.normal(size=(7, dimension + 1, dimension))
    points = RNG.normal(size=(7, dimension))
    weights = barycentric(corners, points)
    assert weights.sum(axis=1) == pytest.approx(1.0)
    assert np.einsum("nk,nkd->nd", weights, corners) == pytest.approx(points)
    assert barycentric(corners[:1], corners[0, 1:2])[0] == pytest.approx(
        np.eye(dimension + 1)[1], abs=1e-9
    )


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("nearest", [None, 30])
def test_a_point_is_in_the_simplex_that_is_found(dimension, nearest):
    random = np.random.default_rng(4)  # some draws have a simplex that reaches beyond 30 centers
    mesh = Delaunay(random.uniform(size=(200, dimension)))
    corners, places = mesh.points[mesh.simplices], random.uniform(0.2, 0.8, size=(40, dimension))
    simplex, weights = locate(corners, places, nearest=nearest)
    assert np.array_equal(simplex, mesh.find_simplex(places))
    assert weights.min() >= -1e-12
    assert np.einsum("nk,nkd->nd", weights, corners[simplex]) == pytest.approx(places)


@pytest.mark.parametrize("dimension", [2, 3])
def test_every_simplex_that_holds_a_point_is_around_it(dimension):
    mesh = Delaunay(RNG.uniform(size=(100, dimension)))
    corners = mesh.points[mesh.simplices]
    places = np.concatenate([RNG.uniform(0.2, 0.8, size=(20, dimension)), mesh.points[:5]])
    for place, (near, weights) in zip(places, around(corners, places, margin=1e-6), strict=True):
        holds = np.flatnonzero(barycentric(corners, place).min(axis=1) >= -1e-9)
        assert np.array_equal(near[weights.min(axis=1) >= -1e-9], holds)
        assert len(near) < len(corners)


def test_a_point_outside_gets_the_simplex_that_comes_closest_and_a_weight_below_none():
    corners = np.array([[[0, 0], [1, 0], [0, 1]], [[5, 5], [6, 5], [5, 6]]], dtype=float)
    (simplex, beyond), weights = locate(corners, np.array([[-0.1, 0.2], [5.1, 4.8]]))
    assert (simplex, beyond) == (0, 1)
    assert weights.min(axis=1) == pytest.approx([-0.1, -0.2])


def test_weights_inside_are_those_of_a_place_of_the_simplex():
    corners = np.array([[[0, 0], [1, 0], [0, 1]], [[5, 5], [6, 5], [5, 6]]], dtype=float)
    simplex, weights = inside_weights(corners, np.array([[0.25, 0.5], [-0.1, 0.2]]))
    assert np.array_equal(simplex, [0, 0])
    assert weights == pytest.approx(np.array([[0.25, 0.25, 0.5], [9 / 11, 0, 2 / 11]]))


def test_a_flat_simplex_holds_nothing_and_does_no_harm():
    corners = np.array([[[0, 0], [1, 1], [2, 2]], [[0, 0], [1, 0], [0, 1]]], dtype=float)
    (simplex,), (weights,) = locate(corners, np.array([[0.25, 0.25]]))
    assert simplex == 1
    assert weights == pytest.approx([0.5, 0.25, 0.25])


def test_one_simplex_alone_is_that_of_all_points():
    corners = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]], dtype=float)
    simplex, weights = locate(corners, np.full((2, 3), 0.1), nearest=24)
    assert simplex.tolist() == [0, 0]
    assert weights[1] == pytest.approx([0.7, 0.1, 0.1, 0.1])
