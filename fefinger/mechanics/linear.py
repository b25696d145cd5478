"""Small-strain finite elements on the whole finger: Taylor-Hood, exact contact, QLV.

The body is solved once under a unit pressure on every candidate vertex of the pad; contact and
relaxation then run on that small dense problem (`press/small_strain.py`). What it leaves out is in
`NOTES`.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

from fefinger.laws import LAWS
from fefinger.mechanics import hertz, layered
from fefinger.mechanics.evidence import costs
from fefinger.mechanics.evidence.presses import largest_exponents
from fefinger.mechanics.evidence.stated_errors import error_of
from fefinger.mechanics.press import notes
from fefinger.mechanics.press.mesh_limits import ALONG, NEAR, gap, refinement_location
from fefinger.mechanics.press.notes import Reason, refusals
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Traits
from fefinger.results.records import Refusal, Response
from fefinger.scene.finger import Finger
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Hard
from fefinger.support.progress import Progress


name = "linear"
traits = Traits(meshed=True, finite=False)

NOTES = (
    "Small strain: the geometry, the surface areas and the tissue stiffness are those of the "
    "undeformed finger; the stiffening of tissue at large strain is left out.",
    "Contact is frictionless unless the indenter has a coefficient of friction; the pressure acts "
    "along the indenter's normal. "
    "Gaps are closed as weighted means over the facets around each vertex, not at every point.",
    "The whole stress of every soft tissue relaxes with one function G(t); Poisson's ratio is "
    "constant.",
    notes.QUASISTATIC,
)

FACETS = {"coarse": 0.8, "standard": 0.42, "fine": 0.3}
"""Length in mm of the facets of the pad where it is touched, by resolution."""

HARD = {"bone": 5e4, "nail": 1e3}
"""Moduli over that of the skin, above which it hardly matters that hard parts relax here as well: a
bone 1.25e5 times as stiff would take 0.5 % more off the peak force if it did not."""

CONTRAST = 30.0
"""Ratio of the moduli of the layers up to which errors are taken as measured at 3: three times the
largest of a published set."""

FAR = 1.25
"""Depth over the gap at the proximal end beyond which contact has reached it; see NEAR."""


def refuse(case: Situation) -> tuple[Refusal, ...]:
    """Return the reasons against it: it can solve every scene, less accurately at large strain."""
    turns = notes.turning_reasons(case.motion, case.indenter)
    unable = (
        *notes.separate_relaxation_reasons(case.finger),
        *turns,
        *case.too_long,
        *unmeshable(case),
    )
    if unable:
        return refusals(name, "ability", unable)
    reasons = [*too_small(case), *too_soft(case.finger), *unmeasured(case.finger)]
    return beyond_cut(name, case) + refusals(name, "accuracy", reasons)


def beyond_cut(mechanics: str, case: Situation) -> tuple[Refusal, ...]:
    """Return the refusal of a mechanics if a plate along the finger reaches its proximal end.

    The finger is continued behind its cut where that is needed. Checked before a solution.
    """
    flat, motion, finger = case.indenter.flat, case.motion, case.finger
    if flat is None or flat.angle > ALONG:
        return ()
    if motion.deepest is None or finger.surface is not None:
        return ()
    if motion.deepest <= NEAR * gap(finger, flat):
        return ()
    end = gap(finger, flat, with_continuation=True)
    if motion.deepest <= NEAR * end:
        return ()
    sure = motion.deepest > FAR * end
    reason = (
        f"depth / gap at the proximal end = {case.motion.peak:.3g} / {end:.3g} mm: contact "
        f"{'reaches' if sure else 'may reach'} the end, behind which there is no finger; press "
        "less, or at a steeper angle"
    )
    return (Refusal(mechanics, "ability" if sure else "accuracy", reason, "motion.depth"),)


def unmeshable(case: Situation) -> tuple[Reason, ...]:
    """Return the reason why the finger of a scene cannot be meshed, if there is one."""
    from fefinger.mesh.store import mesh_problem

    # `case.touch` is rounded: the object at the place of the scene itself has to reach the pad.
    at = case.indenter.place if isinstance(case.touch, tuple) else None
    reason = mesh_problem(case.finger, case.touch, at, max(case.indenter.half_sides))
    return (Reason("finger" if at is None else "", reason),) if reason else ()


def unmeasured(finger: Finger) -> Iterator[Reason]:
    """Yield the tissues outside of the range in which mesh errors were measured."""
    layers = (finger.skin, finger.subcutaneous)
    contrast = layers[0].modulus / layers[1].modulus
    if max(contrast, 1 / contrast) > CONTRAST:
        reason = (
            f"skin modulus / subcutaneous modulus = {contrast:.3g}, not within {CONTRAST:g}: "
            "errors are not measured there"
        )
        yield Reason("finger.skin.modulus", reason)
    for (name, most), layer in zip(largest_exponents().items(), layers, strict=True):
        if layer.law not in LAWS.shipped:
            reason = f"law of {name} = {layer.law!r}: errors are not measured for it"
            yield Reason(f"finger.{name}.law", reason)
        if (layer.exponent or 0.0) > most:
            reason = (
                f"exponent of {name} = {layer.exponent:.3g} > {most:.3g}: errors are not measured "
                "there"
            )
            yield Reason(f"finger.{name}", reason)


def too_small(case: Situation) -> Iterator[Reason]:
    """Yield the reason against a contact (its Hertz radius), or parts, too small for the mesh.

    Under force control the depth comes from flat layers, so that both controls have one limit.
    """
    facet, width = FACETS[case.mesh], case.indenter.feature
    if width < facet:
        reason = (
            f"narrowest part of the object / facet of the pad = {width:.2g} / {facet:g} mm < 1: "
            "the mesh does not resolve it; contact and spikes are of its vertices"
        )
        yield Reason("finger.resolution", reason)
    if case.indenter.hertzian is None:
        return
    radius = hertz.half_space(case.finger, case.indenter).relative_radius
    # Facets per contact radius, below which the force is off by 10 % and more: on the coarse mesh,
    # against the standard one, -65 % at 0.3 facets, 10 % at 0.5, -1 to -3 % at 0.8 to 0.9.
    fewest = 1.0
    depth = layered.deepest(case, (fewest * facet) ** 2 / radius)
    facets = math.sqrt(radius * depth) / facet * (1 + 1e-12)
    if facets < fewest:
        reason = (
            f"contact radius / facet of the pad = {facets * facet:.2g} / {facet:g} mm = "
            f"{facets:.2g} < {fewest:g}: the mesh is too coarse for it"
        )
        yield Reason("finger.resolution", reason)


def too_soft(finger: Finger) -> Iterator[Reason]:
    """Yield the hard parts soft enough for their relaxation, which is wrong here, to matter."""
    for part, least in HARD.items():
        material, field = getattr(finger, part), f"finger.{part}.modulus"
        ratio = material.modulus / finger.skin.modulus if isinstance(material, Hard) else least
        if ratio < least:
            reason = (
                f"{field} / finger.skin.modulus = {ratio:.3g} < {least:g}: it relaxes with the "
                "tissue here"
            )
            yield Reason(field, reason)


cost, once = costs.linear_seconds, costs.mesh_seconds
error = error_of(name)


def coarser(scene: Scene, *, follow: bool = True) -> Finger | None:
    """Return the finger on the next coarser mesh, if that is shipped or cached.

    `follow`: that is the mesh that follows the touch.
    """
    from fefinger.mesh.store import available

    below = {"standard": "coarse", "fine": "standard"}.get(scene.finger.mesh)
    if below is None:
        return None
    finger = replace(scene.finger, resolution=below)
    at = refinement_location(scene.indenter) if follow else None
    return finger if available(finger, at) else None


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Solve the scene with finite elements."""
    from fefinger.mechanics.press import small_strain

    stated = (*NOTES, *notes.hard_parts_notes(scene.finger))
    return small_strain.respond(scene, progress, mechanics=name, notes=stated)
