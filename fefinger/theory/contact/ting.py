"""Viscoelastic contact with any loading history, for a body with one relaxation function G.

Every nested axisymmetric contact is a sum of flat punches of growing radius (Mossakovskii, Jaeger).
With Phi(d) the share of all punches wider than the contact at the elastic depth d, the elastic
contact has Phi = depth - d where it touches. Relaxation acts on each d alone: there Phi_q, the
share of the displacement, is depth - d in contact, and Phi_p, the integral of G(t - s) dPhi_q(s),
the share of the stress, is zero out of contact. So each d is a spring that relaxes and can only
push, on a half-space, a layer or a stack alike. For one maximum of the contact this is the
solution of Ting (1966) and Graham, P(t) = integral to t1 of G(t - s) dP_e; with more maxima it
holds for repeated contact, of tissue that has not yet recovered.

A body that stiffens, of Fung's quasi-linear kind, relaxes in its stress and not in its
displacement: it recovers more slowly than a linear one. Its springs are those of a linear body at
the depth M(d), a `measure` to which its stress is about proportional; a factor of M has no effect.
The displacement follows from the depths with these measures: Phi_q = M^-1(m) - M^-1(m - Phi), with
m the share of the middle. For a linear body M(d) is d. With the elastic force for M, all springs
are one (Pawluk 1997, Eq. 2.3).

At finite strain the stress of an earlier depth works on the present deformation. With S(a) the
second Piola-Kirchhoff stress and E(a) the Green-Lagrange strain of the elastic contact of depth a,
its virtual work at the depth d is K(a, d) = integral of S(a) : E'(d) over the body, and K(d, d) is
the elastic force P_e(d). The force is the sum of K(a, d) over all a, each with the share of S(a)
that is left; while the depth d(t) grows, that is the integral of G(t - s) dK(d(s), d(t)) over s.
The `work` ratio is W(a, d) = K(a, d) / P_e(a). For a linear body it is 1 for a <= d, as all of the
contact of depth a then moves with the indenter, and the force is Ting's.
"""

import math
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact.elastic import Array
from fefinger.theory.relaxation import Prony, checked_signal, exprel


State = tuple[Array, Array, Array, Array, float, float]
"""What the next step of nested contacts depends on."""

SAME = 1e-9
"""Relative difference of depths or forces that counts as none."""


@dataclass(frozen=True)
class ElasticForce:
    """Elastic force over depth, from which the force in any history of contact follows.

    nodes, measure (n,) mm: as of `NestedContact`; values (n,): the force at the nodes for the
    modulus at t = 0, from 0; work (n, n): W of the stress at a node (row) at the depth of another
    (column), None for a linear body.
    """

    nodes: Array
    values: Array
    measure: Array | None = None
    work: Array | None = None

    def along(self, weights: Array, depth: Array | float) -> Array:
        """Force (...) at weights (..., n) of the stresses at the nodes and depths (...) mm."""
        if self.work is None:
            return np.asarray(weights @ self.values)
        at = np.asarray(np.interp(depth, self.nodes, np.arange(len(self.nodes))))
        low = np.minimum(at.astype(int), len(self.nodes) - 2)
        part = (at - low)[..., None]
        columns = self.work.T
        ratio = (1 - part) * columns[low] + part * columns[low + 1]
        return np.maximum((weights * ratio) @ self.values, 0.0)


