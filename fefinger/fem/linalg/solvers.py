"""The linear solvers, behind one small interface: something that comes near a solution.

`solve.System` refines what a solver returns until the true residual is small, so that a solver
decides time and memory and never the answer. In the order of choice:

- "multifrontal": our factor in double precision, the fastest where it fits in memory.
- "single": the same in single precision, for half the memory. It converges until moduli are some
  1e4 apart, and gives way to the one in double precision where it fails.
- "iterative": MINRES with no factor of the matrix: memory grows as the unknowns do. A load costs
  some 170 iterations at every size and Poisson's ratio, and 3 times as many where a part that is
  1e3 to 1e6 times as stiff floats in the rest (reports/bench-fem.json).

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

from fefinger.fem.elements.spaces import Array, Integers, Space
from fefinger.fem.linalg import multifrontal, multifrontal_single
from fefinger.fem.linalg.minres import iterative
from fefinger.fem.linalg.multifrontal import Dissection
from fefinger.support.checks import InputError
from fefinger.support.tolerances import FACTOR_COMPRESSIBILITY


ROOM = 0.5  # part of the free memory that a factor may take
WORKING = 1.5  # memory while factoring, over that of the factor
SPREAD = 1e5  # of the diagonal: beyond it single precision does not converge

GAVE_WAY = (
    "The factor in single precision failed; the one in double precision, of twice the memory, "
    "was taken instead."
)


class Solver(Protocol):
    """What returns solutions, approximately, for right hand sides (n,) or (n, k)."""

    @property
    def entries(self) -> int:
        """Number of entries stored."""
        ...

    def solve(self, right: Array) -> Array:
        """Return the approximate solution in the shape of `right`."""
        ...


@dataclass(frozen=True)
class Equations:
    """What a solver is made from.

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
        return compressible(self.space, self.matrix)[self.free][:, self.free].tocsr()


class Prepared:
    """The solver `name` of some equations, made when it is first needed.

    One in single precision that fails gives way to the one in double; `notes` then say so.
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
                if not self.give_way():
                    raise
                self._made = SOLVERS[self.name](self.equations)
        return self._made

    @property
    def entries(self) -> int:
        """Number of entries stored."""
        return self.made.entries

    def solve(self, right: Array) -> Array:
        """Return the approximate solution in the shape of `right`."""
        return self.made.solve(right)

    def give_way(self) -> bool:
        """Turn from single to double precision; False where it is not in single precision."""
        if self.name != "single":
            return False
        self.name, self.notes, self._made = "multifrontal", (GAVE_WAY,), None
        return True


def choose(equations: Equations) -> str:
    """Return the name of the fastest solver that fits in the free memory."""
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
    """Return the free memory in bytes; without a count of what is free all, or else inf."""
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
    """Return the matrix with at least that compressibility on the diagonal of the pressures."""
    shift = _lacking(space, matrix, least)
    return matrix - sparse.diags(shift, format="csr") if shift.any() else matrix


def _lacking(space: Space, matrix: sparse.csr_matrix, least: float) -> Array:
    """Return what each unknown's diagonal (n_unknowns,) lacks of that compressibility."""
    pressure = np.arange(space.n_displacements, space.n_unknowns)
    coupling = abs(matrix[pressure][:, : space.n_displacements])
    wanted = least * np.asarray(coupling.sum(axis=1)).ravel()
    present = -matrix.diagonal()[pressure]
    shift = np.zeros(space.n_unknowns)
    shift[pressure] = np.maximum(wanted - present, 0.0)
    return shift


SOLVERS: Mapping[str, Callable[[Equations], Solver]] = {
    "multifrontal": lambda e: multifrontal.factor(e.neighbor, e.dissection),
    "single": lambda e: multifrontal_single.factor(e.neighbor, e.dissection),
    "iterative": lambda e: iterative(e.space, e.matrix, e.free, e.reduced),
}
