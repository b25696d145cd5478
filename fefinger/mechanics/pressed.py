"""Finite strain by a pre-solved table: elastic solutions over depth, with relaxation convolved.

With one relaxation for the whole stress, contact at finite strain is nearly the elastic contact of
the same depth, relaxed by a hereditary integral; on retreat, by the integral of nested contacts of
a body that stiffens. The force is the work of that stress on the present deformation (for all of
this see `theory/contact/ting.py`). The table (`press/elastic_press.py`) is solved once per finger
and object and kept; it is shipped for the calibrated fingers under the plate at 30 degrees and a
ball of 5 mm. What the tabulation leaves out is measured against `solid` on the same mesh
(`reports/pressed-error.json`).
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fefinger.mechanics import layered, linear, solid
from fefinger.mechanics.evidence import costs
from fefinger.mechanics.evidence.presses import EVIDENCE, read
from fefinger.mechanics.evidence.stated_errors import error_of
from fefinger.mechanics.press import notes
from fefinger.mechanics.press.notes import Reason, refusals
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Traits
from fefinger.results.records import Refusal, Response
from fefinger.scene.motion import Motion
from fefinger.scene.scene import Scene
from fefinger.support.progress import Progress
from fefinger.support.text import percent


name = "pressed"
traits = Traits(meshed=True, finite=True)

NOTES = (
    notes.LOGARITHMIC,
    "Frictionless contact. Gaps are closed as weighted means over the facets "
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
        *notes.plate_alone_slides(case.motion, case.indenter),
        *notes.soft_reasons(case.indenter),
    ]
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


error = error_of(name)


def retreats(motion: Motion) -> bool:
    """Return whether the depth, or the force, ever falls."""
    if motion.wave_frequency is not None:  # samples could miss the falls of a fast sine
        return True
    time = np.unique(np.concatenate([np.linspace(0.0, motion.duration, 2001), motion.breakpoints]))
    values = np.asarray(motion.value(np.clip(time, 0.0, motion.duration)))
    return bool((np.diff(values) < -1e-9 * np.abs(values).max()).any())


def on_retreat() -> str:
    """State the errors on retreat, which are larger than those at the peak."""
    errors = read(EVIDENCE)["on retreat"]
    return (
        "Errors are stated where the force is largest. Where the indenter retreats, what the "
        f"tabulation leaves out is up to {percent(errors['strain'])} of the largest strain at the "
        f"end organs and {percent(errors['area'])} of the largest contact area "
        f"(reports/{EVIDENCE})."
    )


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Solve the scene from the elastic press of its finger, which is solved if not cached."""
    from fefinger.mechanics.press import tabulated_press

    stated = (*NOTES, notes.RIGID_BONE)
    response = tabulated_press.respond(scene, progress, mechanics=name, notes=stated)
    if scene.finger.prony.long_time == 1.0 or not retreats(scene.motion):
        return response  # elastic tissue comes back as it went
    return replace(response, notes=(*response.notes, on_retreat()))
