"""The lumped finger of Pawluk (1997), chapter 2, for a Scene: force and depth, and no mesh.

The formula is in `theory/lumped.py`, its proof in the tests of it.
"""

from fefinger import library
from fefinger.indenter import Ellipsoid, Flat, Sphere
from fefinger.machine import slowness
from fefinger.mechanics import _tradeoff
from fefinger.mechanics._notes import apart, yielding
from fefinger.mechanics._timeline import time_grid, too_long
from fefinger.mechanics._touch import check_reached
from fefinger.records import Progress, Refusal, Response
from fefinger.scene import Scene
from fefinger.stages import Stages
from fefinger.theory import lumped as law


name = "lumped"

ANGLES = (20.0, 40.0)
"""Angles of the plate in degrees at which the thesis measured (section 2.2.1)."""

FORCE = 3.0
"""Largest force in N at which the thesis measured (section 2.1)."""

MEANS = "means"
OF_THE_FINGER = (
    *("width", "thickness", "pad_radius", "surface"),
    *("skin", "subcutaneous", "prony"),
)
"""Fields of a finger that a law measured on a subject cannot follow."""

STEP_SECONDS = 1.2e-5
"""Wall time of one time step in s, rounded up: an exponential of Eq. 2.3 each takes less."""

MOST = 5_000_000
"""Time steps of which the force still fits into memory."""

NUMERICAL = 1e-3
"""Error of the force against Eq. 2.3 solved exactly: of the time steps, tested in
tests/mechanics/test_lumped.py."""

EVIDENCE = "18 % at the peaks of sinusoids against the measured finger (thesis, section 2.4.1)"

OTHER = (
    "The stated error is that of this law identified from a press of finite elements; with the b "
    "and m of Table 2.1, which it runs with, it is another finger, whose force may be less "
    "than half of theirs"
)

NOTES = (
    "A measured force law (Pawluk 1997, Eq. 2.1 to 2.3), not a body: it holds for the flat plate "
    "at 20 to 40 degrees that it was measured with, and gives force and depth alone.",
    "On sinusoids that were not used to fit it, the thesis found a mean squared error of 7 % and "
    "18 % at the peaks. The fit took a ramp of 60 mm/s for instantaneous; on synthetic trials that "
    "makes b 33 to 43 % low (`fefinger fit` shows it).",
    "Tissue between bone and nail is in it; the law has no mass, so trust it below 30 Hz.",
    "Where Eq. 2.3 would pull, the indenter leaves the skin and the force is zero.",
)


def refuse(scene: Scene) -> tuple[Refusal, ...]:
    """Return why it should not answer: it gives force alone, as measured under a plate."""
    unable = [f"ask.{what}: asked, but it gives force and depth alone" for what in _beyond(scene)]
    unable += [*yielding(scene.finger), *apart(scene.finger)]
    unable += [*too_long(scene.motion, fast=False, most=MOST)]
    if not isinstance(scene.indenter, Flat | Sphere | Ellipsoid):
        unable.append(f"indenter.kind = {scene.indenter.kind!r}: the law is that of a plate")
    if unable:
        return tuple(Refusal(name, "ability", reason) for reason in unable)
    return tuple(Refusal(name, "accuracy", reason) for reason in _doubts(scene))


def cost(scene: Scene) -> float:
    """Return the expected wall time in s."""
    steps = len(time_grid(scene.motion, fast=False, most=MOST))
    return steps * STEP_SECONDS * slowness({})


def error(scene: Scene) -> tuple[float, str]:
    """Return the relative error of the force, and its source.

    Under a plate that of Eq. 2.3 identified from one press of the finger; else not a number: it is
    not known how far the law of one plate and tissue holds for another.
    """
    found = _tradeoff.stated(name, scene)
    if found is None:
        return float("nan"), "not known: no press like it was measured"
    return (
        found.error + NUMERICAL,
        f"{found.source}, identified from one press; {EVIDENCE}. {OTHER}",
    )


def coarser(scene: Scene) -> Scene | None:
    """Return None: there is no mesh."""
    return None


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Answer the scene with Eq. 2.3, or under force control with its inverse."""
    stages = Stages(progress)
    with stages.stage("lumped"):
        row, source = _row(scene)
        spring = law.Spring(row.b, row.m)
        time = time_grid(scene.motion, fast=False, most=MOST)
        given = scene.motion.value(time)
        if scene.motion.control == "depth":
            depth, force = given, law.contact_force(spring, row.prony, time, given)
        else:
            depth, force = law.position_under(spring, row.prony, time, given), given
            check_reached(scene, float(depth.max()))
    return Response(
        mechanics=name,
        time=time,
        depth=depth,
        force=force,
        contact_area=None,
        centroid=None,
        pad=None,
        pressure=None,
        sites=None,
        strain=None,
        reference=None,
        fields=None,
        status=f"Eq. 2.3, exact for straight lines between {len(time)} times.",
        seconds=stages.seconds,
        notes=(*NOTES, f"b, m and G of {source}; tissue and G of the scene are not used. {OTHER}."),
        numbers={"times": float(len(time)), "b": row.b, "m": row.m},
        sources={"lumped": source},
    )


def _beyond(scene: Scene) -> list[str]:
    """Return the names of what is asked beyond force."""
    ask = scene.ask
    return [name for name in ("pressure", "strain", "fields", "spikes") if getattr(ask, name)]


def _doubts(scene: Scene) -> list[str]:
    """Return in which way the scene differs from what was measured, with the numbers."""
    found = []
    indenter, finger = scene.indenter, scene.finger
    if not isinstance(indenter, Flat):
        found.append(f"indenter = {indenter.kind}: it was measured with a flat plate")
    elif not ANGLES[0] <= indenter.angle <= ANGLES[1] or indenter.tilt:
        found.append(
            f"indenter.angle, tilt = {indenter.angle:g}, {indenter.tilt:g} degrees: it was "
            f"measured at {ANGLES[0]:g} to {ANGLES[1]:g}, 0"
        )
    rows = library.pawluk_bulk()
    if finger.subject_name not in rows:
        found.append(
            f"finger.subject = {finger.subject_name}: Table 2.1 has "
            f"{', '.join(subject for subject in rows if subject != MEANS)}; the means are taken"
        )
    return found + _own_values(scene) + _too_hard(scene)


def _own_values(scene: Scene) -> list[str]:
    """Return which values of the finger are the scene's own, not those of its subject."""
    finger = scene.finger
    if finger.subject_name not in library.pawluk_bulk():
        return []
    measured = type(finger).subject(finger.subject_name)
    return [
        f"finger.{field}: changed, but the law is that of subject {finger.subject_name}"
        for field in OF_THE_FINGER
        if getattr(finger, field) != getattr(measured, field)
    ]


def _too_hard(scene: Scene) -> list[str]:
    """Return whether the force goes beyond what was measured; under depth control, once relaxed."""
    peak, where = scene.motion.peak, "force"
    if scene.motion.control == "depth":
        row, _ = _row(scene)
        where = f"relaxed force at {peak:.3g} mm"
        peak = row.prony.long_time * float(law.Spring(row.b, row.m).force(peak))
    if peak <= FORCE:
        return []
    return [f"{where} = {peak:.2g} > {FORCE:g} N, the largest that was measured"]


def _row(scene: Scene) -> tuple[library.Lumped, str]:
    """Return the row of Table 2.1, and its name."""
    rows = library.pawluk_bulk()
    subject = scene.finger.subject_name
    chosen = subject if subject in rows else MEANS
    return rows[chosen], f"Table 2.1, {chosen} ({library.PAWLUK})"
