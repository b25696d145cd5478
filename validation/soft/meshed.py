"""Meshed soft bodies at finite strain, and what stands for them in a scene.

Under a rigid ball, which is the finger, the soft body is an object. The elements know nothing of
the kernel: their error and that of the kernel, small strain on a flat body, are apart.

Two equal domes that are pressed together are mirror images: between them lies a plane. So each is
one dome under a rigid plate at half of the approach, at any strain. What stands for one of them,
beside the other one meshed, has its error beside that.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from fefinger.validation.problems.grids import quarter
from fefinger.validation.problems.quarter import outer, top

from fefinger.contact.complementarity import Complementarity
from fefinger.contact.elastic_kernel import Facets, Kernel, flexibility
from fefinger.contact.soft import ElasticSurface
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
from fefinger.geometry.profiles import Ellipsoid, Plane, Profile
from fefinger.mechanics.press.compliances import elastic_surface
from fefinger.support.arrays import Array
from fefinger.theory.contact.stack import Layer, Stack, moment


RADIUS, MODULUS, POISSON = 10.0, 50.0, 0.49
"""Of the ball in mm, about that of a pad; modulus in kPa and Poisson's ratio of the soft body."""

DEPTHS = (0.3, 0.6, 1.0, 1.5)
"""Depths in mm at which forces are compared."""

WIDE = 4.0
"""Radius of the soft body over its thickness; what stands for it has no end."""

DOME, DOME_SIZE = 20.0, 1.2
"""Radius of a dome in mm, and edge of its cells at the contact.

With cells of 0.9 mm the errors of the forces change by 0.3 % of the force at most.
"""

QUARTERS = np.array([[x, y, 1.0] for x in (1.0, -1.0) for y in (1.0, -1.0)])
"""Signs of the images of the quarter that is meshed."""


@dataclass(frozen=True, eq=False)
class SoftBlock:
    """A quarter of a disc of soft material on a rigid base.

    thickness mm; size mm: edge of the cells under the contact; dome mm: radius of its face.
    """

    thickness: float
    size: float
    dome: float = np.inf

    @cached_property
    def flat(self) -> Space:
        """The quarter, x, y >= 0, with its face at z = 0 and its base at z = `thickness`."""
        r = np.linspace(0.0, WIDE * self.thickness, 9)
        z = np.linspace(0.0, self.thickness, 4)
        reach = 1.2 * np.sqrt(RADIUS * DEPTHS[-1])

        def wanted(r: Array, z: Array) -> Array:
            return np.asarray(self.size + 0.4 * np.maximum(np.hypot(r, z) - reach, 0.0))

        return quarter(r, z, wanted, 6)

    @cached_property
    def space(self) -> Space:
        """The quarter with its dome, which goes on as a cone."""
        if self.dome == np.inf:
            return self.flat
        points = self.flat.points.copy()
        r = np.hypot(points[:, 0], points[:, 1])
        inner = np.minimum(r, 0.4 * self.dome)
        level = np.sqrt(self.dome**2 - inner**2)
        sunk = self.dome - level + (r - inner) * inner / level
        points[:, 2] += sunk
        return Space(points, self.flat.vertices, np.ones(len(self.flat.vertices), dtype=np.int8))

    @property
    def stack(self) -> Stack:
        """What stands for it: the layer."""
        return Stack((Layer(self.thickness, MODULUS, POISSON),))

    @cached_property
    def contact(self) -> ContactSurface:
        """The ball over the face."""
        return self.under(Ellipsoid((RADIUS,) * 3))

    def under(self, profile: Profile) -> ContactSurface:
        """Return an obstacle over the face."""
        obstacle = Obstacle(np.array([0.0, 0.0, 1.0]), np.zeros(3), profile)
        face = top(self.flat)
        near = np.linalg.norm(self.space.points[face][:, :, :2], axis=2).max(axis=1) < 0.9 * RADIUS
        still = np.zeros_like(self.space.points)
        return contact_surface(self.space, face[near], still, obstacle, 2 * DEPTHS[-1])

    def meshed(self) -> Array:
        """Return the forces (n,) in N of the neo-Hookean body at DEPTHS."""
        return self.forces(self.contact, DEPTHS)

    def forces(self, contact: ContactSurface, depths: Sequence[float]) -> Array:
        """Return the forces (n,) in N of the neo-Hookean body at depths (n,) in mm."""
        law = material_of(Elastic(MODULUS, POISSON))
        body = continuum(self.space, {1: law})
        base, _ = outer(self.flat)
        held = np.repeat(base[:, None], 3, axis=1)
        held[:, :2] |= self.space.node_points[:, :2] == 0
        still = np.zeros(self.space.n_unknowns)
        matrix = body.tangent(still, body.at_rest, consistent=False)
        system = factor(self.space, matrix, np.flatnonzero(held.ravel()))
        solver, forces = Equilibrium(body, contact, system), []

        def keep(_: int, state: State) -> None:
            forces.append(4e-3 * float(contact.projected @ state.pressure))

        steps = np.arange(len(depths) + 1.0)
        path = LoadPath("depth", steps, lambda t: float(np.interp(t, steps, (0.0, *depths))))
        follow(solver, StressHistory(body, {}), path, keep)
        return np.array(forces[1:])

    def stood_for(self) -> Array:
        """Return the forces (n,) in N of what stands for it: the layer, on the same facets."""
        on = self.contact.on
        corners = np.ascontiguousarray(self.space.points[on.part.triangles])
        skin = Facets(corners, on.owner, np.ascontiguousarray(on.part.places), on.part.hats)
        own = flexibility(Kernel(*moment(self.stack)), skin, len(self.contact), QUARTERS)
        solver, area = Complementarity(own), self.contact.projected
        height, _ = self.contact.obstacle.gap(on.part.places)
        rise = on.integrated(on.part.hats * height[:, None])
        return np.array([4e-3 * float(area @ solver.solve(rise - d * area)) for d in DEPTHS])


@dataclass(frozen=True)
class MirroredSurface(ElasticSurface):
    """The mirror image of facets, with the flexibility of what stands for their body.

    sunk (n_tri, n_q) mm at the places and (n_near,) mm at the vertices: below the plane at rest.
    """

    sunk: tuple[Array, Array]

    def at_places(self, pressure: Array) -> Array:
        """Return how far it is from the plane (n_tri, n_q) mm, at the quadrature points."""
        return self.sunk[0] + super().at_places(pressure)

    def around(self, pressure: Array) -> Array:
        """Return how far it is from the plane (n_near,) mm, at the candidates and around them."""
        return self.sunk[1] + super().around(pressure)


@cache
def errors_beside_a_dome(thickness: float) -> tuple[float, ...]:
    """Return the errors of the force of what stands for a dome under its equal, at DEPTHS."""
    dome = SoftBlock(thickness, DOME_SIZE, DOME)
    plate = dome.under(Plane())
    stands = elastic_surface(dome.stack, dome.space, plate, QUARTERS)
    sunk = plate.on.part.places[..., 2], plate.at_rest[:, 2]
    mirrored = MirroredSurface(stands.flexibility, stands.places, stands.vertices, sunk)
    found = dome.forces(replace(plate, surface=mirrored), DEPTHS)
    exact = dome.forces(plate, np.divide(DEPTHS, 2).tolist())
    return tuple((found / exact - 1).tolist())
