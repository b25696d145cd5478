"""Stated errors of the rows of a study: of mesh, time steps and model, not of the tissue."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from fefinger.mechanics.evidence.force_control import errors as at_force
from fefinger.mechanics.situation import Situation
from fefinger.plan import choose, settled
from fefinger.result import Result
from fefinger.results.records import Rung
from fefinger.scene.motion import Ramp
from fefinger.studies.columns import ERRORS
from fefinger.studies.times import SAME, until


OF = {
    "depth": "depth_mm",
    "force": "force_N",
    "pressure": "highest_pressure_1mm2_kPa",
    "area": "contact_area_mm2",
    "strain": "strain_rms_percent",
}
"""Columns of what the plan states errors of."""

SPEED = 10.0
"""Speed in mm/s of the press that is asked about: stated errors do not depend on it."""


def stated(result: Result, where: float, given: str) -> dict[str, float]:
    """Return the relative errors of a row, each of the value in it, by column.

    A row is told at a depth or at a force, whichever is `given` ("depth" or "force"): that has no
    error, but the other has one, and the rest are told there. The errors are those of the plan from
    the largest force on, where the motion prescribes what is given; else those that the same
    mechanics states of a press that ends at the depth of the row. That of the force is one of its
    peak, so the farther the force has fallen the larger it is; of the rest none is known once the
    indenter has withdrawn. What is not known is left out.
    """
    force, depth = until(result.response.force, where), until(result.depth, where)
    rung, errors = result.plan.chosen, result.plan.chosen.errors
    fallen = force.max() < result.response.force.max() * (1 - SAME)
    if (fallen or given != result.scene.motion.control) and min(depth.max(), force.max()) > 0:
        rung, errors = _pressed(result, float(depth.max()), given)
    found = dict(errors) if depth[-1] >= depth.max() * (1 - SAME) else {}
    if force[-1] > 0 and given == "depth":
        found["force"] = rung.error * float(force.max() / force[-1])
    known = {name: found[name] for name in OF if np.isfinite(found.get(name, np.nan))}
    return {ERRORS[OF[name]]: error for name, error in known.items()}


def _pressed(result: Result, depth: float, given: str) -> tuple[Rung, Mapping[str, float]]:
    """Return what is stated of the same finger and object pressed to a depth in mm.

    The errors are those there, or where the force is given those at that force.
    """
    scene = settled(result.scene, result.plan)
    scene = replace(scene, motion=Ramp(SPEED, depth, corner=0))
    rung = choose(scene, result.plan.mechanics).chosen
    if given == "depth" or not np.isfinite(rung.error):
        return rung, rung.errors
    return rung, at_force(rung.errors, rung.error, Situation.of(scene))
