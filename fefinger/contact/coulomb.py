"""Compiled contact with Coulomb friction: pressure and traction that fit a flexibility.

Of every vertex the pressure is p >= 0 with the gap w >= 0, p w = 0, and the traction t in the plane
of contact has |t| <= mu p, with t = -mu p s / |s| wherever the vertex slips by s. Both are
projections, p = max(0, p - w / a) and t = P(t - s / b) on the disc of radius mu p (Alart and
Curnier, Comput. Methods Appl. Mech. Eng. 92:353, 1991). A semi-smooth Newton method solves for the
iterate that they do not change; sweeps over the vertices that apply one after the other (block
Gauss-Seidel) come before each step, and take over where no part of it comes closer. The distance
from both projections is the residual.

Vectors of 3n have the pressures first, then the tractions along x, then those along y. The vertices
in question are compressed into a block with three rows for each of them. The outer iteration is in
Python, as numba takes half a minute to compile all of it.
"""

from abc import ABC, abstractmethod

import numpy as np
from scipy.linalg import lapack

from fefinger.contact.active_set import DONE, ENDLESS, SINGULAR, combine
from fefinger.contact.coulomb_kernels import (
    INVERT,
    SETTLED,
    SOLVE,
    TRIED,
    UNKNOWNS,
    Block,
    K,
    Unknowns,
    assemble,
    iterate,
    load,
)
from fefinger.support.arrays import Array, Integers


NONE, NO_INVERSE, NO_CODES = np.empty(0), np.empty((0, 0)), np.empty(0, dtype=np.int64)


