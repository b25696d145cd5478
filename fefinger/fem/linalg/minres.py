"""Preconditioned MINRES for the symmetric mixed system, for meshes too large for a factor.

MINRES (Paige and Saunders, SIAM J. Numer. Anal. 12:617, 1975) with a symmetric positive definite
block preconditioner. On displacements that is one two-level cycle for mu eps : eps instead of the
mu dev eps : dev eps of the matrix: the two agree where div u = 0, and the former gives conformal
motions a stiffness too (a third of the iterations). A Chebyshev polynomial smooths the quadratic
elements; the linear elements of the coarse level, an eighth of the unknowns, are factored. On
pressures it is a diagonal that approximates the mass over the shear modulus (Elman, Silvester and
Wathen, Finite Elements and Fast Iterative Solvers, 2014, chapter 4).
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fefinger.fem.elements.assembly import numbering
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg import multifrontal
from fefinger.fem.linalg.dissection import dissect
from fefinger.support.arrays import Array, Integers


REDUCTION = 2e-6  # of the preconditioned residual in one solution; `System` refines further
ITERATIONS = 1500
DEGREE = 2  # of the smoother
SPREAD = 8.0  # ratio of the eigenvalues that the smoother damps
POWER = 15  # iterations that estimate the largest eigenvalue
MARGIN = 1.1  # factor on that estimate, because the power iteration is a lower bound


@dataclass(frozen=True)
class Iterative:
    """MINRES solver of a preconditioned matrix, for many loads at once.

    matrix (n, n) of the free unknowns, displacements first; strain (m, m): mu eps : eps on these;
    inverse (m, 1) of its diagonal; largest: an upper bound of the eigenvalues of inverse * strain;
    up (m, k): interpolation from linear to quadratic elements, down its transpose; coarse: the
    factor of the linear level; pressures (n - m, 1): the inverse of the diagonal for these.
    """

    matrix: sparse.csr_matrix
    strain: sparse.csr_matrix
    inverse: Array
    largest: float
    up: sparse.csr_matrix
    down: sparse.csr_matrix
    coarse: multifrontal.Factor
    pressures: Array

    def solve(self, right: Array) -> Array:
        """Return an approximate solution (n,) or (n, k) for right hand sides of the same shape."""
        return self.minres(right)[0]

    def minres(self, right: Array) -> tuple[Array, int]:
        """Return the approximate solution and the iterations that it took.

        In the notation of Elman, Silvester and Wathen, Algorithm 4.1, column by column.
        """
        v = right.reshape(len(right), -1)
        z = self.precondition(v)
        old_v, old_w, w, answer = (np.zeros_like(v) for _ in range(4))
        # A load of zeros has eta = 0, so that it asks for no iteration.
        gamma = _norms(z, v)
        old_gamma, eta = np.ones_like(gamma), np.where(v.any(axis=0), gamma, 0.0)
        wanted = REDUCTION * gamma
        c, old_c = np.ones((2, len(gamma)))
        s, old_s = np.zeros((2, len(gamma)))
        count = 0
        while (np.abs(eta) > wanted).any() and count < ITERATIONS:
            count += 1
            z = z / gamma
            moved = self.matrix @ z
            delta = np.einsum("ij,ij->j", moved, z)
            v, old_v = moved - (delta / gamma) * v - (gamma / old_gamma) * old_v, v
            preconditioned = self.precondition(v)
            new = _norms(preconditioned, v)
            a0 = c * delta - old_c * s * gamma
            a1 = np.hypot(a0, new)
            a2 = s * delta + old_c * c * gamma
            a3 = old_s * gamma
            old_c, c, old_s, s = c, a0 / a1, s, new / a1
            w, old_w = (z - a3 * old_w - a2 * w) / a1, w
            answer += (c * eta) * w
            eta = -s * eta
            z, gamma, old_gamma = preconditioned, new, gamma
        return answer.reshape(right.shape), count

    def precondition(self, right: Array) -> Array:
        """Apply the preconditioner to right hand sides (n, k)."""
        m = len(self.inverse)
        moved = self._smoothed(right[:m], None)
        residual = right[:m] - self.strain @ moved
        moved = moved + self.up @ self.coarse.solve(self.down @ residual)
        moved = self._smoothed(right[:m], moved)
        return np.concatenate([moved, self.pressures * right[m:]])

    def _smoothed(self, right: Array, start: Array | None) -> Array:
        """Smooth displacements: DEGREE steps of the Chebyshev iteration from `start`, or 0."""
        middle = (1 + 1 / SPREAD) / 2 * self.largest
        half = (1 - 1 / SPREAD) / 2 * self.largest
        residual = right if start is None else right - self.strain @ start
        step = self.inverse * residual / middle
        answer = step if start is None else start + step
        rho = half / middle
        for _ in range(DEGREE - 1):
            residual = residual - self.strain @ step
            old, rho = rho, 1 / (2 * middle / half - rho)
            step = rho * old * step + (2 * rho / half) * (self.inverse * residual)
            answer = answer + step
        return answer


def iterative(
    space: Space, matrix: sparse.csr_matrix, free: Integers, reduced: sparse.csr_matrix
) -> Iterative:
    """Build the preconditioner of `matrix` of `space`; `reduced` is that of the unknowns `free`.

    Raises
    ------
    InputError
        If the body can move freely, or a cell is degenerate.
    """
    n = space.n_displacements
    moving = free[free < n]
    strain = _strain(matrix[:n][:, :n])[moving][:, moving].tocsr()
    diagonal = strain.diagonal()
    up, coarse = _coarse(space, strain, moving)
    return Iterative(
        matrix=reduced,
        strain=strain,
        inverse=1 / diagonal[:, None],
        largest=MARGIN * _largest(strain, 1 / diagonal),
        up=up,
        down=up.T.tocsr(),
        coarse=coarse,
        pressures=1 / _pressures(reduced, diagonal)[:, None],
    )


def _strain(deviatoric: sparse.csr_matrix) -> sparse.csr_matrix:
    """Return the matrix of 2 mu eps : eps from that of 2 mu dev eps : dev eps.

    With G = integral of mu grad a grad b' for two nodes, the given block is D = tr G + G' - 2/3 G,
    and the wanted one D + 2/3 G.
    """
    given = deviatoric.tobsr(blocksize=(3, 3))
    # tr D = (3 + 1 - 2/3) tr G.
    trace = 0.3 * np.trace(given.data, axis1=1, axis2=2)
    rest = given.data - trace[:, None, None] * np.eye(3)
    # Of rest = G' - 2/3 G: its transpose and 2/3 of itself add up to (1 - 4/9) G.
    slopes = 1.8 * (np.swapaxes(rest, 1, 2) + 2 / 3 * rest)
    blocks = (given.data + 2 / 3 * slopes, given.indices, given.indptr)
    return sparse.bsr_matrix(blocks, shape=given.shape).tocsr()


def _coarse(
    space: Space, strain: sparse.csr_matrix, moving: Integers
) -> tuple[sparse.csr_matrix, multifrontal.Factor]:
    """Interpolation from linear elements to the unknowns `moving`, and the coarse factor."""
    count = len(space.points)
    edges, between = space.scalar.mesh.edges, space.scalar.edge_dofs[0]
    rows = np.concatenate([np.arange(count), between, between])
    columns = np.concatenate([np.arange(count), edges[0], edges[1]])
    values = np.repeat([1.0, 0.5], [count, 2 * len(between)])
    linears = sparse.coo_matrix((values, (rows, columns)), shape=(space.n_nodes, count))
    linear_unknowns = moving[moving < 3 * count]
    up = sparse.kron(linears, sparse.eye(3)).tocsr()[moving][:, linear_unknowns].tocsr()
    number = numbering(linear_unknowns, 3 * count)
    corners = (3 * space.vertices[:, :, None] + np.arange(3)).reshape(len(space.vertices), -1)
    centers = space.points[space.vertices].mean(axis=1)
    parts = dissect(number[corners], centers, len(linear_unknowns))
    return up, multifrontal.factor((up.T @ strain @ up).tocsr(), parts)


def _pressures(reduced: sparse.csr_matrix, diagonal: Array) -> Array:
    """Return the diagonal (n_pressures,) for the pressures: that of B diag(A)^-1 B' + C, C lumped.

    On the scale of a cell it is like the mass over the shear modulus. Measured on cubes, it took
    0.8 of the iterations that the lumped mass takes, and 0.4 where moduli are 1e3 apart.
    """
    m = len(diagonal)
    coupling = reduced[m:][:, :m]
    schur = np.asarray(coupling.power(2) @ (1 / diagonal)).ravel()
    lumped = -np.asarray(reduced[m:][:, m:].sum(axis=1)).ravel()
    return schur + lumped


def _largest(matrix: sparse.csr_matrix, inverse: Array) -> float:
    """Lower estimate of the largest eigenvalue of inverse * matrix, by power iteration."""
    vector = np.random.default_rng(0).normal(size=len(inverse))
    size = 0.0
    for _ in range(POWER):
        vector = inverse * (matrix @ (vector / np.linalg.norm(vector)))
        size = float(np.linalg.norm(vector))
    return size


def _norms(first: Array, second: Array) -> Array:
    """Norms (k,) of columns in the product of `first` and `second`; 1 for a column of zeros."""
    squares = np.einsum("ij,ij->j", first, second)
    return np.sqrt(np.where(squares > 0, squares, 1.0))
