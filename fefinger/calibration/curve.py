"""Force of a finger at any exponent, pad radius and rate, interpolated between presses.

The relaxed force is P = x^(3/2) exp(q(x)): Hertz's power law times the effect of bone, shape,
finite strain and law. Between presses q and the share of every element of the array are
interpolated at the same depth by Lagrange's polynomial in the root of the exponent. Moduli scale
the force as a whole.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike

from fefinger.calibration.slow_press import SlowPress
from fefinger.scene.indenter import Indenter
from fefinger.support.arrays import Array
from fefinger.theory.contact.ting import press_by_depth, radius_nodes
from fefinger.theory.relaxation import Prony, exprel, hereditary_integral


if TYPE_CHECKING:
    from scipy.interpolate import PPoly


DEGREE = 4
"""Degree in the root of the depth, as the radius of contact grows, of q through the few steps of
`solid`, whose contact grows by whole vertices.

Steps on the standard mesh are then off by 0.2 %, and by 0.7 % of one in the depth itself, which
also depends on how deep the press is: by 1.2 % between 0.3 and 1.2 mm, instead of 0.4 %.
"""

NODES = 161
"""Evenly spaced depths at which q is stored; it is interpolated by a cubic spline."""

SHARES = 24
"""Evenly spaced depths at which the shares of the array's elements are stored."""

HISTORY = 96
"""Number of depths at which a curve is tabulated for a contact history."""


@dataclass(frozen=True)
class Curve:
    """The relaxed force on a finger at the moduli of its presses.

    q (NODES,) at even depths from 0 to deepest mm, beyond which log P is extrapolated linearly;
    shares (SHARES, 64) 1/mm² of the force at even depths; growth: m in 1/mm of a factor
    [exp(m x) - 1] / m, the t(u) of the thesis over its b, or None.
    """

    q: Array
    deepest: float
    shares: Array
    growth: float | None = None

    @cached_property
    def _spline(self) -> "PPoly":
        from scipy.interpolate import PPoly

        x = np.linspace(0.0, self.deepest, len(self.q))
        powers = x[1] ** np.arange(3, -1, -1.0)[:, None]
        return PPoly.construct_fast(_unit_splines(len(self.q)) @ self.q / powers, x)

    def power(self, depth: ArrayLike) -> Array:
        """Interpolate q (n,) at depths (n,) of 0 to `deepest` mm."""
        return np.asarray(self._spline(depth))

    def force(self, depth: ArrayLike) -> Array:
        """Compute the force (n,) in N at depths (n,) in mm, 0 without contact."""
        x: Array = np.maximum(np.asarray(depth, float), 0.0)
        logarithm = self._logarithm(np.where(x > 0, np.minimum(x, self.deepest), self.deepest))
        if x.size and x.max() > self.deepest:
            logarithm += np.maximum(x - self.deepest, 0.0) * self._steepness(self.deepest)
        return np.asarray(np.where(x > 0, np.exp(logarithm), 0.0))

    def stiffness(self, depth: ArrayLike) -> Array:
        """Return dP/dx (n,) in N/mm at depths (n,) above 0 mm."""
        depth = np.asarray(depth, float)
        return self.force(depth) * self._steepness(np.minimum(depth, self.deepest))

    def depth(self, force: ArrayLike) -> Array:
        """Return depths (n,) in mm at forces (n,) above 0 N, by Newton's method on logarithms."""
        wanted = np.log(np.asarray(force, float))
        depth = np.full(wanted.shape, 0.5 * self.deepest)
        for _ in range(60):
            error = np.log(self.force(depth)) - wanted
            if np.abs(error).max() < 1e-13:
                break
            slope = depth * self._steepness(np.minimum(depth, self.deepest))
            depth = depth * np.exp(np.clip(-error / slope, -1.0, 1.0))
        return depth

    def array_pressure(self, depth: ArrayLike) -> Array:
        """Compute the readings (n, 64) kPa of the array at depths (n,) mm."""
        depth = np.asarray(depth, float)
        return np.asarray(1e3 * self.force(depth)[:, None] * self.shares_at(depth))

    def shares_at(self, depth: Array) -> Array:
        """Interpolate the shares (n, 64) in 1/mm² at depths (n,) mm."""
        return _columns(depth, np.linspace(0.0, self.deepest, SHARES), self.shares)

    def until(self, depth: float) -> "Curve":
        """Cut the curve off at a depth in mm; a shorter curve is unchanged."""
        if depth >= self.deepest:
            return self
        even, few = (np.linspace(0.0, depth, count) for count in (NODES, SHARES))
        return replace(self, q=self.power(even), deepest=depth, shares=self.shares_at(few))

    def _logarithm(self, depth: Array) -> Array:
        value = 1.5 * np.log(depth) + self.power(depth)
        if self.growth is None:
            return np.asarray(value)
        return np.asarray(value + np.log(depth * exprel(self.growth * depth)))

    def _steepness(self, depth: ArrayLike) -> Array:
        """Return d log P / dx in 1/mm."""
        depth = np.asarray(depth, float)
        slope = 1.5 / depth + self._spline(depth, 1)
        if self.growth is None:
            return np.asarray(slope)
        return np.asarray(slope + 1 / (depth * exprel(-self.growth * depth)))


