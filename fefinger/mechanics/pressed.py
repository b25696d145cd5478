"""Finite strain by a pre-solved table: elastic solutions over depth, with relaxation convolved.

With one relaxation for the whole stress, contact at finite strain is nearly the elastic contact of
the same depth, relaxed by a hereditary integral; on retreat, by the integral of nested contacts of
a body that stiffens. The force is the work of that stress on the present deformation (for all of
this see `theory/contact/ting.py`). The table (`press/elastic_press.py`) is solved once per finger
and object and kept; it is shipped for the calibrated fingers under the plate at 30 degrees and a
ball of 5 mm. What the tabulation leaves out is measured against `solid` on the same mesh
(`evidence/tabulation_error.py`).
"""

import math
from collections.abc import Iterator
from dataclasses import replace

from fefinger.mechanics import layered, linear, solid
from fefinger.mechanics.evidence import costs, tabulation_error
from fefinger.mechanics.press import notes
from fefinger.mechanics.press.notes import Reason, refusals
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Traits
from fefinger.results.records import Refusal, Response
from fefinger.scene.scene import Scene
from fefinger.support.progress import Progress


name = "pressed"
traits = Traits(meshed=True, finite=True)

NOTES = (
    notes.LOGARITHMIC,
    "Frictionless contact with a rigid indenter. Gaps are closed as weighted means over the facets "
    "around each vertex, not at every point.",
    "The press of the relaxed finger was solved at some depths. Through time its whole stress "
    "relaxes, and until the indenter retreats the deformation is taken to depend on the depth "
    "alone, not on the speed. The force is the work of that stress on a change of this depth.",
    "On retreat and after lift-off the tissue recovers as in nested contacts that relax one by "
    "one, more slowly where it stiffens.",
    notes.QUASISTATIC,
)


def refuse(case: Situation) -> tuple[Refusal, ...]:
    """Return the reasons against it: different relaxations, and as for `solid`."""
    unable = [
        *notes.separate_relaxation_reasons(case.finger),
        *notes.elastic_hard_parts_reasons(case.finger),
        *notes.friction_reasons(case.indenter),
    ]
    if case.ask.solver is not None:
        reason = (
            f"ask.solver = {case.ask.solver!r}: this mechanics solves with the factors of 'solid'"
        )
        unable.append(Reason("ask.solver", reason))
    if unable:
        return refusals(name, "ability", unable)
    return (*solid.refused(name, case), *refusals(name, "accuracy", too_shallow(case)))


def too_shallow(case: Situation) -> Iterator[Reason]:
    """Yield the reason against a motion that goes no deeper than the first depth of a table."""
    # Imported here, because errors are also read for scenes without a mesh.
    from fefinger.mechanics.press.depth_table import SHALLOWEST

    first = SHALLOWEST * case.finger.thickness
    depth = layered.deepest(case, first)
    if depth < first * (1 - 1e-9):
        part = f"depth / finger.thickness = {depth / case.finger.thickness:.2g}"
        yield Reason("motion", f"{part} < {SHALLOWEST:g}: its tables begin there")


cost, once, coarser = costs.pressed_seconds, costs.pressed_once, linear.coarser


def error(case: Situation, quantity: str = "force") -> tuple[float, str]:
    """Return the expected relative error, of mesh and tabulation, and its source."""
    error, source = solid.error(case, quantity)
    if math.isnan(error):
        return error, source
    tabulation = tabulation_error.error(case, quantity)
    # Not their sum: on loading a mesh makes the force too large, the table too small.
    return math.hypot(error, tabulation), f"{source}; {tabulation_error.sentence(tabulation, case)}"


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Solve the scene from the elastic press of its finger, which is solved if not cached."""
    from fefinger.mechanics.press import tabulated_press

    stated = (*NOTES, notes.RIGID_BONE)
    response = tabulated_press.respond(scene, progress, mechanics=name, notes=stated)
    prony = scene.finger.prony
    if prony.long_time == 1.0 or not tabulation_error.retreats(scene.motion):
        return response  # elastic tissue comes back as it went
    part = float(response.depth.max()) / scene.finger.thickness
    return replace(response, notes=(*response.notes, tabulation_error.on_retreat(part, prony)))
