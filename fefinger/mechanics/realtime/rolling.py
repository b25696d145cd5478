"""A plate that rolls over a finger in real time: its angle changes from step to step.

As the normal turns, so does the traction of the stress history, so the history is one of vectors
in the medial plane (`fem/contact/rolling_step.py`). The operator is that of
`mechanics/condensed.py`. A step that turns costs a few times one of `Condensed`, where the indenter
keeps its direction.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.spatial import ConvexHull

from fefinger.fem.body import Reduced
from fefinger.fem.condensation import reduce
from fefinger.fem.contact import lcp_compiled, rolling_step, step_compiled
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.contact.patch import Patch, patch, smooth_places
from fefinger.fem.elements.recovery import recovered_strain_at
from fefinger.fem.elements.spaces import trace
from fefinger.mechanics.press import operator, placement, problem
from fefinger.mechanics.realtime.loop import Loop, Step, warn_of_softness
from fefinger.results.records import Sites
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import direction
from fefinger.scene.indenters import Flat
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import InputError, number
from fefinger.support.units import NEWTON_PER_MILLINEWTON


PLANE = (0, 2)  # the components of the normal: the plate turns about y


class Rolling(Loop):
    """Half a finger under a plate that is moved and turned about y; symmetric, so half is enough.

    Parameters
    ----------
    finger
        As in a scene. Tissue that stiffens is taken as soft as it is at first touch, with a
        warning.
    angles
        The angles in degrees between which the plate is going to turn.
    deepest
        Depth in mm beyond first touch at each angle that the pad has to answer.
    sites
        End organs at which the strain is wanted, with y >= 0.

    Raises
    ------
    InputError
        If an angle is not one of a plate, a site lies outside the soft tissue, or the tissues do
        not relax as one.
    """

    def __init__(
        self,
        finger: Finger,
        *,
        angles: Sequence[float] = (10.0, 40.0),
        deepest: float = 1.5,
        sites: Sites,
    ) -> None:
        super().__init__(finger, deepest)
        if not len(angles):
            message = "angles: expected the degrees between which the plate turns, received none"
            raise InputError(message)
        turned = [Flat(angle).angle for angle in angles]
        self.sites, self.angles = sites, (min(turned), max(turned))
        self.shown = ("a plate from {:g} to {:g} degrees".format(*self.angles),)
        warn_of_softness(finger, Flat(sum(self.angles) / 2), self.deepest)
        solid = self.solid = operator.operator(finger, half=True)
        surface = trace(solid.space, solid.pad)
        skin = smooth_places(solid.space.points, solid.normals, surface)[..., PLANE].reshape(-1, 2)
        self._outline = skin[ConvexHull(skin).vertices]
        every = [
            patch(solid.space, solid.pad, solid.normals, Obstacle(axis, np.zeros(3)), np.inf)
            for axis in np.eye(3)[list(PLANE)]
        ]
        chosen = self._candidates(every[0], problem.REACH * deepest)
        self.vertices = every[0].vertices[chosen]
        weights = every[0].areas[chosen]
        moments = np.array([each.gap[chosen] for each in every])
        loads = sparse.hstack([each.loads[:, chosen] for each in every]).tocsc()
        places = sparse.hstack([each.places[:, chosen] for each in every]).tocsc()
        both = np.tile(self.vertices, 2)
        self._both = replace(every[0], vertices=both, loads=loads, places=places)
        reduced, n = self._reduced(sites.points), len(self.vertices)
        self._rows = np.ascontiguousarray(reduced.strain_operator.T)
        flexibility, rim = reduced.flexibility.reshape(2, n, 2, n), np.flatnonzero(self._on_rim())
        self._plate = rolling_step.plate(flexibility, moments, weights, rim)
        self._state = lcp_compiled.lcp_state(np.zeros((n, n)))  # made when the plate has an angle
        nothing = np.zeros(n)
        branches = finger.prony.branches
        self._memory = step_compiled.pad_state(nothing, nothing, *branches, components=2)
        self._along = -every[1].moment[chosen, 1] / every[1].projected[chosen]
        self._strain = np.zeros(6 * len(sites.points))
        self.now = Step.at_rest(self._state.x, self._strain.reshape(-1, 6))
        self.reset()

    @property
    def elastic(self) -> Array:
        """Traction (2n,) kPa along x and z of the linear body at the present displacement."""
        return self._memory.elastic

    def strains(self, points: Array) -> Array:
        """Return the strains (6 n_points, 2n) at points mm in the half under a unit `elastic`."""
        return self._reduced(points).strain_operator

    def reset(self) -> None:
        """Lift the plate off and clear the stress history."""
        step_compiled.reset(self._state, self._memory)
        self._strain[:] = 0.0
        self._read(0.0)

    def step(self, depth: float, angle: float, dt: float) -> Step:
        """Move the plate to `depth` mm beyond its first touch at `angle` degrees in `dt` s.

        A step that is refused leaves the finger as it was.

        Raises
        ------
        InputError
            If the angle is not between those given, or contact reaches the rim of the candidates.
        ConvergenceError
            If no contact is found.
        """
        number("angle", angle, at_least=self.angles[0], at_most=self.angles[1], unit="degrees")
        depth, dt = number("depth", depth, unit="mm"), number("dt", dt, at_least=0, unit="s")
        normal = direction(Flat(angle))[list(PLANE)]
        first = float((self._outline @ normal).min())
        x, z = normal.tolist()
        state, memory, plate = self._state, self._memory, self._plate
        step_compiled.check(
            rolling_step.step(state, memory, plate, dt, x, z, first + depth), self.deepest
        )
        lcp_compiled.combine(self._strain, self._rows, memory.elastic, plate.chosen, plate.factor)
        return self._read(depth)

    def _reduced(self, points: Array) -> Reduced:
        """Return the strain at points under unit tractions in both directions."""
        probe = recovered_strain_at(self.solid.space, points, self.solid.planes)
        return reduce(self.solid, self._both, probe)

    def _read(self, depth: float) -> Step:
        now, plate = self.now, self._plate
        weights = now.pressure * plate.weights
        total = float(weights.sum())
        now.depth, now.force = depth, 2 * total * NEWTON_PER_MILLINEWTON
        now.contact_area = 2 * float(plate.weights[now.pressure > 0].sum())
        now.x = float(weights @ self._along) / total if total > 0 else np.nan
        now.y = 0.0 if total > 0 else np.nan
        return now

    def _candidates(self, every: Patch, reach: float) -> Flags:
        """Flag the vertices that any of the plates is within `reach` mm of at first touch."""
        points = self.solid.space.points[every.vertices][:, PLANE]
        nearest = np.full(len(points), np.inf)
        for angle in np.arange(self.angles[0], self.angles[1] + 1.0, 1.0):
            normal = direction(Flat(min(angle, self.angles[1])))[list(PLANE)]
            first = float((self._outline @ normal).min())
            nearest = np.minimum(nearest, points @ normal - first)
        return nearest <= reach

    def _on_rim(self) -> Flags:
        """Flag the candidates next to pad vertices that are none, or on the border of the pad."""
        pad = self.solid.pad
        inside = np.isin(pad, self.vertices)
        beside = pad[inside.any(axis=1) & ~inside.all(axis=1)]
        return np.isin(self.vertices, beside) | np.isin(self.vertices, placement.border(self.solid))
