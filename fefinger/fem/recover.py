"""Strain at points by recovery: the derivative of a cubic fitted to the displacements around.

The strain of quadratic elements jumps between cells and is of second order. A cubic polynomial,
fitted by least squares to the nodal displacements of the cells around a point, has a gradient of
third order there (Zhang and Naga, SIAM J. Sci. Comput. 26:1192, 2005). Only cells of the tissue
that the point lies in are used, as strain jumps between tissues.
"""

from itertools import product

import numpy as np
from scipy import sparse

from fefinger.checks import InputError
from fefinger.fem.probe import VOIGT, locate
from fefinger.fem.spaces import Array, Integers, Space


POWERS = np.array([p for p in product(range(4), repeat=3) if sum(p) <= 3])
"""Exponents (20, 3) of the monomials of a cubic."""

SLOPES = [int(np.flatnonzero((unit == POWERS).all(axis=1))[0]) for unit in np.eye(3, dtype=int)]
"""Which of them are x, y and z."""

RINGS = 4  # of cells around the point, at most
PLENTY = 3  # nodes of a fit for each monomial
FADE = 1.5  # how the weights fade: exp(-FADE) where there are PLENTY of nodes
RANK = 1e-6  # smallest singular value of a fit, over the largest


def recovered_strain_at(
    space: Space, points: Array, planes: tuple[int, ...] = ()
) -> sparse.csr_matrix:
    """Return the operator (6 n_points, n_unknowns) from unknowns to the strain at `points`.

    `planes` are the axes across whose coordinate plane the body goes on as its mirror image.

    Raises
    ------
    InputError
        If a point (n_points, 3) mm lies outside the body, or too few cells are around it.
    """
    owner, cells, _ = locate(space, points)
    n_cells, n_local = space.vertices.shape
    entries = (
        np.ones(space.vertices.size),
        (np.arange(n_cells).repeat(n_local), space.vertices.ravel()),
    )
    touching = sparse.csr_matrix(entries, shape=(n_cells, len(space.points)))
    blocks = [
        _rows(space, point, cells[owner == k], touching, planes) for k, point in enumerate(points)
    ]
    return (
        sparse.vstack(blocks, format="csr") if blocks else sparse.csr_matrix((0, space.n_unknowns))
    )


def _rows(
    space: Space,
    point: Array,
    host: Integers,
    touching: sparse.csr_matrix,
    planes: tuple[int, ...],
) -> sparse.csr_matrix:
    """Return the rows (6, n_unknowns) of one point, with as many rings of cells as it takes."""
    own = space.tissue == space.tissue[host[0]]
    inside = np.zeros(len(space.tissue), dtype=bool)
    inside[host] = True
    for _ in range(RINGS):
        inside = (touching @ (touching.T @ inside) > 0) & own
        nodes, offsets, signs = _mirrored(space, np.unique(space.nodes[inside]), point, planes)
        slopes = _slopes(offsets)
        if slopes is not None:
            return _strain(slopes, nodes, signs, space.n_unknowns)
    listed = ", ".join(f"{x:.3g}" for x in point)
    message = (
        f"site ({listed}) mm: expected {len(POWERS)} nodes of one tissue in all directions around "
        f"it, received {len(nodes)}; refine the mesh or take the strain of its cell"
    )
    raise InputError(message)


def _mirrored(
    space: Space, nodes: Integers, point: Array, planes: tuple[int, ...]
) -> tuple[Integers, Array, Array]:
    """Return the nodes (n,) with their images, where they are seen from the point, and signs."""
    places, signs = space.node_points[nodes], np.ones((len(nodes), 3))
    for axis in planes:
        off = places[:, axis] != 0
        flip = np.where(np.arange(3) == axis, -1.0, 1.0)
        nodes = np.concatenate([nodes, nodes[off]])
        places = np.concatenate([places, places[off] * flip])
        signs = np.concatenate([signs, signs[off] * flip])
    return nodes, places - point, signs


def _slopes(offsets: Array) -> Array | None:
    """Return what takes values at the offsets (n, 3) to their gradient (3, n), None if unknown."""
    enough = PLENTY * len(POWERS)
    distance = np.linalg.norm(offsets, axis=1)
    if len(distance) < len(POWERS):
        return None
    reach = np.partition(distance, min(enough, len(distance)) - 1)[min(enough, len(distance)) - 1]
    near = distance < 3 * reach
    weights = np.zeros(len(distance))
    weights[near] = np.exp(-FADE * (distance[near] / reach) ** 2)
    monomials = np.prod((offsets / reach)[:, None, :] ** POWERS, axis=2) * weights[:, None]
    left, size, right = np.linalg.svd(monomials, full_matrices=False)
    if size[-1] < RANK * size[0]:
        return None
    return np.asarray((right.T[SLOPES] / size) @ left.T * weights / reach)


def _strain(slopes: Array, nodes: Integers, signs: Array, count: int) -> sparse.csr_matrix:
    """Return the rows (6, count) of the strain from what gives gradients (3, n) of nodal values."""
    block = np.zeros((6, len(nodes), 3))
    for row, (i, j) in enumerate(VOIGT):
        block[row, :, i] += slopes[j] / 2
        block[row, :, j] += slopes[i] / 2
    columns = 3 * nodes[:, None] + np.arange(3)
    where = (np.arange(6).repeat(columns.size), np.tile(columns.ravel(), 6))
    return sparse.coo_matrix(((block * signs).ravel(), where), shape=(6, count)).tocsr()
