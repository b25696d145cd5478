"""Half of a flat block under a sphere that presses and shears it: part of a half-space.

The block is cut in the plane y = 0, along which it is sheared. Its outer faces move as those of the
half-space do, under each unit load as under the point forces of Boussinesq and Cerruti there.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from fefinger.validation.oracles.mindlin import cerruti
from fefinger.validation.oracles.point_force import point_displacement
from fefinger.validation.problems.grids import box
from fefinger.validation.problems.quarter import Indenter, top
from scipy import sparse

from fefinger.fem.contact.patch import Patch, directed, patch
from fefinger.fem.elements.forms import Elastic, stiffness
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg.system import factor
from fefinger.support.arrays import Array, Flags


REACH = 1.3  # contact radii to the last candidate vertex
EXTENT = 4.0  # contact radii to the outer faces
EVEN = 1.25  # contact radii up to which cells are even
GROWTH = 1.6  # of the cells beyond, over their number along a contact radius, above 1


@dataclass(frozen=True)
class ShearBlock:
    """Half a block, y >= 0, under a paraboloid of `radius` mm, with `cells` along `contact` mm."""

    radius: float
    contact: float
    modulus: float
    poisson: float
    cells: int

    @cached_property
    def space(self) -> Space:
        """Taylor-Hood on a graded grid."""
        side, down = (graded(self.contact, self.cells, even) for even in (EVEN, 0.5))
        return box(np.concatenate([-side[:0:-1], side]), side, down)

    @cached_property
    def patch(self) -> Patch:
        """The candidate vertices, with unit pressures."""
        reach = (REACH * self.contact) ** 2 / (2 * self.radius)
        obstacle = Indenter(lambda x, y: (x**2 + y**2) / (2 * self.radius))
        flat = np.zeros_like(self.space.points)
        return patch(self.space, top(self.space), flat, obstacle, reach)

    @cached_property
    def loads(self) -> sparse.csc_matrix:
        """Unit pressures, then unit tractions along x and along y; none of those in the plane."""
        along, across = (directed(self.space, self.patch, np.eye(3)[k]) for k in (0, 1))
        beside = self.space.points[self.patch.vertices, 1] > 0
        across = across @ sparse.diags_array(beside.astype(float))
        return sparse.hstack([self.patch.loads, along, across]).tocsc()

    @cached_property
    def flexibility(self) -> Array:
        """F (3n, 3n) of half the block."""
        places = self.space.node_points
        outer = (np.abs(places) > np.abs(places).max(axis=0) * (1 - 1e-9)).any(axis=1)
        held = np.repeat(outer[:, None], 3, axis=1)
        held[:, 1] |= places[:, 1] == 0
        fixed = np.flatnonzero(held.ravel())
        tissues = {1: Elastic(self.modulus, self.poisson)}
        system = factor(self.space, stiffness(self.space, tissues), fixed)
        moved = system.solve(
            self.loads.toarray(), self._far(outer).reshape(len(held) * 3, -1)[fixed]
        )
        matrix = np.asarray(self.loads.T @ moved)
        return (matrix + matrix.T) / 2

    def _far(self, outer: Flags) -> Array:
        """Return the displacement (n_nodes, 3, 3n) of the half-space at the outer faces."""
        places, count = self.space.node_points[outer], len(self.patch.vertices)
        shear = self.modulus / (2 * (1 + self.poisson))
        field = np.zeros((len(self.space.node_points), 3, 3 * count))
        for column, vertex in enumerate(self.patch.vertices):
            x, y = self.space.points[vertex, :2]
            for sign in (1.0, -1.0):
                u, v = (places[:, :2] - (x, sign * y)).T
                z, r = places[:, 2], np.maximum(np.hypot(u, v), 1e-12)
                outward, down = point_displacement(
                    r, z, force=1.0, modulus=self.modulus, poisson=self.poisson
                )
                field[outer, :, column] += np.column_stack([outward * u / r, outward * v / r, down])
                along = cerruti(u, v, z, shear=shear, poisson=self.poisson)
                field[outer, :, count + column] += along.T
                across = cerruti(v, u, z, shear=shear, poisson=self.poisson)[[1, 0, 2]]
                field[outer, :, 2 * count + column] += sign * (y > 0) * across.T
        # On the plane of symmetry a vertex has half of its hat, and both images coincide.
        return field * np.tile(self.patch.projected, 3)


def graded(a: float, cells: int, even: float) -> Array:
    """Even steps a / cells to `even` a, then growing to EXTENT a."""
    count = max(1, round(even * cells))
    steps, growth = [a / cells], 1.0 + GROWTH / cells
    while sum(steps) < (EXTENT - even) * a:
        steps.append(steps[-1] * growth)
    outer = np.cumsum(steps)
    inner = np.linspace(0, even * a, count + 1)
    return np.concatenate([inner, even * a + outer * ((EXTENT - even) * a / outer[-1])])
