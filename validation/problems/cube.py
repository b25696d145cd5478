"""A unit cube under a plate: every quantity of its squeeze has a closed form."""

from dataclasses import dataclass

import numpy as np
from fefinger.validation.problems.grids import box
from scipy.optimize import brentq

from fefinger.fem.contact.deformed_gap import contact_surface
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.continuum import Continuum, continuum
from fefinger.fem.hyperelastic.material import Material, material_of
from fefinger.fem.hyperelastic.newton import Equilibrium
from fefinger.fem.linalg.system import factor
from fefinger.geometry.profiles import Profile
from fefinger.support.arrays import Array


@dataclass(frozen=True)
class Cube:
    """The cube 0 to 1 mm, that slides on the planes x = 0, y = 0, z = 0, under a plate at z = 1."""

    law: Material
    body: Continuum
    equilibrium: Equilibrium


def cube(law: Material, cells: int = 2) -> Cube:
    """Return a cube with `cells` boxes of six tetrahedra along each edge."""
    space = box(*3 * (np.linspace(0.0, 1.0, cells + 1),))
    body = continuum(space, {1: law})
    places = space.node_points
    fixed = np.flatnonzero((places == 0).ravel())
    at_rest = np.zeros(space.n_unknowns)
    system = factor(space, body.tangent(at_rest, body.at_rest, consistent=False), fixed)
    facets = np.asarray(space.scalar.mesh.facets.T)
    top = facets[(space.points[facets][:, :, 2] == 1).all(axis=1)]
    plate = Obstacle(np.array([0.0, 0.0, -1.0]), np.array([0.5, 0.5, 1.0]))
    contact = contact_surface(
        space,
        top,
        np.zeros_like(space.points),
        plate,
        reach=1.0,
        spreads=body.nearly_incompressible,
    )
    return Cube(law, body, Equilibrium(body, contact, system))


def glued_cube(turn: Array, profile: Profile, poisson: float) -> tuple[Continuum, Equilibrium]:
    """Return a cube of 1 mm and 40 kPa, held at its base, under an object with friction.

    turn (3, 3): a rotation of the whole scene; profile: of the object, which travels along -z.
    """
    straight = box(*3 * (np.linspace(0.0, 1.0, 3),))
    space = Space(straight.points @ turn.T, straight.cells, straight.tissue)
    body = continuum(space, {1: material_of(Elastic(40.0, poisson))})
    base = np.flatnonzero(np.abs(straight.node_points[:, 2]) < 1e-9)
    fixed = (3 * base[:, None] + np.arange(3)).ravel()
    rest = np.zeros(space.n_unknowns)
    system = factor(space, body.tangent(rest, body.at_rest, consistent=False), fixed)
    facets = np.asarray(straight.scalar.mesh.facets.T)
    top = facets[(straight.points[facets][:, :, 2] == 1).all(axis=1)]
    axis, origin = turn @ [0.0, 0.0, -1.0], turn @ [0.5, 0.5, 1.0]
    contact = contact_surface(
        space,
        top,
        np.zeros_like(space.points),
        Obstacle(axis, origin, profile),
        reach=1.0,
        spreads=body.nearly_incompressible,
    )
    return body, Equilibrium(body, contact, system, frictional=True)


def energy(law: Material, along: float, across: float) -> float:
    """Return the strain energy in kPa of the stretches along z and across it."""
    volume = along * across**2
    one = (along**2 + 2 * across**2) * volume ** (-2 / 3) - 3
    two = (across**4 + 2 * along**2 * across**2) * volume ** (-4 / 3) - 3
    work = float(law.energy(np.array(one), np.array(two)))
    return work + (volume - 1) ** 2 / (2 * law.compressibility) if law.compressibility else work


def across(law: Material, along: float) -> float:
    """Return the stretch across that leaves the sides free of stress."""
    if law.compressibility == 0:
        return float(along**-0.5)
    step = 1e-5

    def pull(stretch: float) -> float:
        return energy(law, along, stretch + step) - energy(law, along, stretch - step)

    return float(brentq(pull, 0.3, 3.0, xtol=1e-13))


def nominal(law: Material, along: float) -> float:
    """Return the nominal pressure in kPa that holds the stretch `along`."""
    step = 1e-5

    def least(stretch: float) -> float:
        return energy(law, stretch, across(law, stretch))

    return -(least(along + step) - least(along - step)) / (2 * step)


def stretches(values: Array, body: Continuum) -> Array:
    """Return the three stretches of the corner (1, 1, 1)."""
    corner = int(np.argmax(body.space.node_points.sum(axis=1)))
    return np.asarray(1 + values[3 * corner : 3 * corner + 3])
