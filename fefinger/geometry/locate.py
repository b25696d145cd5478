"""Point location among triangles of a plane or tetrahedra: the simplex and its weights."""

from collections.abc import Iterator

import numpy as np

from fefinger.support.arrays import Array, Integers


def barycentric(corners: Array, points: Array) -> Array:
    """Return the weights (..., d + 1) of simplex corners (..., d + 1, d) that give points (..., d).

    They sum to 1 and are 0 or more inside. A simplex without a volume has none: -inf.
    """
    first = corners[..., 0, :]
    sides = np.swapaxes(corners[..., 1:, :] - first[..., None, :], -1, -2)
    volume = np.linalg.det(sides)
    flat = volume == 0.0
    sides = np.where(flat[..., None, None], np.eye(sides.shape[-1]), sides)
    others = np.linalg.solve(sides, (points - first)[..., None])[..., 0]
    weights = np.concatenate([1 - others.sum(axis=-1, keepdims=True), others], axis=-1)
    return np.where(flat[..., None], -np.inf, weights)


def around(
    corners: Array, points: Array, *, margin: float = 0.0
) -> Iterator[tuple[Integers, Array]]:
    """Yield, for each of the points (n, d), the simplices (k,) near it and its weights (k, d + 1).

    A simplex (of m with corners (m, d + 1, d)) is near, and may hold the point, if the point lies
    in the sphere about its center, enlarged by the share `margin`.
    """
    centers = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centers[:, None], axis=2).max(axis=1)
    reach = ((1 + margin) * radii) ** 2
    for point in points:
        apart = centers - point
        near = np.flatnonzero(np.einsum("ij,ij->i", apart, apart) <= reach)
        yield near, barycentric(corners[near], point)


def locate(corners: Array, points: Array, *, nearest: int | None = None) -> tuple[Integers, Array]:
    """Return the simplex (n,) that holds each of the points (n, d), or comes closest, and weights.

    corners (m, d + 1, d); the weights (n, d + 1) of its corners have one below 0 for a point that
    none holds. `nearest`: only so many simplices are looked at, those with the nearest centers.
    """
    count = min(nearest or len(corners), len(corners))
    near = np.broadcast_to(np.arange(count), (len(points), count))
    if count < len(corners):
        from scipy.spatial import cKDTree

        near = cKDTree(corners.mean(axis=1)).query(points, np.arange(1, count + 1))[1]
    weights = barycentric(corners[near], points[:, None])
    best = np.argmax(weights.min(axis=-1), axis=1)
    rows = np.arange(len(points))
    return near[rows, best], weights[rows, best]


def inside_weights(corners: Array, points: Array) -> tuple[Integers, Array]:
    """Return the simplex (n,) of each of the points (n, d), as `locate`, with weights of 0 or more.

    A point that no simplex holds gets weights in the simplex that comes closest.
    """
    simplex, weights = locate(corners, points, nearest=24)
    weights = np.maximum(weights, 0.0)
    return simplex, weights / weights.sum(axis=1, keepdims=True)
