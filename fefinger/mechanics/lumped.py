"""Lumped model of Pawluk (1997), chapter 2: force and depth alone.

The formula is in `theory/lumped/spring.py`, its proof in the tests of it. Its b and m are fitted to
a whole finger under a plate. For fingers of published tissue they were identified from presses of
`solid` (`reports/lumped-force.json`). A finger that was calibrated on a subject of the thesis has
b and m of Table 2.1, to which it was fitted.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from fefinger.mechanics import hertz
from fefinger.mechanics.evidence import costs, presses
from fefinger.mechanics.evidence.presses import read
from fefinger.mechanics.evidence.stated_errors import stated
from fefinger.mechanics.press import notes
from fefinger.mechanics.press.mesh_limits import check_reached
from fefinger.mechanics.press.notes import Reason, refusals
from fefinger.mechanics.press.time_steps import MOST_OF_FORCE, time_grid, too_long
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate, Traits
from fefinger.results.records import Refusal, Response
from fefinger.scene import library
from fefinger.scene.ask import OUTPUTS
from fefinger.scene.finger import Finger
from fefinger.scene.scene import Scene
from fefinger.support.progress import Progress, Stages
from fefinger.support.text import format_excess
from fefinger.theory.lumped import spring as theory
from fefinger.theory.lumped.spring import Spring
from fefinger.theory.relaxation import Prony


name = "lumped"
traits = Traits(meshed=False, finite=False, local=False)

REPORT = "lumped-force.json"
"""Laws that were identified from presses of `solid`."""

ANGLES = (20.0, 40.0)
"""Angles of the plate in degrees at which Pawluk (1997) measured (section 2.2.1)."""

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

SAME = 1e-3
"""Relative difference below which sizes and ratios of moduli count as equal."""


class LumpedLaw(NamedTuple):
    """The law of a finger: b in N/mm, m in 1/mm, G, and their source.

    printed: whether they are from Table 2.1. error: relative error of the force against `solid`
    of the same finger, not a number if unknown; evidence: its source. caveat: reason why the law
    may not fit the scene; empty without one.
    """

    spring: Spring
    prony: Prony
    source: str
    printed: bool
    error: float
    evidence: str
    caveat: str = ""


def law(case: Situation) -> LumpedLaw:
    """Return the law of the finger of a scene, or the law of Table 2.1 with a caveat."""
    finger = case.finger
    if presses.calibrated_subject(finger) is not None:
        error, evidence = stated(Candidate(name), case)
        evidence = f"{evidence}: Table 2.1 against the finger that was fitted to it"
        return _printed(case, error, evidence)
    rows = [row for row in read(REPORT)["rows"] if _same(finger, row)]
    if not rows:
        other = "of other size or tissue" if finger.surface is None else "from a surface"
        return _printed(case, caveat=f"finger: {other} than those whose law was identified")
    flat = case.indenter.flat
    if flat is not None and not flat.tilt:
        interpolated = between(rows, flat.angle)
        if interpolated is not None:
            return _own(case, rows, *interpolated)
    angles = ", ".join(f"{angle:g}" for angle in sorted({row["angle"] for row in rows}))
    return _printed(case, caveat=f"its law is known under plates at {angles} degrees")


def _printed(
    case: Situation, error: float = float("nan"), evidence: str = "not known", caveat: str = ""
) -> LumpedLaw:
    rows, subject = library.lumped(), case.finger.subject_name
    name = subject if subject in rows else library.MEANS
    row, source = rows[name], f"Table 2.1, {name} ({library.SOURCE})"
    if caveat:
        caveat = f"{caveat}; that of Table 2.1, {name}, is taken"
    return LumpedLaw(Spring(row.b, row.m), row.prony, source, True, error, evidence, caveat)


def _own(case: Situation, rows: Sequence[Mapping[str, Any]], b: float, m: float) -> LumpedLaw:
    """Return the identified law of a finger, scaled to the moduli of the scene."""
    finger = case.finger
    stiffer = finger.subcutaneous.modulus / rows[0]["subcutaneous_kPa"]
    # The presses are of relaxed tissue, b of the law is that of an instant.
    spring = Spring(stiffer * b / finger.prony.long_time, m)
    source = f"reports/{REPORT}: identified from {' and '.join(row['source'] for row in rows)}"
    error, evidence = stated(Candidate(name), case)
    evidence = f"{evidence}, identified from presses of the same finger (reports/{REPORT})"
    return LumpedLaw(spring, finger.prony, source, False, error, evidence)


def between(rows: Iterable[Mapping[str, Any]], angle: float) -> tuple[float, float] | None:
    """Interpolate b and m, log-linear in the angle of the plate in degrees.

    None outside of the measured angles.
    """
    by_angle = sorted(rows, key=lambda row: float(row["angle"]))
    angles = [row["angle"] for row in by_angle]
    if not angles[0] <= angle <= angles[-1]:
        return None
    b, m = (float(np.exp(np.interp(angle, angles, np.log([r[k] for r in by_angle])))) for k in "bm")
    return b, m


def _same(finger: Finger, row: Mapping[str, Any]) -> bool:
    """Whether a finger is one that was pressed, but for a factor on its moduli and for G."""
    contrast = finger.skin.modulus / finger.subcutaneous.modulus
    skin = finger.skin.thickness or 0.0
    sizes = [finger.width, finger.thickness, finger.pad_radius, contrast, skin]
    names = ("width_mm", "thickness_mm", "pad_radius_mm", "skin_over_subcutaneous", "skin_mm")
    same = np.allclose(sizes, [row[name] for name in names], rtol=SAME)
    return same and presses.published_tissue(finger)


def refuse(case: Situation) -> tuple[Refusal, ...]:
    """Return the reasons against it: it gives force alone, as measured under a plate."""
    unable = [
        Reason(
            f"ask.{each}", f"ask.{each}: requested, but this mechanics gives only force and depth"
        )
        for each in (*OUTPUTS, "spikes")
        if getattr(case.ask, each)
    ]
    unable += notes.tangential_reasons(case.motion, case.indenter)
    unable += notes.soft_reasons(case.indenter)
    unable += notes.own_relaxation_reasons(case.finger)
    unable += [
        Reason("motion", each) for each in too_long(case.motion, fast=False, most=MOST_OF_FORCE)
    ]
    if case.indenter.hertzian is None:
        reason = f"indenter.kind = {case.indenter.kind!r}: the law is that of a plate"
        unable.append(Reason("indenter", reason))
    if unable:
        return refusals(name, "ability", unable)
    return refusals(name, "accuracy", _reasons(case))


def cost(case: Situation) -> float:
    """Return the expected CPU time in s."""
    return costs.formula_seconds(name, case)


once, coarser = hertz.once, hertz.coarser


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


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Solve the scene with Eq. 2.3, or under force control with its inverse."""
    stages = Stages(progress)
    with stages.stage("lumped"):
        identified, motion = law(Situation.of(scene)), scene.motion
        spring, prony = identified.spring, identified.prony
        time = time_grid(motion, fast=False, most=MOST_OF_FORCE)
        depth = force = motion.value(time)
        if motion.by_force:
            depth = theory.position_under(spring, prony, time, force)
            check_reached(motion, scene.finger.pulp, float(depth.max()))
        else:
            force = theory.contact_force(spring, prony, time, depth)
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
    too_hard = [*_too_hard(case, identified_law)] if identified_law.printed else []
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


def _too_hard(case: Situation, identified_law: LumpedLaw) -> Iterator[Reason]:
    peak, where = case.motion.peak, "force"
    if not case.motion.by_force:
        where = f"relaxed force at {peak:.3g} mm"
        peak = identified_law.prony.long_time * float(identified_law.spring.force(peak))
    force = 3.0  # largest force in N at which Pawluk (1997) measured (section 2.1)
    if peak > force:
        reason = f"{where} = {format_excess(peak, force)} N, the largest that was measured"
        yield Reason("motion", reason)
