"""Fields at points: strain of a displacement at end-organ sites and at mesh vertices."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fefinger.checks import InputError
from fefinger.fem.spaces import Array, Integers, Space
from fefinger.tolerances import INSIDE, SHARED


VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""Order of the six strain components: xx yy zz xy yz xz, tensor (not engineering) shear."""

ODD = (3, 4)
"""Components that change sign in the mirror y = 0."""


def strain_at(space: Space, points: Array, *, medial: bool = False) -> sparse.csr_matrix:
    """Return the operator (6 n_points, n_unknowns) from unknowns to the strain at `points`.

    A point that several cells share gets their mean, as strain jumps between cells. With `medial`
    the plane y = 0 is a mirror: a point on it gets the mean with its image.

    Raises
    ------
    InputError
        If a point (n_points, 3) mm lies outside the body.
    """
    owner, cells, local = locate(space, points)
    share = np.repeat(1.0 / np.bincount(owner, minlength=len(points))[owner], 6)
    place = (6 * owner[:, None] + np.arange(6)).ravel()
    shape = (6 * len(points), 6 * len(cells))
    mean = sparse.csr_matrix((share, (place, np.arange(shape[1]))), shape)
    mirrored = np.ones((len(points), 6))
    if medial:
        mirrored[np.ix_(points[:, 1] == 0, ODD)] = 0.0
    return (sparse.diags(mirrored.ravel()) @ mean @ _strain_rows(space, cells, local)).tocsr()


def strain_at_vertices(space: Space) -> sparse.csr_matrix:
    """Return the operator (6 n_points, n_unknowns) to the strain at the vertices.

    The strain jumps between cells (and tissues); a vertex gets the mean of its cells, weighted by
    their volumes. For pictures, not for numbers.
    """
    n_cells = len(space.vertices)
    volumes = space.scalar.dx.sum(axis=1)
    total = np.bincount(space.vertices.ravel(), np.repeat(volumes, 4), len(space.points))
    mean = sparse.csr_matrix((6 * len(space.points), space.n_unknowns))
    for corner in range(4):
        local = np.zeros((n_cells, 3))
        if corner:
            local[:, corner - 1] = 1.0
        rows = _strain_rows(space, np.arange(n_cells), local)
        vertex = space.vertices[:, corner]
        share = np.repeat(volumes / total[vertex], 6)
        place = (6 * vertex[:, None] + np.arange(6)).ravel()
        shape = (mean.shape[0], 6 * n_cells)
        mean = mean + sparse.csr_matrix((share, (place, np.arange(6 * n_cells))), shape) @ rows
    return mean.tocsr()


def tensors(components: Array) -> Array:
    """Return symmetric tensors (..., 3, 3) from components (..., 6) in the order of VOIGT."""
    full = np.empty((*components.shape[:-1], 3, 3))
    for k, (i, j) in enumerate(VOIGT):
        full[..., i, j] = full[..., j, i] = components[..., k]
    return full


def locate(space: Space, points: Array) -> tuple[Integers, Integers, Array]:
    """Return the cells that hold the points: point number, cell and reference coordinates (m, 3).

    Points are numbered in order; a point on a face, edge or vertex has an entry for each cell.

    Raises
    ------
    InputError
        If a point (n_points, 3) mm lies outside the body.
    """
    origin = space.points[space.vertices[:, 0]]
    inverse = _inverse_jacobians(space)
    owners, cells, local = [], [], []
    for k, point in enumerate(points):
        inner = np.einsum("eij,ej->ei", inverse, point - origin)
        least = np.minimum(inner.min(axis=1), 1 - inner.sum(axis=1))
        if least.max() < -INSIDE:
            listed = ", ".join(f"{x:.3g}" for x in point)
            message = (
                f"site ({listed}) mm: expected a point in the soft tissue, received one outside; "
                "choose a smaller depth or another place on the pad"
            )
            raise InputError(message)
        found = np.flatnonzero(least >= min(least.max(), -SHARED))
        owners.append(np.full(len(found), k))
        cells.append(found)
        local.append(inner[found])
    if not cells:
        return np.empty(0, np.int64), np.empty(0, np.int64), np.empty((0, 3))
    return np.concatenate(owners), np.concatenate(cells), np.concatenate(local)


def inside(space: Space, points: Array) -> NDArray[np.bool_]:
    """Return which points (n, 3) mm lie in the body, by the measure of `locate`."""
    origin, inverse = space.points[space.vertices[:, 0]], _inverse_jacobians(space)
    found = np.zeros(len(points), dtype=np.bool_)
    for k, point in enumerate(points):
        inner = np.einsum("eij,ej->ei", inverse, point - origin)
        found[k] = np.minimum(inner.min(axis=1), 1 - inner.sum(axis=1)).max() >= -INSIDE
    return found


def _inverse_jacobians(space: Space) -> Array:
    """Gradients (n_cells, 3, 3) of the reference coordinates, one per row."""
    corners = space.points[space.vertices]
    return np.asarray(np.linalg.inv(np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 2)))


def _strain_rows(space: Space, cells: Integers, local: Array) -> sparse.csr_matrix:
    """Strain (6 n, n_unknowns) at reference coordinates `local` (n, 3) of `cells` (n,)."""
    element = space.scalar.elem
    n_local = space.nodes.shape[1]
    reference = np.array([element.lbasis(local.T, i)[1] for i in range(n_local)])
    gradients = np.einsum("kjp,pjd->pkd", reference, _inverse_jacobians(space)[cells])
    block = np.zeros((len(cells), 6, n_local, 3))
    for row, (i, j) in enumerate(VOIGT):
        block[:, row, :, i] += gradients[:, :, j] / 2
        block[:, row, :, j] += gradients[:, :, i] / 2
    unknowns = 3 * space.nodes[cells][:, :, None] + np.arange(3)
    rows = np.arange(6 * len(cells)).reshape(len(cells), 6, 1, 1)
    shape = (6 * len(cells), space.n_unknowns)
    where = (
        np.broadcast_to(rows, block.shape).ravel(),
        np.broadcast_to(unknowns[:, None], block.shape).ravel(),
    )
    return sparse.coo_matrix((block.ravel(), where), shape=shape).tocsr()
