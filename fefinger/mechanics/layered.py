"""Contact with flat viscoelastic layers of skin and subcutaneous tissue on rigid bone, exact.

In `theory/contact/`, `stack.py` and `indentation.py` are the equations, `contact_table.py` the
contacts solved once per stack, and `ting.py` extends them to unloading and renewed contact. The
first press of a stack takes a quarter of a second, another one some 30 ms
(`reports/afferent-cost.json`).

That is for plates, balls and ellipsoids, which only press a smooth pad. Every other object, a path
and a pad with ridges are solved on a grid (`press/layer_press.py`), and so are friction and
soft objects.
"""

import math
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from fefinger.mechanics import hertz
from fefinger.mechanics.evidence import costs, presses, vibration
from fefinger.mechanics.evidence.stated_errors import StatedError, error_of
from fefinger.mechanics.press import axisymmetric, notes
from fefinger.mechanics.press.notes import Reason, refusals
from fefinger.mechanics.press.sites import REFERENCE_DEPTH
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Traits
from fefinger.results.records import Refusal, Response
from fefinger.scene.ask import Ask, innervation
from fefinger.scene.finger import BONE, RESOLUTIONS, Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.motion import Motion
from fefinger.scene.scene import Scene
from fefinger.support.checks import BeyondError, InputError
from fefinger.support.progress import Progress, Stages
from fefinger.support.text import percent
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.theory.contact.stack import Layer, Stack


if TYPE_CHECKING:
    from fefinger.mechanics.press.layer_grid import LayerGrid
    from fefinger.theory.contact.contact_table import ContactTable


name = "layered"
traits = Traits(meshed=False, finite=False, ridges=True)


THINNEST = 0.02
"""Least share of the tissue over the bone that the layer below the skin has, a convention: a film
thinner than that is no layer of a finger."""

NARROW = 0.25
"""Depth over the relative radius R up to which no contact is wider than R: on a thin incompressible
layer, the widest, the depth is a quarter of the squared contact radius over R (Barber 1990)."""

NOTES = (
    "The finger is a flat stack of skin and subcutaneous tissue bonded to rigid bone; the sides, "
    "the tip and the nail are left out, and the bone is flat.",
    notes.SPHERICAL,
    "Small strain, a contact small against the radii, no friction.",
    notes.CONVOLVED,
    notes.QUASISTATIC,
)


ON_GRID = (
    "The finger is a flat stack of skin and subcutaneous tissue bonded to rigid, flat bone, and "
    "its pad a paraboloid.",
    "Small strain; the pressure acts along the travel, not along the slopes of the object, and the "
    "skin meets the heights ahead of its undeformed points.",
    "The whole stress relaxes with one function G(t). Stated errors are those of a press without a "
    "path or friction.",
    notes.QUASISTATIC,
)

SMOOTH = (
    "The skin is smooth: its ridges ([finger.ridges]) and {others} are left out. Over textures "
    "FAII fire because of such causes."
)

RIDGED = (
    "The skin has {shape} ridges, sinusoidal heights of {height:g} mm every {pitch:g} mm; they do "
    "not bend aside; the papillae of the dermis below are left out, as are {others}."
)

COULOMB = (
    "Friction: Coulomb's law at every point of the grid, of {static:g} where it sticks and "
    "{kinetic:g} where it slips."
)

UNKNOWN = "not known: no press of a skin with ridges was compared with finite strain"

FLATTENED = "{share} of ridges, as if all of them gave way by half of their height"

ON_A_GRID = f"{name} on a grid"
"""Name of its cost there."""

INERTIA = (
    "Inertia, left out: {what} pass at {frequency:.3g} Hz, at which it changes an oscillation of "
    "the force under a plate or a ball by up to {share} (reports/modal.json)."
)

HIGHEST, APART = 6.0, 0.1
"""Distance in mm from the middle within which the heights of an object are looked at, and steps."""


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


