"""Small-strain finite elements, condensed once per finger to its pad and its end organs.

The operator (`fem/condensation.py`) is built once per finger and cached; contact then runs in
compiled steps (`contact/frictionless.py`). On the same mesh it answers as `linear` does, up
to rounding. One operator serves every indenter, so its mesh is that of the 30
degree plate, where the mesh of `linear` follows the touch.
"""

from dataclasses import replace

from fefinger.mechanics import linear
from fefinger.mechanics.evidence import costs
from fefinger.mechanics.evidence.stated_errors import error_of
from fefinger.mechanics.press.notes import RIGID_BONE, elastic_hard_parts_reasons, refusals
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Traits
from fefinger.results.records import Refusal, Response
from fefinger.scene.finger import Finger
from fefinger.scene.scene import Scene
from fefinger.support.progress import Progress


name = "condensed"
traits = Traits(meshed=True, finite=False)

NOTES = (
    *linear.NOTES,
    RIGID_BONE,
    "The body was reduced once to its pad; the reduction is exact, and is used again.",
)

BEYOND = (
    "Contact reaches the skin beyond the palmar part of the pad, which the reduced body does not "
    "keep: the whole mesh was solved."
)


def refuse(case: Situation) -> tuple[Refusal, ...]:
    """Return the reasons against it: as for `linear`, and an elastic bone."""
    unable = [*elastic_hard_parts_reasons(case.finger)]
    shared = tuple(replace(refusal, mechanics=name) for refusal in linear.refuse(case))
    return refusals(name, "ability", unable) + shared


cost, once = costs.condensed_seconds, costs.condensed_once
error = error_of(name)


def coarser(scene: Scene) -> Finger | None:
    """Return the finger on the next coarser mesh, if that is shipped or cached."""
    return linear.coarser(scene, follow=False)


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Solve the scene with the operator of its finger, which is built if it is not cached.

    Where contact reaches the pad beyond its palmar part, for which the operator is not defined, the
    whole mesh is solved: the same answer, at the cost of `linear`. InputError also if the cached
    operator does not fit the finger.
    """
    from fefinger.fem.condensation import OutsideError
    from fefinger.mechanics.press import small_strain
    from fefinger.mechanics.press.operator import METHOD

    try:
        return small_strain.respond(scene, progress, mechanics=name, notes=NOTES, method=METHOD)
    except OutsideError:
        whole = replace(small_strain.WHOLE_MESH, touch=METHOD.touch)
        notes = (*linear.NOTES, RIGID_BONE, BEYOND)
        return small_strain.respond(scene, progress, mechanics=name, notes=notes, method=whole)
