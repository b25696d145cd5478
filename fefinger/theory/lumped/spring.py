"""Lumped fingerpad of Pawluk (1997), chapter 2: an exponential spring with relaxation (QLV).

Forces are exact for positions that are linear between samples. Eq. 2.3 holds in contact;
`contact_force` lets the indenter leave the skin and come back.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array
from fefinger.theory.relaxation import (
    Prony,
    checked_signal,
    creep_integral,
    exprel,
    recursion,
)


LARGEST = 600.0
"""Largest exponent m times depth of Eq. 2.1: exp(600) is still a finite number."""


@dataclass(frozen=True)
class Spring:
    """Instantaneous elastic response T(x) = (b/m) [exp(m (x - x0)) - 1], and 0 before touch.

    Parameters
    ----------
    b
        Stiffness at first touch in N/mm.
    m
        Rise of the stiffness with the force in 1/mm.
    x0
        Position of first touch in mm.

    Raises
    ------
    ValueError
        b or m that is not above 0, or a number that is not finite.

    Notes
    -----
    Pawluk (1997), Eq. 2.1 and 3.4.
    """

    b: float
    m: float
    x0: float = 0.0

    def __post_init__(self) -> None:
        finite = all(map(math.isfinite, (self.b, self.m, self.x0)))
        if not finite or self.b <= 0 or self.m <= 0:
            msg = f"spring: expected b > 0 N/mm, m > 0 1/mm and a finite x0, received {self}"
            raise ValueError(msg)

    def force(self, position: ArrayLike) -> Array:
        """Return T in N at positions in mm, of any shape (Eq. 2.1)."""
        y = self.depth(position)
        _require_small(self.m * float(y.max()))
        return self.b * y * exprel(self.m * y)

    def stiffness(self, force: ArrayLike) -> Array:
        """Return k = m T + b in N/mm at instantaneous elastic forces in N (Eq. 2.4)."""
        return self.m * elastic.numbers("spring", "forces", force, least=0.0) + self.b

    def depth(self, position: ArrayLike) -> Array:
        """Return the indentation max(0, x - x0) in mm."""
        return np.maximum(elastic.numbers("spring", "positions", position) - self.x0, 0.0)

    def position(self, force: ArrayLike) -> Array:
        """Return the position in mm at which T is `force` >= 0 N: the inverse of `force`."""
        pressed = elastic.numbers("spring", "forces", force, least=0.0)
        return self.x0 + np.log1p(self.m / self.b * pressed) / self.m


def force(spring: Spring, prony: Prony, time: ArrayLike, position: ArrayLike) -> Array:
    """Force P in N of Eq. 2.3, exact for a position that is linear between samples.

    Parameters
    ----------
    spring, prony
        T and G.
    time
        (n_t,) s, not decreasing; a repeated time is a step.
    position
        (n_t,) mm; the finger is at rest before, so an indented first sample is a step.

    Raises
    ------
    ValueError
        Arrays of two shapes or with values that are not finite, or times that decrease.

    Notes
    -----
    Where x falls fast, P is below zero: Eq. 2.3 lets the indenter adhere to the skin. On a segment
    each exponential gains b e^(m y) dy e^(max(A, -v h)) (1 - e^-|z|) / |z| with A = m dy,
    z = A + v h, y the indentation at its start, dy its change and h the part of the segment in
    contact.
    """
    time, position = checked_signal("lumped", time, position)
    _require_small(spring.m * float(spring.depth(position).max()))
    decay, gain = _gains(spring, prony, time, position)
    weights = prony.weights
    start = float(spring.force(position[0]))
    terms = recursion(decay, gain, start)
    return weights[0] * spring.force(position) + terms @ np.array(weights[1:])


def contact_force(spring: Spring, prony: Prony, time: ArrayLike, position: ArrayLike) -> Array:
    """Force in N of an indenter that can leave the skin; arguments as in `force`.

    Where Eq. 2.3 would give tension, the force is zero and the skin recovers freely: T follows from
    P = 0 until the indenter reaches the skin again. Loss and return of contact are resolved to one
    time step.
    """
    time, position = checked_signal("lumped", time, position)
    pulled = force(spring, prony, time, position)
    if not np.any(pulled < 0):
        return pulled
    decay, gain = _gains(spring, prony, time, position)
    weights = np.array(prony.weights)
    ramp = exprel(-np.multiply.outer(np.diff(time), np.array(prony.v)))
    elastic = spring.force(position).tolist()
    memory, surface, out = np.full(len(prony.v), elastic[0]), elastic[0], [elastic[0]]
    for i, (before, after) in enumerate(pairwise(elastic)):
        # Exact on purpose: `surface` is a copy of `before`, unless the skin was free.
        touching = surface == before
        decayed = decay[i] * memory
        added = gain[i] if touching else ramp[i] * (after - surface)
        total = weights[0] * after + weights[1:] @ (decayed + added)
        free = total < 0
        if free:
            rate = weights[1:] @ ramp[i]
            after = (rate * surface - weights[1:] @ decayed) / (weights[0] + rate)
            added = ramp[i] * (after - surface)
        memory, surface = decayed + added, after
        out.append(0.0 if free else float(total))
    return np.array(out)


def constant_velocity(spring: Spring, prony: Prony, position: ArrayLike, speed: float) -> Array:
    """Force P in N of an indenter that moves in at `speed` > 0 mm/s from before first touch.

    The closed form of Eq. 2.3: each exponential gives b s (e^(m y) - e^(-v y / s)) / (m s + v).
    """
    elastic.require_positive("constant_velocity", speed=speed)
    y = spring.depth(position)
    _require_small(spring.m * float(y.max()))
    rates = np.array((0.0, *prony.v))
    response = exprel(-y[..., None] * (spring.m + rates / speed)) @ np.array(prony.weights)
    return spring.b * y * np.exp(spring.m * y) * response


def position_under(spring: Spring, prony: Prony, time: ArrayLike, applied: ArrayLike) -> Array:
    """Position in mm under the force `applied` >= 0 in N: the inverse of Eq. 2.3.

    Exact for a force that is linear between samples; a first value above 0 is a step.
    T is the integral of J(t - s) dP(s) with the creep function J.
    """
    applied = elastic.numbers("position_under", "forces", applied, least=0.0)
    return spring.position(np.maximum(creep_integral(prony, time, applied), 0.0))


def _require_small(exponent: float) -> None:
    """Raise ValueError if the exponent m times depth is beyond LARGEST."""
    if exponent > LARGEST:
        msg = f"lumped: expected m times depth of at most {LARGEST:g}, received {exponent:.3g}"
        raise ValueError(msg)


def _gains(spring: Spring, prony: Prony, time: Array, position: Array) -> tuple[Array, Array]:
    """Decay factor and gain of each exponential over each step, (n_t - 1, n) each."""
    step, travel = np.diff(time), np.diff(position)
    y = spring.depth(position)
    change = np.diff(y)
    touching = y[:-1] > 0
    share = np.divide(change, travel, out=touching.astype(float), where=travel != 0)
    inside = step * share
    after = np.where(touching, np.maximum(step - inside, 0.0), 0.0)
    rates = np.array(prony.v)
    within = np.multiply.outer(inside, rates)
    growth = (spring.m * change)[:, None]
    gain = (spring.b * np.exp(spring.m * y[:-1]) * change)[:, None]
    gain = gain * np.exp(np.maximum(growth, -within) - np.multiply.outer(after, rates))
    gain = gain * exprel(-np.abs(growth + within))
    return np.exp(-np.multiply.outer(step, rates)), gain