def contact(scene: Scene | Situation) -> "ContactTable":
    """Return the elastic contacts of the relaxed finger that the motion passes through.

    BeyondError if the contact becomes wider than its relative radius.
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
        raise BeyondError(
            f"motion.{motion.control}: expected one whose contact is narrower than its relative "
            f"radius of {radius:.4g} mm, as small strain is assumed, received {motion.peak:g} "
            f"{motion.unit}; press less, or take a larger indenter"
        ) from error
    except ValueError as error:
        raise BeyondError(f"motion: {error}; press less") from error


def deepest(case: Situation, enough: float) -> float:
    """Return the largest depth in mm of the contact, or `enough` where it is at least that.

    Under force control the layers bear the largest elastic force there; at first touch only the
    skin counts, against which a half-space of both tissues is far too soft. Objects without
    curvature have the depth of the measured presses.
    """
    finger, peak = case.finger, case.motion.peak
    if case.motion.deepest is not None:
        return case.motion.deepest
    if case.indenter.hertzian is None:
        return case.depth_over_thickness * finger.thickness
    body = hertz.half_space(finger, case.indenter)
    hardest = max(finger.skin.modulus, finger.subcutaneous.modulus)
    least = replace(body, modulus=hardest)
    # Tissue that has not relaxed bears more; at once it is as if the elastic force were this part.
    if least.depth(peak / NEWTON_PER_MILLINEWTON * finger.prony.long_time) >= enough:
        return enough
    elastic = hertz.elastic_peak(case.motion, finger.prony)
    try:
        return float(contact(case).depth(elastic))
    except InputError:  # no such layers, or wider than the pad is round: far from too small
        return float(least.depth(elastic))


def on_grid(finger: Finger, indenter: Indenter, motion: Motion) -> bool:
    """Return whether a press takes a grid: all but a hard, smooth, round object on a smooth pad."""
    round_ = indenter.hertzian is not None and indenter.soft_body is None
    return indenter.friction > 0 or not round_ or motion.slides or finger.raised_ridges is not None


@lru_cache(maxsize=32)
def grid(finger: Finger, indenter: Indenter, motion: Motion, ask: Ask) -> "LayerGrid":
    """Return the grid of a press: contact and thickness wide, as fine as object, ridges and organs.

    InputError for one that does not fit into memory, for a contact wider than the pad is round,
    and for ridges coarser than the contact.
    """
    from fefinger.mechanics.press import layer_gap

    reach = _reach(finger, indenter, motion)
    layer_gap.check_ridges(finger.raised_ridges, reach)
    types = ask.spikes or (tuple(innervation()) if ask.wants("strain") else ())
    depths = {kind: organ.depth for kind, organ in innervation().items()} | dict(ask.depths)
    shallowest = min((depths[kind] for kind in types), default=math.inf)
    step = layer_gap.spacing(finger, indenter, reach, shallowest)
    return layer_gap.grid_of(stack(finger), reach, step)


def _reach(finger: Finger, indenter: Indenter, motion: Motion) -> float:
    """Return the radius in mm of the contact with a plate that goes as deep as the object."""
    from fefinger.theory.contact.contact_table import TooWideError, tabulate_to

    layers, radius = stack(finger), finger.pad_radius
    lines = np.arange(-HIGHEST, HIGHEST + APART, APART)
    rise = indenter.profile.rise(np.stack(np.meshgrid(lines, lines), axis=-1))
    relief = float(rise[np.isfinite(rise)].max()) if indenter.profile.level else 0.0
    try:
        depth = motion.deepest
        if depth is None:
            force = motion.peak / NEWTON_PER_MILLINEWTON
            depth = relief + float(tabulate_to(layers, radius, force=force).depth(force))
        return float(tabulate_to(layers, radius, depth=depth).contact_radius(np.array(depth)))
    except (TooWideError, ValueError) as error:
        raise InputError(
            f"motion.{motion.control}: expected one whose contact is narrower than the "
            f"{radius:.4g} mm by which the pad is round, as small strain is assumed, received "
            f"{motion.peak:g} {motion.unit}; press less"
        ) from error


def _grid_refusals(case: Situation) -> list[Reason]:
    """Return the features of a scene that a grid of layers cannot represent."""
    from fefinger.mechanics.press import layer_gap

    unable = [*notes.own_relaxation_reasons(case.finger), *case.too_long]
    if case.motion.turns_plate:
        reason = f"motion.kind = {case.motion.kind!r}: its plate does not turn along a path"
        unable.append(Reason("motion.angle", reason))
    if case.ask.fields:
        reason = "ask.fields: this mechanics has no mesh; ask.fields = false leaves them out"
        unable.append(Reason("ask.fields", reason))
    if layer_gap.first_touch(case.finger, case.indenter) is None:
        reason = "indenter.at: it lies beyond the sphere that replaces the pad"
        unable.append(Reason("indenter.at", reason))
    if not unable:
        try:
            grid(case.finger, case.indenter, case.motion, case.ask)
        except InputError as error:
            unable.append(Reason(error.field, str(error)))
    return unable


def _beyond(case: Situation) -> list[Reason]:
    """Return the reason against a contact wider than the pad is round, or through the tissue."""
    depth, body = case.motion.deepest, hertz.half_space(case.finger, case.indenter)
    if depth is not None and depth < NARROW * body.relative_radius:
        return []  # without the table
    try:
        table = contact(case)
    except BeyondError as error:
        return [Reason(error.field, str(error))]
    if depth is not None:
        return []
    elastic = hertz.elastic_peak(case.motion, case.finger.prony)
    return hertz.too_deep(case, float(table.depth(elastic)))


def refuse(case: Situation) -> tuple[Refusal, ...]:
    """Return the reasons against it: what it cannot represent, and ranges not measured."""
    gridded = on_grid(case.finger, case.indenter, case.motion)
    try:
        bone = stack(case.finger).thickness
    except InputError as error:
        return (Refusal(name, "ability", str(error), "finger.skin.thickness"),)
    unable = _grid_refusals(case) if gridded else hertz.lacking(case)
    if not (gridded or unable):
        unable += _beyond(case)
    deepest = max(dict(case.ask.depths).values(), default=0)
    if deepest >= bone:
        reason = f"ask.depths: {deepest:.3g} mm is not above the bone at {bone:.3g} mm"
        unable.append(Reason("ask.depths", reason))
    return refusals(name, "ability", unable)


def cost(case: Situation) -> float:
    """Return the expected CPU time in s."""
    if not on_grid(case.finger, case.indenter, case.motion):
        return costs.formula_seconds(name, case)
    feature = case.indenter.feature if case.motion.slides else math.inf
    steps = len(time_grid(case.motion, fast=False, feature=feature))
    points = grid(case.finger, case.indenter, case.motion, case.ask).points ** 2
    stages = ("point", "gripped") if case.indenter.friction else ("point",)
    spent = steps * points * sum(costs.seconds(ON_A_GRID, stage) for stage in stages)
    organs = costs.organs(case.ask) if case.ask.population is not None else 0.0
    spent += organs * len(case.times) * costs.seconds(ON_A_GRID, "sample")
    spent += costs.seconds(ON_A_GRID, "setup")
    coarse = case.on(RESOLUTIONS[0])  # whose press says what the finger yields beyond its layers
    spent += costs.mesh_seconds(coarse, follow=False)
    return spent + costs.seconds("linear", "setup", coarse.mesh)


once, coarser = hertz.once, hertz.coarser
_measured = error_of(name)


def error(case: Situation, quantity: str = "force") -> StatedError:
    """Return the measured relative error of a quantity, and its source.

    With ridges that of the force alone: of a smooth pad, and of ridges that do not give way here.
    """
    ridges, found = case.finger.raised_ridges, _measured(case, quantity)
    if ridges is None:
        return found
    if quantity != "force":
        return StatedError(math.nan, UNKNOWN)
    depth = case.depth_over_thickness * case.finger.thickness
    power = presses.pressed(case.features).steepness(case.depth_over_thickness)
    own = power * ridges.height / 2 / depth if depth else math.inf
    source = f"{found.source}; {FLATTENED.format(share=percent(own))}"
    return StatedError(math.hypot(found.error, own), source)


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Solve the scene with the exact contact of the stack and the field below it.

    InputError also if the contact becomes wider than its relative radius, or of a grid.
    """
    if on_grid(scene.finger, scene.indenter, scene.motion):
        return respond_on_grid(scene, progress)
    body, plate = contact(scene), _plate(scene.finger)
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