class NestedContact:
    """Contact through time, step by step, of a body at rest at first.

    Parameters
    ----------
    prony
        Relaxation G of the whole body.
    nodes
        (n,) mm: elastic depths that rise from 0.
    measure
        (n,) mm: M at the nodes, rising from 0; the nodes themselves for a linear body.
    deepest
        Largest depth in mm of a step, by default the last node.

    Attributes
    ----------
    depth
        mm, of the indenter; under no force it just touches.
    stressed, strained
        (n,) mm: Phi_p in the measure, and Phi_q.
    edge
        mm: the elastic depth whose contact is the present one, 0 out of contact.

    Raises
    ------
    ValueError
        Nodes or a measure that do not rise from 0.
    """

    def __init__(
        self,
        prony: Prony,
        nodes: Array,
        measure: Array | None = None,
        deepest: float | None = None,
    ) -> None:
        self.nodes = np.asarray(nodes, float)
        self.measure = self.nodes if measure is None else np.asarray(measure, float)
        for name, values in (("nodes", self.nodes), ("measure", self.measure)):
            rising = len(values) > 1 and values[0] == 0 and (np.diff(values) > 0).all()
            if not (rising and values.shape == self.nodes.shape):
                raise ValueError(f"{name}: expected {len(nodes)} depths that start at 0 and rise")
        self.deepest = float(self.nodes[-1]) if deepest is None else deepest
        self._linear = measure is None
        self._weights, self._rates = np.array(prony.weights), np.array(prony.v)
        self.reset()

    def reset(self) -> None:
        """Forget all contact."""
        count = len(self.nodes)
        self._terms, self._share = np.zeros((len(self._rates), count)), np.zeros(count)
        self.stressed, self.strained = np.zeros(count), np.zeros(count)
        self.depth = self.edge = 0.0

    def state(self) -> State:
        """Return the state that the next step depends on; no copies, as a step makes new arrays."""
        arrays = self._terms, self._share, self.stressed, self.strained
        return (*arrays, self.depth, self.edge)

    def restore(self, state: State) -> None:
        """Return to a state of this contact."""
        self._terms, self._share, self.stressed, self.strained, self.depth, self.edge = state

    def advance(self, dt: float, depth: float) -> None:
        """Move the indenter to a depth in mm within dt >= 0 s, at a constant rate.

        Raises ValueError for a depth beyond the deepest; nothing has moved then.
        """
        if depth > self.deepest * (1 + SAME):
            raise ValueError(
                f"depth: expected at most {self.deepest:.4g} mm, received {depth:.4g} mm"
            )
        gain, past, *factors = self._past(dt)
        self._finish(gain * (self._measured(depth) - self.measure) + past, gain, past, *factors)
        self.depth = depth

    def advance_force(self, dt: float, force: float, elastic: ElasticForce) -> None:
        """Load the indenter with a force >= 0 within dt >= 0 s; at 0 it just touches.

        elastic: the force of the body over these nodes and this measure.

        Raises ValueError for a force that presses deeper than the deepest; nothing has moved then.
        """
        gain, past, *factors = self._past(dt)
        onset = gain * self.measure - past
        reached = self._balanced(force, onset, gain, elastic) if force > 0 else float(onset.min())
        self._finish(reached - onset, gain, past, *factors)
        self.depth = self._depth(reached / gain)

    def _balanced(self, force: float, onset: Array, gain: float, elastic: ElasticForce) -> float:
        """Solve for the stressed share of the depth at which springs of these onsets bear a force.

        The force is quadratic between two neighbors of the onsets (n,) and the nodes.
        """

        def borne(reached: float) -> float:
            weights = node_weights(np.maximum(reached - onset, 0.0), self.measure)
            return float(elastic.along(weights, self._depth(reached / gain)))

        farthest = gain * self._measured(self.deepest)
        ends = np.sort(np.concatenate([onset, gain * self.measure]))
        ends = np.append(ends[ends < farthest], farthest)
        after = bisect_left(ends, force, key=borne)
        if after == len(ends):
            most = borne(farthest)
            if force <= most * (1 + SAME):
                return farthest
            raise ValueError(
                f"force: expected at most {most:.4g}, that of the largest depth, "
                f"{self.deepest:.4g} mm, received {force:g}"
            )
        low, high = float(ends[after - 1]), float(ends[after])
        first, middle, last = borne(low), borne((low + high) / 2), borne(high)
        bend, slope = 2 * (first + last - 2 * middle), 4 * middle - 3 * first - last
        root = math.sqrt(max(slope**2 + 4 * bend * (force - first), 0.0))
        return low + (high - low) * 2 * (force - first) / (slope + root)

    def _past(self, dt: float) -> tuple[float, Array, Array, Array]:
        """Return g and h of Phi_p = g Phi + h at the end of a step, and its factors."""
        weights, exponent = self._weights, self._rates * dt
        decay, ramp = np.exp(-exponent), exprel(-exponent)
        gain = float(weights[1:] @ ramp)
        past = (weights[1:] * decay) @ self._terms - gain * self._share
        return float(weights[0]) + gain, past, decay, ramp

    def _finish(self, push: Array, gain: float, past: Array, decay: Array, ramp: Array) -> None:
        """Set the state at the end of a step: contact is where the springs push, (n,) mm."""
        self.stressed = np.maximum(push, 0.0)
        share = (self.stressed - past) / gain
        self._terms = decay[:, None] * self._terms + ramp[:, None] * (share - self._share)
        self._share = self.strained = share
        if not self._linear:
            middle = share[0]
            inner = np.interp(middle - share, self.measure, self.nodes)
            self.strained = self._depth(float(middle)) - inner
        self.edge = self._edge(push)

    def _measured(self, depth: float) -> float:
        """M at a depth in mm; a depth above the surface is its own."""
        if self._linear or depth < 0:
            return depth
        return float(np.interp(depth, self.nodes, self.measure))

    def _depth(self, measure: float) -> float:
        """Depth in mm of a measure."""
        if self._linear or measure < 0:
            return measure
        return float(np.interp(measure, self.measure, self.nodes))

    def _edge(self, push: Array) -> float:
        """Elastic depth of the edge of the contact, where the push falls to zero."""
        if push[0] <= 0:
            return 0.0
        outside = int(np.argmax(push <= 0))
        if outside == 0:
            return float(self.nodes[-1])
        inside = outside - 1
        part = push[inside] / (push[inside] - push[outside])
        at = self.measure[inside] + part * (self.measure[outside] - self.measure[inside])
        return self._depth(float(at))


