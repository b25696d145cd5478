"""Lumped model of Pawluk (1997), chapter 2: force and depth alone.

The formula is in `theory/lumped/spring.py`, its proof in the tests of it; whose b and m are taken,
in `evidence/lumped_law.py`.
"""

import math

from fefinger.mechanics.evidence.lumped_law import LumpedLaw, law
from fefinger.mechanics.evidence.machine import slowness
from fefinger.mechanics.press.limits import check_reached
from fefinger.mechanics.press.notes import (
    elastic_hard_parts_reasons,
    separate_relaxation_reasons,
    tangential_reasons,
)
from fefinger.mechanics.press.time_steps import time_grid, too_long
from fefinger.mechanics.refusals import Reason, refusals
from fefinger.mechanics.situation import Situation
from fefinger.results.records import Refusal, Response
from fefinger.scene.scene import Scene
from fefinger.support.progress import Progress, Stages
from fefinger.support.text import format_excess
from fefinger.theory.lumped import spring as theory


name = "lumped"

ANGLES = (20.0, 40.0)
"""Angles of the plate in degrees at which Pawluk (1997) measured (section 2.2.1)."""

FORCE = 3.0
"""Largest force in N at which Pawluk (1997) measured (section 2.1)."""

STEP_SECONDS = 1.2e-5
"""Wall time of one time step in s, rounded up: an exponential of Eq. 2.3 each takes less."""

MOST = 5_000_000
"""Time steps of which the force still fits into memory."""

NUMERICAL = 1e-3
"""Error of the force against Eq. 2.3 solved exactly: of the time steps, tested in
tests/mechanics/test_lumped.py."""

SINUSOIDS = "18 % at the peaks of sinusoids against the measured finger (thesis, section 2.4.1)"

NOTES = (
    "A force law (Pawluk 1997, Eq. 2.1 to 2.3), not a body: it holds under a flat plate, and gives "
    "force and depth alone.",
    "Tissue between bone and nail is in it; the law has no mass, so trust it below 30 Hz.",
    "Where Eq. 2.3 would pull, the indenter leaves the skin and the force is zero.",
)

PRINTED = (
    "On sinusoids that were not used to fit it, the thesis found a mean squared error of 7 % and "
    "18 % at the peaks. The fit took a ramp of 60 mm/s for instantaneous; on synthetic trials that "
    "makes b 33 to 43 % low (`fefinger fit` shows it).",
    "It is the law of the finger that was measured; tissue and G of the scene are not used.",
)
"""Notes on the law of Table 2.1."""


def refuse(case: Situation) -> tuple[Refusal, ...]:
    """Return the reasons against it: it gives force alone, as measured under a plate."""
    unable = [
        Reason(
            f"ask.{each}", f"ask.{each}: requested, but this mechanics gives only force and depth"
        )
        for each in ("pressure", "strain", "fields", "spikes")
        if getattr(case.ask, each)
    ]
    unable += tangential_reasons(case.motion, case.indenter)
    unable += [*elastic_hard_parts_reasons(case.finger), *separate_relaxation_reasons(case.finger)]
    unable += [Reason("motion", each) for each in too_long(case.motion, fast=False, most=MOST)]
    if case.indenter.hertzian is None:
        reason = f"indenter.kind = {case.indenter.kind!r}: the law is that of a plate"
        unable.append(Reason("indenter", reason))
    if unable:
        return refusals(name, "ability", unable)
    return refusals(name, "accuracy", _reasons(case))


def cost(case: Situation) -> float:
    """Return the expected CPU time in s."""
    return len(case.times) * STEP_SECONDS * slowness({})


def once(case: Situation) -> float:
    """Return 0: nothing is built and cached."""
    return 0.0


def error(case: Situation, quantity: str = "force") -> tuple[float, str]:
    """Return the relative error of the force against `solid` of the same finger, and its source.

    Not a number where the law of the scene's finger was not compared under such an object.
    """
    identified_law = law(case)
    if quantity != "force" or math.isnan(identified_law.error):
        return float("nan"), "not known: no comparable press was measured"
    source = identified_law.evidence
    if identified_law.printed:
        source = f"{source}; {SINUSOIDS}"
    return identified_law.error + NUMERICAL, source


def coarser(scene: Scene) -> None:
    """Return None: there is no mesh."""
    return None


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Solve the scene with Eq. 2.3, or under force control with its inverse."""
    stages = Stages(progress)
    with stages.stage("lumped"):
        identified, motion = law(Situation.of(scene)), scene.motion
        spring, prony = identified.spring, identified.prony
        time = time_grid(motion, fast=False, most=MOST)
        if motion.control == "depth":
            depth = motion.value(time)
            force = theory.contact_force(spring, prony, time, depth)
        else:
            force = motion.value(time)
            depth = theory.position_under(spring, prony, time, force)
            check_reached(motion, scene.finger.pulp, float(depth.max()))
    return Response(
        mechanics=name,
        time=time,
        depth=depth,
        force=force,
        status=f"Eq. 2.3, exact for straight lines between {len(time)} times.",
        seconds=stages.seconds,
        notes=(*NOTES, *(PRINTED if identified.printed else ()), f"b and m: {identified.source}."),
        numbers={"times": float(len(time)), "b": spring.b, "m": spring.m},
        sources={"lumped": identified.source},
    )


def _reasons(case: Situation) -> list[Reason]:
    """Differences of the scene from the measured conditions, with the numbers."""
    flat, identified_law = case.indenter.flat, law(case)
    too_hard = _too_hard(case, identified_law) if identified_law.printed else []
    if not math.isnan(identified_law.error):
        return too_hard
    reasons = [Reason("finger", identified_law.caveat)] if identified_law.caveat else []
    if flat is None:
        reason = f"indenter = {case.indenter.kind}: it was measured with a flat plate"
        reasons.append(Reason("indenter", reason))
    elif identified_law.printed and not (ANGLES[0] <= flat.angle <= ANGLES[1] and not flat.tilt):
        reason = (
            f"indenter.angle, tilt = {flat.angle:g}, {flat.tilt:g} degrees: it was "
            f"measured at {ANGLES[0]:g} to {ANGLES[1]:g}, 0"
        )
        reasons.append(Reason("indenter", reason))
    return reasons + too_hard


def _too_hard(case: Situation, identified_law: LumpedLaw) -> list[Reason]:
    """Return the reason against it if the (relaxed) force exceeds the largest measured one."""
    peak, where = case.peak, "force"
    if case.motion.control == "depth":
        where = f"relaxed force at {peak:.3g} mm"
        peak = identified_law.prony.long_time * float(identified_law.spring.force(peak))
    if peak <= FORCE:
        return []
    reason = f"{where} = {format_excess(peak, FORCE)} N, the largest that was measured"
    return [Reason("motion", reason)]
