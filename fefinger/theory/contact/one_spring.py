"""Viscoelastic contact of a body that deforms at any speed as in its elastic press.

With one relaxation G of the whole stress, a body at finite strain is nearly one spring of Fung's
quasi-linear kind whose elastic response is the force of its elastic press, as in the lumped model
of Pawluk (1997), Eq. 2.3: the depth fixes the deformation, and a force or pressure X is the
integral of G(t - s) dX_e(depth(s)). The spring can only push: where the indenter retreats faster
than the tissue recovers, contact ends, and the depth of the body is then the one without force.

On retreat the pressure at the rim of the contact falls to zero first; negative values are set to
zero, and the rest is scaled to the force. Unloading of relaxed fingers by `solid` gives the area:
with P / P_e = r at the turn, the contact is that of the elastic depth of the force P / r, times
SLOWER, and no larger than that of the depth.
"""

from dataclasses import dataclass

import numpy as np

from fefinger.theory.contact.elastic import Array
from fefinger.theory.relaxation import Prony, exprel


SLOWER = 1.25
"""By which the elastic depth of the rim falls more slowly on retreat than that of the force.

Fingers of two tissues, unloaded to 0.97 to 0.6 of the depth with 0.4 and 0.7 of their stress
relaxed, gave 1.1 to 1.4."""

SAME = 1e-9
"""Relative difference of depths that counts as none."""


@dataclass(frozen=True)
class ElasticForce:
    """Force of an elastic press, linear between nodes.

    nodes (n,) mm: depths that rise from 0; force (n,) in any unit, 0 at first (a mesh may not
    resolve the first touch) and then rising.

    Raises
    ------
    ValueError
        Nodes that do not rise from 0, or forces that are not like this.
    """

    nodes: Array
    force: Array

    def __post_init__(self) -> None:
        """Check the nodes and the forces."""
        nodes, force = self.nodes, self.force
        if not (len(nodes) > 1 and nodes[0] == 0 and (np.diff(nodes) > 0).all()):
            msg = f"nodes: expected two or more depths that rise from 0 mm, received {nodes!r}"
            raise ValueError(msg)
        rises = force.shape == nodes.shape and force[0] == 0 and force[-1] > 0
        if not (rises and (np.diff(force[self.first :]) > 0).all()):
            raise ValueError(
                f"force: expected {len(nodes)} forces that are 0 at first and then rise, received "
                f"{force!r}"
            )

    @property
    def first(self) -> int:
        """Number of the deepest node without force."""
        return int(np.argmax(self.force > 0)) - 1

    def at(self, depth: float) -> float:
        """Force at a depth in mm."""
        return float(np.interp(depth, self.nodes, self.force))

    def depth(self, force: float) -> float:
        """Depth in mm at a force: 0 at none, the deepest node beyond its force."""
        if force <= 0:
            return 0.0
        return float(np.interp(force, self.force[self.first :], self.nodes[self.first :]))

    def weights(self, depth: float) -> Array:
        """Weights (n,) of the values at the nodes in the one at a depth in mm."""
        low, part = self.between(depth)
        weights = np.zeros(len(self.nodes))
        weights[low], weights[low + 1] = 1.0 - part, part
        return weights

    def between(self, depth: float) -> tuple[int, float]:
        """Return the number of the node below a depth in mm, and the part of the way beyond it."""
        low = int(np.searchsorted(self.nodes, depth, side="right")) - 1
        low = min(max(low, 0), len(self.nodes) - 2)
        return low, float((depth - self.nodes[low]) / (self.nodes[low + 1] - self.nodes[low]))


