"""The approximate linear solvers behind one small interface.

`system.System` refines the solution until the true residual is small, so that the solver decides
time and memory but not the answer. In the order of choice:

- "multifrontal": a factor in double precision, the fastest where it fits in memory.
- "single": a factor in single precision, for half the memory. It converges for ratios of moduli
  up to about 1e4; where it fails, the factor in double precision replaces it.
- "iterative": MINRES without a factor of the matrix: memory grows in proportion to the unknowns. A
  load costs some 170 iterations at every size and Poisson's ratio, and 3 times as many where a
  part that is 1e3 to 1e6 times as stiff floats in the rest (reports/bench-fem.json).

CHOLMOD is no choice: the matrix is quasi-definite, which its supernodal code refuses, and its
simplicial one took 11 times as long as "multifrontal" on 28 thousand unknowns.
"""

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from scipy import sparse

from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg import multifrontal, multifrontal_indefinite
from fefinger.fem.linalg.dissection import Dissection
from fefinger.fem.linalg.minres import iterative
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError
from fefinger.support.tolerances import FACTOR_COMPRESSIBILITY


ROOM = 0.5  # share of the free memory that a factor may take
WORKING = 1.5  # memory while factoring, over that of the factor
SPREAD = 1e5  # largest ratio of diagonal entries for which single precision converges

SINGLE_FAILED = (
    "The factor in single precision failed; the factor in double precision, with twice the "
    "memory, was used instead."
)


class Solver(Protocol):
    """Interface of a solver: approximate solutions for right hand sides (n,) or (n, k)."""

    def solve(self, right: Array) -> Array:
        """Return the approximate solution in the shape of `right`."""
        ...


@dataclass(frozen=True)
class Equations:
    """Input of a solver: the matrix, its free unknowns and their dissection.

    matrix (n_unknowns, n_unknowns) of all unknowns of the space; free (n,): those to be solved for;
    reduced (n, n): their matrix; dissection: the order of a factor.
    """

    space: Space
    matrix: sparse.csr_matrix
    free: Integers
    reduced: sparse.csr_matrix
    dissection: Dissection

    @property
    def neighbor(self) -> sparse.csr_matrix:
        """The slightly compressible, quasi-definite matrix (n, n) that is factored."""
        return neighbor(self.space, self.matrix, self.free)


class Prepared:
    """The solver `name` of some equations, built on first use.

    Where single precision fails, the solver in double precision replaces it; `notes` then say so.
    """

    def __init__(self, name: str, equations: Equations) -> None:
        self.name, self.equations = name, equations
        self.notes: tuple[str, ...] = ()
        self._made: Solver | None = None

    @property
    def made(self) -> Solver:
        """The solver itself.

        Raises
        ------
        InputError
            If the matrix is singular, also in double precision.
        """
        if self._made is None:
            try:
                self._made = SOLVERS[self.name](self.equations)
            except InputError:
                if not self.use_double():
                    raise
                self._made = SOLVERS[self.name](self.equations)
        return self._made

    def solve(self, right: Array) -> Array:
        """Return the approximate solution in the shape of `right`."""
        return self.made.solve(right)

    def use_double(self) -> bool:
        """Switch from single to double precision; False if it is not in single precision."""
        if self.name != "single":
            return False
        self.name, self.notes, self._made = "multifrontal", (SINGLE_FAILED,), None
        return True


def choose(equations: Equations) -> str:
    """Choose the fastest solver that fits in the free memory, by name."""
    room = ROOM * free_memory()
    size = WORKING * equations.dissection.entries
    if 8 * size <= room:
        return "multifrontal"
    diagonal = equations.reduced.diagonal()
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


def neighbor(space: Space, matrix: sparse.csr_matrix, free: Integers) -> sparse.csr_matrix:
    """Return the `compressible` matrix of the unknowns `free` (n,): the one that is factored."""
    return compressible(space, matrix)[free][:, free].tocsr()


SOLVERS: Mapping[str, Callable[[Equations], Solver]] = {
    "multifrontal": lambda e: multifrontal.factor(e.neighbor, e.dissection),
    "single": lambda e: multifrontal_indefinite.factor(e.neighbor, e.dissection),
    "iterative": lambda e: iterative(e.space, e.matrix, e.free, e.reduced),
}
