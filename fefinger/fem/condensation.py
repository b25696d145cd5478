"""A body reduced once to its pad: everything that contact may ask of it, without its mesh.

The pad's displacement nodes are eliminated last. What is left of the stiffness then acts between
them alone, and its inverse A gives the displacement u = A f of the pad under any load f on it, in
three directions: so one operator serves every obstacle, place and angle. The fronts before it are
kept, because they lead from the pad to strain and displacement anywhere in the body.

A finger is its own mirror image. A load on a whole one is the sum of an even and an odd part, and
each is a problem of the half: two operators of half the size do the work of one.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg.lapack import dpotri
from scipy.spatial import cKDTree

from fefinger.fem.body import Reduced, Solid
from fefinger.fem.contact.patch import Patch
from fefinger.fem.elements.forms import Elastic, stiffness
from fefinger.fem.elements.spaces import Array, Integers, Space
from fefinger.fem.linalg import multifrontal
from fefinger.fem.linalg.solvers import compressible
from fefinger.fem.linalg.threads import one_thread
from fefinger.geometry import mirror
from fefinger.support.checks import InputError
from fefinger.support.tolerances import REDUCED_COMPRESSIBILITY


BLOCK = 96  # columns swept through the fronts at once
PALMAR = 0.5
"""Outward z of the normal up to which a vertex belongs to the operator: 30 degrees beyond the
side of the finger, where neither plates nor objects on the pad reach."""

SAME = 1e-9  # of the size of the body, by which the image of a node may miss its twin


class OutsideError(InputError):
    """A load outside the part of the pad that an operator keeps."""


@dataclass(frozen=True)
class Compliance:
    """One parity of a body, reduced to its pad.

    order (n,) the free unknowns in the order of elimination, those of the pad last; fronts of the
    others; matrix (n_pad, n_pad) the displacement A under unit loads on the pad.
    """

    order: Integers
    fronts: tuple[multifrontal.Eliminated, ...]
    matrix: Array

    @property
    def pad(self) -> Integers:
        """The unknowns (n_pad,) of the pad."""
        return self.order[len(self.order) - len(self.matrix) :]

    def tractions(self, rows: sparse.csr_matrix) -> Array:
        """Return T (n_pad, n_rows): `rows` @ u = T' A f for every load f on the pad."""
        factor = multifrontal.Factor(self.order, self.fronts)
        found = np.empty((len(self.matrix), rows.shape[0]))
        for start in range(0, rows.shape[0], BLOCK):
            work = np.asarray(rows[start : start + BLOCK][:, self.order].toarray().T, order="C")
            factor.forward(work)
            found[:, start : start + BLOCK] = work[len(work) - len(found) :]
        return found

    def displacements(self, pad: Array, size: int) -> Array:
        """Return all unknowns (size, k) that go with displacements (n_pad, k) of the pad."""
        work = np.zeros((len(self.order), pad.shape[1]))
        work[len(work) - len(pad) :] = pad
        multifrontal.Factor(self.order, self.fronts).backward(work)
        unknowns = np.zeros((size, pad.shape[1]))
        unknowns[self.order] = work
        return unknowns


@dataclass(frozen=True)
class Part:
    """A parity of an operator.

    unfold (n_unknowns, n_unknowns of the half) makes a field of the body from one of the half;
    scale: what a unit response of `compliance` stands for.
    """

    compliance: Compliance
    unfold: sparse.csr_matrix
    scale: float


@dataclass(frozen=True)
class Operator(Solid):
    """A solid with all that it does under loads on its pad.

    known: what decides each of its parts, to keep what follows from it; None where that is unknown.
    """

    parts: tuple[Part, ...]
    known: tuple[dict[str, Any] | None, ...] = (None,)


def faces_down(solid: Solid) -> NDArray[np.bool_]:
    """Return which vertices (n_points,) belong to the palmar part with all of their triangles."""
    return np.asarray(solid.normals[:, 2] < PALMAR)


def palmar(solid: Solid) -> Integers:
    """Return the nodes of the pad that an operator keeps."""
    under = faces_down(solid)
    return solid.space.face_nodes(solid.pad[under[solid.pad].any(axis=1)])


@one_thread
def condense(solid: Solid, tissues: Mapping[int, Elastic], fixed: Integers) -> Compliance:
    """Reduce a solid whose unknowns `fixed` are zero to the palmar part of its pad.

    Incompressible tissue keeps a compressibility that is next to none.

    Raises
    ------
    InputError
        If the fixed unknowns leave a rigid motion free.
    """
    space = solid.space
    is_free = np.ones(space.n_unknowns, dtype=np.bool_)
    is_free[fixed] = False
    number = np.where(is_free, np.cumsum(is_free) - 1, -1)
    kept = number[(3 * palmar(solid)[:, None] + np.arange(3)).ravel()]
    dissection = multifrontal.dissect(
        number[space.unknowns],
        space.points[space.vertices].mean(axis=1),
        int(is_free[: space.n_displacements].sum()),
        last=np.sort(kept[kept >= 0]),
    )
    matrix = compressible(space, stiffness(space, tissues), REDUCED_COMPRESSIBILITY)
    free = np.flatnonzero(is_free)
    factored = multifrontal.factor(matrix[free][:, free].tocsr(), dissection)
    inverse, _ = dpotri(factored.fronts[-1].lower, lower=1)
    upper = np.triu_indices(len(inverse), 1)
    inverse[upper] = inverse.T[upper]
    return Compliance(free[factored.order], factored.fronts[:-1], np.ascontiguousarray(inverse))


