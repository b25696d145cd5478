"""History of a linear viscoelastic body with one relaxation function, for steps in time.

The displacement follows from an elastic stress y: of the fully relaxed body at this
displacement (Lee and Radok, J. Appl. Mech. 27:438, 1960). The contact stress is its hereditary
integral, p = integral of G(t - s) dy(s). Over a step in which y is linear the integral is exact:
p = g y + h, with g and h from one exponential per Prony term. h and F h follow from the same
recursion, so that the history needs no product with the flexibility F.
"""

from typing import NamedTuple

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.compiled import njit


class PronyHistory(NamedTuple):
    """Prony internal variables of a contact whose long-time modulus is 1.

    weights and rates (m,) of the terms, over the long-time one, in 1/s; terms and moved_terms
    (m, n): the internal variables of the stress and F times them; elastic and moved_elastic (n,):
    y in kPa and F y in mm³, at the end of the last step; past and moved_past (n,): h and F h of the
    present step. With several components of traction per vertex they stand one after the other.
    """

    weights: Array
    rates: Array
    terms: Array
    moved_terms: Array
    elastic: Array
    moved_elastic: Array
    past: Array
    moved_past: Array

    @property
    def state(self) -> tuple[Array, Array, Array, Array]:
        """The arrays that a later step depends on."""
        return self.terms, self.moved_terms, self.elastic, self.moved_elastic


def prony_history(branches: tuple[Array, Array], size: int) -> PronyHistory:
    """Allocate the history of `size` stresses at rest; branches: weights and rates (m,)."""
    weights, rates = (np.array(each, dtype=np.float64) for each in branches)
    rows = np.zeros((2, len(rates), size))
    return PronyHistory(weights, rates, rows[0].copy(), rows[1].copy(), *np.zeros((4, size)))


@njit(cache=True, inline="always")
def gain(weight: float, rate: float, dt: float) -> float:
    """Return the stress of a Prony term per strain that grows linearly over a step of `dt` s."""
    exponent = rate * dt
    return weight * (-np.expm1(-exponent) / exponent if exponent > 0.0 else 1.0)


@njit(cache=True)
def load_history(m: PronyHistory, dt: float) -> float:
    """Compute h and F h of a step of `dt` s into `past` and `moved_past`; return g."""
    total = 0.0
    m.past[:] = 0.0
    m.moved_past[:] = 0.0
    for k in range(len(m.rates)):
        total += gain(m.weights[k], m.rates[k], dt)
        decay = np.exp(-m.rates[k] * dt)
        for j in range(len(m.past)):
            m.past[j] += decay * m.terms[k, j]
            m.moved_past[j] += decay * m.moved_terms[k, j]
    for j in range(len(m.past)):
        m.past[j] -= total * m.elastic[j]
        m.moved_past[j] -= total * m.moved_elastic[j]
    return 1.0 + total


@njit(cache=True)
def store_history(m: PronyHistory, stress: Array, moved: Array, dt: float, g: float) -> None:
    """Update the internal variables with the stress p and F p (n,) at the end of a step."""
    for k in range(len(m.rates)):
        part, decay = gain(m.weights[k], m.rates[k], dt), np.exp(-m.rates[k] * dt)
        for j in range(len(m.past)):
            y, z = (stress[j] - m.past[j]) / g, (moved[j] - m.moved_past[j]) / g
            m.terms[k, j] = decay * m.terms[k, j] + part * (y - m.elastic[j])
            m.moved_terms[k, j] = decay * m.moved_terms[k, j] + part * (z - m.moved_elastic[j])
    for j in range(len(m.past)):
        m.elastic[j] = (stress[j] - m.past[j]) / g
        m.moved_elastic[j] = (moved[j] - m.moved_past[j]) / g


def increments(weights: Array, rates: Array, step: float) -> Array:
    """Return the stress of each Prony term (n,) per strain that grows linearly over a step in s."""
    exponent = rates * step
    return np.asarray(weights * (-np.expm1(-exponent) / exponent if step > 0 else 1.0))


class Relaxation:
    """Internal variables of a Prony series whose long-time value is 1: G(0) = 1 / c0.

    The same recursion without F, for stresses of any body. weights (1 + n,) add up to 1, rates (n,)
    in 1/s. Before the first step the body is at rest.
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
        """Update the internal variables with the elastic stress at the end of a step."""
        _, decay, gain = self.factors(step)
        increment = elastic - self.elastic
        self.terms = decay[:, None] * self.terms + gain[:, None] * increment
        self.elastic = elastic
