"""Operators from unknowns to strain and displacement gradient, at sites and at mesh vertices."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fefinger.fem.elements.spaces import Array, Integers, Space
from fefinger.support.checks import InputError
from fefinger.support.tolerances import INSIDE, SHARED


VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""Order of the six strain components: xx yy zz xy yz xz, tensor (not engineering) shear."""

Rows = Callable[[Space, Integers, Array], sparse.csr_matrix]
"""From a space, cells (n,) and reference coordinates (n, 3) to rows for each point."""


def strain_at(space: Space, points: Array, planes: Sequence[int] = ()) -> sparse.csr_matrix:
    """Return the operator (6 n_points, n_unknowns) from unknowns to the strain at `points`.

    A point that several cells share gets their mean, as strain jumps between cells. `planes` are
    the axes across whose coordinate plane the body goes on as its mirror image: a point on one gets
    the mean with its image.

    Raises
    ------
    InputError
        If a point (n_points, 3) mm lies outside the body.
    """
    mirrored = _mirrored(points, planes)[:, *np.transpose(VOIGT)]
    return _at_points(space, points, _strain_rows, mirrored)


def gradient_at(space: Space, points: Array, planes: Sequence[int] = ()) -> sparse.csr_matrix:
    """Return the operator (9 n_points, n_unknowns) to du_i/dX_j at `points`, i before j.

    Shared points and mirrors are treated as by `strain_at`, which raises the same error.
    """
    return _at_points(space, points, _gradient_rows, _mirrored(points, planes))


def _mirrored(points: Array, planes: Sequence[int]) -> Array:
    """Factors (n_points, 3, 3), 1 or 0, of the mean of a point's gradient with its mirror image."""
    factors = np.ones((len(points), 3, 3))
    for axis in planes:
        across = np.arange(3) == axis
        factors[np.ix_(points[:, axis] == 0, across, ~across)] = 0.0
        factors[np.ix_(points[:, axis] == 0, ~across, across)] = 0.0
    return factors


def _at_points(space: Space, points: Array, rows_at: Rows, mirrored: Array) -> sparse.csr_matrix:
    """Mean of the rows over the cells of each point, times `mirrored` (n_points, ...)."""
    owner, cells, local = locate(space, points)
    width = mirrored[0].size if len(points) else 1
    share = np.repeat(1.0 / np.bincount(owner, minlength=len(points))[owner], width)
    place = (width * owner[:, None] + np.arange(width)).ravel()
    shape = (width * len(points), width * len(cells))
    mean = sparse.csr_matrix((share, (place, np.arange(shape[1]))), shape)
    return (sparse.diags(mirrored.ravel()) @ mean @ rows_at(space, cells, local)).tocsr()


def strain_at_vertices(space: Space) -> sparse.csr_matrix:
    """Return the operator (6 n_points, n_unknowns) to the strain at the vertices.

    The strain jumps between cells (and tissues); a vertex gets the mean of its cells, weighted by
    their volumes. For pictures, not for numbers.
    """
    return _at_vertices(space, _strain_rows, 6)


def gradient_at_vertices(space: Space) -> sparse.csr_matrix:
    """Return the operator (9 n_points, n_unknowns) to du_i/dX_j at the vertices.

    A vertex gets the same mean over its cells as in `strain_at_vertices`.
    """
    return _at_vertices(space, _gradient_rows, 9)


def _at_vertices(space: Space, rows_at: Rows, width: int) -> sparse.csr_matrix:
    n_cells = len(space.vertices)
    volumes = space.scalar.dx.sum(axis=1)
    total = np.bincount(space.vertices.ravel(), np.repeat(volumes, 4), len(space.points))
    mean = sparse.csr_matrix((width * len(space.points), space.n_unknowns))
    for corner in range(4):
        local = np.zeros((n_cells, 3))
        if corner:
            local[:, corner - 1] = 1.0
        rows = rows_at(space, np.arange(n_cells), local)
        vertex = space.vertices[:, corner]
        share = np.repeat(volumes / total[vertex], width)
        place = (width * vertex[:, None] + np.arange(width)).ravel()
        shape = (mean.shape[0], width * n_cells)
        entries = (share, (place, np.arange(width * n_cells)))
        mean = mean + sparse.csr_matrix(entries, shape) @ rows
    return mean.tocsr()


