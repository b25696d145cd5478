"""Expected errors of the rows of a study: of mesh, time steps and model, not of the tissue."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from fefinger.mechanics.evidence.stated_errors import at_force
from fefinger.mechanics.situation import Situation
from fefinger.plan import choose, settled
from fefinger.result import Result
from fefinger.results.records import Rung
from fefinger.scene.motions import Ramp
from fefinger.studies.columns import ERRORS
from fefinger.studies.times import SAME, until


OF = {
    "depth": "depth_mm",
    "force": "force_N",
    "pressure": "highest_pressure_1mm2_kPa",
    "area": "contact_area_mm2",
    "strain": "strain_rms_percent",
}
"""Columns of the quantities for which a plan states errors."""

SPEED = 10.0
"""Speed in mm/s of the press whose errors are looked up.

Only those of closed formulas depend on it, by a few percent of the error.
"""


def stated(result: Result, where: float, given: str) -> dict[str, float]:
    """Look up the expected relative errors of a row's values, by column.

    A row is at a `given` depth or force ("depth" or "force"), which has no error. From the largest
    force on, where the motion prescribes the given quantity, the errors are those of the plan; else
    those of the same mechanics for a press that ends at the depth of the row. The error of the
    force is relative to its peak and so grows as the force falls; the others are unknown once the
    indenter has withdrawn. Unknown errors are left out.
    """
    force, depth = until(result.response.force, where), until(result.depth, where)
    rung, errors = result.plan.chosen, result.plan.chosen.errors
    fallen = force.max() < result.response.force.max() * (1 - SAME)
    if (fallen or given != result.scene.motion.control) and min(depth.max(), force.max()) > 0:
        rung, errors = _pressed(result, float(depth.max()), given)
    by_quantity = dict(errors) if depth[-1] >= depth.max() * (1 - SAME) else {}
    if force[-1] > 0 and given == "depth":
        by_quantity["force"] = rung.error * float(force.max() / force[-1])
    finite = {name: by_quantity[name] for name in OF if np.isfinite(by_quantity.get(name, np.nan))}
    return {ERRORS[OF[name]]: error for name, error in finite.items()}


def _pressed(result: Result, depth: float, given: str) -> tuple[Rung, Mapping[str, float]]:
    """Errors of the same mechanics for the same finger and object pressed to a depth in mm.

    They are at that depth or, where the force is given, at that force.
    """
    scene = settled(result.scene, result.plan)
    scene = replace(scene, motion=Ramp(SPEED, depth, corner=0))
    rung = choose(scene, result.plan.mechanics).chosen
    if given == "depth" or not np.isfinite(rung.error):
        return rung, rung.errors
    return rung, at_force(rung.errors, rung.error, Situation.of(scene))
