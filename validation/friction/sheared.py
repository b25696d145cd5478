"""A sphere on a half-space that is pressed, sheared, and sheared back: numbers and their theory.

Of two bodies: a block of finite elements, and squares of a boundary-element method. At nu = 0.5
pressure and traction do not move each other's contact, as the theory takes for granted; it leaves
out that slip turns a little aside.
"""

from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from fefinger.validation.oracles import squares
from fefinger.validation.oracles.mindlin import Mindlin
from fefinger.validation.problems.half_space import ShearBlock

from fefinger.contact.active_set import DONE
from fefinger.contact.frictional import FrictionalContact
from fefinger.contact.stepper import Target
from fefinger.support.arrays import Array, Flags


Body = Literal["block", "squares"]

RADIUS, CONTACT, MODULUS, POISSON, MU = 10.0, 1.0, 100.0, 0.5, 0.3
SHEAR = MODULUS / (2 * (1 + POISSON))
REACH = 1.25  # contact radii covered by squares
PEAK = 0.6  # displacement of a cycle over that at which all slides
STEPS = 24


@dataclass(frozen=True)
class Contact:
    """A flexibility (3n, 3n) with gaps (n,) mm³, areas (n,) mm² and places (n, 2) mm of its nodes.

    sides: how many times the body makes the whole.
    """

    flexibility: Array
    gap: Array
    areas: Array
    places: Array
    sides: int


@cache
def contact(body: Body, size: int, poisson: float = POISSON) -> Contact:
    """Return a body: of `size` cells along a contact radius, or of so many squares across all."""
    if body == "block":
        block = ShearBlock(RADIUS, CONTACT, MODULUS, poisson, size)
        on = block.patch
        places = block.space.points[on.vertices, :2]
        return Contact(block.flexibility, on.gap, on.projected, places, 2)
    side = 2 * CONTACT * REACH / size
    line = side * (np.arange(size) + 0.5) - CONTACT * REACH
    grid = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2)
    grid = grid[np.hypot(*grid.T) < REACH * CONTACT]
    shear = MODULUS / (2 * (1 + poisson))
    matrix = squares.flexibility(grid, side, shear=shear, poisson=poisson)
    areas = np.full(len(grid), side**2)
    return Contact(matrix, areas * np.sum(grid**2, axis=1) / (2 * RADIUS), areas, grid, 1)


@dataclass(frozen=True)
class Sheared:
    """What a path of displacements (k,) mm along x gives, after a press.

    theory; pressure (k, n) and traction (k, 2, n) kPa, sticking (k, n); tangential (k,) mN and lost
    (k,) µJ of the whole body.
    """

    theory: Mindlin
    path: Array
    pressure: Array
    traction: Array
    sticking: Flags
    tangential: Array
    lost: Array


def sheared(body: Body, size: int, path: Array, mu: float = MU) -> Sheared:
    """Press to the depth of CONTACT and shear along a path (k,) mm."""
    on = contact(body, size)
    elastic = np.zeros(0), np.zeros(0)
    body_contact = FrictionalContact(on.flexibility, (mu, mu), on.gap, on.areas, elastic)
    depth, rows, lost = CONTACT**2 / RADIUS, [], []
    for moved in path.tolist():
        outcome = body_contact.advance(0.0, Target(depth, shift=(moved, 0.0)))
        if outcome != DONE:
            raise ArithmeticError(body_contact.failures[outcome])
        traction = body_contact.traction.copy()
        rows.append((body_contact.pressure.copy(), traction, body_contact.sticking))
        lost.append(float(body_contact.lost[0]))
    pressure, traction, sticking = (np.array(each) for each in zip(*rows, strict=True))
    force = on.sides * float(pressure[0] @ on.areas)
    radius = float(np.cbrt(3 * force * RADIUS * (1 - POISSON) / (8 * SHEAR)))
    return Sheared(
        Mindlin(radius, force, SHEAR, POISSON, mu),
        path,
        pressure,
        traction,
        sticking,
        on.sides * traction[:, 0] @ on.areas,
        on.sides * np.array(lost),
    )


def limit() -> float:
    """Return the displacement in mm at which, by the theory, all slides."""
    force = 4 / 3 * 2 * SHEAR / (1 - POISSON) * CONTACT**3 / RADIUS
    theory = Mindlin(CONTACT, force, SHEAR, POISSON, MU)
    return 1.5 * theory.most / theory.stiffness