@dataclass(frozen=True)
class ContactHistory:
    """History of a contact, which converts elastic quantities to viscoelastic histories.

    time (n_t,) s; depth (n_t,) mm; nodes and measure (n,) mm, as of `NestedContact`; stressed and
    strained (n_t, n) mm, the shares Phi_p and Phi_q at the nodes; edge (n_t,) mm, the elastic depth
    whose contact is the present one, 0 out of contact.
    """

    time: Array
    depth: Array
    nodes: Array
    measure: Array
    stressed: Array
    strained: Array
    edge: Array

    def stress(self, elastic: ArrayLike) -> Array:
        """History (n_t, ...) of a pressure or stress, or the force of a linear body.

        `elastic` (n, ...) is its value at the nodes in the body of the modulus at t = 0.
        """
        return self._history(self.stress_weights, elastic)

    def strain(self, elastic: ArrayLike) -> Array:
        """History (n_t, ...) of a strain or displacement from its elastic values."""
        return self._history(self.strain_weights, elastic)

    @property
    def stress_weights(self) -> Array:
        """Weights (n_t, n) of the elastic values at the nodes in forces and pressures."""
        return node_weights(self.stressed, self.measure)

    @property
    def strain_weights(self) -> Array:
        """Weights (n_t, n) of the elastic values at the nodes in displacements and strains."""
        return node_weights(self.strained, self.nodes)

    def _history(self, weights: Array, elastic: ArrayLike) -> Array:
        elastic = np.asarray(elastic, float)
        if len(elastic) != len(self.nodes):
            raise ValueError(
                f"elastic: expected {len(self.nodes)} values at the nodes, received {len(elastic)}"
            )
        flat = weights @ elastic.reshape(len(elastic), -1)
        return np.asarray(flat.reshape(len(self.time), *elastic.shape[1:]))


