"""Operators from unknowns to strain and displacement gradient, at sites and at mesh vertices."""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy import sparse

from fefinger.fem.elements.assembly import scattered
from fefinger.fem.elements.spaces import Space
from fefinger.geometry.locate import around
from fefinger.geometry.voigt import VOIGT
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import InputError
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
