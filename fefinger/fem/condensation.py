"""Static condensation of a body to the displacements of its pad, for contact with any obstacle.

The pad's displacement nodes are eliminated last. The Schur complement on them has the inverse A,
which gives the displacement u = A f of the pad under any load f on it, in three directions: one
operator serves every obstacle, place and angle. The fronts before it are stored too, because they
give strain and displacement anywhere in the body from the displacement of the pad.

A finger is symmetric about its medial plane. A load on a whole finger is the sum of an even and an
odd part, each a problem of the half: two operators of half the size replace one.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg.lapack import dpotri
from scipy.spatial import cKDTree

from fefinger.fem.body import Reduced, Solid
from fefinger.fem.contact.patch import Patch
from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg import multifrontal
from fefinger.fem.linalg.dissection import dissect_space
from fefinger.fem.linalg.system import compressible
from fefinger.geometry import finger_mesh
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import InputError
from fefinger.support.processes import one_thread
from fefinger.support.tolerances import REDUCED_COMPRESSIBILITY


BLOCK = 96  # columns per pass through the fronts
PALMAR = 0.5
"""Largest z of the outward normal of a vertex of the operator: 30 degrees beyond the side of the
finger, which neither plates nor objects on the pad reach."""


class OutsideError(InputError):
    """Error for a load outside the palmar part of the pad, where the operator is not defined."""


@dataclass(frozen=True)
class Compliance:
    """Compliance of the pad of a condensed body, for loads of one parity.

    order (n,) the free unknowns in the order of elimination, the pad's last; fronts of the
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
        """Matrix T (n_pad, n_rows) such that `rows` @ u = T' A f for every load f on the pad."""
        factor = multifrontal.Factor(self.order, self.fronts)
        tractions = np.empty((len(self.matrix), rows.shape[0]))
        for start in range(0, rows.shape[0], BLOCK):
            work = np.asarray(rows[start : start + BLOCK][:, self.order].toarray().T, order="C")
            factor.forward(work)
            tractions[:, start : start + BLOCK] = work[len(work) - len(tractions) :]
        return tractions

    def displacements(self, pad: Array) -> Array:
        """Recover the free unknowns (n, k), in their `order`, from those (n_pad, k) of the pad."""
        work = np.zeros((len(self.order), pad.shape[1]))
        work[len(work) - len(pad) :] = pad
        multifrontal.Factor(self.order, self.fronts).backward(work)
        return work


@dataclass(frozen=True)
class Part:
    """Even or odd part of an operator.

    unfold (n_unknowns, n_unknowns of the half): matrix from a field of the half to one of the body;
    scale: factor on the response of `compliance`, which was computed for a skin of 1 kPa.
    """

    compliance: Compliance
    unfold: sparse.csr_matrix
    scale: float


@dataclass(frozen=True)
class Operator(Solid):
    """A solid with its response to loads on the pad.

    identities: the inputs that determine each of its parts, as a key for the cache of derived
    results; None where they are not recorded.
    """

    parts: tuple[Part, ...]
    identities: tuple[dict[str, Any] | None, ...] = (None,)

    @property
    def loadable(self) -> Flags:
        """Whether each vertex (n_points,) belongs to the palmar part of the pad."""
        return _faces_down(self)


def _faces_down(solid: Solid) -> Flags:
    return np.asarray(solid.normals[:, 2] < PALMAR)


def palmar(solid: Solid) -> Integers:
    """Nodes of the palmar part of the pad, on which an operator is defined."""
    under = _faces_down(solid)
    return solid.space.face_nodes(solid.pad[under[solid.pad].any(axis=1)])


@one_thread
def condense(solid: Solid, tissues: Mapping[int, Elastic], fixed: Integers) -> Compliance:
    """Condense a solid, whose unknowns `fixed` are zero, to the palmar part of its pad.

    Incompressible tissue gets a compressibility of `REDUCED_COMPRESSIBILITY`, so that it can be
    factored.

    Raises InputError if the fixed unknowns leave a rigid motion free.
    """
    space = solid.space
    free = np.setdiff1d(np.arange(space.n_unknowns), fixed)
    pad = np.intersect1d(3 * palmar(solid)[:, None] + np.arange(3), free)
    matrix = compressible(space, stiffness(space, tissues), REDUCED_COMPRESSIBILITY)
    factored = multifrontal.factor(
        matrix[free][:, free].tocsr(), dissect_space(space, free, last=pad)
    )
    inverse, _ = dpotri(factored.fronts[-1].lower, lower=1)
    upper = np.triu_indices(len(inverse), 1)
    inverse[upper] = inverse.T[upper]
    return Compliance(free[factored.order], factored.fronts[:-1], np.ascontiguousarray(inverse))


