"""A flat block under a paraboloid, with Hertz's own far field on its outer faces.

The gap is r² / 2R exactly and the block ends where the half-space goes on, so that Hertz's
assumptions hold and only the finite elements can be wrong. One quarter is meshed.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fefinger.fem.area import Surface
from fefinger.fem.contact import Complementarity, Patch, patch
from fefinger.fem.forms import Elastic, stiffness
from fefinger.fem.grids import box
from fefinger.fem.solve import System, factor
from fefinger.fem.spaces import Space
from fefinger.theory.hertz import Hertz


Array = NDArray[np.float64]

EXTENT = 5.0  # contact radii to the outer faces
REFINED = 1.25  # contact radii of even cells around the contact


@dataclass(frozen=True)
class Paraboloid:
    """The indenter of Hertz's theory: a gap of r² / 2R that presses straight down."""

    radius: float

    @property
    def axis(self) -> Array:
        """Direction of travel (3,)."""
        return np.array([0.0, 0.0, 1.0])

    def gap(self, points: Array) -> tuple[Array, Array]:
        """Return the gap (...,) mm and the pressing direction (..., 3)."""
        distance = np.sum(points[..., :2] ** 2, axis=-1) / (2 * self.radius)
        return distance, np.broadcast_to(self.axis, points.shape)


@dataclass(frozen=True)
class Block:
    """A quarter block under the indenter of `hertz`, with `cells` cells along its radius."""

    hertz: Hertz
    cells: int

    @cached_property
    def space(self) -> Space:
        """Taylor-Hood on a graded grid: even under the contact, growing away from it."""
        a = self.hertz.contact_radius
        across, down = (_graded(a, self.cells, even) for even in (REFINED, 0.5))
        return box(across, across, down)

    @cached_property
    def far(self) -> NDArray[np.bool_]:
        """The nodes on the outer faces, where Hertz's displacement is prescribed."""
        places = self.space.node_points
        return np.asarray((places > places.max(axis=0) * (1 - 1e-9)).any(axis=1))

    @cached_property
    def system(self) -> System:
        """The factored quarter, held on its outer faces and sliding in the symmetry planes."""
        held = np.repeat(self.far[:, None], 3, axis=1)
        held[:, :2] |= self.space.node_points[:, :2] == 0
        elastic = Elastic(self.hertz.modulus, self.hertz.poisson)
        return factor(self.space, stiffness(self.space, {1: elastic}), np.flatnonzero(held.ravel()))

    @cached_property
    def patch(self) -> Patch:
        """The candidate vertices, out to 1.6 contact radii."""
        facets = self.top()
        reach = (1.6 * self.hertz.contact_radius) ** 2 / (2 * self.hertz.radius)
        flat = np.zeros_like(self.space.points)
        return patch(self.space, facets, flat, Paraboloid(self.hertz.radius), reach)

    @cached_property
    def solved(self) -> tuple[Array, Array]:
        """The contact pressure (n,) kPa and the gap (n,) mm at the vertices of the patch."""
        exact = np.zeros((self.space.n_nodes, 3))
        places = self.space.node_points[self.far]
        r = np.hypot(places[:, 0], places[:, 1])
        outward, inward = self.hertz.displacement(r, np.maximum(places[:, 2], 1e-12))
        exact[self.far, :2] = (outward / np.maximum(r, 1e-12))[:, None] * places[:, :2]
        exact[self.far, 2] = inward
        prescribed = exact.ravel()[self.system.fixed]
        base = self.system.solve(np.zeros(self.space.n_unknowns), prescribed)
        unit = self.system.solve(self.patch.loads.toarray())
        free = self.patch.gap - self.hertz.depth * self.patch.travel + self.patch.loads.T @ base
        pressure = Complementarity(np.asarray(self.patch.loads.T @ unit)).solve(free)
        approach = self.patch.places.T @ (base + unit @ pressure)
        return pressure, self.patch.clearance(np.array([self.hertz.depth]), approach)[0]

    @property
    def pressure(self) -> Array:
        """The contact pressure (n,) kPa at the vertices of the patch."""
        return self.solved[0]

    @property
    def force(self) -> float:
        """The contact force of the whole block in mN."""
        return 4 * float(self.patch.travel @ self.pressure)

    @property
    def area(self) -> float:
        """The contact area of the whole block in mm²."""
        pressure, gap = self.solved
        number = np.full(len(self.space.points), -1)
        number[self.patch.vertices] = np.arange(len(pressure))
        triangles = number[self.patch.triangles]
        triangles = triangles[(triangles >= 0).all(axis=1)]
        places = self.space.points[self.patch.vertices]
        surface = Surface(places, triangles, np.array([0.0, 0.0, 1.0]))
        return 4 * float(surface.area((pressure > 0)[None], gap[None])[0])

    def top(self) -> NDArray[np.int64]:
        """Triangles (n, 3) of the face z = 0."""
        facets = np.asarray(self.space.scalar.mesh.facets.T, dtype=np.int64)
        return facets[(self.space.points[facets][:, :, 2] == 0).all(axis=1)]


def _graded(a: float, cells: int, even: float) -> Array:
    """Even steps a / cells to `even` a, then growing smoothly to EXTENT a."""
    count = max(1, round(even * cells))
    inner = np.linspace(0, even * a, count + 1)
    growth = 1.0 + 1.6 / cells
    steps = [a / cells]
    while sum(steps) < (EXTENT - even) * a:
        steps.append(steps[-1] * growth)
    outer = np.cumsum(steps)
    return np.concatenate([inner, even * a + outer * ((EXTENT - even) * a / outer[-1])])
