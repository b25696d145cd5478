"""Stated errors of the rows of a study: of mesh, time steps and model, not of the tissue."""

from dataclasses import replace

import numpy as np

from fefinger.records import Result, Rung
from fefinger.scene import ForceRamp, Ramp
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
"""mm/s, or N/s, of the press that is asked about: stated errors do not depend on it."""


def stated(result: Result, where: float) -> dict[str, float]:
    """Return the relative errors of a row, each of the value in it, by column.

    They are those of the plan from the largest force on, and before that those that the same
    mechanics states of a press that ends at the depth of the row. That of the force is one of its
    peak, so the farther the force has fallen the larger it is; of the rest none is known once the
    indenter has withdrawn. What is not known is left out. Where the force is prescribed it has no
    error, but the depth has one.
    """
    force, depth = until(result.response.force, where), until(result.depth, where)
    rung = result.plan.chosen
    if force.max() < result.response.force.max() * (1 - SAME):
        rung = _shallower(result, float(depth.max()), float(force.max()))
    found = dict(rung.errors) if depth[-1] >= depth.max() * (1 - SAME) else {}
    if force[-1] > 0 and result.scene.motion.control == "depth":
        found["force"] = rung.error * float(force.max() / force[-1])
    known = {name: found[name] for name in OF if np.isfinite(found.get(name, np.nan))}
    return {ERRORS[OF[name]]: error for name, error in known.items()}


def _shallower(result: Result, depth: float, force: float) -> Rung:
    """Return what is stated of the same finger and object, pressed to a depth in mm or force in N.

    As the motion of the scene has it.
    """
    from fefinger.plan import choose, settled

    if depth <= 0 or force <= 0:
        return result.plan.chosen
    scene = settled(result.scene, result.plan)
    by_force = scene.motion.control == "force"
    motion = ForceRamp(SPEED, force, corner=0) if by_force else Ramp(SPEED, depth, corner=0)
    return choose(replace(scene, motion=motion), result.plan.mechanics).chosen
