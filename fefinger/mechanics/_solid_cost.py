"""What `solid` costs: CPU seconds of presses in `reports/solid-cost.json`, by mesh and depth."""

from functools import cache
from typing import NamedTuple

import numpy as np

from fefinger.machine import slowness
from fefinger.mechanics import _evidence
from fefinger.mechanics._stride import stride
from fefinger.mechanics._symmetry import symmetric
from fefinger.mechanics._timeline import time_grid
from fefinger.scene import Scene


REPORT = "solid-cost.json"

MESHES = ("coarse", "standard")
"""The measured ones; the fine one costs more as these do with their unknowns."""


class Cost(NamedTuple):
    """CPU seconds on half a finger: of setting up, of the press that scales spikes, of a step.

    That of a step is at first touch; it grows as exp(growth * depth / thickness).
    """

    setup: float
    reference: float
    step: float
    growth: float


@cache
def cost(mesh: str) -> Cost:
    """Return the cost on a mesh: medians of the presses, of the steps by least squares."""
    rows = _evidence.read(REPORT)["rows"]
    on = np.array([MESHES.index(row["mesh"]) for row in rows])
    parts = np.array([row["depth_mm"] / row["thickness_mm"] for row in rows])
    basis = np.column_stack([on == 0, on == 1, parts])
    steps = np.log([row["step_seconds"] for row in rows])
    *first, growth = np.linalg.lstsq(basis, steps, rcond=None)[0].tolist()
    known = [
        [np.median([row[stage] for row in rows if row["mesh"] == name]) for name in MESHES]
        for stage in ("setup_seconds", "reference_seconds")
    ]
    costs = np.array([*known, np.exp(first)])
    sizes = np.log([_evidence.linear()[name]["unknowns"] for name in (*MESHES, mesh)])
    power = np.diff(np.log(costs))[:, 0] / (sizes[1] - sizes[0])
    setup, reference, step = (costs[:, 1] * np.exp(power * (sizes[2] - sizes[1]))).tolist()
    return Cost(setup, reference, step, growth)


def seconds(scene: Scene) -> float:
    """Return the expected wall time in s."""
    spent = cost(scene.finger.mesh)
    time = time_grid(scene.motion, fast="FAII" in scene.ask.spikes)
    steps = len(stride(scene.motion, time).chosen)
    deep = min(_evidence.small_strain_part(scene), _evidence.solid_reach("flat-30"))
    whole = spent.setup + steps * spent.step * np.exp(spent.growth * deep)
    whole += spent.reference if scene.ask.spikes else 0.0
    whole *= 1.0 if symmetric(scene) else _evidence.WHOLE
    return float(whole * slowness(_evidence.read(REPORT))) + _evidence.mesh_seconds(scene)
