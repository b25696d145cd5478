"""Viscoelastic contact with any loading history, for a body with one relaxation function G.

Every nested axisymmetric contact is a sum of flat punches of growing radius (Mossakovskii, Jaeger).
With Phi(d) the share of all punches wider than the contact at the elastic depth d, the elastic
contact has Phi = depth - d where it touches. Relaxation acts on each d alone: there Phi_q, the
share of the displacement, is depth - d in contact, and Phi_p, the integral of G(t - s) dPhi_q(s),
the share of the stress, is zero out of contact. So each d is a spring that relaxes and can only
push, on a half-space, a layer or a stack alike. For one maximum of the contact this is the
solution of Ting (1966) and Graham, P(t) = integral to t1 of G(t - s) dP_e; with more maxima it
holds for repeated contact, of tissue that has not yet recovered.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact.elastic import Array
from fefinger.theory.relaxation import Prony, checked_signal, exprel


@dataclass(frozen=True)
class ContactHistory:
    """History of a contact, which converts elastic quantities to viscoelastic histories.

    time (n_t,) s; depth (n_t,) mm; nodes (n,) mm, elastic depths, first 0; stressed and strained
    (n_t, n) mm, the shares Phi_p and Phi_q at the nodes; edge (n_t,) mm, the elastic depth whose
    contact is the present one, 0 out of contact.
    """

    time: Array
    depth: Array
    nodes: Array
    stressed: Array
    strained: Array
    edge: Array

    def stress(self, elastic: ArrayLike) -> Array:
        """History (n_t, ...) of a force, pressure or stress.

        `elastic` (n, ...) is its value at the nodes in the body of the modulus at t = 0.
        """
        return self._history(self.stressed, elastic)

    def strain(self, elastic: ArrayLike) -> Array:
        """History (n_t, ...) of a strain or displacement from its elastic values."""
        return self._history(self.strained, elastic)

    def _history(self, shares: Array, elastic: ArrayLike) -> Array:
        """Combine elastic values at the nodes with the shares of the punches."""
        elastic = np.asarray(elastic, float)
        if len(elastic) != len(self.nodes):
            raise ValueError(
                f"elastic: expected {len(self.nodes)} values at the nodes, received {len(elastic)}"
            )
        weights = -np.diff(shares, axis=1) / np.diff(self.nodes)
        steps = np.diff(elastic, axis=0)
        flat = weights @ steps.reshape(len(steps), -1)
        return np.asarray(flat.reshape(len(self.time), *elastic.shape[1:]))


def radius_nodes(deepest: float, count: int = 256) -> Array:
    """Depths (`count` + 1,) from 0 to `deepest` mm with equally spaced Hertz contact radii.

    The elastic force is joined by straight lines between them: with 256, Hertz's force is right to
    1e-5 at the deepest and to 1e-3 at a hundredth of it.
    """
    if not (0 < deepest < math.inf and count >= 1):
        msg = f"nodes: expected a depth above 0 mm and 1 or more, received {deepest!r}, {count!r}"
        raise ValueError(msg)
    return deepest * np.linspace(0.0, 1.0, count + 1) ** 2


def press_by_depth(prony: Prony, time: ArrayLike, depth: ArrayLike, nodes: Array) -> ContactHistory:
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
    return _march(prony, time, nodes, lambda step, g, onset: float(depth[step]))


def press_by_force(
    prony: Prony,
    time: ArrayLike,
    force: ArrayLike,
    nodes: Array,
    elastic_force: Callable[[Array], Array],
) -> ContactHistory:
    """Compute the contact history of an indenter with prescribed `force` (n_t,) >= 0.

    `elastic_force` gives the force against the depth in mm for the modulus at t = 0, rising ever
    more steeply. At zero force the indenter just touches.

    Raises
    ------
    ValueError
        As `press_by_depth`; also for a force below zero.
    """
    time, force = checked_signal("force", time, force)
    if force.min() < 0:
        raise ValueError(
            f"force: expected forces of 0 or more (a contact cannot pull), received {force.min():g}"
        )
    stiffness = spring_weights(elastic_force(nodes), nodes)

    def balance(step: int, g: float, onset: Array) -> float:
        """Solve sum of stiffness * max(0, g depth - onset) = force, which bends at each onset."""
        order = np.argsort(onset[:-1])
        sorted_onset, weight = onset[:-1][order], stiffness[order]
        slope, moment = np.cumsum(weight), np.cumsum(weight * sorted_onset)
        bends = slope * sorted_onset - moment
        last = max(int(np.searchsorted(bends, force[step], side="right")) - 1, 0)
        return float((force[step] + moment[last]) / slope[last] / g)

    return _march(prony, time, nodes, balance)


def spring_weights(elastic_force: Array, nodes: Array) -> Array:
    """Stiffness (n - 1,) of the spring at each node but the last.

    They are the changes of slope of the force (n,) joined by straight lines over the nodes.
    """
    slopes = np.diff(elastic_force) / np.diff(nodes)
    weights = np.diff(np.concatenate([[0.0], slopes]))
    if not (weights[0] > 0 and weights.min() >= -1e-9 * slopes.max()):
        msg = "elastic_force: expected a force that rises ever more steeply with the depth"
        raise ValueError(msg)
    return weights


def _march(
    prony: Prony, time: Array, nodes: Array, depth_at: Callable[[int, float, Array], float]
) -> ContactHistory:
    """Step all springs through time: contact where g depth > onset.

    `depth_at(step, g, onset)` gives the depth in mm.
    """
    nodes = np.asarray(nodes, float)
    if len(nodes) < 2 or nodes[0] != 0 or (np.diff(nodes) <= 0).any():
        raise ValueError("nodes: expected depths that start at 0 and rise")
    weights, rates = np.array(prony.weights), np.array(prony.v)
    exponent = np.multiply.outer(np.diff(time, prepend=time[0]), rates)
    decays, ramps = np.exp(-exponent), exprel(-exponent)
    gains = weights[0] + ramps @ weights[1:]
    memory, share = np.zeros((len(rates), len(nodes))), np.zeros(len(nodes))
    stressed, strained = np.empty((len(time), len(nodes))), np.empty((len(time), len(nodes)))
    depth, edge = np.empty(len(time)), np.empty(len(time))
    for step, (g, decay, ramp) in enumerate(zip(gains, decays, ramps, strict=True)):
        past = (weights[1:] * decay) @ memory - (weights[1:] @ ramp) * share
        # In contact Phi_q = depth - node, so Phi_p = g (depth - node) + past: positive, as a
        # contact only pushes, where g depth exceeds the onset.
        onset = g * nodes - past
        depth[step] = depth_at(step, g, onset)
        push = g * depth[step] - onset
        stressed[step] = np.maximum(push, 0.0)
        strained[step] = (stressed[step] - past) / g
        memory = decay[:, None] * memory + ramp[:, None] * (strained[step] - share)
        share = strained[step]
        edge[step] = _edge(nodes, push)
    if depth.max() > nodes[-1] * (1 + 1e-12):
        msg = f"nodes: expected depths up to {depth.max():g} mm, received up to {nodes[-1]:g} mm"
        raise ValueError(msg)
    return ContactHistory(time, depth, nodes, stressed, strained, edge)


def _edge(nodes: Array, push: Array) -> float:
    """Elastic depth of the edge of the contact, where the push falls to zero."""
    if push[0] <= 0:
        return 0.0
    outside = int(np.argmax(push <= 0))
    if outside == 0:
        return float(nodes[-1])
    part = push[outside - 1] / (push[outside - 1] - push[outside])
    return float(nodes[outside - 1] + part * (nodes[outside] - nodes[outside - 1]))
