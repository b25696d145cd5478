"""Contact with friction of a pad and objects at any pose, by the compliance of the pad.

Of F = d . A . d, with the frames d of the vertices, the part of those in contact is set alone;
F x is a product with A.
"""

import numpy as np

from fefinger.contact.coulomb import CoulombIteration
from fefinger.contact.coulomb_kernels import K
from fefinger.contact.pad_gaps import moved
from fefinger.contact.pad_worlds import Work
from fefinger.support.arrays import Array, Floats, Integers
from fefinger.support.compiled import njit


class PosedCoulomb(CoulombIteration):
    """Solver of a step with friction of one world.

    compliance A (3n, 3n) mm³/kPa, of which this keeps no copy; mu: coefficient.
    """

    def __init__(self, compliance: Floats, mu: float) -> None:
        n = len(compliance) // 3
        super().__init__(n, mu)
        self.compliance, self._diagonal = compliance, np.diagonal(compliance).reshape(n, 3)
        self._frame, self._near = np.zeros((3, n, 3)), np.zeros(0, dtype=np.int64)
        self._traction, self._displaced = np.zeros((2, 3 * n))

    def begin(self, frame: Array, m: Work, count: int) -> None:
        """Begin a step, with the frames (3, n, 3) of near vertices.

        x (3n,) is set, and so are the `count` vertices in contact, in `where`.
        """
        self._frame, self._near = frame, m.listed[: m.found[0]]
        self.counts[K], self.moved[:] = count, 0.0
        self.rebuild()
        self._multiply()

    def _gives_way(self, vertices: Integers) -> bool:
        return bool((self._diagonal[vertices] > 0.0).all())

    def _fill(self, start: int) -> None:
        k = int(self.counts[K])
        _fill(self._block.matrix, self.compliance, self._frame, self.where, start, k)

    def _multiply(self) -> None:
        known = self.compliance, self._frame, self._near
        _multiply(self.moved, self.x, *known, self._traction, self._displaced)


@njit(cache=True, fastmath={"contract"})
def _fill(
    matrix: Array, compliance: Floats, frame: Array, where: Integers, start: int, k: int
) -> None:
    """Set the rows and columns (3k, 3k) of vertices from `start` to before k, three of each."""
    turned = np.empty((3, 3))
    for p in range(start, k):
        i = where[p]
        r0, r1, r2 = compliance[3 * i], compliance[3 * i + 1], compliance[3 * i + 2]
        for q in range(p + 1):
            j = where[q]
            for a in range(3):
                x, y, z = frame[a, i, 0], frame[a, i, 1], frame[a, i, 2]
                for c in range(3):
                    at = 3 * j + c
                    turned[a, c] = x * r0[at] + y * r1[at] + z * r2[at]
            for a in range(3):
                for b in range(3):
                    value = (
                        turned[a, 0] * frame[b, j, 0]
                        + turned[a, 1] * frame[b, j, 1]
                        + turned[a, 2] * frame[b, j, 2]
                    )
                    matrix[3 * p + a, 3 * q + b] = value
                    matrix[3 * q + b, 3 * p + a] = value


@njit(cache=True)
def _multiply(
    product: Array,
    x: Array,
    compliance: Floats,
    frame: Array,
    near: Integers,
    traction: Array,
    displaced: Array,
) -> None:
    """Compute F x (3n,) at the near vertices, which x is 0 beyond."""
    n = len(x) // 3
    traction[:] = 0.0
    for j in near:
        for a in range(3):
            on = x[a * n + j]
            for c in range(3):
                traction[3 * j + c] += on * frame[a, j, c]
    moved(compliance, traction, near, displaced)
    for j in near:
        for a in range(3):
            value = 0.0
            for c in range(3):
                value += frame[a, j, c] * displaced[3 * j + c]
            product[a * n + j] = value
