"""A flat block condensed to its face: part of a half-space, or a layer on a rigid base.

The block of a half-space ends in faces that move as those of the half-space do: under the unit load
of each vertex as under Boussinesq's point force there, the four images of which make the quarter.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from fefinger.validation.oracles.point_force import point_displacement
from fefinger.validation.problems.grids import box
from fefinger.validation.problems.quarter import Indenter

from fefinger.fem import condensation
from fefinger.fem.body import Solid
from fefinger.fem.contact.march import march
from fefinger.fem.contact.patch import Patch, patch
from fefinger.fem.contact.viscoelastic import Prescribed, Relaxation
from fefinger.fem.elements.forms import Elastic, stiffness
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg.system import factor
from fefinger.support.arrays import Array, Integers
from fefinger.theory.relaxation import Prony


REACH = 1.5  # contact radii to the last candidate vertex
EXTENT = 5.0  # contact radii to the outer faces of a half-space
WIDTH = 5.0  # thicknesses of a layer to its outer faces


@dataclass(frozen=True)
class HalfSpaceQuarter:
    """A quarter of a block under a paraboloid of `radius` mm, with `cells` along `contact` mm.

    thickness: None for a half-space, else that of a layer in mm, bonded below and free aside.
    """

    radius: float
    contact: float
    modulus: float
    poisson: float
    cells: int
    thickness: float | None = None

    @cached_property
    def space(self) -> Space:
        """Taylor-Hood on a graded grid."""
        across, down = (_graded(self.contact, self.cells, even) for even in (1.25, 0.5))
        if self.thickness is not None:
            across = across * max(1.0, WIDTH * self.thickness / across[-1])
            down = down[down < self.thickness - self.contact / self.cells / 2]
            down = np.append(down, self.thickness)
        return box(across, across, down)

    @cached_property
    def solid(self) -> Solid:
        """The block, with its face as the pad."""
        facets = np.asarray(self.space.scalar.mesh.facets.T, dtype=np.int64)
        top = facets[(self.space.points[facets][:, :, 2] == 0).all(axis=1)]
        flat = np.zeros_like(self.space.points)
        return Solid(self.space, top, flat, np.arange(len(flat)), False)

    @cached_property
    def fixed(self) -> Integers:
        """The unknowns that are held: the outer faces or the base, and the symmetry planes."""
        places = self.space.node_points
        outer = places > places.max(axis=0) * (1 - 1e-9)
        away = outer[:, 2] if self.thickness is not None else outer.any(axis=1)
        held = np.repeat(away[:, None], 3, axis=1)
        held[:, :2] |= places[:, :2] == 0
        return np.flatnonzero(held.ravel())

    @cached_property
    def patch(self) -> Patch:
        """The candidate vertices."""
        reach = (REACH * self.contact) ** 2 / (2 * self.radius)
        obstacle = Indenter(lambda x, y: (x**2 + y**2) / (2 * self.radius))
        return patch(self.space, self.solid.pad, self.solid.normals, obstacle, reach)

    @cached_property
    def flexibility(self) -> Array:
        """F (n, n) of the patch, from the condensed block."""
        tissues, size = {1: Elastic(self.modulus, self.poisson)}, self.space.n_unknowns
        compliance = condensation.condense(self.solid, tissues, self.fixed)
        loads = self.patch.loads.tocsr()[compliance.pad].tocsc()
        matrix = np.asarray(loads.T @ (loads.T @ compliance.matrix).T)
        if self.thickness is None:
            system = factor(self.space, stiffness(self.space, tissues), self.fixed)
            nothing = np.zeros((size, len(self.patch.vertices)))
            matrix += np.asarray(self.patch.loads.T @ system.solve(nothing, self._far()))
        return (matrix + matrix.T) / 2

    def _far(self) -> Array:
        """Return the displacement (n_fixed, n) of the half-space under each unit load."""
        places = self.space.node_points
        away = (places > places.max(axis=0) * (1 - 1e-9)).any(axis=1)
        field = np.zeros((len(places), 3, len(self.patch.vertices)))
        for column, vertex in enumerate(self.patch.vertices):
            x, y = self.space.points[vertex, :2]
            for image in ((x, y), (-x, y), (x, -y), (-x, -y)):
                offset = places[away, :2] - image
                r = np.maximum(np.hypot(*offset.T), 1e-12)
                outward, down = point_displacement(
                    r, places[away, 2], force=1.0, modulus=self.modulus, poisson=self.poisson
                )
                field[away, :2, column] += (outward / r)[:, None] * offset
                field[away, 2, column] += down
        field *= self.patch.projected
        return np.asarray(field.reshape(-1, len(self.patch.vertices))[self.fixed])

    def forces(self, prony: Prony, time: Array, depth: Array) -> Array:
        """Return the force (n_t,) in mN of the whole block, stepped as a condensed finger is."""
        count = len(self.patch.vertices)
        memory = Relaxation(np.array(prony.weights), np.array(prony.v), count)
        prescribed = Prescribed("depth", time, depth)
        history = march(self.flexibility, self.patch.gap, self.patch.projected, memory, prescribed)
        if (history.pressure[:, self.patch.border] > 0).any():
            message = "block: contact reached the rim of its candidates"
            raise AssertionError(message)
        return 4 * np.asarray(history.pressure @ self.patch.projected)


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
