"""A plate that rolls over a finger: the angle changes while the tissue remembers its traction.

As the normal turns, so does the traction that the tissue remembers, so the history is one of
vectors in the medial plane. The operator is that of `mechanics/condensed`; the flexibility along
the plate's normal is a quadratic form in it, made anew in every step. That costs a few times a step
of `realtime.Condensed`, where the indenter keeps its direction.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fefinger.checks import InputError, number
from fefinger.fem.condense import reduce
from fefinger.fem.contact import Complementarity, Patch, patch, smooth_places
from fefinger.fem.march import Relaxation
from fefinger.fem.obstacle import Obstacle
from fefinger.fem.probe import strain_at
from fefinger.fem.spaces import trace
from fefinger.mechanics import _operator, _placing, _press
from fefinger.mechanics._touch import direction
from fefinger.realtime import Step
from fefinger.records import Sites
from fefinger.scene import Finger, Flat
from fefinger.units import NEWTON_PER_MILLINEWTON


Array = NDArray[np.float64]

PLANE = (0, 2)  # the components of the normal: the plate turns about y


class Rolling:
    """Half a finger under a plate that is moved and turned about y; symmetric, so half is enough.

    Parameters
    ----------
    finger
        As in a scene.
    angles
        The angles in degrees between which the plate is going to turn.
    deepest
        Depth in mm beyond first touch at each angle that the pad has to answer.
    sites
        End organs at which the strain is wanted, with y >= 0.

    Raises
    ------
    InputError
        If an angle is not one of a plate, or a site lies outside the soft tissue.
    """

    def __init__(
        self,
        finger: Finger,
        *,
        angles: Sequence[float] = (10.0, 40.0),
        deepest: float = 1.5,
        sites: Sites,
    ) -> None:
        number("deepest", deepest, above=0, unit="mm")
        self.sites, self.angles = sites, (min(angles), max(angles))
        solid = self.solid = _operator.operator(finger, half=True)
        surface = trace(solid.space, solid.pad)
        self._places = smooth_places(solid.space.points, solid.normals, surface)[..., PLANE]
        every = [
            patch(solid.space, solid.pad, solid.normals, Obstacle(axis, np.zeros(3)), np.inf)
            for axis in np.eye(3)[list(PLANE)]
        ]
        chosen = self._candidates(every[0], _press.REACH * deepest)
        self.vertices = every[0].vertices[chosen]
        self._weights = every[0].areas[chosen]
        self._moments = np.array([each.gap[chosen] for each in every])
        loads = sparse.hstack([each.loads[:, chosen] for each in every]).tocsc()
        places = sparse.hstack([each.places[:, chosen] for each in every]).tocsc()
        both = replace(every[0], vertices=np.tile(self.vertices, 2), loads=loads, places=places)
        probe = strain_at(solid.space, sites.points, medial=True)
        reduced = reduce(solid, both, probe)
        n = len(self.vertices)
        self._flexibility = reduced.flexibility.reshape(2, n, 2, n)
        self._strain, self._prony = reduced.strain, finger.prony
        self._rim = self._on_rim()
        empty = np.zeros(n), np.zeros((len(sites.points), 6))
        self.now = Step(0.0, 0.0, 0.0, np.nan, np.nan, *empty)
        self.reset()

    def reset(self) -> None:
        """Take the plate off, and let the tissue forget."""
        self._active = np.zeros(len(self.vertices), dtype=np.bool_)
        weights, rates = np.array(self._prony.weights), np.array(self._prony.v)
        self._memory = Relaxation(weights, rates, 2 * len(self.vertices))

    def step(self, depth: float, angle: float, dt: float) -> Step:
        """Move the plate to `depth` mm beyond its first touch at `angle` degrees in `dt` s.

        Raises
        ------
        InputError
            If the angle is not between those given, or contact reaches the rim of the candidates.
        ConvergenceError
            If no contact is found.
        """
        number("angle", angle, at_least=self.angles[0], at_most=self.angles[1], unit="degrees")
        normal = direction(Flat(angle))[list(PLANE)]
        first = float((self._places @ normal).min())
        g, past = self._memory.history(dt)
        n = len(self.vertices)
        full = self._flexibility.reshape(2 * n, 2 * n)
        remembered = normal @ (full @ past).reshape(2, n) / g
        free = normal @ self._moments - (first + depth) * self._weights - remembered
        solver = Complementarity(np.einsum("c,d,cidj->ij", normal, normal, self._flexibility))
        solver.active = self._active
        pressure = g * solver.solve(free)
        self._active = solver.active
        elastic = (np.outer(normal, pressure).ravel() - past) / g
        self._memory.advance(dt, elastic)
        return self._read(depth, pressure, elastic)

    def _read(self, depth: float, pressure: Array, elastic: Array) -> Step:
        if (pressure[self._rim] > 0).any():
            message = "step: contact reached the rim of the candidates; make `deepest` larger"
            raise InputError(message)
        points = self.solid.space.points[self.vertices]
        weights, now = pressure * self._weights, self.now
        total = float(weights.sum())
        now.depth, now.force = depth, 2 * total * NEWTON_PER_MILLINEWTON
        now.contact_area = 2 * float(self._weights[pressure > 0].sum())
        now.x = float(weights @ points[:, 0]) / total if total > 0 else np.nan
        now.y = 0.0 if total > 0 else np.nan
        now.pressure[:] = pressure
        now.strain[:] = (self._strain @ elastic).reshape(-1, 6)
        return now

    def _candidates(self, every: Patch, reach: float) -> NDArray[np.bool_]:
        """Return which vertices any of the plates comes within `reach` mm of, at first touch."""
        points = self.solid.space.points[every.vertices][:, PLANE]
        nearest = np.full(len(points), np.inf)
        for angle in np.arange(self.angles[0], self.angles[1] + 1.0, 1.0):
            normal = direction(Flat(min(angle, self.angles[1])))[list(PLANE)]
            first = float((self._places @ normal).min())
            nearest = np.minimum(nearest, points @ normal - first)
        return nearest <= reach

    def _on_rim(self) -> NDArray[np.bool_]:
        """Return which candidates have a neighbor that is none, or lie on the border of the pad."""
        pad = self.solid.pad
        inside = np.isin(pad, self.vertices)
        beside = pad[inside.any(axis=1) & ~inside.all(axis=1)]
        return np.isin(self.vertices, beside) | np.isin(self.vertices, _placing.border(self.solid))
