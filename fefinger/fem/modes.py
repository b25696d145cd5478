"""Undamped modes of an elastic body: the lowest solutions of K phi = w² M phi.

Block Lanczos for the inverse of K in the inner product of M (Grimes, Lewis and Simon, SIAM J.
Matrix Anal. Appl. 15:228, 1994), without a shift: it takes the factor of statics, and a block of
vectors passes through it at a fraction of the cost of single ones. The mean stress has no mass:
the iteration lives on the displacements, and the factor eliminates the mean stress exactly. Full
reorthogonalization replaces selective one, because dense products cost less than solutions.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import linalg, sparse

from fefinger.fem.condensation import Compliance
from fefinger.fem.elements.assembly import numbering
from fefinger.fem.linalg import multifrontal
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError, InputError, number
from fefinger.support.processes import one_thread


BLOCK = 24  # vectors per block: two solutions in the time of 24 on the standard finger are 8 single
TOLERANCE = 1e-6
"""Of the residual of a mode, over its share 1 / w² of the flexibility: the frequency errs by its
square, and the residual flexibility makes up for the shape."""

CHECK = 2  # blocks between looks at the residuals
SLACK = 10.0  # longest basis over the number of modes wanted
LEAST = 600  # vectors that a basis may always have; smaller bodies are solved as dense ones
SEED = 27  # of the first vectors, so that the modes are the same in every run


Solves = Callable[[Array], Array]
"""A static solution: displacements (n, k) under loads (n, k) on the free displacements."""


@dataclass(frozen=True)
class Modes:
    """Modes of a body, lowest first.

    omega_squared (n,) of the angular frequencies, 1/s² for a stiffness in mN/mm and a mass in kg;
    shapes (n_displacements, n) with unit modal mass, zero where the body is held; residual: the
    largest residual of K^-1 M phi = phi / w², over 1 / w².
    """

    omega_squared: Array
    shapes: Array
    residual: float

    @property
    def frequencies(self) -> Array:
        """Frequencies (n,) in Hz."""
        return np.asarray(np.sqrt(self.omega_squared) / (2 * np.pi))


def static(compliance: Compliance, free: Integers) -> Solves:
    """Return the static solution of a condensed body for loads anywhere on its free displacements.

    free (n,): the numbers of the unknowns that loads and displacements belong to.
    """
    factor = multifrontal.Factor(compliance.order, compliance.fronts)
    places = numbering(compliance.order, int(compliance.order.max()) + 1)[free]
    n_pad = len(compliance.matrix)

    def solve(loads: Array) -> Array:
        work = np.zeros((len(compliance.order), loads.shape[1]))
        work[places] = loads
        factor.forward(work)
        work[-n_pad:] = compliance.matrix @ work[-n_pad:]
        factor.backward(work)
        return np.asarray(work[places])

    return solve


def modes_of(
    compliance: Compliance,
    mass: sparse.csr_matrix,
    count: int,
    progress: Callable[[float], None] = lambda fraction: None,
) -> Modes:
    """Compute the `count` lowest modes of a condensed body, with the mass matrix of its space.

    Raises
    ------
    InputError, ConvergenceError
        As `lowest`.
    """
    size = mass.shape[0]
    free = np.sort(compliance.order[compliance.order < size])
    inner = mass[free][:, free].tocsr()
    lowest_modes = lowest(static(compliance, free), inner, count, progress)
    shapes = np.zeros((size, lowest_modes.shapes.shape[1]))
    shapes[free] = lowest_modes.shapes
    return Modes(lowest_modes.omega_squared, shapes, lowest_modes.residual)


@one_thread
def lowest(
    solve: Solves,
    mass: sparse.csr_matrix,
    count: int,
    progress: Callable[[float], None] = lambda fraction: None,
) -> Modes:
    """Compute the `count` lowest modes of a body held such that `solve` inverts its stiffness.

    Raises InputError if the body has fewer unknowns than modes wanted, or a number that is no
    count, and ConvergenceError if the modes do not converge in a basis of `SLACK` times their
    number.
    """
    size = mass.shape[0]
    count = int(number("modes", count, at_least=1))
    if count > size:
        message = f"modes: expected at most {size}, the unknowns of the body, received {count}"
        raise InputError(message)
    if size <= LEAST:
        return _dense(solve, mass, count)
    longest = min(size, max(LEAST, int(SLACK * count)))
    basis = np.empty((size, longest + BLOCK), order="F")
    projected = np.zeros((longest + BLOCK, longest + BLOCK))
    start = np.random.default_rng(SEED).standard_normal((size, BLOCK))
    # One solution first: so the start has no part that no mode can have.
    basis[:, :BLOCK], _ = _orthonormal(solve(mass @ start), mass)
    used, worst = BLOCK, np.inf
    while True:
        newest = slice(used - BLOCK, used)
        images = solve(mass @ basis[:, newest])
        basis_so_far = basis[:, :used]
        # The last two blocks are all that exact arithmetic needs; then all, against its rounding.
        for first in (max(0, used - 2 * BLOCK), 0):
            others = basis[:, first:used]
            shares = others.T @ (mass @ images)
            projected[first:used, newest] += shares
            images -= others @ shares
        following, coupling = _orthonormal(images, mass)
        full = used + BLOCK > longest
        if full or (used >= count and (used // BLOCK) % CHECK == 0):
            inverse, vectors = _ritz(projected[:used, :used], count)
            left = np.linalg.norm(coupling @ vectors[-BLOCK:], axis=0) / inverse
            worst = float(left.max()) if len(left) == count else np.inf
            progress(min(1.0, float((left <= TOLERANCE).sum()) / count))
            if worst <= TOLERANCE or used == size:
                return Modes(1.0 / inverse, basis_so_far @ vectors, worst)
        if full:
            raise ConvergenceError(
                f"modes: expected {count} with residuals of at most {TOLERANCE:g}, reached "
                f"{worst:.1e} in a basis of {used} vectors; ask for fewer modes"
            )
        basis[:, used : used + BLOCK] = following
        used += BLOCK


def _dense(solve: Solves, mass: sparse.csr_matrix, count: int) -> Modes:
    """Compute the modes of a small body from its whole flexibility."""
    heavy = mass.toarray()
    flexible = heavy @ solve(heavy)
    low = len(heavy) - count
    values, vectors = linalg.eigh(
        (flexible + flexible.T) / 2, heavy, subset_by_index=(low, len(heavy) - 1)
    )
    left = solve(heavy @ vectors) - vectors * values
    residual = float(
        np.max(np.linalg.norm(left, axis=0) / np.linalg.norm(vectors * values, axis=0))
    )
    return Modes(1.0 / values[::-1], vectors[:, ::-1], residual)


def _ritz(projected: Array, count: int) -> tuple[Array, Array]:
    """Return the largest eigenvalues 1 / w² of the projected problem, descending, and vectors.

    Its upper triangle counts: products of each block with those before it.
    """
    low = max(0, len(projected) - count)
    values, vectors = linalg.eigh(projected, lower=False, subset_by_index=(low, len(projected) - 1))
    return values[::-1], vectors[:, ::-1]


def _orthonormal(vectors: Array, mass: sparse.csr_matrix) -> tuple[Array, Array]:
    """Orthonormalize vectors (n, k) in the inner product of M; return them and R, V = Q R.

    Twice, through the eigenvalues of the Gram matrix, which may be singular.
    """
    factor = np.eye(vectors.shape[1])
    for _ in range(2):
        scale = np.sqrt(np.maximum(np.einsum("ij,ij->j", vectors, mass @ vectors), 1e-300))
        scaled = vectors / scale
        values, rotation = np.linalg.eigh(scaled.T @ (mass @ scaled))
        roots = np.sqrt(np.maximum(values, np.finfo(float).eps * values[-1]))
        vectors = scaled @ (rotation / roots)
        factor = ((roots[:, None] * rotation.T) * scale) @ factor
    return vectors, factor
