"""Recovered strain at points: gradient of a cubic fitted to the nodal displacements nearby.

The strain of quadratic elements jumps between cells and is of second order. A cubic polynomial,
fitted by least squares to the nodal displacements of the cells around a point, has a gradient of
third order there (Zhang and Naga, SIAM J. Sci. Comput. 26:1192, 2005). Only cells of the tissue
that the point lies in are used, as strain jumps between tissues; where they are too few for a
cubic, the gradient of the elements is used.
"""

from collections.abc import Sequence
from itertools import product

import numpy as np
from scipy import sparse

from fefinger.fem.elements.assembly import scattered
from fefinger.fem.elements.probe import gradient_at, locate, symmetric_part
from fefinger.fem.elements.spaces import Space
from fefinger.support.arrays import Array, Integers


POWERS = np.array([p for p in product(range(4), repeat=3) if sum(p) <= 3])
"""Exponents (20, 3) of the monomials of a cubic."""

SLOPES = [int(np.flatnonzero((unit == POWERS).all(axis=1))[0]) for unit in np.eye(3, dtype=int)]
"""Indices of x, y and z among the monomials."""

PLENTY = 3  # nodes of a fit per monomial
FADE = 1.5  # the weight is exp(-FADE (r / R)²), R the radius that encloses PLENTY of nodes


def recovered_strain_at(
    space: Space, points: Array, planes: Sequence[int] = ()
) -> sparse.csr_matrix:
    """Return the operator (6 n_points, n_unknowns) from unknowns to the strain at `points`.

    `planes` are the axes across whose coordinate plane the body goes on as its mirror image.

    Raises InputError if a point (n_points, 3) mm lies outside the body.
    """
    return symmetric_part(len(points)) @ recovered_gradient_at(space, points, planes)


def recovered_gradient_at(
    space: Space, points: Array, planes: Sequence[int] = ()
) -> sparse.csr_matrix:
    """Return the operator (9 n_points, n_unknowns) to du_i/dX_j at `points`, i before j.

    `planes` and errors as in `recovered_strain_at`.
    """
    if len(points) == 0:
        return sparse.csr_matrix((0, space.n_unknowns))
    owner, cells, _ = locate(space, points)
    around = _Around(space, planes)
    blocks = [_rows(around, point, cells[owner == k]) for k, point in enumerate(points)]
    return sparse.vstack(blocks, format="csr")


class _Around:
    """Adjacency of the cells of a body and of its mirror images.

    A cell, vertex or node has one number per image; on a mirror plane the images are one.
    """

    def __init__(self, space: Space, planes: Sequence[int]) -> None:
        self.space, self.planes = space, planes
        self.signs = np.ones((1, 3))
        for axis in planes:
            flip = np.where(np.arange(3) == axis, -1.0, 1.0)
            self.signs = np.concatenate([self.signs, self.signs * flip])
        self.vertices = self._images(space.vertices, space.points)
        self.nodes = self._images(space.nodes, space.node_points)
        self.tissue = np.tile(space.tissue, len(self.signs))
        cells = np.repeat(np.arange(len(self.vertices)), self.vertices.shape[1])
        shape = (len(space.points) * len(self.signs), len(self.vertices))
        entries = (np.ones(len(cells)), (self.vertices.ravel(), cells))
        self._touching = sparse.csr_matrix(entries, shape)

    def _images(self, members: Integers, points: Array) -> Integers:
        """Assign numbers (n_cells, k) to the members of the cells of all images, image by image."""
        numbered = []
        for image, signs in enumerate(self.signs):
            images = np.full(len(points), image)
            # A point whose coordinates are 0 where the signs differ is its own image.
            for lower in range(image):
                same = (points[:, signs != self.signs[lower]] == 0).all(axis=1) & (images == image)
                images[same] = lower
            numbered.append(images[members] * len(points) + members)
        return np.concatenate(numbered)

    def hosts(self, point: Array, cells: Integers) -> Integers:
        """Cells of one tissue that contain a point; on a mirror plane, their images too."""
        same = cells[self.tissue[cells] == self.tissue[cells[0]]]
        images = np.flatnonzero((point * self.signs == point).all(axis=1))
        return (images[:, None] * len(self.space.vertices) + same).ravel()

    def grown(self, cells: Integers) -> Integers:
        """Extend cells by one ring: all cells of the same tissue that share a vertex with them."""
        ring = np.unique(self._touching[np.unique(self.vertices[cells])].indices)
        return ring[self.tissue[ring] == self.tissue[cells[0]]]

    def places(self, cells: Integers) -> tuple[Integers, Array, Array]:
        """Nodes (n,) of cells, positions (n, 3) mm of them or of their images, and signs (n, 3)."""
        images, nodes = np.divmod(np.unique(self.nodes[cells]), len(self.space.node_points))
        signs = self.signs[images]
        return nodes, self.space.node_points[nodes] * signs, signs


def _rows(around: _Around, point: Array, host: Integers) -> sparse.csr_matrix:
    """Rows (9, n_unknowns) of one point, from the fewest rings of cells that determine the fit."""
    space, cells = around.space, around.hosts(point, host)
    rings = 4  # largest number of rings of cells around the point
    for _ in range(rings):
        cells = around.grown(cells)
        nodes, places, signs = around.places(cells)
        slopes = _slopes(places - point)
        if slopes is not None:
            values = slopes[None] * signs.T[:, None]  # (i, j, n): du_i / dX_j
            rows, columns = np.arange(9).reshape(3, 3, 1), 3 * nodes + np.arange(3)[:, None, None]
            return scattered(values, rows, columns, (9, space.n_unknowns)).tocsr()
    return gradient_at(space, point[None], around.planes)


def _slopes(offsets: Array) -> Array | None:
    """Weights (3, n) of values at the offsets (n, 3) in the gradient; None if undetermined."""
    enough = PLENTY * len(POWERS)
    distance = np.linalg.norm(offsets, axis=1)
    if len(distance) < len(POWERS):
        return None
    reach = np.partition(distance, min(enough, len(distance)) - 1)[min(enough, len(distance)) - 1]
    near = distance < 3 * reach
    weights = np.zeros(len(distance))
    weights[near] = np.exp(-FADE * (distance[near] / reach) ** 2)
    x, y, z = (offsets / reach).T[:, :, None] ** np.arange(4)
    monomials = x[:, POWERS[:, 0]] * y[:, POWERS[:, 1]] * z[:, POWERS[:, 2]] * weights[:, None]
    left, size, right = np.linalg.svd(monomials, full_matrices=False)
    rank = 1e-6  # least ratio of the singular values of a fit
    if size[-1] < rank * size[0]:
        return None
    return np.asarray((right.T[SLOPES] / size) @ left.T * weights / reach)
