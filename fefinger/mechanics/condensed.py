"""The answer of `linear`, from a finger that was reduced once to its pad and its end organs.

The operator (`fem/condense.py`) is built once per finger and kept; contact then runs in compiled
steps (`fem/loop.py`). Same contact, same relaxation: on the same mesh it differs from `linear` by
rounding. One operator serves every indenter, so its mesh is that of the 30 degree plate, where the
mesh of `linear` follows the touch.
"""

from dataclasses import replace

from fefinger.mechanics import linear
from fefinger.mechanics.evidence import reports, tradeoff
from fefinger.mechanics.press.notes import RIGID_BONE, yielding
from fefinger.results.records import Refusal, Response
from fefinger.scene.scene import Scene
from fefinger.support.progress import Progress


name = "condensed"

SOLVER = "multifrontal"

NOTES = (
    *linear.NOTES,
    RIGID_BONE,
    "The body was reduced once to its pad; the reduction is exact, and is used again.",
)

BEYOND = (
    "The indenter comes near the skin beyond the palmar part of the pad, which the reduced body "
    "does not keep: the whole mesh was solved."
)


def refuse(scene: Scene) -> tuple[Refusal, ...]:
    """Return why it should not answer, as `linear`; and it has one bone and one solver."""
    unable = yielding(scene.finger)
    if scene.ask.solver not in (None, SOLVER):
        unable.append(f"ask.solver = {scene.ask.solver!r}: its operator is made by {SOLVER!r}")
    own = tuple(Refusal(name, "ability", reason) for reason in unable)
    return own + tuple(replace(refusal, mechanics=name) for refusal in linear.refuse(scene))


def cost(scene: Scene) -> float:
    """Return the expected wall time in s, less where the finger's operator is in the cache."""
    return reports.condensed_seconds(scene)


def error(scene: Scene) -> tuple[float, str]:
    """Return the expected relative error of the force, of mesh and small strain, and its source."""
    candidate = f"{name} {scene.finger.mesh}"
    found = tradeoff.stated(candidate, scene)
    if found is not None:
        return found.error, found.source
    return tradeoff.instead(candidate, scene, *reports.condensed_error(scene))


def coarser(scene: Scene) -> Scene | None:
    """Return the scene on the next coarser mesh, if that is at hand."""
    return linear.coarser(scene, follow=False)


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Answer the scene with the operator of its finger, which is built if it is not at hand.

    Where the indenter comes near the pad beyond its palmar part, which the operator does not keep,
    the whole mesh is solved: the same answer, at the cost of `linear`.

    Raises
    ------
    InputError
        As `linear`; and if the kept operator does not fit the finger.
    ConvergenceError
        If a contact solution is not reached.
    """
    from fefinger.fem.condensation import OutsideError
    from fefinger.mechanics.press import small_strain
    from fefinger.mechanics.press.operator import METHOD

    try:
        return small_strain.respond(scene, progress, mechanics=name, notes=NOTES, method=METHOD)
    except OutsideError:  # met when the unit loads are solved, so nothing of the press is kept
        whole = replace(small_strain.WHOLE_MESH, touch=METHOD.touch)
        notes = (*linear.NOTES, RIGID_BONE, BEYOND)
        return small_strain.respond(scene, progress, mechanics=name, notes=notes, method=whole)
