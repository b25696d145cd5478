"""A soft hemisphere on a fixed base under a rigid plate: the finite-strain problem of the peers.

Radius 14 mm, held at its equator, pressed by 1.5 mm. A quarter is meshed, as a body of revolution.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from fefinger.validation.problems.grids import quarter
from fefinger.validation.problems.quarter import outer

from fefinger.fem.contact.deformed_gap import ContactSurface, contact_surface
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.continuum import Continuum, continuum
from fefinger.fem.hyperelastic.load_path import LoadPath, Series, StressHistory, follow
from fefinger.fem.hyperelastic.material import Material
from fefinger.fem.hyperelastic.newton import Equilibrium
from fefinger.fem.hyperelastic.state import State
from fefinger.fem.linalg.system import System, factor
from fefinger.support.arrays import Array, Flags
from fefinger.support.tolerances import EQUILIBRIUM


RADIUS, DEPTH, SPEED = 14.0, 1.5, 60.0
FINE = 0.45  # of the radius: the reach of the finest cells from the pole


@dataclass(frozen=True, eq=False)
class Hemisphere:
    """A quarter of the hemisphere; `size` mm is the edge of its cells at the pole.

    Away from the pole they grow with the distance, by `growth` mm per mm.
    """

    law: Material
    size: float
    growth: float = 0.35
    sectors: int = 8

    @cached_property
    def space(self) -> Space:
        """The quarter, x, y >= 0, with the pole at z = 0 and the base at z = RADIUS."""
        grid = np.linspace(0.0, RADIUS, 5)
        flat = quarter(grid, grid, self._wanted, self.sectors)
        points = flat.points * [1.0, 1.0, -1.0] + [0.0, 0.0, RADIUS]
        largest = np.maximum(np.hypot(points[:, 0], points[:, 1]), points[:, 2])
        length = np.linalg.norm(points, axis=1)
        ball = points * (largest / np.where(length > 0, length, 1.0))[:, None]
        ball[:, 2] = RADIUS - ball[:, 2]
        return Space(ball, flat.cells, flat.tissue)

    def _wanted(self, r: Array, z: Array) -> Array:
        away = np.maximum(np.hypot(r, z) - FINE * RADIUS, 0.0)
        return np.asarray(self.size + self.growth * away)

    @cached_property
    def body(self) -> Continuum:
        """The elements."""
        return continuum(self.space, {1: self.law})

    @cached_property
    def held(self) -> Flags:
        """Displacements (n_nodes, 3) that are zero: of the base, and across planes of symmetry."""
        base, _ = outer(self.space)
        held = np.repeat(base[:, None], 3, axis=1)
        held[:, :2] |= self.space.node_points[:, :2] == 0
        return held

    @cached_property
    def system(self) -> System:
        """The factored body at rest, held at its base, sliding in the planes of symmetry."""
        at_rest = np.zeros(self.space.n_unknowns)
        matrix = self.body.tangent(at_rest, self.body.at_rest, consistent=False)
        return factor(self.space, matrix, np.flatnonzero(self.held.ravel()))

    @cached_property
    def contact(self) -> ContactSurface:
        """The plate against the round surface."""
        mesh = self.space.scalar.mesh
        facets = np.asarray(mesh.facets[:, mesh.boundary_facets()].T, dtype=np.int64)
        arms = self.space.points - [0.0, 0.0, RADIUS]
        length = np.linalg.norm(arms, axis=1)
        on = np.abs(length - RADIUS) < 1e-9 * RADIUS
        upper = self.space.points[:, 2] < 0.7 * RADIUS
        cut = (self.space.points[facets][:, :, :2] == 0).all(axis=1).any(axis=1)
        round_ = facets[(on & upper)[facets].all(axis=1) & ~cut]
        normals = np.where(on[:, None], arms / np.where(on, length, 1.0)[:, None], 0.0)
        plate = Obstacle(np.array([0.0, 0.0, 1.0]), np.zeros(3))
        return contact_surface(
            self.space, round_, normals, plate, 1.6 * DEPTH, spreads=self.body.nearly_incompressible
        )

    @property
    def n_nodes(self) -> int:
        """Displacement nodes of the quarter."""
        return self.space.n_nodes

    def force(self, steps: int = 4) -> float:
        """Return the force on the whole hemisphere at DEPTH in N, elastic."""
        times = np.arange(steps + 1) / steps
        return float(self.pressed(times, DEPTH, None)[0][-1])

    def pressed(
        self,
        times: Array,
        rate: float,
        series: Series | None,
        tolerance: float = EQUILIBRIUM,
    ) -> tuple[Array, Equilibrium]:
        """Return the force in N at the times of a ramp at `rate` mm/s and a hold at DEPTH.

        tolerance: the relative residual of a step.
        """
        solver = Equilibrium(self.body, self.contact, self.system, tolerance)
        history = StressHistory(self.body, {} if series is None else {1: series})
        forces: list[float] = []

        def keep(_: int, state: State) -> None:
            forces.append(4e-3 * float(self.contact.projected @ state.pressure))

        follow(solver, history, LoadPath("depth", times, lambda t: min(rate * t, DEPTH)), keep)
        return np.array(forces), solver
