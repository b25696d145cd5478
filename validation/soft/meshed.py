"""A meshed soft body under a rigid ball at finite strain, and what stands for it in a scene.

The ball is the finger, of its radius and rigid; the soft body is an object. The elements know
nothing of the kernel: their error and that of the kernel, small strain on a flat body, are apart.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from fefinger.validation.problems.grids import quarter
from fefinger.validation.problems.quarter import outer, top

from fefinger.contact.complementarity import Complementarity
from fefinger.contact.elastic_kernel import Facets, Kernel, flexibility
from fefinger.fem.contact.deformed_gap import ContactSurface, contact_surface
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.continuum import continuum
from fefinger.fem.hyperelastic.load_path import LoadPath, StressHistory, follow
from fefinger.fem.hyperelastic.material import material_of
from fefinger.fem.hyperelastic.newton import Equilibrium
from fefinger.fem.hyperelastic.state import State
from fefinger.fem.linalg.system import factor
from fefinger.geometry.profiles import Ellipsoid
from fefinger.support.arrays import Array
from fefinger.theory.contact.stack import Layer, Stack, moment


RADIUS, MODULUS, POISSON = 10.0, 50.0, 0.49
"""Of the ball in mm, about that of a pad; modulus in kPa and Poisson's ratio of the soft body."""

DEPTHS = (0.3, 0.6, 1.0, 1.5)
"""Depths in mm at which forces are compared."""

WIDE = 4.0
"""Radius of the soft body over its thickness; what stands for it has no end."""

QUARTERS = np.array([[x, y, 1.0] for x in (1.0, -1.0) for y in (1.0, -1.0)])
"""Signs of the images of the quarter that is meshed."""


@dataclass(frozen=True, eq=False)
class SoftBlock:
    """A quarter of a disc of soft material on a rigid base, under the ball.

    thickness mm; size mm: edge of the cells under the ball.
    """

    thickness: float
    size: float

    @cached_property
    def space(self) -> Space:
        """The quarter, x, y >= 0, with its face at z = 0 and its base at z = `thickness`."""
        r = np.linspace(0.0, WIDE * self.thickness, 9)
        z = np.linspace(0.0, self.thickness, 4)
        reach = 1.2 * np.sqrt(RADIUS * DEPTHS[-1])

        def wanted(r: Array, z: Array) -> Array:
            return np.asarray(self.size + 0.4 * np.maximum(np.hypot(r, z) - reach, 0.0))

        return quarter(r, z, wanted, 6)

    @cached_property
    def contact(self) -> ContactSurface:
        """The ball over the face."""
        ball = Obstacle(np.array([0.0, 0.0, 1.0]), np.zeros(3), Ellipsoid((RADIUS,) * 3))
        face = top(self.space)
        near = np.linalg.norm(self.space.points[face][:, :, :2], axis=2).max(axis=1) < 0.9 * RADIUS
        flat = np.zeros_like(self.space.points)
        return contact_surface(self.space, face[near], flat, ball, 2 * DEPTHS[-1])

    def meshed(self) -> Array:
        """Return the forces (n,) in N of the neo-Hookean body at DEPTHS."""
        law = material_of(Elastic(MODULUS, POISSON))
        body = continuum(self.space, {1: law})
        base, _ = outer(self.space)
        held = np.repeat(base[:, None], 3, axis=1)
        held[:, :2] |= self.space.node_points[:, :2] == 0
        still = np.zeros(self.space.n_unknowns)
        matrix = body.tangent(still, body.at_rest, consistent=False)
        system = factor(self.space, matrix, np.flatnonzero(held.ravel()))
        solver, forces = Equilibrium(body, self.contact, system), []

        def keep(_: int, state: State) -> None:
            forces.append(4e-3 * float(self.contact.projected @ state.pressure))

        steps = np.arange(len(DEPTHS) + 1.0)
        path = LoadPath("depth", steps, lambda t: float(np.interp(t, steps, (0.0, *DEPTHS))))
        follow(solver, StressHistory(body, {}), path, keep)
        return np.array(forces[1:])

    def stood_for(self) -> Array:
        """Return the forces (n,) in N of what stands for it: the layer, on the same facets."""
        on = self.contact.on
        corners = np.ascontiguousarray(self.space.points[on.part.triangles])
        skin = Facets(corners, on.owner, np.ascontiguousarray(on.part.places), on.part.hats)
        stack = Stack((Layer(self.thickness, MODULUS, POISSON),))
        own = flexibility(Kernel(*moment(stack)), skin, len(self.contact), QUARTERS)
        solver, area = Complementarity(own), self.contact.projected
        height, _ = self.contact.obstacle.gap(on.part.places)
        rise = on.integrated(on.part.hats * height[:, None])
        return np.array([4e-3 * float(area @ solver.solve(rise - d * area)) for d in DEPTHS])
