"""Exact complementarity between weighted gaps and pressures, by an active set."""

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve, lu_factor, lu_solve

from fefinger.contact.force_control import CORRECTIONS, depth_of_force
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import PRESS_LESS, ConvergenceError
from fefinger.support.tolerances import COMPLEMENTARITY, FORCE_MATCH


PATIENCE = 12  # block exchanges without fewer violations before single ones take over
EXCHANGES = 500  # limit; block exchanges may cycle, single ones of the last index (Murty) cannot

ENDLESS = f"contact: expected a consistent contact set, found none in {EXCHANGES} exchanges"
INDEFINITE = (
    "contact: expected a positive definite flexibility of the pad, received another; take another "
    "mesh (finger.resolution)"
)


class Complementarity:
    """Solver of w = F lambda + b >= 0, lambda >= 0, lambda . w = 0 for many b and one F.

    Block principal pivoting (Júdice and Pires, Comput. Oper. Res. 21:587, 1994): finite for every
    F whose principal minors are positive. It starts from the last active set, whose factor is
    reused. With `any_sign`, F may be indefinite, as for a body that would buckle without the
    obstacle.
    """

    def __init__(self, flexibility: Array, *, any_sign: bool = False) -> None:
        self.flexibility, self.any_sign = flexibility, any_sign
        self.active = np.zeros(len(flexibility), dtype=bool)
        self._factored: tuple[bytes, Integers, Callable[[Array], Array]] | None = None

    def solve(self, offset: Array) -> Array:
        """Return lambda (n,) for b = `offset` (n,).

        Raises
        ------
        ConvergenceError
            If F is not positive definite or the exchanges do not end.
        """
        least, patience = len(offset) + 1, PATIENCE
        scale = float(np.max(np.abs(offset), initial=0.0))
        for _ in range(EXCHANGES):
            answer = self.on_active(-offset)
            gaps = self.flexibility @ answer + offset
            tension = self.active & (answer < 0)
            penetration = ~self.active & (gaps < -COMPLEMENTARITY * scale)
            wrong = tension | penetration
            if not wrong.any():
                return answer
            count = int(wrong.sum())
            if count < least:
                least, patience = count, PATIENCE
            elif patience > 0:
                patience -= 1
            else:
                # The last violation alone (Murty's rule): slow, but it cannot cycle.
                wrong[: int(np.flatnonzero(wrong)[-1])] = False
            self.active = self.active ^ wrong
        raise ConvergenceError(f"{ENDLESS}; {PRESS_LESS}")

    def on_active(self, right: Array) -> Array:
        """Return x (n,), zero off the active set, with F x = `right` on it."""
        key = self.active.tobytes()
        if self._factored is None or self._factored[0] != key:
            where = np.flatnonzero(self.active)
            self._factored = (key, where, self._inverse(self.flexibility[np.ix_(where, where)]))
        _, where, inverse = self._factored
        answer = np.zeros(len(right))
        if len(where):
            answer[where] = inverse(right[where])
        return answer

    def _inverse(self, block: Array) -> Callable[[Array], Array]:
        """Factor a block of F; return the function that solves with it."""
        try:
            return partial(cho_solve, cho_factor(block, check_finite=False), check_finite=False)
        except LinAlgError as error:
            if not self.any_sign:
                raise ConvergenceError(INDEFINITE) from error
        return partial(lu_solve, lu_factor(block, check_finite=False), check_finite=False)


def pressure_at_force(
    solver: Complementarity,
    g: float,
    free: Array,
    projected: Array,
    force: float,
    guess: float,
    peak: float,
    closing: Array | None = None,
) -> tuple[float, Array, int]:
    """Solve for depth in mm and pressure (n,) kPa at a force in mN; also count the solutions.

    The gaps `free` (n,) mm³ are those at a depth of 0 without pressure; they close by `closing`
    (n,) mm² per mm of depth, by default `projected`; the pressure is g times the elastic one. Under
    no force the depth is at first touch. `guess` mm and `peak` mN as of `depth_of_force`.

    Raises
    ------
    ConvergenceError
        If the force is not reached, or as `Complementarity.solve`.
    """
    closing = projected if closing is None else closing
    touch = float(np.min(free / closing))
    pressure = np.zeros(len(free))
    if force <= 0:
        return touch, pressure, 0

    def borne(depth: float) -> tuple[float, float]:
        pressure[:] = g * solver.solve(free - depth * closing)
        return float(projected @ pressure), g * float(projected @ solver.on_active(closing))

    depth, count = depth_of_force(borne, touch, force, guess=guess, peak=peak, match=FORCE_MATCH)
    if count > CORRECTIONS:
        raise ConvergenceError(
            f"force control: expected {force:.6g} mN, reached {projected @ pressure:.6g} mN after "
            f"{CORRECTIONS} corrections; {PRESS_LESS}"
        )
    return depth, pressure, count
