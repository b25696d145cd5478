"""Contact with flat viscoelastic layers of skin and subcutaneous tissue on rigid bone, exact.

In `theory/contact/`, `stack.py` and `indentation.py` are the equations, `contact_table.py` the
contacts solved once per stack, and `ting.py` extends them to unloading and renewed contact. The
first press of a stack takes a quarter of a second, another one some 30 ms
(`reports/afferent-cost.json`).
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fefinger.mechanics import hertz
from fefinger.mechanics.evidence import costs
from fefinger.mechanics.evidence.stated_errors import error_of
from fefinger.mechanics.press import axisymmetric, notes
from fefinger.mechanics.press.notes import Reason, refusals
from fefinger.mechanics.press.sites import REFERENCE_DEPTH
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Traits
from fefinger.results.records import Refusal, Response
from fefinger.scene.finger import BONE, Finger
from fefinger.scene.scene import Scene
from fefinger.support.checks import InputError
from fefinger.support.progress import Progress
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.theory.contact.stack import Layer, Stack
from fefinger.theory.relaxation import creep_integral


if TYPE_CHECKING:
    from fefinger.theory.contact.contact_table import ContactTable


name = "layered"
traits = Traits(meshed=False, finite=False)

PLATE_LEVELS = 8  # of the table of contacts that the small reference press is read from

THINNEST = 0.02
"""Least share of the tissue over the bone that the layer below the skin has, a convention: a film
thinner than that is no layer of a finger."""

NOTES = (
    "The finger is a flat stack of skin and subcutaneous tissue bonded to rigid bone; the sides, "
    "the tip and the nail are left out, and the bone is flat.",
    notes.SPHERICAL,
    "Small strain, a contact small against the radii, no friction.",
    notes.CONVOLVED,
    notes.QUASISTATIC,
)


def stack(finger: Finger) -> Stack:
    """Return the layers of the finger under the pad, over rigid bone.

    InputError if the skin leaves less than `THINNEST` of the tissue to the layer below it.
    """
    skin, rest = finger.skin, finger.subcutaneous
    thick, bone = float(skin.thickness or 0.0), BONE * finger.thickness
    below = bone - thick
    if below < THINNEST * bone:
        raise InputError(
            f"finger.skin.thickness: expected at most {(1 - THINNEST) * bone:.4g} mm, which leaves "
            f"{THINNEST:g} of the {bone:.4g} mm above the bone to the tissue below, received "
            f"{thick:g} mm; take a thinner skin or a thicker finger"
        )
    return Stack(
        (Layer(thick, skin.modulus, skin.poisson), Layer(below, rest.modulus, rest.poisson))
    )


def contact(scene: Scene) -> "ContactTable":
    """Return the elastic contacts of the relaxed finger that the motion passes through.

    InputError if the contact becomes wider than its relative radius.
    """
    from fefinger.theory.contact.contact_table import TooWideError, tabulate_to

    radius = hertz.half_space(scene.finger, scene.indenter).relative_radius
    motion = scene.motion
    try:
        if motion.hardest is None:
            return tabulate_to(stack(scene.finger), radius, depth=motion.peak)
        force = motion.hardest / NEWTON_PER_MILLINEWTON
        return tabulate_to(stack(scene.finger), radius, force=force)
    except TooWideError as error:
        raise InputError(
            f"motion.{motion.control}: expected one whose contact is narrower than its relative "
            f"radius of {radius:.4g} mm, as small strain is assumed, received {motion.peak:g} "
            f"{motion.unit}; press less, or take a larger indenter"
        ) from error
    except ValueError as error:
        raise InputError(f"motion: {error}; press less") from error


def deepest(case: Situation, enough: float) -> float:
    """Return the largest depth in mm of the contact, or `enough` where it is at least that.

    Under force control the layers bear the largest elastic force there; at first touch only the
    skin counts, against which a half-space of both tissues is far too soft. Objects without
    curvature have the depth of the measured presses.
    """
    from fefinger.theory.contact.contact_table import tabulate_to

    finger, peak = case.finger, case.motion.peak
    if case.motion.deepest is not None:
        return case.motion.deepest
    if case.indenter.hertzian is None:
        return case.depth_over_thickness * finger.thickness
    body = hertz.half_space(finger, case.indenter)
    hardest = max(finger.skin.modulus, finger.subcutaneous.modulus)
    least = replace(body, modulus=hardest)
    # Tissue that has not relaxed bears more; at once it is as if the elastic force were this part.
    elastic = peak / NEWTON_PER_MILLINEWTON * finger.prony.long_time
    if least.depth(elastic) >= enough:
        return enough
    load = np.asarray(case.motion.value(case.times)) / NEWTON_PER_MILLINEWTON
    relaxing = creep_integral(finger.prony, case.times, load) * finger.prony.long_time
    elastic = max(elastic, float(relaxing.max()))
    try:
        table = tabulate_to(stack(finger), body.relative_radius, force=elastic)
    except ValueError:  # no such layers, or wider than the pad is round: far from too small
        return float(least.depth(elastic))
    return float(table.depth(elastic))


def refuse(case: Situation) -> tuple[Refusal, ...]:
    """Return the reasons against it: what it cannot represent, and ranges not measured."""
    unable = [*hertz.lacking(case), *notes.soft_reasons(case.indenter)]
    try:
        bone = stack(case.finger).thickness
    except InputError as error:
        return (Refusal(name, "ability", str(error), "finger.skin.thickness"),)
    deepest = max(dict(case.ask.depths).values(), default=0)
    if deepest >= bone:
        reason = f"ask.depths: {deepest:.3g} mm is not above the bone at {bone:.3g} mm"
        unable.append(Reason("ask.depths", reason))
    return refusals(name, "ability", unable)


def cost(case: Situation) -> float:
    """Return the expected CPU time in s."""
    return costs.formula_seconds(name, case)


once, coarser = hertz.once, hertz.coarser
error = error_of(name)


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Solve the scene with the exact contact of the stack and the field below it.

    InputError also if the contact becomes wider than its relative radius.
    """
    from fefinger.theory.contact.contact_table import tabulate_to

    body = contact(scene)
    # The plate is needed at one depth, at the end of its table, where few contacts are exact.
    plate = tabulate_to(
        stack(scene.finger), scene.finger.pad_radius, depth=REFERENCE_DEPTH, levels=PLATE_LEVELS
    )
    ellipse = (hertz.ELLIPTIC,) if hertz.elliptic(scene.indenter) else ()
    stated = (*NOTES, notes.RIGID_OBJECT, *notes.normalization_notes(scene.finger.prony), *ellipse)
    peak = scene.motion.peak
    if scene.motion.by_force:
        peak = float(body.depth(peak / NEWTON_PER_MILLINEWTON))
    widest = float(body.contact_radius(peak))
    numbers = {
        "relative_radius_mm": body.radius,
        "contact_radius_over_thickness": widest / body.stack.thickness,
    }
    return axisymmetric.respond(
        scene, body, plate, progress, mechanics=name, notes=stated, numbers=numbers
    )
