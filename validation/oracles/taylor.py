"""Taylor test of a Jacobian."""

from collections.abc import Sequence

import numpy as np

from fefinger.calibration.inverse import Residual, Unknown, Values, jacobian
from fefinger.support.arrays import Array


def remainders(residual: Residual, unknowns: Sequence[Unknown], values: Values) -> Array:
    """First-order remainders (3,) at steps of 0.02, 0.01, 0.005 in a random direction.

    With a correct Jacobian each is a quarter of the one before.
    """
    matrix = jacobian(residual, unknowns, values)
    way = np.random.default_rng(0).normal(size=len(unknowns))
    here, out = residual(values), []
    for size in (0.02, 0.01, 0.005):
        moved = values | {
            each.name: each.outside(each.inside(values[each.name]) + size * w)
            for each, w in zip(unknowns, way.tolist(), strict=True)
        }
        out.append(np.linalg.norm(residual(moved) - here - size * matrix @ way))
    return np.array(out)