def mirrored(whole: Space, half: Space, *, odd: bool) -> sparse.csr_matrix:
    """Return the matrix that makes an even or odd displacement of `whole` from one of `half`."""
    distance, twin = cKDTree(half.node_points).query(mirror.to_half(whole.node_points))
    if distance.max() > SAME * np.ptp(half.node_points):
        message = "mesh: expected a finger that is its own mirror image, received another"
        raise InputError(message)
    signs = np.ones((whole.n_nodes, 3))
    beyond = whole.node_points[:, 1] < 0
    signs[beyond] = -mirror.SIGNS if odd else mirror.SIGNS
    columns = (3 * twin[:, None] + np.arange(3)).ravel()
    where = (np.arange(len(columns)), columns)
    shape = (whole.n_unknowns, half.n_unknowns)
    return sparse.csr_matrix((signs.ravel(), where), shape=shape)


@one_thread
def reduce(
    operator: Operator,
    patch: Patch,
    strain: sparse.csr_matrix,
    progress: Callable[[float], None] = lambda fraction: None,
) -> Reduced:
    """Return F of the patch and the strains `strain` @ unknowns under its unit loads.

    Raises
    ------
    InputError
        If the patch reaches beyond the part of the pad that the operator keeps.
    """
    count = len(patch.vertices)
    flexibility = np.zeros((count, count))
    approach = np.zeros((patch.places.shape[1], count))
    beyond = _beyond(operator, patch.places)
    probe = sparse.vstack([strain, patch.places[:, beyond].T]).tocsr()
    read = np.zeros((probe.shape[0], count))
    for number, part in enumerate(operator.parts):
        loads = _on_pad(operator, part, patch.loads)
        moved = np.ascontiguousarray((loads.T @ part.compliance.matrix).T)
        flexibility += part.scale * (loads.T @ moved)
        pad = _on_pad(operator, part, patch.places[:, ~beyond])
        approach[~beyond] += part.scale * (pad.T @ moved)
        read += part.scale * _read(part.compliance, (probe @ part.unfold).tocsr(), moved)
        progress((number + 1) / len(operator.parts))
    strains, approach[beyond] = np.split(read, [strain.shape[0]])
    return Reduced(patch, (flexibility + flexibility.T) / 2, strains, approach)


def _beyond(operator: Operator, places: sparse.csc_matrix) -> NDArray[np.bool_]:
    """Return which of the `places` (n_unknowns, k) lie beyond the pad that the operator keeps."""
    entries = places.tocoo()
    outside = ~np.isin(entries.row // 3, palmar(operator))
    return np.bincount(entries.col[outside], minlength=places.shape[1]) > 0


def _read(compliance: Compliance, rows: sparse.csr_matrix, moved: Array) -> Array:
    """Return `rows` @ u (n_rows, k) for displacements `moved` (n_pad, k) of the pad.

    The fronts are swept for the rows or for the displacements, whichever are fewer.
    """
    if rows.shape[0] <= moved.shape[1]:
        return np.asarray(compliance.tractions(rows).T @ moved)
    found = np.empty((rows.shape[0], moved.shape[1]))
    for start in range(0, moved.shape[1], BLOCK):
        block = slice(start, start + BLOCK)
        found[:, block] = rows @ compliance.displacements(moved[:, block], rows.shape[1])
    return found


@one_thread
def displaced(operator: Operator, loads: Array) -> Array:
    """Return the unknowns (n_unknowns, k) under `loads` (n_unknowns, k) on the pad, its stresses 0.

    Raises
    ------
    InputError
        If a load lies outside the part of the pad that the operator keeps.
    """
    unknowns = np.zeros_like(loads)
    for part in operator.parts:
        on_pad = _on_pad(operator, part, sparse.csc_matrix(loads))
        pad = part.scale * (on_pad.T @ part.compliance.matrix).T
        unknowns += part.unfold @ part.compliance.displacements(pad, part.unfold.shape[1])
    return unknowns


def _on_pad(operator: Operator, part: Part, loads: sparse.csc_matrix) -> sparse.csc_matrix:
    """Return the loads (n_pad, k) of the half that do the work of `loads` (n_unknowns, k)."""
    kept = palmar(operator)
    touched = np.unique(loads.tocoo().row // 3)
    if not np.isin(touched, kept).all():
        message = (
            "indenter: expected contact on the palmar part of the pad, received candidates beyond "
            "the side of the finger; press less, or use the mechanics 'linear'"
        )
        raise OutsideError(message)
    return (part.unfold.T @ loads).tocsr()[part.compliance.pad].tocsc()
