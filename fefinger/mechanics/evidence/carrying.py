"""What `pressed` errs by beside the mesh, and what it costs: measured against `solid`.

Of the scenes that were measured and are about as deep the largest error is taken, with a margin:
shallow contact errs most on retreat, deep contact in its pressure. They hardly depend on the object
and the tissue. Tissue of which less relaxes than of all of these errs less, and not at all without
relaxation.
"""

from collections.abc import Sequence

import numpy as np

from fefinger.mechanics.evidence import reports
from fefinger.mechanics.evidence.machine import slowness
from fefinger.mechanics.evidence.table import CARRYING, PRESS_MESH, Measured, read, table
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene.motion import Motion
from fefinger.support.text import percent


REPORT = CARRYING

PRESSED = Candidate("pressed")

PLATE = "a.h./flat-30"
"""The press that tells how deep a force brings a finger."""

MARGIN = 1.2
"""Factor on the largest error in the scenes that were measured, for what lies between them."""

ABOUT = 1.25
"""Factor of the depth within which scenes have the errors of a scene. With the margin, 0.99 of the
scenes have a force, and 0.95 a pressure, area and strain, within the error that all others give."""

RELAXING = 0.67
"""Least 1 - G(infinity) of the scenes that were measured."""

TIMED = 0.16
"""Depth over the thickness of the press whose cost was measured."""

DEEPER = 2.0
"""Power of the depth that the cost of deeper presses grows with: 79 and 33 s at 0.28 of the
thickness under the plate at 30 degrees and the ball of 5 mm on the standard mesh."""

SHALLOW = 0.5
"""Cost of a press that ends at first touch over that of one as deep as TIMED: 0.4 to 0.6 under 12
balls, bars, gratings and cylinders of the held-out scenes on both meshes."""

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
    rows = _rows(quantity)
    if quantity == "force" and retreats(case.motion):
        rows = [*rows, *_rows("force on retreat")]
    pairs = [(row.conditions["part"], row.value) for row in rows]
    largest = largest_about(_part(case), pairs)
    return MARGIN * largest * min(1.0, (1.0 - case.finger.prony.long_time) / RELAXING)


def sentence(carried: float, case: Situation) -> str:
    """Return the source of an error of carrying, and how deep it was measured if not so deep."""
    phase = "with retreat" if retreats(case.motion) else "without retreat"
    deepest = max(row.conditions["part"] for row in _rows("area"))
    deeper = f", measured to {deepest:.2g} of the thickness" if _part(case) > deepest else ""
    return f"reports/{REPORT}: {percent(carried)} of carrying it through time, {phase}{deeper}"


def _part(case: Situation) -> float:
    """Return the depth over thickness, under force control by presses like it or by PLATE."""
    if case.among_neighbors is not None:
        return case.among_neighbors
    forces = table().presses(PRESS_MESH, "force", Candidate("solid"))
    return case.depth_over_thickness(forces[PLATE])


def largest_about(part: float, errors: Sequence[tuple[float, float]]) -> float:
    """Return the largest error at about a depth over thickness, of pairs of depth and error.

    Of the nearest where none is about as deep.
    """
    parts = np.array([each for each, _ in errors])
    nearest = parts[np.argmin(np.abs(parts - part))]
    here = part if nearest / ABOUT <= part <= nearest * ABOUT else nearest
    return max(value for each, value in errors if here / ABOUT <= each <= here * ABOUT)


def _rows(quantity: str) -> list[Measured]:
    return table().all(REPORT, f"error of {quantity}", PRESSED)


def at_hand(case: Situation) -> bool:
    """Return whether the press of a scene is shipped or cached, to its depth or force."""
    # Imported here: errors are asked of scenes that need no mesh.
    from fefinger.mechanics.press.elastic_store import deepest_at_hand

    depth, force = deepest_at_hand(case.finger, case.indenter, case.motion)
    reached = depth if case.motion.control == "depth" else force
    return reached > 0 and reached >= case.peak * (1 - 1e-9)


def seconds(case: Situation) -> float:
    """Return the expected CPU time in s."""
    setup, step = (_seconds(case, stage) for stage in ("setup", "step"))
    return (setup + len(case.times) * step) * slowness(read(REPORT)) + once(case)


def once(case: Situation) -> float:
    """Return the time in s of building mesh and press, which are kept; 0 where at hand."""
    return 0.0 if at_hand(case) else building(case) + reports.mesh_seconds(case)


def building(case: Situation) -> float:
    """Return the CPU time in s of solving the press of a scene; 0 where it is at hand."""
    if at_hand(case):
        return 0.0
    deep = _part(case) / TIMED
    if deep > 1.0:
        harder = deep**DEEPER
    else:  # plates go on to that depth, so that other motions find their press
        harder = 1.0 if case.indenter.flat is not None else SHALLOW + (1 - SHALLOW) * deep
    return _seconds(case, "build") * harder * slowness(read(REPORT))


def _seconds(case: Situation, stage: str) -> float:
    mesh = "standard" if case.mesh == "fine" else case.mesh
    seconds = table().value(REPORT, f"{stage} seconds", Candidate("pressed", mesh))
    bodies = 1.0 if case.half or stage == "step" else reports.WHOLE
    return seconds * bodies * (FINE if case.mesh == "fine" and stage != "step" else 1.0)
