"""A quarter of a body under a rigid indenter, solved once and compared with an exact contact.

The gap is a function of the place, the outer faces have the displacement of the exact solution, so
that only the finite elements and their contact can be wrong.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from fefinger.validation.oracles.mindlin import point_displacement

from fefinger.contact.complementarity import Complementarity
from fefinger.fem.contact.patch import Patch, patch
from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.elements.probe import recovered_strain_at, strain_at
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg.system import System, factor
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.tensors import tensor_from_voigt


Surface = Callable[[Array, Array], Array]
"""A function of x and y (...,) mm on the surface: a gap in mm or a pressure in kPa."""

CUTS = 24  # parts of an edge into which a triangle is cut to compare pressures
RINGS, SPOKES = 40, 64  # quadrature of a pressure on its ellipse


@dataclass(frozen=True)
class Indenter:
    """A rigid indenter that presses straight down: its gap at first touch, infinite beyond it."""

    profile: Surface

    @property
    def axis(self) -> Array:
        """Direction of travel (3,)."""
        return np.array([0.0, 0.0, 1.0])

    def gap(self, points: Array) -> tuple[Array, Array]:
        """Return the gap (...,) mm and the pressing direction (..., 3)."""
        distance = self.profile(points[..., 0], points[..., 1])
        return distance, np.broadcast_to(self.axis, points.shape)

    def beyond(self, points: Array) -> Flags:
        """Return False: the paraboloid goes on."""
        return np.zeros(points.shape[:-1], dtype=bool)


@dataclass(frozen=True)
class Exact:
    """What the contact should be: depth mm, force mN, half axes mm and pressure(x, y) kPa."""

    depth: float
    force: float
    axes: tuple[float, float]
    pressure: Surface


@dataclass(frozen=True, eq=False)
class Quarter:
    """A quarter body, x and y >= 0, and the indenter on its face z = 0.

    held (n_nodes, 3) which displacements are prescribed and prescribed (n_nodes, 3) mm their
    values; reach mm is the largest gap at first touch that may close.
    """

    space: Space
    tissues: Mapping[int, Elastic]
    held: Flags
    prescribed: Array
    indenter: Indenter
    reach: float

    @cached_property
    def system(self) -> System:
        """The factored body, sliding in the planes of symmetry."""
        held = self.held.copy()
        held[:, :2] |= self.space.node_points[:, :2] == 0
        fixed = np.flatnonzero(held.ravel())
        return factor(self.space, stiffness(self.space, self.tissues), fixed)

    @cached_property
    def patch(self) -> Patch:
        """The candidate vertices."""
        flat = np.zeros_like(self.space.points)
        return patch(self.space, top(self.space), flat, self.indenter, self.reach)

    @cached_property
    def unloaded(self) -> Array:
        """The unknowns (n,) without contact: what the outer faces do alone."""
        prescribed = self.prescribed.ravel()[self.system.fixed]
        return self.system.solve(np.zeros(self.space.n_unknowns), prescribed)

    @cached_property
    def unit(self) -> Array:
        """The unknowns (n, n_vertices) under unit pressures."""
        return self.system.solve(self.patch.loads.toarray())

    @cached_property
    def flexibility(self) -> Array:
        """F (n_vertices, n_vertices) of the quarter."""
        matrix = np.asarray(self.patch.loads.T @ self.unit)
        return (matrix + matrix.T) / 2

    def pressed(self, depth: float) -> "Pressed":
        """Return the contact at a depth in mm."""
        free = self.patch.gap - depth * self.patch.projected + self.patch.loads.T @ self.unloaded
        return Pressed(self, Complementarity(self.flexibility).solve(free))


@dataclass(frozen=True, eq=False)
class Pressed:
    """A solved contact: pressure (n_vertices,) kPa at the vertices of the patch."""

    body: Quarter
    pressure: Array

    @property
    def force(self) -> float:
        """The force on the whole body in mN."""
        return 4 * float(self.body.patch.projected @ self.pressure)

    @property
    def area(self) -> float:
        """The area of the hats in contact, of the whole body, in mm²."""
        return 4 * float(self.body.patch.areas[self.pressure > 0].sum())

    @property
    def unknowns(self) -> Array:
        """Displacements and mean stresses (n,)."""
        return np.asarray(self.body.unloaded + self.body.unit @ self.pressure)

    @property
    def imbalance(self) -> float:
        """Force and the reactions of the outer faces along it, over the force."""
        system = self.body.system
        loads = self.body.patch.loads @ self.pressure
        along = system.fixed % 3 == 2
        along &= system.fixed < self.body.space.n_displacements
        reactions = system.reactions(self.unknowns, loads)[along]
        return float(4 * reactions.sum() / self.force + 1)

    def strain(self, points: Array) -> Array:
        """Return the strain (n_points, 3, 3) at points (n_points, 3) mm."""
        rows = strain_at(self.body.space, points) @ self.unknowns
        return tensor_from_voigt(rows.reshape(-1, 6))

    def recovered_strain(self, points: Array) -> Array:
        """Return the strain (n_points, 3, 3) recovered from the displacements around the points."""
        rows = recovered_strain_at(self.body.space, points, planes=(0, 1)) @ self.unknowns
        return tensor_from_voigt(rows.reshape(-1, 6))

    def pressure_error(self, exact: Exact, within: float) -> float:
        """Return the L2 error of the pressure over that of the exact one.

        Both over the part of the exact contact within `within` of its half axes.
        """
        space, patch = self.body.space, self.body.patch
        values = np.zeros(len(space.points))
        values[patch.vertices] = self.pressure
        shapes = _centers()
        corners = space.points[patch.triangles][:, :, :2]
        x, y = np.einsum("qi,tid->dtq", shapes, corners)
        sides = corners[:, 1:] - corners[:, :1]
        areas = np.abs(np.linalg.det(sides))[:, None]
        scaled = (x / exact.axes[0]) ** 2 + (y / exact.axes[1]) ** 2
        weight = areas * (scaled < within**2)
        truth = np.where(weight > 0, exact.pressure(x, y), 0.0)
        square = np.sum(weight * (values[patch.triangles] @ shapes.T - truth) ** 2)
        return float(np.sqrt(square / np.sum(weight * truth**2)))


def top(space: Space) -> Integers:
    """Return the triangles (n, 3) of the face z = 0."""
    facets = np.asarray(space.scalar.mesh.facets.T, dtype=np.int64)
    return facets[(space.points[facets][:, :, 2] == 0).all(axis=1)]


def outer(space: Space) -> tuple[Flags, Flags]:
    """Flag the nodes (n_nodes,) on the bottom, and of those on the outer side."""
    points = space.node_points
    facets = np.asarray(space.scalar.mesh.facets[:, space.scalar.mesh.boundary_facets()].T)
    corners = space.points[facets]
    flat = [(corners[:, :, axis] == 0).all(axis=1) for axis in range(3)]
    bottom = (corners[:, :, 2] == space.points[:, 2].max()).all(axis=1)
    around = facets[~np.any([*flat, bottom], axis=0)]
    side = np.zeros(len(points), dtype=bool)
    side[space.face_nodes(around.astype(np.int64))] = True
    return points[:, 2] == points[:, 2].max(), side


def half_space(
    space: Space, elastic: Elastic, indenter: Indenter, exact: Exact, *, spread: float
) -> Quarter:
    """Return a quarter whose outer faces move as those of the half-space do.

    `spread` is how much wider than the exact contact the candidate contact is.
    """
    far = np.any(outer(space), axis=0)
    prescribed = np.zeros((space.n_nodes, 3))
    prescribed[far] = half_space_field(
        space.node_points[far], exact, modulus=elastic.modulus, poisson=elastic.poisson
    )
    held = np.repeat(far[:, None], 3, axis=1)
    reach = float(indenter.profile(np.array(spread * exact.axes[0]), np.array(0.0)))
    if not np.isfinite(reach):
        reach = exact.depth
    return Quarter(space, {1: elastic}, held, prescribed, indenter, reach)


def turned(strain: Array, turn: Array) -> Array:
    """Return tensors (n, 3, 3) from the components r, theta, z, rz (4, n) in the direction `turn`.

    `turn` (2,) is the unit vector along x and y that the points lie in.
    """
    outward = np.append(turn, 0.0)
    around, down = np.array([-turn[1], turn[0], 0.0]), np.array([0.0, 0.0, 1.0])
    parts = [np.outer(outward, outward), np.outer(around, around), np.outer(down, down)]
    parts.append(np.outer(outward, down) + np.outer(down, outward))
    return np.einsum("kn,kij->nij", strain, np.array(parts))


def half_space_field(points: Array, exact: Exact, *, modulus: float, poisson: float) -> Array:
    """Return the displacement (n, 3) mm in a half-space at points (n, 3) mm far from the contact.

    Boussinesq's solution integrated over the exact pressure, whose edge and tip the rule resolves.
    """
    nodes, weights = np.polynomial.legendre.leggauss(RINGS)
    slant = np.pi / 4 * (nodes + 1)
    turn = 2 * np.pi * (np.arange(SPOKES) + 0.5) / SPOKES
    a, b = exact.axes
    x = a * np.multiply.outer(np.sin(slant), np.cos(turn)).ravel()
    y = b * np.multiply.outer(np.sin(slant), np.sin(turn)).ravel()
    ring = np.pi / 4 * weights * np.sin(slant) * np.cos(slant) * a * b * 2 * np.pi / SPOKES
    loads = exact.pressure(x, y) * np.repeat(ring, SPOKES)
    field = np.empty_like(points)
    for start in range(0, len(points), 256):
        part = points[start : start + 256]
        dx, dy = part[:, :1] - x, part[:, 1:2] - y
        r = np.hypot(dx, dy)
        outward, inward = point_displacement(
            r, part[:, 2:], force=1.0, modulus=modulus, poisson=poisson
        )
        outward = outward / np.where(r > 0, r, 1.0)
        field[start : start + 256] = np.stack(
            [(outward * dx) @ loads, (outward * dy) @ loads, inward @ loads], axis=1
        )
    return field


def _centers() -> Array:
    """Return barycentric coordinates (n, 3) of the centers of the CUTS² parts of a triangle."""
    i, j = np.meshgrid(np.arange(CUTS), np.arange(CUTS))
    upright, inverted = i + j < CUTS, i + j < CUTS - 1
    first = np.concatenate([i[upright] + 1 / 3, i[inverted] + 2 / 3]) / CUTS
    second = np.concatenate([j[upright] + 1 / 3, j[inverted] + 2 / 3]) / CUTS
    return np.column_stack([1 - first - second, first, second])
