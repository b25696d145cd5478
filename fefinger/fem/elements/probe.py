"""Strain and displacement at points of a body: by the elements, and recovered from their nodes.

The strain of quadratic elements jumps between cells and is of second order. A cubic polynomial,
fitted by least squares to the nodal displacements of the cells around a point, has a gradient of
third order there (Zhang and Naga, SIAM J. Sci. Comput. 26:1192, 2005). Only cells of the tissue
that the point lies in are used, as strain jumps between tissues; where they are too few for a
cubic, the gradient of the elements is used.
"""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
from scipy import sparse

from fefinger.fem.elements.assembly import scattered
from fefinger.fem.elements.spaces import Space
from fefinger.geometry.finger_mesh import around
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import InputError
from fefinger.support.tensors import VOIGT
from fefinger.support.tolerances import INSIDE, SHARED


def symmetric_part(count: int) -> sparse.csr_matrix:
    """Return the operator (6 count, 9 count) from gradients du_i/dX_j to strains."""
    mean = np.zeros((6, 9))
    for row, (i, j) in enumerate(VOIGT):
        mean[row, 3 * i + j] += 0.5
        mean[row, 3 * j + i] += 0.5
    return sparse.kron(sparse.identity(count), mean, format="csr")


def strain_at(space: Space, points: Array, planes: Sequence[int] = ()) -> sparse.csr_matrix:
    """Return the operator (6 n_points, n_unknowns) from unknowns to the strain at `points`.

    A point that several cells share gets their mean, as strain jumps between cells. `planes` are
    the axes across whose coordinate plane the body goes on as its mirror image: a point on one gets
    the mean with its image.

    Raises InputError if a point (n_points, 3) mm lies outside the body.
    """
    return symmetric_part(len(points)) @ gradient_at(space, points, planes)


def gradient_at(space: Space, points: Array, planes: Sequence[int] = ()) -> sparse.csr_matrix:
    """Return the operator (9 n_points, n_unknowns) to du_i/dX_j at `points`, i before j.

    Shared points and mirrors are treated as by `strain_at`, which raises the same error.
    """
    owner, cells, local = locate(space, points)
    mean = _mean(owner, 1.0 / np.bincount(owner)[owner], len(points))
    mirrored = sparse.diags(_mirrored(points, planes).ravel())
    return (mirrored @ mean @ _gradient_rows(space, cells, local)).tocsr()


def _mean(owner: Integers, share: Array, count: int) -> sparse.csr_matrix:
    """Matrix (9 count, 9 n) that adds gradients (n, 3, 3), times a share (n,), at their owners."""
    adding = sparse.csr_matrix((share, (owner, np.arange(len(owner)))), (count, len(owner)))
    return sparse.kron(adding, sparse.identity(9), format="csr")


def _mirrored(points: Array, planes: Sequence[int]) -> Array:
    """Factors (n_points, 3, 3), 1 or 0, of the mean of a point's gradient with its mirror image."""
    factors = np.ones((len(points), 3, 3))
    for axis in planes:
        across = np.arange(3) == axis
        factors[np.ix_(points[:, axis] == 0, across, ~across)] = 0.0
        factors[np.ix_(points[:, axis] == 0, ~across, across)] = 0.0
    return factors


def strain_at_vertices(space: Space) -> sparse.csr_matrix:
    """Return the operator (6 n_points, n_unknowns) to the strain at the vertices.

    The strain jumps between cells (and tissues); a vertex gets the mean of its cells, weighted by
    their volumes. For pictures, not for numbers.
    """
    return symmetric_part(len(space.points)) @ gradient_at_vertices(space)


def gradient_at_vertices(space: Space) -> sparse.csr_matrix:
    """Return the operator (9 n_points, n_unknowns) to du_i/dX_j at the vertices.

    A vertex gets the same mean over its cells as in `strain_at_vertices`.
    """
    count, volumes = len(space.points), space.scalar.dx.sum(axis=1)
    total = np.bincount(space.vertices.ravel(), np.repeat(volumes, 4), count)
    share = volumes[:, None] / total[space.vertices]
    corners = space.shape_gradients(np.eye(4)[:, 1:].T)
    gradients = np.einsum("ec,kjc,ejd->ecdk", share, corners, space.jacobians, optimize=True)
    rows = 3 * space.vertices[:, :, None, None] + np.arange(3)[:, None]
    columns = space.nodes[:, None, None, :]
    slopes = scattered(gradients, rows, columns, (3 * count, space.n_nodes)).tocsr()
    # The same for each component i of the displacement, as rows 9 p + 3 i + j of vertex p.
    i, j = (each.ravel() for each in np.indices((3, 3)))
    rows_of = slopes[(3 * np.arange(count)[:, None] + j).ravel()]
    component = np.repeat(np.tile(i, count), np.diff(rows_of.indptr))
    unknowns = (rows_of.data, 3 * rows_of.indices + component, rows_of.indptr)
    return sparse.csr_matrix(unknowns, shape=(9 * count, space.n_unknowns))


def locate(space: Space, points: Array) -> tuple[Integers, Integers, Array]:
    """Locate points in the mesh: point number, cell and reference coordinates (m, 3).

    Points are numbered in order; a point on a face, edge or vertex has an entry for each cell.

    Raises InputError if a point (n_points, 3) mm lies outside the body.
    """
    owners, cells, local = [], [], []
    for k, (near, weights) in enumerate(_around(space, points)):
        least = weights.min(axis=1)
        if not (least >= -INSIDE).any():
            listed = ", ".join(f"{x:.3g}" for x in points[k])
            raise InputError(
                f"site ({listed}) mm: expected a point in the soft tissue, received one outside; "
                "choose a smaller depth or another place on the pad"
            )
        holding = np.flatnonzero(least >= min(least.max(), -SHARED))
        owners.append(np.full(len(holding), k))
        cells.append(near[holding])
        local.append(weights[holding, 1:])
    if not cells:
        return np.empty(0, np.int64), np.empty(0, np.int64), np.empty((0, 3))
    return np.concatenate(owners), np.concatenate(cells), np.concatenate(local)


def inside(space: Space, points: Array) -> Flags:
    """Whether points (n, 3) mm lie in the body, with the tolerance of `locate`."""
    flags = [(weights.min(axis=1) >= -INSIDE).any() for _, weights in _around(space, points)]
    return np.array(flags, dtype=np.bool_)


def _around(space: Space, points: Array) -> Iterator[tuple[Integers, Array]]:
    """Yield, per point, the cells near it and its barycentric coordinates (m, 4) in each."""
    return around(space.points[space.vertices], points, margin=8 * INSIDE)


def _gradient_rows(space: Space, cells: Integers, local: Array) -> sparse.csr_matrix:
    """Gradient (9 n, n_unknowns) at reference coordinates `local` (n, 3) of `cells` (n,)."""
    reference = space.shape_gradients(local.T)
    gradients = np.einsum("kjp,pjd->pkd", reference, space.jacobians[cells])
    block = np.broadcast_to(gradients.transpose(0, 2, 1)[:, None], (len(cells), 3, 3, 10))
    rows = np.arange(9 * len(cells)).reshape(len(cells), 3, 3, 1)
    unknowns = 3 * space.nodes[cells][:, None, None, :] + np.arange(3)[:, None, None]
    return scattered(block, rows, unknowns, (9 * len(cells), space.n_unknowns)).tocsr()


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