class CoulombIteration(ABC):
    """Solver of contact with friction on n vertices; it starts from its last solution.

    A subclass knows F (3n, 3n).

    Parameters
    ----------
    n
        Number of vertices.
    mu
        Coefficient of every vertex at first.

    Attributes
    ----------
    x, moved
        Pressures and tractions (3n,), and F times them.
    mu
        Coefficients (n,).
    where, place
        (n,): the vertices in the block, and the position in it of each vertex, or -1.
    counts
        (4,): vertices in the block, and Newton steps.
    residual
        Of the last solution.
    """

    def __init__(self, n: int, mu: float) -> None:
        self.x, self.moved, self.mu = np.zeros(3 * n), np.zeros(3 * n), np.full(n, float(mu))
        self.where, self.place = np.zeros(n, dtype=np.int64), np.full(n, -1, dtype=np.int64)
        self.counts, self.residual = np.zeros(4, dtype=np.int64), 0.0
        self._block = Block(np.zeros((3 * n, 3 * n)), np.zeros(n), *np.zeros((3, 3 * n)))
        self._index = np.zeros(3 * n, dtype=np.int64)
        (vertex, code), entries = np.zeros((2, 3 * n), dtype=np.int64), np.zeros((2, 3 * n, 3))
        self._unknowns = Unknowns(vertex, code, entries[0], entries[1], np.zeros(3 * n))
        self._forget()

    @property
    def volatile(self) -> tuple[Array | Integers, ...]:
        """Arrays that a failed solution leaves changed."""
        return self.x, self.moved, self.where, self.place, self.counts

    def solve(self, offset: Array, tolerance: float) -> int:
        """Solve for x with b = `offset` (3n,), from the last x; return DONE or a failure."""
        n = len(self.where)
        least = -tolerance * float(np.abs(offset[:n]).max())
        rounds = 60  # in each of which vertices join
        for number in range(rounds):
            out = np.flatnonzero((self.place < 0) & (self.moved[:n] + offset[:n] < least))
            if not self._gives_way(out):
                return SINGULAR
            if len(out):
                self._join(out)
            elif number > 0 or self.counts[K] == 0:
                return DONE
            if not self._settle(offset):
                return ENDLESS
            self._unload()
        return ENDLESS

    def rebuild(self) -> None:
        """Compress the vertices in `where` into the block anew; the last matrix is forgotten."""
        vertices = self.where[: self.counts[K]].copy()
        self.counts[K], self.place[:] = 0, -1
        self._join(vertices)
        self._forget()

    def _forget(self) -> None:
        """Forget the matrix of the last Newton step: the codes of its unknowns, its inverse."""
        self._kept: Integers = NO_CODES
        self._inverse: Array = NO_INVERSE

    def _join(self, vertices: Integers) -> None:
        """Add vertices to the block."""
        n, start = len(self.where), int(self.counts[K])
        k = start + len(vertices)
        self.where[start:k], self.place[vertices] = vertices, np.arange(start, k)
        self.counts[K] = k
        self._index[3 * start : 3 * k] = (vertices[:, None] + n * np.arange(3)).ravel()
        self._fill(start)

    def _leave(self, at: int) -> None:
        """Remove the vertex at a position from the block: the last one takes its place."""
        last = int(self.counts[K]) - 1
        self.place[self.where[at]] = -1
        if at != last:
            here, there = slice(3 * at, 3 * at + 3), slice(3 * last, 3 * last + 3)
            matrix = self._block.matrix
            matrix[here] = matrix[there]
            matrix[:, here] = matrix[:, there]
            self._index[here] = self._index[there]
            self.where[at] = self.where[last]
            self.place[self.where[at]] = at
        self.counts[K] = last

    def _unload(self) -> None:
        """Write the block into x; vertices without pressure leave it."""
        k = int(self.counts[K])
        self.x[self._index[: 3 * k]] = self._block.x[: 3 * k]
        at = 0 if (self._block.x[: 3 * k : 3] <= 0.0).any() else k
        while at < self.counts[K]:
            if self.x[self.where[at]] > 0.0:
                at += 1
            else:
                self._leave(at)
        self._multiply()

    @abstractmethod
    def _gives_way(self, vertices: Integers) -> bool:
        """Whether the diagonal of F is above 0 for the pressures of vertices."""

    @abstractmethod
    def _fill(self, start: int) -> None:
        """Copy F into the block, for its vertices from position `start` on."""

    @abstractmethod
    def _multiply(self) -> None:
        """Compute `moved`."""

    def _settle(self, offset: Array) -> bool:
        """Find the iterate that no projection changes; False if that does not happen."""
        s, k = self._block, int(self.counts[K])
        index = self._index[: 3 * k]
        s.constant[: 3 * k], s.x[: 3 * k] = offset[index], self.x[index]
        s.mu[:k] = self.mu[self.where[:k]]
        load(s, k)
        self.counts[TRIED], values = 0, NONE
        refreshed = 8  # steps with an inverse after which it is computed anew, the next time
        while True:
            last = self._kept, self._inverse, values, self.counts
            outcome, self.residual = iterate(s, self.where, k, self._unknowns, *last)
            if outcome not in {SOLVE, INVERT}:
                if self.counts[TRIED] > refreshed:
                    self._inverse = NO_INVERSE
                return bool(outcome == SETTLED)
            values = self._newton(k, invert=outcome == INVERT)

    def _newton(self, k: int, *, invert: bool) -> Array:
        """Solve for the unknowns of a Newton step (q,), or `invert` its matrix and return none.

        Where it is singular, sweeps go on.
        """
        q = int(self.counts[UNKNOWNS])
        matrix, right = assemble(self._block, k, self._unknowns, q)
        self._forget()
        values, inverse = NONE, NO_INVERSE
        factor, pivots, singular = lapack.dgetrf(matrix.T, overwrite_a=True)
        if not singular and invert:
            work = 64  # columns of the blocks in which LAPACK inverts a matrix
            inverse = lapack.dgetri(factor, pivots, lwork=work * q, overwrite_lu=True)[0].T
        elif not singular:
            values, _ = lapack.dgetrs(factor, pivots, right, trans=1, overwrite_b=True)
        if singular or not invert:
            self.counts[TRIED] += 1
        if singular:
            return NONE
        self._kept, self._inverse = self._unknowns.code[:q].copy(), inverse
        return values


class CoulombSolver(CoulombIteration):
    """Solver with a flexibility F (3n, 3n); the rest as of `CoulombIteration`."""

    def __init__(self, flexibility: Array, mu: float) -> None:
        super().__init__(len(flexibility) // 3, mu)
        # A copy: numba compiles read-only arrays as another type, which takes seconds.
        self.flexibility = np.array(flexibility, order="C")
        self._chosen, self._work = np.zeros_like(self._index), np.zeros_like(self.x)

    def _gives_way(self, vertices: Integers) -> bool:
        return bool((self.flexibility[vertices, vertices] > 0.0).all())

    def _fill(self, start: int) -> None:
        k, matrix = int(self.counts[K]), self._block.matrix
        index = self._index[: 3 * k]
        rows = self.flexibility[np.ix_(index[3 * start :], index)]
        matrix[3 * start : 3 * k, : 3 * k] = rows
        matrix[: 3 * k, 3 * start : 3 * k] = rows.T

    def _multiply(self) -> None:
        combine(self.moved, self.flexibility, self.x, self._chosen, self._work)
