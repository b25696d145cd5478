"""Records and relaxation of a viscoelastic contact, and the depth of a step at a given force.

With one relaxation function for the body, the displacement follows from an elastic pressure q: that
of the fully relaxed body at this displacement (Lee and Radok, J. Appl. Mech. 27:438, 1960). The
contact pressure is its hereditary integral, p = integral of G(t - s) dq(s). Over a step in which q
is linear the integral is exact: p = g q + h, with g and h from one exponential per Prony term.
The compiled steps are in `step_compiled.py`, the way through time in `march.py`.
"""

from dataclasses import dataclass

import numpy as np

from fefinger.fem.contact.complementarity import Complementarity
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import PRESS_LESS, ConvergenceError
from fefinger.support.compiled import njit
from fefinger.support.tolerances import FORCE_MATCH, LEAST_FORCE, SMALL_FORCE


CORRECTIONS = 60  # Newton or bisection steps on the depth under force control


@dataclass(frozen=True)
class SlidingHistory:
    """Path, tangential force and slip of a contact over time.

    shift (n_t, 2) mm of the obstacle across its axis; slopes (n_t, 2) mN: the force on the meshed
    part with which pressure on inclined heights pushes along these two directions. With friction:
    traction (n_t, 2, n) kPa on the skin, slip (n_t, 2, n) mm of the skin over the obstacle, summed
    since first contact, sticking (n_t, n), lost (n_t,) µJ: the work of friction so far, and cone:
    the largest distance of a traction from Coulomb's law, over the largest pressure.
    """

    shift: Array
    slopes: Array
    traction: Array | None = None
    slip: Array | None = None
    sticking: Flags | None = None
    lost: Array | None = None
    cone: float = 0.0


@dataclass(frozen=True)
class History:
    """Contact through time.

    depth (n_t,) mm, pressure (n_t, n) kPa the contact pressure p, elastic_pressure (n_t, n) kPa the
    elastic one q, followed by both components of the elastic traction where there is friction
    (n_t, 3n); exchanges counts the contact solutions; sliding: where the obstacle moves
    sideways or has friction.
    """

    depth: Array
    pressure: Array
    elastic_pressure: Array
    exchanges: int
    sliding: SlidingHistory | None = None


def increments(weights: Array, rates: Array, step: float) -> Array:
    """Return the stress of each Prony term (n,) per strain that grows linearly over a step in s."""
    exponent = rates * step
    return np.asarray(weights * (-np.expm1(-exponent) / exponent if step > 0 else 1.0))


class Relaxation:
    """Internal variables of a Prony series whose long-time value is 1: G(0) = 1 / c0.

    weights (1 + n,) add up to 1, rates (n,) in 1/s. Before the first step the body is at rest.
    """

    def __init__(self, weights: Array, rates: Array, size: int) -> None:
        self.weights = weights[1:] / weights[0]
        self.rates = rates
        self.terms = np.zeros((len(rates), size))
        self.elastic = np.zeros(size)

    def factors(self, step: float) -> tuple[float, Array, Array]:
        """Return g, the decays (n,) and the weights (n,) of the increment for a step in seconds."""
        gain = increments(self.weights, self.rates, step)
        return 1.0 + float(gain.sum()), np.exp(-self.rates * step), gain

    def history(self, step: float) -> tuple[float, Array]:
        """Return g and h (size,) of p = g q + h at the end of a step."""
        g, decay, gain = self.factors(step)
        return g, decay @ self.terms - gain.sum() * self.elastic

    def advance(self, step: float, elastic: Array) -> None:
        """Update the internal variables with the elastic pressure at the end of a step."""
        _, decay, gain = self.factors(step)
        increment = elastic - self.elastic
        self.terms = decay[:, None] * self.terms + gain[:, None] * increment
        self.elastic = elastic


@dataclass(frozen=True)
class Prescribed:
    """Prescribed depth in mm or force in mN of the indenter at each time in s."""

    control: str
    time: Array
    value: Array


@njit(cache=True)
def corrected(
    depth: float, excess: float, rise: float, low: float, high: float, first_touch: float
) -> tuple[float, float, float]:
    """Correct a depth in mm by Newton's method, inside a bracket that may be open above.

    `excess` mN is that of the force at this depth, `rise` mN/mm its slope, 0 or less if unknown.
    Return the next depth and the bracket.
    """
    if excess < 0.0:
        low = depth
    else:
        high = depth
    depth = depth - excess / rise if rise > 0.0 else 2.0 * depth - first_touch
    if not (low < depth and depth < high):
        depth = (low + high) / 2.0 if np.isfinite(high) else low + 2.0 * (low - first_touch)
    return depth, low, high


def depth_at(
    solver: Complementarity,
    g: float,
    free: Array,
    projected: Array,
    force: float,
    guess: float,
    peak: float,
    closing: Array | None = None,
) -> tuple[float, Array, int]:
    """Solve for depth and pressure at a force in mN; also return the number of contact solutions.

    The gaps `free` (n,) mm³ are those at a depth of 0 without pressure; they close by `closing`
    (n,) mm² per mm of depth, by default `projected`.

    The force is a rising, piecewise linear function of the depth: Newton's method, kept inside a
    bracket that starts at the last depth without contact. `peak` in mN is the largest force of the
    path, which scales the tolerance of small forces.
    """
    closing = projected if closing is None else closing
    first_touch = float(np.min(free / closing))
    if force <= 0:
        return first_touch, np.zeros(len(free)), 0
    close = FORCE_MATCH * max(force, SMALL_FORCE * peak, LEAST_FORCE)
    low, high = first_touch, np.inf
    # A little beyond first touch, where there is a contact whose slope Newton can follow.
    depth = max(guess, first_touch + 1e-6 * (1.0 + abs(first_touch)))
    for count in range(1, CORRECTIONS + 1):
        pressure = g * solver.solve(free - depth * closing)
        excess = float(projected @ pressure) - force
        if abs(excess) <= close:
            return depth, pressure, count
        rise = g * float(projected @ solver.on_active(closing))
        depth, low, high = corrected(depth, excess, rise, low, high, first_touch)
    message = (
        f"force control: expected {force:.6g} mN, reached {excess + force:.6g} mN after "
        f"{CORRECTIONS} corrections; {PRESS_LESS}"
    )
    raise ConvergenceError(message)