def _plate(finger: Finger) -> "ContactTable":
    """Return the contacts with the plate of the reference press."""
    from fefinger.theory.contact.contact_table import tabulate_to

    # It is needed at one depth, at the end of its table, where few contacts are exact.
    return tabulate_to(stack(finger), finger.pad_radius, depth=REFERENCE_DEPTH, levels=8)


def causes(finger: Finger, indenter: Indenter) -> list[str]:
    """Return in words which causes of spikes over textures an answer on a grid has."""
    ridges = finger.raised_ridges
    others = "inertia" if indenter.friction else "friction and inertia"
    if ridges is None:
        found = [SMOOTH.format(others=others)]
    else:
        form = {"shape": ridges.shape, "height": ridges.height, "pitch": ridges.pitch}
        found = [RIDGED.format(**form, others=others)]
    if indenter.friction:
        found.append(COULOMB.format(static=indenter.friction, kinetic=indenter.kinetic))
    return found


def inertia(case: Situation) -> tuple[str, ...]:
    """Return in words what inertia would change where a texture or ridges pass."""
    ridges, indenter = case.finger.raised_ridges, case.indenter
    if not case.motion.slides or (ridges is None and indenter.feature == math.inf):
        return ()
    path = np.linalg.norm(np.diff(case.motion.shift(case.times), axis=0), axis=1)
    speed = float((path / np.diff(case.times)).max())
    what, period = "ridges", ridges.pitch if ridges is not None else math.inf
    if ridges is None:
        what, period = "parts of the object and the gaps between them", 2 * indenter.feature
    share = percent(vibration.of_oscillation(case, speed / period))
    return (INERTIA.format(what=what, frequency=speed / period, share=share),)


def respond_on_grid(scene: Scene, progress: Progress | None = None) -> Response:
    """Solve the scene on a grid, whatever its object: as `respond` solves those that need one."""
    from fefinger.mechanics.press import beyond_layers, layer_press

    finger, indenter, stages = scene.finger, scene.indenter, Stages(progress)
    layers = grid(finger, indenter, scene.motion, scene.ask)
    with stages.stage("body"):
        body, yields = beyond_layers.on_finger(layers, finger, indenter)
    left_out = (*causes(finger, indenter), *inertia(Situation.of(scene)))
    return layer_press.respond(
        scene,
        body,
        lambda: axisymmetric.small_press(scene.ask, finger.pulp, _plate(finger)),
        stages,
        mechanics=name,
        notes=(
            *ON_GRID,
            yields,
            notes.object_note(indenter),
            *left_out,
            *notes.normalization_notes(finger.prony),
        ),
    )