@cache
def _unit_splines(count: int) -> Array:
    """Return coefficients (4, count - 1, count) of cubic splines, 1 at one of the nodes 0, 1, 2 ...

    A spline is linear in its values: a fit, which takes thousands, solves for these once.
    """
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(np.arange(count), np.eye(count)).c)


def curve(press: SlowPress) -> tuple[Curve, float]:
    """Fit the curve of a press; also return the largest relative distance of its steps from it."""
    x, force = press.depth, press.force
    power, deepest = np.log(force / x**1.5), float(x[-1])
    even = np.linspace(0.0, deepest, NODES)
    # Number of steps from which q interpolates all of them, as for presses at small strain.
    dense = 100
    # Share of the depth below which the contact is too small on the mesh to determine q.
    shallow = 0.1
    if len(x) >= dense:
        q = np.asarray(np.interp(even, x, power))
    else:
        weights = np.minimum(x / (shallow * deepest), 1.0)
        fitted_q = polynomial.polyfit(np.sqrt(x), power, DEGREE, w=weights)
        q = np.asarray(polynomial.polyval(np.sqrt(even), fitted_q))
    share = press.array_pressure / (1e3 * force[:, None])
    fitted = Curve(q, deepest, _columns(np.linspace(0.0, deepest, SHARES), x, share))
    deep = x > shallow * deepest
    return fitted, float(np.abs(fitted.force(x[deep]) / force[deep] - 1).max())


@dataclass(frozen=True)
class ForceLaw:
    """Force at any rate: the relaxed force curve P of presses, a factor on it, and one G.

    T = P / c0 is the instantaneous force; the force at any rate is the integral of G(t - s) dT(s)
    while the contact grows. others: curves under other objects.
    """

    curve: Curve
    prony: Prony
    factor: float = 1.0
    others: Mapping[Indenter, Curve] = field(default_factory=dict)

    def under(self, indenter: Indenter) -> Self:
        """Return the force law under one of the `others`, or this one."""
        if indenter not in self.others:
            return self
        return replace(self, curve=self.others[indenter], others={})

    def relaxed(self, depth: ArrayLike) -> Array:
        """Compute the relaxed force (n,) in N at depths (n,) in mm."""
        return self.factor * self.curve.force(depth)

    def slope(self, depth: ArrayLike) -> Array:
        """Compute the derivative (n,) in N/mm of the relaxed force at depths (n,) above 0 mm."""
        return self.factor * self.curve.stiffness(depth)

    def array_pressure(self, depth: ArrayLike) -> Array:
        """Compute the relaxed readings (n, 64) in kPa of the array at depths (n,) in mm."""
        return self.factor * self.curve.array_pressure(depth)

    def depth(self, force: ArrayLike) -> Array:
        """Compute the depths (n,) in mm at which the instantaneous force T is `force` (n,) in N."""
        return self.curve.depth(self.prony.long_time * np.asarray(force, float) / self.factor)

    def stiffness(self, force: ArrayLike) -> Array:
        """Compute dT/dx (n,) in N/mm where the instantaneous force T is `force` (n,) in N."""
        return self.curve.stiffness(self.depth(force)) * self.factor / self.prony.long_time

    def loading(self, time: Array, depth: Array) -> Array:
        """Compute the force (n_t,) in N of a growing contact, at depths (n_t,) in mm."""
        return hereditary_integral(self.prony, time, self.relaxed(depth)) / self.prony.long_time

    def predicted(self, time: Array, depth: Array) -> Array:
        """Predict the force (n_t,) in N of any motion with depths (n_t,) mm from first touch.

        Valid on unloading, detachment and renewed contact (`theory/contact/ting.py`).
        """
        nodes = radius_nodes(max(float(depth.max()), 1e-6), HISTORY)
        history = press_by_depth(self.prony, time, depth, nodes)
        return history.stress(self.relaxed(nodes) / self.prony.long_time)


