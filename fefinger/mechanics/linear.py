"""Small-strain finite elements on the whole finger: Taylor-Hood, exact contact, QLV.

The body is solved once under a unit pressure on every candidate vertex of the pad; contact and
relaxation then run on that small dense problem (`press/small_strain.py`). What it leaves out is in
`NOTES`.
"""

from fefinger.mechanics import hertz
from fefinger.mechanics.evidence import reports, tradeoff
from fefinger.mechanics.press import proximal_cut
from fefinger.mechanics.press.discretization import meshed_at
from fefinger.mechanics.press.notes import apart, hard
from fefinger.mechanics.press.time_steps import too_long
from fefinger.results.records import Refusal, Response
from fefinger.scene.finger import Finger
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Hard
from fefinger.support.progress import Progress
from fefinger.support.text import beyond


name = "linear"

NOTES = (
    "Small strain: the geometry, the surface areas and the tissue stiffness are those of the "
    "undeformed finger; the stiffening of tissue at large strain is left out.",
    "Frictionless contact with a rigid indenter; the pressure acts along the indenter's normal. "
    "Gaps are closed as weighted means over the facets around each vertex, not at every point.",
    "The whole stress of every soft tissue relaxes with one function G(t); Poisson's ratio is "
    "constant.",
    "Quasi-static: no inertia and no waves.",
)


HARD = {"bone": 5e4, "nail": 1e3}
"""Moduli over that of the skin, above which it hardly matters that hard parts relax here as well: a
bone 1.25e5 times as stiff would take 0.5 % more off the peak force if it did not."""

CONTRAST = 30.0
"""Ratio of the moduli of the layers up to which errors are taken as measured at 3: three times the
largest of a published set."""

EXPONENT = 10.0
"""Exponent of the tissue up to which errors are taken; calibrated fingers go up to 7.5."""

LAW = "neo-hookean"
"""The law of finite strain against which the error of small strain is measured."""


def refuse(scene: Scene) -> tuple[Refusal, ...]:
    """Return why it should not answer: it can do every scene, less well at large strain."""
    unable = (
        *apart(scene.finger),
        *too_long(scene.motion, fast="FAII" in scene.ask.spikes),
        *unmeshable(scene),
    )
    if unable:
        return tuple(Refusal(name, "ability", reason) for reason in unable)
    found = list(proximal_cut.reached(name, scene))
    doubts = (*too_small(scene), *too_soft(scene.finger), *unmeasured(scene.finger))
    found += [Refusal(name, "accuracy", reason) for reason in doubts]
    if tradeoff.stated(f"{name} {scene.finger.mesh}", scene) is not None:
        return tuple(found)
    radius, least = scene.indenter.least_radius, reports.linear_radius(scene)
    if radius < least:
        reason = f"radius = {radius:.3g} mm < {least:g} mm: the mesh error is not measured there"
        found.append(Refusal(name, "accuracy", reason))
    press = reports.solid_press(scene)
    part, limit = reports.small_strain_part(scene), reports.solid_reach(press)
    if part > limit:
        reason = f"depth / thickness = {beyond(part, limit)}: small strain is not measured there"
        found.append(Refusal(name, "accuracy", reason))
    for layer in ("skin", "subcutaneous"):
        law = getattr(scene.finger, layer).law
        if law != LAW:
            reason = f"finger.{layer}.law = {law!r}: small strain is measured for {LAW!r} only"
            found.append(Refusal(name, "accuracy", reason))
    return tuple(found)


def unmeshable(scene: Scene) -> tuple[str, ...]:
    """Return why there is no mesh of the scene's finger, if so."""
    from fefinger.mesh.store import fault

    touch = meshed_at(scene.indenter)
    # That place is rounded: whether it is on the pad is asked of the one that the scene has.
    at = scene.indenter.place if isinstance(touch, tuple) else None
    said = fault(scene.finger, touch, at)
    return (said,) if said else ()


def unmeasured(finger: Finger) -> list[str]:
    """Return which tissue is far from those whose mesh errors were measured."""
    layers = (finger.skin, finger.subcutaneous)
    contrast = layers[0].modulus / layers[1].modulus
    found = []
    if max(contrast, 1 / contrast) > CONTRAST:
        found.append(
            f"skin modulus / subcutaneous modulus = {contrast:.3g}, not within {CONTRAST:g}: "
            "errors are not measured there"
        )
    steepest = max(layer.exponent or 0.0 for layer in layers)
    if steepest > EXPONENT:
        found.append(f"exponent = {steepest:.3g} > {EXPONENT:g}: errors are not measured there")
    return found


def too_small(scene: Scene) -> tuple[str, ...]:
    """Return why a contact is too small for the mesh, by the width that Hertz gives it."""
    if scene.indenter.hertzian is None:
        return ()
    facet = reports.FACETS[scene.finger.mesh]
    facets = hertz.widest(scene) / facet
    if facets >= reports.FEWEST:
        return ()
    reason = (
        f"contact radius / facet of the pad = {facets * facet:.2g} / {facet:g} mm = {facets:.2g} < "
        f"{reports.FEWEST:g}: the mesh is too coarse for it"
    )
    return (reason,)


def too_soft(finger: Finger) -> list[str]:
    """Return what hard parts are so soft that it matters that they relax with the tissue here."""
    found = []
    for part, least in HARD.items():
        material = getattr(finger, part)
        ratio = material.modulus / finger.skin.modulus if isinstance(material, Hard) else least
        if ratio < least:
            found.append(
                f"finger.{part}.modulus / finger.skin.modulus = {ratio:.3g} < {least:g}: it "
                "relaxes with the tissue here"
            )
    return found


def cost(scene: Scene) -> float:
    """Return the expected wall time in s."""
    return reports.linear_seconds(scene)


def error(scene: Scene) -> tuple[float, str]:
    """Return the expected relative error of the force, of mesh and small strain, and its source."""
    candidate = f"{name} {scene.finger.mesh}"
    found = tradeoff.stated(candidate, scene)
    if found is not None:
        return found.error, found.source
    return tradeoff.instead(candidate, scene, *reports.linear_error(scene))


def coarser(scene: Scene, *, follow: bool = True) -> Scene | None:
    """Return the scene on the next coarser mesh, if that is at hand.

    `follow`: that is the mesh that follows the touch.
    """
    from dataclasses import replace

    from fefinger.mesh.store import at_hand

    below = {"standard": "coarse", "fine": "standard"}.get(scene.finger.mesh)
    if below is None:
        return None
    finger = replace(scene.finger, resolution=below)
    at = meshed_at(scene.indenter) if follow else None
    return replace(scene, finger=finger) if at_hand(finger, at) else None


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Answer the scene with finite elements.

    Raises
    ------
    InputError
        If the indenter does not touch the pad, or goes deeper than the tissue or the pad allows.
    ConvergenceError
        If a linear or contact solution is not reached.
    """
    from fefinger.mechanics.press import small_strain

    notes = (*NOTES, *hard(scene.finger))
    return small_strain.respond(scene, progress, mechanics=name, notes=notes)