def node_weights(shares: Array, at: Array) -> Array:
    """Weights (..., n) of elastic values at nodes, of shares (..., n) of the punches at `at` (n,).

    Values are joined by straight lines over `at`. The weights sum to 0: values count from the value
    at the first node.
    """
    punches = np.zeros((*shares.shape[:-1], shares.shape[-1] + 1))
    # Slices, as numpy.diff takes ten times as long for so few numbers, several times a step.
    punches[..., 1:-1] = (shares[..., 1:] - shares[..., :-1]) / (at[1:] - at[:-1])
    return np.asarray(punches[..., 1:] - punches[..., :-1])


def radius_nodes(deepest: float, count: int = 256) -> Array:
    """Depths (`count` + 1,) from 0 to `deepest` mm with equally spaced Hertz contact radii.

    The elastic force is joined by straight lines between them: with 256, Hertz's force is right to
    1e-5 at the deepest and to 1e-3 at a hundredth of it.
    """
    if not (0 < deepest < math.inf and count >= 1):
        msg = f"nodes: expected a depth above 0 mm and 1 or more, received {deepest!r}, {count!r}"
        raise ValueError(msg)
    return deepest * np.linspace(0.0, 1.0, count + 1) ** 2


def press_by_depth(
    prony: Prony, time: ArrayLike, depth: ArrayLike, nodes: Array, measure: Array | None = None
) -> ContactHistory:
    """Compute the contact history of an indenter with prescribed depth.

    Parameters
    ----------
    prony
        Relaxation G of the whole body.
    time, depth
        (n_t,) s and mm, joined by straight lines; at rest before, so a first depth above 0 is a
        jump. Below 0 the indenter is off the surface at rest.
    nodes
        (n,) mm, rising from 0 to at least the largest depth.
    measure
        (n,) mm, as of `NestedContact`.

    Raises
    ------
    ValueError
        Shapes that do not match, times that decrease, or nodes that do not reach the depth.

    Notes
    -----
    Each exponential of G is exact over a step in which its share is linear; where contact begins
    or ends inside a step, that is an error of second order in the step.
    """
    time, depth = checked_signal("depth", time, depth)
    contact = NestedContact(prony, nodes, measure)
    return _march(contact, time, lambda step, dt: contact.advance(dt, float(depth[step])))


def press_by_force(
    prony: Prony,
    time: ArrayLike,
    force: ArrayLike,
    elastic: ElasticForce,
) -> ContactHistory:
    """Compute the contact history of an indenter with prescribed `force` (n_t,) >= 0.

    At zero force the indenter just touches.

    Raises ValueError as `press_by_depth`; also for a force below zero, and an elastic one that does
    not rise with depth, but for the first nodes, where it may stay 0.
    """
    time, force = checked_signal("force", time, force)
    steps = np.diff(elastic.values)
    touching = int(np.argmax(steps > 0))
    if not (elastic.values[0] == 0 and (steps >= 0).all() and (steps[touching:] > 0).all()):
        raise ValueError("elastic_force: expected a force that is 0 at first and then rises")
    if force.min() < 0:
        raise ValueError(
            f"force: expected forces of 0 or more (a contact cannot pull), received {force.min():g}"
        )
    contact = NestedContact(prony, elastic.nodes, elastic.measure)
    return _march(
        contact, time, lambda step, dt: contact.advance_force(dt, float(force[step]), elastic)
    )


def _march(
    contact: NestedContact, time: Array, advance: Callable[[int, float], None]
) -> ContactHistory:
    """Step a contact through time; `advance(step, dt)` makes a step."""
    shape = len(time), len(contact.nodes)
    stressed, strained = np.empty(shape), np.empty(shape)
    depth, edge = np.empty(len(time)), np.empty(len(time))
    for step, dt in enumerate(np.diff(time, prepend=time[0]).tolist()):
        advance(step, dt)
        stressed[step], strained[step] = contact.stressed, contact.strained
        depth[step], edge[step] = contact.depth, contact.edge
    return ContactHistory(time, depth, contact.nodes, contact.measure, stressed, strained, edge)
