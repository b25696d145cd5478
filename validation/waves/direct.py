"""Direct integration of a finger with inertia: no modes, every unknown of the mesh at each step.

A second method for `modal` at small strain, on the same mesh and candidates. Time is stepped by the
backward differences of second order, which damp what a step does not resolve, with contact by
complementarity at the end of each step; the Prony terms are exact for a displacement that is linear
in it. It shares the stiffness and mass matrices with `modal`, and the solver of the contact.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Noted
from fefinger.validation.waves import loops
from scipy import sparse
from scipy.sparse.linalg import splu

from fefinger.contact.complementarity import Complementarity
from fefinger.fem.body import prescribed
from fefinger.fem.elements.assembly import mass, stiffness
from fefinger.fem.elements.probe import recovered_strain_at
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.press.modal_body import PER_CUBIC_METER
from fefinger.mechanics.press.problem import fixed_facets, tissues
from fefinger.mesh.store import load_or_build
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.support.arrays import Array, Integers
from fefinger.support.units import NEWTON_PER_MILLINEWTON


VISCOUS = "maeno1998_viscous"
DEEPEST = 0.8  # mm

SUBSTEP = 5e-5
"""s of a step of both methods."""

STABLE = 0.01
"""Diagonal entries over the largest of their column that need no pivoting."""


Path = Callable[[Array], Array]
"""Depths in mm at times in s."""


@cache
def finger() -> Finger:
    """Return the coarse finger whose vibrations are damped."""
    return Finger.subject(loops.SUBJECT, tissue=VISCOUS, resolution="coarse")


@cache
def loop() -> Loop:
    """Return it as `modal` under the standard plate."""
    return Loop(finger(), Flat(30), mechanics="modal", deepest=DEEPEST, substep=SUBSTEP)


@cache
def _matrices() -> tuple[Integers, sparse.csr_matrix, sparse.csr_matrix]:
    """Return the free unknowns, and the relaxed stiffness and the mass between them."""
    solid, here = loop().prepared.solid, finger()
    fixed = prescribed(solid, load_or_build(here, half=True), fixed_facets(here))
    space = solid.space
    free = np.setdiff1d(np.arange(space.n_unknowns), fixed)
    densities = {1: here.skin.density, 2: here.subcutaneous.density}
    heavy = mass(space, {k: value * PER_CUBIC_METER for k, value in densities.items()})
    rest = space.n_unknowns - heavy.shape[0]  # pressures have no mass
    heavy = sparse.block_diag([heavy, sparse.csr_matrix((rest, rest))]).tocsr()
    matrix = stiffness(space, tissues(here))
    return free, matrix[free][:, free], heavy[free][:, free]


def _step(x: Array) -> Array:
    """Return a smooth step from 0 to 1, without a jump of the acceleration."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x**3 * (10 - 15 * x + 6 * x**2))


def tap(time: Array) -> Array:
    """Press to .6 mm and leave, in 10 ms; then the skin is free."""
    return np.where(time < 0.01, 0.6 * np.sin(np.pi * time / 0.01) ** 2, 0.0)


def vibration(frequency: float, amplitude: float, time: Array) -> Array:
    """Press to .5 mm in 20 ms, and vibrate about that; amplitude mm."""
    swing = np.sin(2 * np.pi * frequency * (time - 0.02))
    return 0.5 * _step(time / 0.02) + amplitude * _step((time - 0.02) * frequency) * swing


PATHS: dict[str, tuple[Path, int]] = {
    "tap of 10 ms": (tap, 600),
    "vibration at 100 Hz": (partial(vibration, 100.0, 0.05), 1000),
    "vibration at 250 Hz": (partial(vibration, 250.0, 0.02), 800),
}
"""Motions by name, and their numbers of steps."""


@dataclass(frozen=True)
class Answer:
    """Forces (n_t,) in N and the strain (n_t, n_rows) at the end organs."""

    force: Array
    strain: Array


