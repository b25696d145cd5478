"""SuperLU, the sparse factor of SciPy: a baseline of speed, and an independent check in tests."""

from typing import cast

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg.system import System, prepare
from fefinger.support.arrays import Array, Integers


class SuperLU:
    """Factor of SuperLU, symmetric and in the order of our own, which is better than its orders."""

    def __init__(self, system: System) -> None:
        self._order = system.dissection.order
        self.factor = splu(
            system.neighbor(system.matrix)[self._order][:, self._order].tocsc(),
            permc_spec="NATURAL",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True, "Equil": False},
        )

    def solve(self, right: Array) -> Array:
        """Return the approximate solution in the shape of `right`."""
        answer = np.empty_like(right)
        answer[self._order] = self.factor.solve(right[self._order])
        return answer


def factor(space: Space, matrix: sparse.csr_matrix, fixed: Integers) -> System:
    """Return the system that `fem.linalg.system.factor` returns, with SuperLU as its solver."""
    system = prepare(space, matrix, fixed)
    system.solver = SuperLU(system)
    return system


def entries(system: System) -> int:
    """Return the number of entries of a factor of SuperLU."""
    return int(cast(SuperLU, system.solver).factor.L.nnz)