def tensors(components: Array) -> Array:
    """Return symmetric tensors (..., 3, 3) from components (..., 6) in the order of VOIGT."""
    full = np.empty((*components.shape[:-1], 3, 3))
    for k, (i, j) in enumerate(VOIGT):
        full[..., i, j] = full[..., j, i] = components[..., k]
    return full


def locate(space: Space, points: Array) -> tuple[Integers, Integers, Array]:
    """Locate points in the mesh: point number, cell and reference coordinates (m, 3).

    Points are numbered in order; a point on a face, edge or vertex has an entry for each cell.

    Raises
    ------
    InputError
        If a point (n_points, 3) mm lies outside the body.
    """
    owners, cells, local = [], [], []
    for k, (near, inner, least) in enumerate(_coordinates(space, points)):
        if not (least >= -INSIDE).any():
            listed = ", ".join(f"{x:.3g}" for x in points[k])
            message = (
                f"site ({listed}) mm: expected a point in the soft tissue, received one outside; "
                "choose a smaller depth or another place on the pad"
            )
            raise InputError(message)
        holding = np.flatnonzero(least >= min(least.max(), -SHARED))
        owners.append(np.full(len(holding), k))
        cells.append(near[holding])
        local.append(inner[holding])
    if not cells:
        return np.empty(0, np.int64), np.empty(0, np.int64), np.empty((0, 3))
    return np.concatenate(owners), np.concatenate(cells), np.concatenate(local)


def inside(space: Space, points: Array) -> NDArray[np.bool_]:
    """Whether points (n, 3) mm lie in the body, with the tolerance of `locate`."""
    flags = [(least >= -INSIDE).any() for _, _, least in _coordinates(space, points)]
    return np.array(flags, dtype=np.bool_)


def _coordinates(space: Space, points: Array) -> Iterator[tuple[Integers, Array, Array]]:
    """Compute the reference coordinates of each point in the cells near it.

    Yields per point: cells (m,), coordinates (m, 3), and the least of the four barycentric ones
    (m,), which is 0 or more inside a cell. Only cells whose circumscribed sphere about the
    centroid contains the point are tested.
    """
    corners = space.points[space.vertices]
    centers, inverse = corners.mean(axis=1), _inverse_jacobians(space)
    radii = np.linalg.norm(corners - centers[:, None], axis=2).max(axis=1)
    reach = ((1 + 8 * INSIDE) * radii) ** 2
    for point in points:
        apart = centers - point
        near = np.flatnonzero(np.einsum("ij,ij->i", apart, apart) <= reach)
        inner = np.einsum("eij,ej->ei", inverse[near], point - corners[near, 0])
        yield near, inner, np.minimum(inner.min(axis=1), 1 - inner.sum(axis=1))


def _inverse_jacobians(space: Space) -> Array:
    """Gradients (n_cells, 3, 3) of the reference coordinates, one per row."""
    corners = space.points[space.vertices]
    return np.asarray(np.linalg.inv(np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 2)))


def _gradient_rows(space: Space, cells: Integers, local: Array) -> sparse.csr_matrix:
    """Gradient (9 n, n_unknowns) at reference coordinates `local` (n, 3) of `cells` (n,)."""
    element, n_local = space.scalar.elem, space.nodes.shape[1]
    reference = np.array([element.lbasis(local.T, i)[1] for i in range(n_local)])
    gradients = np.einsum("kjp,pjd->pkd", reference, _inverse_jacobians(space)[cells])
    block = np.broadcast_to(gradients.transpose(0, 2, 1)[:, None], (len(cells), 3, 3, n_local))
    rows = np.arange(9 * len(cells)).reshape(len(cells), 3, 3, 1)
    unknowns = 3 * space.nodes[cells][:, None, None, :] + np.arange(3)[:, None, None]
    where = (
        np.broadcast_to(rows, block.shape).ravel(),
        np.broadcast_to(unknowns, block.shape).ravel(),
    )
    shape = (9 * len(cells), space.n_unknowns)
    return sparse.coo_matrix((block.ravel(), where), shape=shape).tocsr()


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
