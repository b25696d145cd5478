"""Linear system of mixed elasticity, solved for many loads with iterative refinement.

The solution is refined until the residual of the true matrix is small, so that the approximate
solver decides time and memory but not the answer. In the order of choice:

- "multifrontal": a factor in double precision, the fastest where it fits in memory. On the standard
  finger (reports/bench-fem.json, one thread) it is 4 times faster than SuperLU on the same order of
  the unknowns, and 3 times faster for its loads. In trials PARDISO took 1.4 to 2.9 s for the factor
  (here 1.9 to 2.4 s) and 0.4 to 1.5 s for 64 loads (here 0.4 s), so neither it nor its 0.9 GB of
  MKL is a dependency. CHOLMOD is no choice: the matrix is quasi-definite, which its supernodal code
  refuses, and its simplicial one took 11 times as long on 28 thousand unknowns.
- "single": a factor in single precision, for half the memory. It converges for ratios of moduli
  up to about 1e4; where it fails, the factor in double precision replaces it.
- "iterative": MINRES without a factor of the matrix: memory grows in proportion to the unknowns. A
  load costs some 170 iterations at every size and Poisson's ratio, and 3 times as many where a
  part that is 1e3 to 1e6 times as stiff floats in the rest (reports/bench-fem.json).

For nu < 0.5 the matrix is quasi-definite; at nu = 0.5 a slightly compressible neighbor is factored.
"""

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Protocol

import numpy as np
from scipy import sparse

from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg import multifrontal, multifrontal_indefinite
from fefinger.fem.linalg.dissection import Dissection, dissect_space
from fefinger.fem.linalg.minres import iterative
from fefinger.fem.linalg.multifrontal_indefinite import ApproximateFactor, Precision
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError, InputError, choice
from fefinger.support.threads import one_thread
from fefinger.support.tolerances import FACTOR_COMPRESSIBILITY, FORCE_BALANCE, LINEAR_RESIDUAL


ROOM = 0.5  # share of the free memory that a factor may take
WORKING = 1.5  # memory while factoring, over that of the factor
SPREAD = 1e5  # largest ratio of diagonal entries for which single precision converges

REFINEMENTS = 8  # limit of iterative refinement
LEFT = 0.1  # largest relative residual of a factor for the rigid motions of a held body

SINGLE_FAILED = (
    "The factor in single precision failed; the factor in double precision, with twice the "
    "memory, was used instead."
)


class Solver(Protocol):
    """Interface of a solver: approximate solutions for right hand sides (n,) or (n, k)."""

    def solve(self, right: Array) -> Array:
        """Return the approximate solution in the shape of `right`."""
        ...