@cache
def loaded(body: Body, size: int) -> Sheared:
    """Shear once, past the displacement at which all slides; the first place is the press alone."""
    return sheared(body, size, np.linspace(0, 1.25 * limit(), STEPS + 1))


@cache
def cycled(body: Body, size: int) -> Sheared:
    """Shear forth, back and forth again, between PEAK of the limit on both sides."""
    peak = PEAK * limit()
    there = np.linspace(0, peak, STEPS)
    back = np.linspace(peak, -peak, 2 * STEPS)[1:]
    return sheared(body, size, np.concatenate([there, back, -back]))


def force_error(body: Body, size: int) -> float:
    """Return the largest error of the tangential force, over the largest force."""
    run = loaded(body, size)
    exact = run.theory.force_at(run.path)
    return float(np.abs(run.tangential - exact).max() / run.theory.most)


def stiffness_ratio(body: Body, size: int) -> float:
    """Return the tangential over the normal stiffness of the contact while it sticks."""
    step = 1e-3 * limit()
    run = sheared(body, size, np.array([0.0, step]))
    stuck = (run.tangential[1] - run.tangential[0]) / step
    # The normal stiffness of a circle that does not change is 4 G a / (1 - nu).
    return float(stuck / (4 * SHEAR * run.theory.radius / (1 - POISSON)))


def stick_error(body: Body, size: int) -> float:
    """Return the largest error of the stick radius over a, from its area, at 10 to 90 % of mu P."""
    on, run = contact(body, size), loaded(body, size)
    chosen = (run.tangential > 0.1 * run.theory.most) & (run.tangential < 0.9 * run.theory.most)
    radius = np.sqrt(on.sides * run.sticking[chosen] @ on.areas / np.pi)
    exact = run.theory.stick_radius(run.tangential[chosen])
    return float(np.abs(radius - exact).max() / run.theory.radius)


def traction_error(body: Body, size: int) -> float:
    """Return the L2 error of the traction along x at about half of mu P, over that of mu p."""
    on, run = contact(body, size), loaded(body, size)
    k = int(np.argmin(np.abs(run.tangential - run.theory.most / 2)))
    exact = run.theory.traction(np.hypot(*on.places.T), float(run.tangential[k]))
    error = np.sum(on.areas * (run.traction[k, 0] - exact) ** 2)
    return float(np.sqrt(error / np.sum(on.areas * (MU * run.pressure[k]) ** 2)))


def aside(body: Body, size: int) -> float:
    """Return the largest traction across the shear, over the largest along it."""
    run = loaded(body, size)
    return float(np.abs(run.traction[:, 1]).max() / np.abs(run.traction[:, 0]).max())


def cycle_ratio(body: Body, size: int) -> float:
    """Return the work lost in a closed cycle over the work by Mindlin and Deresiewicz."""
    run = cycled(body, size)
    lost = run.lost[-1] - run.lost[STEPS - 1]
    return float(lost / run.theory.loop(float(run.tangential[STEPS - 1])))


def memory_error(body: Body, size: int) -> float:
    """Return by how much a closed cycle misses its start, over the tangential force there."""
    run = cycled(body, size)
    return float(abs(run.tangential[-1] / run.tangential[STEPS - 1] - 1))


def masing_error(body: Body, size: int) -> float:
    """Return the largest error of the way back against Masing's rule on the way there.

    Both of the same body: Q(peak) - Q(peak - 2 d) = 2 Q(d).
    """
    run = cycled(body, size)
    peak, there = run.path[STEPS - 1], slice(0, STEPS)
    back = slice(STEPS, 3 * STEPS - 1)
    half = np.interp((peak - run.path[back]) / 2, run.path[there], run.tangential[there])
    exact = run.tangential[STEPS - 1] - 2 * half
    return float(np.abs(run.tangential[back] - exact).max() / run.theory.most)


def sliding_error(body: Body, size: int) -> float:
    """Return the largest | |t| - mu p | in gross sliding, over the largest mu p."""
    run = loaded(body, size)
    size_ = np.hypot(run.traction[-1, 0], run.traction[-1, 1])
    assert not run.sticking[-1].any()
    return float(np.abs(size_ - MU * run.pressure[-1]).max() / (MU * run.pressure[-1].max()))


def returned_work(body: Body, size: int) -> float:
    """Return the largest work that friction returns in a step, over all that it takes."""
    run = cycled(body, size)
    return float(max(0.0, -np.diff(run.lost).min() / run.lost[-1]))