def mirrored(whole: Space, half: Space, *, odd: bool) -> sparse.csr_matrix:
    """Matrix from a displacement of `half` to the even or odd displacement of `whole`."""
    distance, twin = cKDTree(half.node_points).query(finger_mesh.to_half(whole.node_points))
    same = 1e-9  # largest distance of a mirrored node from its twin, over the size of the body
    if distance.max() > same * np.ptp(half.node_points):
        raise InputError("mesh: expected a finger that is symmetric about y = 0, received another")
    signs = np.ones((whole.n_nodes, 3))
    beyond = whole.node_points[:, 1] < 0
    signs[beyond] = -finger_mesh.SIGNS if odd else finger_mesh.SIGNS
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
    """Evaluate the operator on a patch: F, and the strains `strain` @ unknowns of unit loads.

    Raises InputError if the patch reaches beyond the palmar part of the pad.
    """
    count = len(patch.vertices)
    flexibility = np.zeros((count, count))
    displacement = np.zeros((patch.places.shape[1], count))
    entries = patch.places.tocoo()
    outside = ~np.isin(entries.row // 3, palmar(operator))
    beyond = np.bincount(entries.col[outside], minlength=patch.places.shape[1]) > 0
    probe = sparse.vstack([strain, patch.places[:, beyond].T]).tocsr()
    read = np.zeros((probe.shape[0], count))
    for number, part in enumerate(operator.parts):
        loads = _on_pad(operator, part, patch.loads)
        moved = np.ascontiguousarray((loads.T @ part.compliance.matrix).T)
        flexibility += part.scale * (loads.T @ moved)
        pad = _on_pad(operator, part, patch.places[:, ~beyond])
        displacement[~beyond] += part.scale * (pad.T @ moved)
        read += part.scale * _read(part.compliance, (probe @ part.unfold).tocsr(), moved)
        progress((number + 1) / len(operator.parts))
    strains, displacement[beyond] = np.split(read, [strain.shape[0]])
    return Reduced(patch, (flexibility + flexibility.T) / 2, strains, displacement)


def _read(compliance: Compliance, rows: sparse.csr_matrix, moved: Array) -> Array:
    """Return `rows` @ u (n_rows, k) for displacements `moved` (n_pad, k) of the pad.

    The fronts are swept for the rows or for the displacements, whichever are fewer.
    """
    if rows.shape[0] <= moved.shape[1]:
        return np.asarray(compliance.tractions(rows).T @ moved)
    values, rows = np.empty((rows.shape[0], moved.shape[1])), rows[:, compliance.order]
    for start in range(0, moved.shape[1], BLOCK):
        block = slice(start, start + BLOCK)
        values[:, block] = rows @ compliance.displacements(moved[:, block])
    return values


@one_thread
def displaced(operator: Operator, loads: Array | sparse.csc_matrix) -> Array:
    """Compute the unknowns (n_unknowns, k) under `loads` (n_unknowns, k) on the pad.

    The pressure unknowns on the pad itself are zero.

    Raises InputError if a load lies outside the palmar part of the pad.
    """
    unknowns = np.zeros(loads.shape)
    for part in operator.parts:
        on_pad = _on_pad(operator, part, sparse.csc_matrix(loads))
        pad = part.scale * (on_pad.T @ part.compliance.matrix).T
        unknowns += part.unfold[:, part.compliance.order] @ part.compliance.displacements(pad)
    return unknowns


def _on_pad(operator: Operator, part: Part, loads: sparse.csc_matrix) -> sparse.csc_matrix:
    """Work-equivalent loads (n_pad, k) of the half for `loads` (n_unknowns, k) of the body."""
    loaded = np.unique(loads.tocoo().row // 3)
    if not np.isin(loaded, palmar(operator)).all():
        raise OutsideError(
            "indenter: expected contact on the palmar part of the pad, received candidates beyond "
            "the side of the finger; press less, or use the mechanics 'linear'"
        )
    return (part.unfold.T @ loads).tocsr()[part.compliance.pad].tocsc()