def by_modes(path: Path, count: int) -> Answer:
    """Step `modal` through a path."""
    stepped = loop()
    stepped.reset()
    forces, strains = [], []
    for depth in path(SUBSTEP * np.arange(1.0, count + 1)).tolist():
        now = stepped.step(SUBSTEP, depth=depth)
        forces.append(now.force)
        strains.append(now.strain.flatten())
    return Answer(np.array(forces), np.array(strains))


def directly(path: Path, count: int, parts: int = 1) -> Answer:
    """Integrate through the same times, each step divided into some parts."""
    prepared, dt = loop().prepared, SUBSTEP / parts
    body = prepared.body
    assert body is not None
    patch, solid = body.static.patch, prepared.solid
    weights, rates = finger().prony.branches
    decay = np.exp(-rates * dt)
    held = weights * (1 - decay) / (rates * dt)
    unit = solid.sides * NEWTON_PER_MILLINEWTON
    free, matrix, heavy = _matrices()
    effective = (1 + held.sum()) * matrix + 9 / (4 * dt**2) * heavy
    solver = splu(
        effective.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        options={"SymmetricMode": True},
        diag_pivot_thresh=STABLE,
    )
    loads = patch.loads.tocsr()[free].tocsc()
    under = solver.solve(loads.toarray())
    contact = Complementarity(loads.T @ under)
    points = solid.folded(loop().sites.points)
    probe = recovered_strain_at(solid.space, points, solid.planes)[:, free]
    moved, before = np.zeros(len(free)), np.zeros(len(free))
    speed, speed_before = np.zeros(len(free)), np.zeros(len(free))
    past = np.zeros((len(rates), len(free)))
    forces, strains = [], []
    for number, depth in enumerate(path(dt * np.arange(1.0, parts * count + 1)).tolist(), 1):
        # M and the Prony terms of what is known, over the differences (3 u - 4 u0 + u1) / 2 dt.
        known = 3 * (4 * moved - before) / (2 * dt) + 4 * speed - speed_before
        history = matrix @ (held.sum() * moved - decay @ past)
        unloaded = solver.solve(heavy @ known / (2 * dt) + history)
        gap = patch.gap - depth * patch.projected + loads.T @ unloaded
        pressure = contact.solve(gap)
        now = unloaded + under @ pressure
        past = decay[:, None] * past + np.outer(held, now - moved)
        speed, speed_before = (3 * now - 4 * moved + before) / (2 * dt), speed
        moved, before = now, moved
        if number % parts == 0:
            forces.append(unit * float(patch.projected @ pressure))
            strains.append(probe @ moved)
    return Answer(np.array(forces), np.array(strains))


@cache
def compared(name: str) -> tuple[Answer, Answer]:
    """Return the answers of `modal` and of direct integration to a motion."""
    path, count = PATHS[name]
    return by_modes(path, count), directly(path, count)


def force_error(name: str) -> float:
    """Return the largest difference of the forces over their peak."""
    modes, direct = compared(name)
    return float(np.abs(modes.force - direct.force).max() / direct.force.max())


def strain_error(name: str) -> float:
    """Return the largest difference of the strain of a type over the peak there."""
    modes, direct = compared(name)
    shape = len(direct.strain), -1, 6
    one, other = modes.strain.reshape(shape), direct.strain.reshape(shape)
    return float((np.abs(one - other).max(axis=(0, 2)) / np.abs(other).max(axis=(0, 2))).max())


def spikes(name: str) -> Noted:
    """Return the largest difference of the numbers of spikes of a type, with the numbers."""
    counts = []
    for answer in compared(name):
        units = loop().afferents()
        count = np.zeros(len(loop().sites.types), dtype=np.int64)
        for row in answer.strain:
            units.step(row.reshape(-1, 6), SUBSTEP)
            for unit, _ in units.fired():
                count[unit] += 1
        counts.append(count)
    one, other = counts
    kinds = ", ".join(
        f"{kind} {a} and {b}" for kind, a, b in zip(loop().sites.types, one, other, strict=True)
    )
    return Noted(float(np.abs(one - other).max()), f"{kinds} spikes")
