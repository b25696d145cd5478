"""What `pressed` errs by beside the mesh, and what it costs: measured against `solid`.

Of the scenes of the rules the largest error is taken, with a margin: they hardly depend on the
depth, from a twentieth to a fifth of the thickness, nor on the object and the tissue. Tissue of
which less relaxes than of all of these errs less, and not at all without relaxation.
"""

from functools import cache

import numpy as np

from fefinger.mechanics.evidence import reports
from fefinger.mechanics.evidence.machine import slowness
from fefinger.mechanics.evidence.table import CARRYING, read, table
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene.motion import Motion
from fefinger.support.text import percent


REPORT = CARRYING

PRESSED = Candidate("pressed")

MARGIN = 1.2
"""Factor on the largest error in the scenes of the rules, for what lies between them; chosen when
0.92 of 31 held-out scenes had a force within that error itself."""

RELAXING = 0.67
"""Least 1 - G(infinity) of the scenes of the rules."""

FINE = 2.5
"""Cost on the fine mesh over that on the standard one, as their unknowns; not measured."""


def retreats(motion: Motion) -> bool:
    """Return whether the depth, or the force, ever falls."""
    if motion.wave_frequency is not None:  # samples could miss the falls of a fast sine
        return True
    time = np.unique(np.concatenate([np.linspace(0.0, motion.duration, 2001), motion.breaks]))
    values = np.asarray(motion.value(np.clip(time, 0.0, motion.duration)))
    return bool((np.diff(values) < -1e-9 * np.abs(values).max()).any())


def error(case: Situation, quantity: str) -> float:
    """Return the error of carrying: of the force the largest through time, else at its peak."""
    largest = _largest(quantity)
    if quantity == "force" and retreats(case.motion):
        largest = max(largest, _largest("force on retreat"))
    return largest * min(1.0, (1.0 - case.finger.prony.long_time) / RELAXING)


def sentence(carried: float, case: Situation) -> str:
    """Return the source of an error of carrying."""
    phase = "with retreat" if retreats(case.motion) else "without retreat"
    return f"reports/{REPORT}: {percent(carried)} of carrying it through time, {phase}"


@cache
def _largest(quantity: str) -> float:
    """Return the largest error of a quantity in the scenes of the rules, with a margin."""
    return MARGIN * max(row.value for row in table().all(REPORT, f"error of {quantity}", PRESSED))


def at_hand(case: Situation) -> bool:
    """Return whether the press of a scene is shipped or cached, to its depth or force."""
    # Imported here: errors are asked of scenes that need no mesh.
    from fefinger.mechanics.press.elastic_store import deepest_at_hand

    depth, force = deepest_at_hand(case.finger, case.indenter, case.motion)
    reached = depth if case.motion.control == "depth" else force
    return reached > 0 and reached >= case.peak * (1 - 1e-9)


def seconds(case: Situation) -> float:
    """Return the expected wall time in s."""
    setup, step = (_seconds(case, stage) for stage in ("setup", "step"))
    return (setup + len(case.times) * step) * slowness(read(REPORT)) + once(case)


def once(case: Situation) -> float:
    """Return the time in s of building mesh and press, which are kept; 0 where at hand."""
    if at_hand(case):
        return 0.0
    deeper = max(case.peak / case.finger.thickness / 0.16, 1.0) ** 0.5
    build = _seconds(case, "build") * deeper
    return build * slowness(read(REPORT)) + reports.mesh_seconds(case)


def _seconds(case: Situation, stage: str) -> float:
    mesh = "standard" if case.mesh == "fine" else case.mesh
    seconds = table().value(REPORT, f"{stage} seconds", Candidate("pressed", mesh))
    bodies = 1.0 if case.half or stage == "step" else reports.WHOLE
    return seconds * bodies * (FINE if case.mesh == "fine" and stage != "step" else 1.0)
