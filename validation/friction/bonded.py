"""Limits of the coefficient of friction, and the same contact by another method."""

import numpy as np
from fefinger.validation.friction.sheared import CONTACT, RADIUS, contact, limit
from fefinger.validation.oracles.coulomb import projected

from fefinger.contact.active_set import DONE
from fefinger.contact.complementarity import Complementarity
from fefinger.contact.coulomb import CoulombSolver
from fefinger.support.arrays import Array
from fefinger.support.tolerances import COMPLEMENTARITY


SQUARES = 10
HUGE = 1e9


def solved(flexibility: Array, offset: Array, mu: float) -> Array:
    """Return pressures and tractions (3n,) of one contact without a past."""
    state = CoulombSolver(flexibility, mu)
    outcome = state.solve(offset, COMPLEMENTARITY)
    if outcome != DONE:
        message = f"friction: no solution, outcome {outcome}"
        raise ArithmeticError(message)
    return state.x.copy()


def offset(moved: float) -> tuple[Array, Array]:
    """Return F and what is to be overcome (3n,) where the sphere is pressed and sheared at once.

    The body has nu < 1/2, so that pressure and traction do move each other's contact.
    """
    on = contact("squares", SQUARES, 0.3)
    depth = CONTACT**2 / RADIUS
    rest = np.concatenate([on.gap - depth * on.areas, -moved * on.areas, 0.3 * moved * on.areas])
    return on.flexibility, rest


def against_gradients(mu: float, part: float) -> float:
    """Return the largest difference from projected gradients, over the largest pressure.

    Sheared by a part of the displacement at which all slides.
    """
    matrix, rest = offset(part * limit())
    x = solved(matrix, rest, mu)
    return float(np.abs(x - projected(matrix, rest, mu)).max() / x.max())


def turned(angle: float = 37.0) -> float:
    """Return the largest difference of the solution in axes turned in the plane, by degrees.

    Over the largest pressure: Coulomb's law knows no direction.
    """
    matrix, rest = offset(0.7 * limit())
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    axes = np.kron([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]], np.eye(len(rest) // 3))
    x = solved(matrix, rest, 0.5)
    turned = solved(axes @ matrix @ axes.T, axes @ rest, 0.5)
    return float(np.abs(turned - axes @ x).max() / x.max())


def against_frictionless() -> float:
    """Return the largest difference of mu = 0 from contact without friction."""
    matrix, rest = offset(limit())
    n = len(rest) // 3
    x = solved(matrix, rest, 0.0)
    pressure = Complementarity(matrix[:n, :n]).solve(rest[:n])
    return float(max(np.abs(x[:n] - pressure).max(), np.abs(x[n:]).max()) / pressure.max())


def against_bonded() -> float:
    """Return the largest difference of a huge mu from one system of the vertices in contact."""
    matrix, rest = offset(0.2 * limit())
    n = len(rest) // 3
    x = solved(matrix, rest, HUGE)
    chosen = np.flatnonzero(np.tile(x[:n] > 0, 3))
    bonded = np.zeros(3 * n)
    bonded[chosen] = np.linalg.solve(matrix[np.ix_(chosen, chosen)], -rest[chosen])
    return float(np.abs(x - bonded).max() / np.abs(bonded).max())