class RelaxingSpring:
    """One spring through time, with a relaxation G whose long-time value is 1.

    deepest mm: the largest depth, by default that of the last node.
    depth mm of the indenter; body mm: the elastic depth that the body is deformed to; stress (n,):
    weights of the elastic values at the nodes in forces and pressures; force, in the unit of the
    elastic one; edge mm: the elastic depth whose contact is the present one.
    """

    def __init__(self, elastic: ElasticForce, prony: Prony, deepest: float | None = None) -> None:
        self.elastic = elastic
        self.deepest = float(elastic.nodes[-1]) if deepest is None else deepest
        self._weights, self._rates = prony.branches
        self.reset()

    def reset(self) -> None:
        """Forget all contact."""
        count = len(self.elastic.nodes)
        self._terms = np.zeros((len(self._rates), count))
        self._shape = self.elastic.weights(0.0)
        self.stress = np.zeros(count)
        self.depth = self.body = self.force = self.edge = 0.0
        self._turn, self._ratio = 0.0, 1.0

    def advance(self, dt: float, depth: float) -> None:
        """Move the indenter to a depth in mm within dt >= 0 s, at a constant rate.

        Raises
        ------
        ValueError
            A depth beyond the deepest.
        """
        if depth > self.deepest * (1 + SAME):
            raise ValueError(f"depth: expected at most {self.deepest:g} mm, received {depth:g} mm")
        step = self._past(dt)
        self._finish(depth, max(min(depth, self.deepest), self._free(*step[:2])), *step)

    def advance_force(self, dt: float, force: float) -> None:
        """Load the indenter with a force >= 0 within dt >= 0 s; at 0 it just touches.

        Raises
        ------
        ValueError
            A force that presses deeper than the deepest; nothing has moved then.
        """
        gain, past, *_ = step = self._past(dt)
        borne = float(past @ self.elastic.force)
        elastic, largest = (force - borne) / gain, self.elastic.at(self.deepest)
        if elastic > largest * (1 + SAME):
            most = gain * largest + borne
            where = f"that of the largest depth, {self.deepest:.4g} mm"
            raise ValueError(f"force: expected at most {most:.4g}, {where}, received {force:g}")
        depth = max(self.elastic.depth(elastic), self._free(gain, past))
        self._finish(depth, depth, *step, prescribed=force)

    def _past(self, dt: float) -> tuple[float, Array, Array, Array]:
        """Return g and h of stress = g shape + h at the end of a step, and its factors."""
        exponent = self._rates * dt
        decay, ramp = np.exp(-exponent), exprel(-exponent)
        gain = float(self._weights @ ramp)
        past = (self._weights * decay) @ self._terms - gain * self._shape
        return 1.0 + gain, past, decay, ramp

    def _free(self, gain: float, past: Array) -> float:
        """Elastic depth in mm at which the body bears no force."""
        return self.elastic.depth(-float(past @ self.elastic.force) / gain)

    def _finish(
        self,
        depth: float,
        body: float,
        gain: float,
        past: Array,
        decay: Array,
        ramp: Array,
        prescribed: float | None = None,
    ) -> None:
        """Set the state at the end of a step; a prescribed force is borne to the last digit."""
        shape = self.elastic.weights(body)
        self._terms = decay[:, None] * self._terms + np.outer(ramp, shape - self._shape)
        self._shape, self.depth, self.body = shape, depth, body
        stress = gain * shape + past
        force = float(stress @ self.elastic.force) if prescribed is None else prescribed
        touching = depth >= body and force > 0
        self.stress = stress if touching else np.zeros_like(stress)
        self.force = force if touching else 0.0
        self.edge = self._rim()

    def _rim(self) -> float:
        """Elastic depth in mm whose contact is the present one; 0 out of contact."""
        if self.force <= 0:
            self._turn = 0.0
            return 0.0
        if self.body >= self._turn * (1 - SAME):
            self._turn = self.body
            self._ratio = self.force / max(self.elastic.at(self.body), 1e-300)
            return self.body
        return min(self.body, SLOWER * self.elastic.depth(self.force / self._ratio))


@dataclass(frozen=True)
class RelaxedPress:
    """An elastic press relaxed along a motion, by convolution with G.

    depth (n_t,) mm of the indenter; force (n_t,); stress and strain (n_t, n): weights of the
    elastic values at the nodes, of the relaxed body, in pressures and moments and in
    displacements and strains; edge (n_t,) mm: the elastic depth whose contact is the present one.
    """

    depth: Array
    force: Array
    stress: Array
    strain: Array
    edge: Array


def relax(
    elastic: ElasticForce, prony: Prony, time: Array, value: Array, control: str
) -> RelaxedPress:
    """Convolve an elastic press with the relaxation along a prescribed depth (mm) or force.

    Raises
    ------
    ValueError
        A depth or force beyond the deepest node.

    Notes
    -----
    Each exponential of G is exact for elastic values that are linear over a step.
    """
    spring, shape = RelaxingSpring(elastic, prony), (len(time), len(elastic.nodes))
    depth, force, edge = np.empty(len(time)), np.empty(len(time)), np.empty(len(time))
    stress, strain = np.empty(shape), np.empty(shape)
    advance = spring.advance if control == "depth" else spring.advance_force
    for step, dt in enumerate(np.diff(time, prepend=time[0]).tolist()):
        advance(dt, float(value[step]))
        depth[step], force[step], edge[step] = spring.depth, spring.force, spring.edge
        stress[step], strain[step] = spring.stress, elastic.weights(spring.body)
    return RelaxedPress(depth, force, stress, strain, edge)
