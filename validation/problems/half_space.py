"""A flat block under a ball: part of a half-space, or a layer on a rigid base.

The block of a half-space ends in faces that move as those of the half-space do: under the unit load
of each vertex as under the point forces of Boussinesq and Cerruti there, whose images make a
quarter, which is condensed to its face, or a half, which is sheared as well.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from fefinger.validation.oracles.mindlin import cerruti, point_displacement
from fefinger.validation.problems.grids import box
from fefinger.validation.problems.quarter import Indenter, top
from scipy import sparse

from fefinger.contact.frictionless import FrictionlessContact
from fefinger.contact.stepper import Prescribed, march
from fefinger.fem import condensation
from fefinger.fem.body import Solid
from fefinger.fem.contact.patch import Patch, directed, patch
from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg.system import factor
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.theory.relaxation import Prony


REACH, SHEARED_REACH = 1.5, 1.3  # contact radii to the last candidate vertex
EXTENT, SHEARED_EXTENT = 5.0, 4.0  # contact radii to the outer faces of a half-space
EVEN = 1.25  # contact radii up to which cells are even
GROWTH = 1.6  # of the cells beyond, over their number along a contact radius, above 1
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
        across, down = (_graded(self.contact, self.cells, even, EXTENT) for even in (EVEN, 0.5))
        if self.thickness is not None:
            across = across * max(1.0, WIDTH * self.thickness / across[-1])
            down = down[down < self.thickness - self.contact / self.cells / 2]
            down = np.append(down, self.thickness)
        return box(across, across, down)

    @cached_property
    def solid(self) -> Solid:
        """The block, with its face as the pad."""
        flat = np.zeros_like(self.space.points)
        return Solid(self.space, top(self.space), flat, np.arange(len(flat)), False)

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
        pad, normals = self.solid.pad, self.solid.normals
        return patch(self.space, pad, normals, _ball(self.radius), reach)

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
        pad = self.flexibility, self.patch.gap, self.patch.projected, prony.branches
        history = march(FrictionlessContact(*pad), Prescribed("depth", time, depth))
        if (history.pressure[:, self.patch.border] > 0).any():
            message = "block: contact reached the rim of its candidates"
            raise AssertionError(message)
        return 4 * np.asarray(history.pressure @ self.patch.projected)


@dataclass(frozen=True)
class ShearBlock:
    """Half a block, y >= 0, under the same paraboloid: pressed, and sheared along its cut."""

    radius: float
    contact: float
    modulus: float
    poisson: float
    cells: int

    @cached_property
    def space(self) -> Space:
        """Taylor-Hood on a graded grid."""
        side, down = (_graded(self.contact, self.cells, k, SHEARED_EXTENT) for k in (EVEN, 0.5))
        return box(np.concatenate([-side[:0:-1], side]), side, down)

    @cached_property
    def patch(self) -> Patch:
        """The candidate vertices, with unit pressures."""
        reach = (SHEARED_REACH * self.contact) ** 2 / (2 * self.radius)
        flat = np.zeros_like(self.space.points)
        return patch(self.space, top(self.space), flat, _ball(self.radius), reach)

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


def _ball(radius: float) -> Indenter:
    return Indenter(lambda x, y: (x**2 + y**2) / (2 * radius))


def _graded(a: float, cells: int, even: float, extent: float) -> Array:
    """Even steps a / cells to `even` a, then growing smoothly to `extent` a."""
    count = max(1, round(even * cells))
    steps, growth = [a / cells], 1.0 + GROWTH / cells
    while sum(steps) < (extent - even) * a:
        steps.append(steps[-1] * growth)
    outer = np.cumsum(steps)
    inner = np.linspace(0, even * a, count + 1)
    return np.concatenate([inner, even * a + outer * ((extent - even) * a / outer[-1])])
