"""Cost of `solid`: CPU seconds of presses in `reports/solid-cost.json`, by mesh and depth."""

from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from fefinger.mechanics.evidence import small_strain_cost
from fefinger.mechanics.evidence.machine import slowness
from fefinger.mechanics.evidence.measured_tissue import PUBLISHED_LAW
from fefinger.mechanics.evidence.table import SMALL_STRAIN_COST, SOLID_COST, Measured, read, table
from fefinger.mechanics.press.load_steps import load_steps, tissue_relaxations
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene.indenters import INDENTERS
from fefinger.scene.motion import Motion
from fefinger.theory.relaxation import Prony


MESHES = ("coarse", "standard")
"""The measured meshes; the cost on the fine one is extrapolated in the number of unknowns."""

SIZE, LARGER = 140.0, 0.6
"""Width times thickness in mm² of the finger of most presses, and the exponent of cost over it:
unknowns on the coarse mesh grow as its root (12 560, 13 267 and 15 547 at 140, 161 and 221 mm²),
cost a little faster."""


class Cost(NamedTuple):
    """CPU seconds on half a finger: of setting up, of the press that scales spikes, of a step.

    `step` is that at first touch; its logarithm grows by `growth` times the relative depth, by
    `sharp` under an edge or ridge and by `stiffening` on tissue of another law; `deepest` is the
    largest relative depth that was timed.
    """

    setup: float
    reference: float
    step: float
    growth: float
    sharp: float
    stiffening: float
    deepest: float


@cache
def cost(mesh: str) -> Cost:
    """Return the cost on a mesh: medians of the presses, for steps a least-squares fit."""
    every = table().entries
    timed = [x for x in every if (x.report, x.quantity) == (SOLID_COST, "step seconds")]
    basis = [
        [
            *(each.candidate.resolution == name for name in MESHES),
            _part(each),
            INDENTERS[each.conditions["kind"]].sharp,
            each.conditions["law"] != PUBLISHED_LAW,
        ]
        for each in timed
    ]
    steps = np.log([each.value for each in timed])
    solution = np.linalg.lstsq(np.array(basis, dtype=float), steps, rcond=None)[0]
    growth, sharp, stiffening = solution[len(MESHES) :].tolist()
    rows = [
        [table().all(SOLID_COST, f"{stage} seconds", Candidate("solid", name)) for name in MESHES]
        for stage in ("setup", "reference")
    ]
    medians = [[np.median([each.value for each in there]) for there in row] for row in rows]
    costs = np.array([*medians, np.exp(solution[: len(MESHES)])])
    meshes = [Candidate("linear", name) for name in (*MESHES, mesh)]
    sizes = np.log([table().value(SMALL_STRAIN_COST, "unknowns", each) for each in meshes])
    power = np.diff(np.log(costs))[:, 0] / (sizes[1] - sizes[0])
    setup, reference, step = (costs[:, 1] * np.exp(power * (sizes[2] - sizes[1]))).tolist()
    deepest = max(map(_part, timed))
    return Cost(setup, reference, step, growth, sharp, stiffening, deepest)


def _part(timed: Measured) -> float:
    """Return the relative depth of a timed press."""
    return float(timed.conditions["depth_mm"] / timed.conditions["thickness_mm"])


@lru_cache(maxsize=8)
def _steps(motion: Motion, relaxing: frozenset[Prony], friction: float, *, fast: bool) -> int:
    """Count the load steps of a motion."""
    time = time_grid(motion, fast=fast)
    return len(load_steps(motion, time, relaxing, friction=friction).chosen)


def seconds(case: Situation) -> float:
    """Return the expected CPU time in s."""
    spent, finger = cost(case.mesh), case.finger
    relaxing, friction = tissue_relaxations(finger), case.indenter.kinetic
    steps = _steps(case.motion, relaxing, friction, fast=case.resolves_faii)
    deep = min(case.depth_over_thickness, spent.deepest)
    harder = spent.growth * deep + spent.sharp * case.indenter.sharp
    layers = (finger.skin, finger.subcutaneous)
    harder += spent.stiffening * any(layer.law != PUBLISHED_LAW for layer in layers)
    whole = spent.setup + steps * spent.step * np.exp(harder)
    whole += spent.reference if case.ask.spikes else 0.0
    whole *= 1.0 if case.half else small_strain_cost.WHOLE
    whole *= (finger.width * finger.thickness / SIZE) ** LARGER
    return float(whole * slowness(read(SOLID_COST))) + small_strain_cost.mesh_seconds(case)