@dataclass(frozen=True)
class Family:
    """Curves over the shape of the law, with first-order effects of pad radius and skin.

    The shape is the exponent of a law in `solid`, and m of t(u) in `condensed`, whose family has
    one curve. radius: pad radius in mm of the curves; by_radius, by_ratio (NODES,): derivatives of
    q with respect to the logarithms of the pad radius and of the ratio of skin to subcutaneous
    modulus; shares_by_radius (SHARES, 64) likewise; correction (NODES,) and shares_correction
    (SHARES, 64) are added to every q and all shares, and reached mm is the depth of the press that
    they are from; ripple: the largest relative distance of a solved step from its curve; others:
    families under other objects.
    """

    shapes: tuple[float, ...]
    curves: tuple[Curve, ...]
    radius: float
    ripple: float
    correction: Array
    by_ratio: Array
    by_radius: Array
    shares_by_radius: Array
    shares_correction: Array
    reached: float = math.inf
    others: Mapping[Indenter, Self] = field(default_factory=dict)

    @property
    def deepest(self) -> float:
        """Depth in mm that all curves reach."""
        return min(each.deepest for each in self.curves)

    @cached_property
    def _at_nodes(self) -> tuple[tuple[Array, Array], ...]:
        """What a fit takes a thousand times: q and shares of every curve at even depths."""
        even, few = (np.linspace(0.0, self.deepest, count) for count in (NODES, SHARES))
        return tuple((each.power(even), each.shares_at(few)) for each in self.curves)

    def at(self, shape: float, radius: float, ratio: float = 1.0) -> Curve:
        """Interpolate the curve at a shape, a pad radius in mm and a ratio of the moduli.

        `ratio`: of skin to subcutaneous modulus, over the same ratio of the presses.
        """
        # In the root of the exponent q bends least: left out, a press is met within 0.6 %, not 1.5.
        nodes = [math.sqrt(each) for each in self.shapes]
        # A single curve holds at any shape: the growth of t(u), whose differences go below 0.
        weights = _lagrange(nodes, math.sqrt(shape) if len(nodes) > 1 else nodes[0])
        wider = np.log(radius / self.radius)
        q: Array = self.correction + np.log(ratio) * self.by_ratio + wider * self.by_radius
        shares: Array = self.shares_correction + wider * self.shares_by_radius
        for weight, (power, share) in zip(weights.tolist(), self._at_nodes, strict=True):
            q = q + weight * power
            shares = shares + weight * share
        growth = None if len(self.shapes) > 1 else shape
        return Curve(q, self.deepest, shares, growth).until(self.reached)

    def corrected(self, press: SlowPress, shape: float, radius: float) -> Self:
        """Shift the family to agree with a press on a better mesh at a shape and radius."""
        whole = replace(self, reached=math.inf)
        present, (better, ripple) = whole.at(shape, radius), curve(press)
        return replace(
            self,
            ripple=ripple,
            reached=better.deepest,
            correction=self.correction + self._difference(present, better),
            shares_correction=self.shares_correction + self._shares_difference(present, better),
        )

    def with_ratio(self, press: SlowPress, shape: float, factor: float) -> Self:
        """Add the effect of the ratio of the moduli, from a press at `factor` times the ratio.

        The other press is at the same subcutaneous modulus.
        """
        shift = self._difference(self.at(shape, self.radius), curve(press)[0])
        return replace(self, by_ratio=shift / np.log(factor))

    def with_radius(self, press: SlowPress, shape: float, radius: float) -> Self:
        """Add the effect of the pad radius, from a press at another one."""
        present, other = self.at(shape, self.radius), curve(press)[0]
        wider = np.log(radius / self.radius)
        return replace(
            self,
            by_radius=self._difference(present, other) / wider,
            shares_by_radius=self._shares_difference(present, other) / wider,
        )

    def _difference(self, one: Curve, other: Curve) -> Array:
        """Difference of log P, `other` less `one`, (NODES,)."""
        even = np.linspace(0.0, self.deepest, NODES)
        at = np.minimum(even, min(one.deepest, other.deepest))
        return other.power(at) - one.power(at)

    def _shares_difference(self, one: Curve, other: Curve) -> Array:
        """Difference of the shares, `other` less `one`, (SHARES, 64)."""
        even = np.linspace(0.0, self.deepest, SHARES)
        return other.shares_at(even) - one.shares_at(even)


def family(shapes: Sequence[float], radius: float, press: Callable[[float], SlowPress]) -> Family:
    """Make the family of presses at shapes that rise; `press` gives the one at a shape."""
    curves = [curve(press(shape)) for shape in shapes]
    q, shares = np.zeros(NODES), np.zeros_like(curves[0][0].shares)
    return Family(
        tuple(shapes),
        tuple(each for each, _ in curves),
        radius,
        max(ripple for _, ripple in curves),
        *(q, q, q, shares, shares),
    )


def _columns(at: Array, depth: Array, values: Array) -> Array:
    """Interpolate the columns of values (n, k) at depths (n,) linearly."""
    return np.stack([np.interp(at, depth, column) for column in values.T], axis=1)


def _lagrange(nodes: Sequence[float], at: float) -> Array:
    """Weights (n,) of the values at the nodes in Lagrange's polynomial."""
    return np.array([math.prod((at - b) / (a - b) for b in nodes if b != a) for a in nodes])
