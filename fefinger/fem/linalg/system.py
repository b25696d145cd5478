"""Linear system of mixed elasticity, solved for many loads with iterative refinement.

The factor is in double precision, and the solution is refined until the residual of the true matrix
is small. On the standard finger (reports/bench-fem.json, one thread) the factor is 2.7 times faster
than SuperLU on the same order of the unknowns, and 2.5 times faster for its loads. In trials
PARDISO took 1.4 to 2.9 s for the factor (then 1.9 to 2.4 s) and 0.4 to 1.5 s for 64 loads (here
0.4 s), so neither it nor its 0.9 GB of MKL is a dependency. CHOLMOD is no choice: the matrix is
quasi-definite, which its supernodal code refuses. A factor in single precision saved 5 to 20 % of
the peak memory, and MINRES took 50 times as long for each load.

For nu < 0.5 the matrix is quasi-definite; at nu = 0.5 a slightly compressible neighbor is factored.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy import sparse

from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg import multifrontal, multifrontal_indefinite
from fefinger.fem.linalg.dissection import Dissection, dissect_space
from fefinger.fem.linalg.multifrontal_indefinite import ApproximateFactor, Precision
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.processes import one_thread
from fefinger.support.tolerances import FACTOR_COMPRESSIBILITY, FORCE_BALANCE, LINEAR_RESIDUAL


class Solver(Protocol):
    """Interface of a factor: approximate solutions for right hand sides (n,) or (n, k)."""

    def solve(self, right: Array) -> Array:
        """Return the approximate solution in the shape of `right`."""
        ...


@dataclass(eq=False)
class System:
    """Equations with the unknowns `fixed` (n_fixed,) prescribed, and their factor.

    matrix (n_unknowns, n_unknowns) of all unknowns of the space; free (n,): those to be solved for;
    reduced (n, n): their matrix; dissection: the order of the factor; failed: why single precision
    failed, once for each factor that `approximate_factor` had to make in double.
    """

    space: Space
    matrix: sparse.csr_matrix
    fixed: Integers
    free: Integers
    reduced: sparse.csr_matrix
    dissection: Dissection
    failed: list[str] = field(default_factory=list)

    @cached_property
    def solver(self) -> Solver:
        """The factor, made on first use; InputError if the matrix is singular."""
        return multifrontal.factor(self.neighbor(self.matrix), self.dissection)

    def neighbor(self, matrix: sparse.csr_matrix) -> sparse.csr_matrix:
        """Return the `compressible` matrix (n, n) of the free unknowns: the one that is factored.

        It is slightly compressible and quasi-definite.
        """
        return compressible(self.space, matrix)[self.free][:, self.free].tocsr()

    @property
    def rigid(self) -> Array:
        """Translations and rotations (n_free, 6) of the body, restricted to the free unknowns."""
        axes, places = np.eye(3), self.space.node_points
        motions = np.zeros((self.space.n_unknowns, 6))
        for k, axis in enumerate(axes):
            motions[: self.space.n_displacements, k] = np.tile(axis, len(places))
            motions[: self.space.n_displacements, 3 + k] = np.cross(axis, places).ravel()
        return motions[self.free]

    @cached_property
    def approximate_factor(self) -> ApproximateFactor:
        """Approximate factor of the matrix at rest, cached; see the function of this name.

        Raises InputError if the matrix is singular.
        """
        return approximate_factor(self.matrix, self, held=True)

    @one_thread
    def solve(self, loads: Array, prescribed: Array | None = None) -> Array:
        """Return the unknowns (n,) or (n, k) under loads of the same shape.

        `prescribed` gives the values of the fixed unknowns, (n_fixed,) or (n_fixed, k); without it
        they are zero.

        Raises ConvergenceError if the relative residual stays above `tolerances.LINEAR_RESIDUAL`
        or, where rounding allows no less, above `tolerances.FORCE_BALANCE`.
        """
        right = loads[self.free]
        if prescribed is not None:
            right = right - self.matrix[self.free][:, self.fixed] @ prescribed
        answer = np.zeros_like(loads)
        answer[self.free] = self._iterated(right)
        if prescribed is not None:
            answer[self.fixed] = prescribed
        return answer

    def reactions(self, unknowns: Array, loads: Array) -> Array:
        """Return the forces (n_fixed,) or (n_fixed, k) in mN that hold the fixed unknowns."""
        return np.asarray(self.matrix[self.fixed] @ unknowns - loads[self.fixed])

    def _iterated(self, right: Array) -> Array:
        """Solve with iterative refinement until the true residual is small."""
        scale = np.linalg.norm(right, axis=0)
        scale = np.where(scale > 0, scale, 1.0)
        answer, worst = self.solver.solve(right), np.inf
        refinements = 8  # limit of iterative refinement
        for _ in range(refinements):
            residual, last = right - self.reduced @ answer, worst
            worst = float(np.max(np.linalg.norm(residual, axis=0) / scale, initial=0.0))
            if worst <= LINEAR_RESIDUAL:
                return answer
            if last / 2 < worst <= FORCE_BALANCE:
                break  # no longer falls: the rest may be rounding, which is judged below
            answer = answer + self.solver.solve(residual)
        # A stiff part on a soft one moves nearly rigidly: its forces are differences of large
        # numbers, and the attainable residual is eps times the sum of their magnitudes.
        sums = np.linalg.norm(abs(self.reduced) @ np.abs(answer), axis=0)
        rounding = float(np.finfo(float).eps * np.max(sums / scale, initial=0.0))
        if worst <= min(rounding, FORCE_BALANCE):
            return answer
        advice = "check the held facets, the mesh, and whether the moduli are too far apart"
        if worst <= rounding:
            advice = (
                f"rounding alone may cause {rounding:.1e} between a stiff tissue and the soft one "
                "that carries it; bring their moduli closer or hold the stiff one"
            )
        message = (
            f"linear solution: expected a relative residual of at most "
            f"{LINEAR_RESIDUAL:g}, reached {worst:.1e}; {advice}"
        )
        raise ConvergenceError(message)


@one_thread
def factor(space: Space, matrix: sparse.csr_matrix, fixed: Integers) -> System:
    """Build and factor the system of `matrix` of `space`, with the unknowns `fixed` prescribed.

    Raises InputError if the fixed unknowns leave a rigid motion free, or a cell is degenerate.
    """
    system = prepare(space, matrix, fixed)
    _ = system.solver  # factor now, so that a singular system is reported here
    return system


def prepare(space: Space, matrix: sparse.csr_matrix, fixed: Integers) -> System:
    """Build the system as `factor`, but factor the matrix on first use.

    InputError if no unknown is prescribed.
    """
    held = np.unique(fixed)
    if not len(held):
        message = "held facets: expected at least one held face, received none"
        raise InputError(message)
    free = np.setdiff1d(np.arange(space.n_unknowns), held)
    reduced, dissection = matrix[free][:, free].tocsr(), dissect_space(space, free)
    return System(space, matrix, held, free, reduced, dissection)


@one_thread
def approximate_factor(
    matrix: sparse.csr_matrix, system: System, *, held: bool = False
) -> ApproximateFactor:
    """Make an approximate factor of `matrix` on the free unknowns of `system`.

    In single precision or, where that fails, in double. With `held`, the factor also fails where
    it does not solve for rigid motions, as in a body without held facets.

    Raises InputError if it is singular, or beyond double precision.
    """
    close = system.neighbor(matrix)
    rigid = system.rigid if held else np.empty((len(system.free), 0))

    left = 0.1  # largest relative residual of a factor for the rigid motions of a held body

    def factored(precision: Precision) -> ApproximateFactor:
        approximate = multifrontal_indefinite.factor(close, system.dissection, precision)
        residual = np.linalg.norm(close @ approximate.solve(rigid) - rigid, axis=0)
        # "not <=" also catches nan.
        if not (residual <= left * np.linalg.norm(rigid, axis=0)).all():
            raise InputError(multifrontal.SINGULAR)
        return approximate

    try:
        return factored(np.float32)
    except InputError as error:
        in_double = factored(np.float64)
        system.failed.append(str(error))
    return in_double


def compressible(
    space: Space, matrix: sparse.csr_matrix, least: float = FACTOR_COMPRESSIBILITY
) -> sparse.csr_matrix:
    """Return the matrix with at least the compressibility `least` on the pressure diagonal."""
    n = space.n_displacements
    wanted = least * np.asarray(abs(matrix[n:][:, :n]).sum(axis=1)).ravel()
    shift = np.zeros(space.n_unknowns)
    shift[n:] = np.maximum(wanted + matrix.diagonal()[n:], 0.0)  # C stands there as -C
    return matrix - sparse.diags(shift, format="csr") if shift.any() else matrix