@dataclass(eq=False)
class System:
    """Equations with the unknowns `fixed` (n_fixed,) prescribed, and their solver.

    matrix (n_unknowns, n_unknowns) of all unknowns of the space; free (n,): those to be solved for;
    reduced (n, n): their matrix; dissection: the order of a factor; name: of the solver; notes: on
    a solver in single precision that failed; failed: why single precision failed, once for each
    factor that `approximate_factor` had to make in double.
    """

    space: Space
    matrix: sparse.csr_matrix
    fixed: Integers
    free: Integers
    reduced: sparse.csr_matrix
    dissection: Dissection
    name: str
    notes: tuple[str, ...] = ()
    failed: list[str] = field(default_factory=list)

    @cached_property
    def solver(self) -> Solver:
        """The solver, built on first use.

        Raises
        ------
        InputError
            If the matrix is singular, also in double precision.
        """
        try:
            return SOLVERS[self.name](self)
        except InputError:
            if not self._use_double():
                raise
            return SOLVERS[self.name](self)

    def neighbor(self, matrix: sparse.csr_matrix) -> sparse.csr_matrix:
        """Return the `compressible` matrix (n, n) of the free unknowns: the one that is factored.

        It is slightly compressible and quasi-definite.
        """
        return compressible(self.space, matrix)[self.free][:, self.free].tocsr()

    def _use_double(self) -> bool:
        """Switch from single to double precision; False if it is not in single precision."""
        if self.name != "single":
            return False
        self.name, self.notes = "multifrontal", (SINGLE_FAILED,)
        self.__dict__.pop("solver", None)
        return True

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

        Raises
        ------
        InputError
            If the matrix is singular.
        """
        return approximate_factor(self.matrix, self, held=True)

    @one_thread
    def solve(self, loads: Array, prescribed: Array | None = None) -> Array:
        """Return the unknowns (n,) or (n, k) under loads of the same shape.

        `prescribed` gives the values of the fixed unknowns, (n_fixed,) or (n_fixed, k); without it
        they are zero.

        Raises
        ------
        ConvergenceError
            If the relative residual stays above `tolerances.LINEAR_RESIDUAL` or, where rounding
            allows no less, above `tolerances.FORCE_BALANCE`.
        """
        right = loads[self.free]
        if prescribed is not None:
            right = right - self.matrix[self.free][:, self.fixed] @ prescribed
        answer = np.zeros_like(loads)
        answer[self.free] = self._refined(right)
        if prescribed is not None:
            answer[self.fixed] = prescribed
        return answer

    def reactions(self, unknowns: Array, loads: Array) -> Array:
        """Return the forces (n_fixed,) or (n_fixed, k) in mN that hold the fixed unknowns."""
        return np.asarray(self.matrix[self.fixed] @ unknowns - loads[self.fixed])

    def _refined(self, right: Array) -> Array:
        """Solve; repeat with a factor in double precision where the single one fails."""
        try:
            return self._iterated(right)
        except ConvergenceError:
            if not self._use_double():
                raise
        return self._iterated(right)

    def _iterated(self, right: Array) -> Array:
        """Solve with iterative refinement until the true residual is small."""
        scale = np.linalg.norm(right, axis=0)
        scale = np.where(scale > 0, scale, 1.0)
        answer, worst = self.solver.solve(right), np.inf
        for _ in range(REFINEMENTS):
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
            f"linear solution ({self.name}): expected a relative residual of at most "
            f"{LINEAR_RESIDUAL:g}, reached {worst:.1e}; {advice}"
        )
        raise ConvergenceError(message)


SOLVERS: Mapping[str, Callable[[System], Solver]] = {
    "multifrontal": lambda s: multifrontal.factor(s.neighbor(s.matrix), s.dissection),
    "single": lambda s: multifrontal_indefinite.factor(s.neighbor(s.matrix), s.dissection),
    "iterative": lambda s: iterative(s.space, s.matrix, s.free, s.reduced),
}


@one_thread
def factor(
    space: Space,
    matrix: sparse.csr_matrix,
    fixed: Integers,
    solver: str | None = None,
) -> System:
    """Build and factor the system of `matrix` of `space`, with the unknowns `fixed` prescribed.

    `solver` is one of `SOLVERS`; default `choose`.

    Raises
    ------
    InputError
        If the fixed unknowns leave a rigid motion free, a cell is degenerate, or the solver is not
        known.
    """
    system = prepare(space, matrix, fixed, solver)
    _ = system.solver  # factor now, so that a singular system is reported here
    return system


def prepare(
    space: Space,
    matrix: sparse.csr_matrix,
    fixed: Integers,
    solver: str | None = None,
) -> System:
    """Build the system as `factor`, but factor the matrix on first use.

    Raises
    ------
    InputError
        If no unknown is prescribed, or the solver is not known.
    """
    held = np.unique(fixed)
    if not len(held):
        message = "held facets: expected at least one held face, received none"
        raise InputError(message)
    free = np.setdiff1d(np.arange(space.n_unknowns), held)
    reduced, dissection = matrix[free][:, free].tocsr(), dissect_space(space, free)
    if solver is None:
        name = choose(reduced, dissection)
    else:
        name = choice("ask.solver", solver, SOLVERS)
    return System(space, matrix, held, free, reduced, dissection, name)


@one_thread
def approximate_factor(
    matrix: sparse.csr_matrix, system: System, *, held: bool = False
) -> ApproximateFactor:
    """Make an approximate factor of `matrix` on the free unknowns of `system`.

    In single precision or, where that fails, in double. With `held`, the factor also fails where
    it does not solve for rigid motions, as in a body without held facets.

    Raises
    ------
    InputError
        If it is singular, or beyond double precision.
    """
    close = system.neighbor(matrix)
    rigid = system.rigid if held else np.empty((len(system.free), 0))

    def factored(precision: Precision) -> ApproximateFactor:
        approximate = multifrontal_indefinite.factor(close, system.dissection, precision)
        residual = np.linalg.norm(close @ approximate.solve(rigid) - rigid, axis=0)
        # "not <=" also catches nan.
        if not (residual <= LEFT * np.linalg.norm(rigid, axis=0)).all():
            raise InputError(multifrontal.SINGULAR)
        return approximate

    try:
        return factored(np.float32)
    except InputError as error:
        in_double = factored(np.float64)
        system.failed.append(str(error))
    return in_double


def choose(reduced: sparse.csr_matrix, dissection: Dissection) -> str:
    """Choose the fastest solver that fits in the free memory, by name; arguments as of `System`."""
    room = ROOM * free_memory()
    size = WORKING * dissection.entries
    if 8 * size <= room:
        return "multifrontal"
    diagonal = reduced.diagonal()
    stiffness = diagonal[diagonal > 0]
    if 4 * size <= room and stiffness.max() <= SPREAD * stiffness.min():
        return "single"
    return "iterative"


def free_memory() -> float:
    """Free memory in bytes; the installed memory where the free one is not known, or else inf."""
    with suppress(OSError, StopIteration):
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        line = next(line for line in lines if line.startswith("MemAvailable:"))
        return 1024.0 * int(line.split()[1])
    with suppress(AttributeError, ValueError, OSError):
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    return float("inf")


def compressible(
    space: Space, matrix: sparse.csr_matrix, least: float = FACTOR_COMPRESSIBILITY
) -> sparse.csr_matrix:
    """Return the matrix with at least the compressibility `least` on the pressure diagonal."""
    n = space.n_displacements
    wanted = least * np.asarray(abs(matrix[n:][:, :n]).sum(axis=1)).ravel()
    shift = np.zeros(space.n_unknowns)
    shift[n:] = np.maximum(wanted + matrix.diagonal()[n:], 0.0)  # C stands there as -C
    return matrix - sparse.diags(shift, format="csr") if shift.any() else matrix
