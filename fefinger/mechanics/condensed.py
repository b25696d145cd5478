"""The answer of `linear`, from a finger that was reduced once to its pad and its end organs.

The operator (`fem/condense.py`) is built once per finger and kept; contact then runs in compiled
steps (`fem/loop.py`). Same mesh, same contact, same relaxation: what differs from `linear` is
rounding.
"""

from dataclasses import replace

from fefinger.mechanics import _evidence, _tradeoff, linear
from fefinger.records import Progress, Refusal, Response
from fefinger.scene import Scene


name = "condensed"

NOTES = (
    *linear.NOTES,
    "The body was reduced once to its pad; the reduction is exact, and is used again.",
)

STIFFEST = 0.49999
"""Poisson's ratio above which the factor needs refinement, which a reduced body cannot have."""


def refuse(scene: Scene) -> tuple[Refusal, ...]:
    """Return why it should not answer: as `linear`, and for tissue that is incompressible."""
    found = [replace(refusal, mechanics=name) for refusal in linear.refuse(scene)]
    for layer in ("skin", "subcutaneous"):
        poisson = getattr(scene.finger, layer).poisson
        if poisson > STIFFEST:
            reason = (
                f"finger.{layer}.poisson = {poisson:g} > {STIFFEST:g}: an incompressible body is "
                "solved by refinement, which a reduced one cannot have"
            )
            found.append(Refusal(name, "ability", reason))
    return tuple(found)


def cost(scene: Scene) -> float:
    """Return the expected wall time in s, less where the finger's operator is in the cache."""
    return _evidence.condensed_seconds(scene)


def error(scene: Scene) -> tuple[float, str]:
    """Return the expected relative error of the force, that of `linear`, and its source."""
    found = _tradeoff.stated(f"{name} {scene.finger.mesh}", scene)
    return _evidence.linear_error(scene) if found is None else (found.error, found.source)


def coarser(scene: Scene) -> Scene | None:
    """Return the scene on the next coarser mesh, if that is at hand."""
    return linear.coarser(scene)


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Answer the scene with the operator of its finger, which is built if it is not at hand.

    Raises
    ------
    InputError
        As `linear`; and if contact reaches beyond the palmar part of the pad, or the kept operator
        does not fit the finger.
    ConvergenceError
        If a contact solution is not reached.
    """
    from fefinger.mechanics._operator import METHOD
    from fefinger.mechanics._press import press

    return press(scene, progress, mechanics=name, notes=NOTES, method=METHOD)
