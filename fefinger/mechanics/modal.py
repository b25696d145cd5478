"""`condensed` with inertia: modes of vibration of the finger, static flexibility for the rest.

One real eigenproblem per finger serves every relaxation and every frequency, because all tissue
relaxes with one function. Through time each mode is an oscillator with the memory of the tissue,
and contact opens and closes as in `condensed` (`contact/inertial.py`). At finite strain the
answer without inertia comes from `pressed` (`press/modal_response.py`).
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from types import ModuleType

from fefinger.mechanics import condensed, pressed
from fefinger.mechanics.evidence import costs, vibration
from fefinger.mechanics.press.notes import (
    QUASISTATIC,
    Reason,
    refusals,
    relaxing_object_reasons,
    soft_reasons,
    stiffens,
    tangential_reasons,
)
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Traits
from fefinger.results.records import Refusal, Response
from fefinger.scene.finger import Finger
from fefinger.scene.motion import Motion
from fefinger.scene.oscillation import SAMPLED
from fefinger.scene.scene import Scene
from fefinger.support.progress import Progress


name = "modal"
traits = Traits(meshed=True, finite=False, inertia=True)

INERTIA = (
    "Inertia of the tissue, about a bone that does not move; the indenter has its motion or its "
    "force prescribed, and no mass."
)


def refuse(case: Situation) -> tuple[Refusal, ...]:
    """Return the reasons against it: as for its statics, friction or a path, too fast motion."""
    base = _base(case.finger)
    shared = tuple(replace(refusal, mechanics=name) for refusal in base.refuse(case))
    if any(refusal.about == "ability" for refusal in shared):
        return shared
    unable = refusals(name, "ability", _unable(case))
    return unable + shared + refusals(name, "accuracy", reasons(case))


def _unable(case: Situation) -> Iterator[Reason]:
    """Yield a path or friction, an object that relaxes, and a sweep of a soft object.

    The closed form of a sweep has one complex modulus for all that gives way.
    """
    yield from tangential_reasons(case.motion, case.indenter)
    yield from relaxing_object_reasons(case.indenter)
    if case.motion.frequencies is not None:
        yield from soft_reasons(case.indenter)


def reasons(case: Situation) -> list[Reason]:
    """Return the reasons against a motion faster than what was measured, modes or its samples."""
    return [*_too_sudden(case), *_too_high(case), *_too_coarse(case.motion)]


def _too_sudden(case: Situation) -> Iterator[Reason]:
    last = vibration.last_mode(case)
    press_suddenness = vibration.suddenness(case.motion, 1 / last)
    # Suddenness of a press beyond which the modes cannot follow: the force is off by some tenths.
    sudden = 0.5
    if press_suddenness > sudden:
        pace = case.motion.control.pace
        reason = (
            f"sudden change of the speed / (peak x frequency of the last mode, {last:.3g} Hz) = "
            f"{press_suddenness:.2g} > {sudden:g}: the modes do not follow it; press more slowly, "
            "or with a longer motion.corner"
        )
        yield Reason(f"motion.{pace}" if hasattr(case.motion, pace) else "motion", reason)


def _too_high(case: Situation) -> Iterator[Reason]:
    frequency = case.motion.highest_frequency
    if frequency is None:
        return
    reduced, highest = vibration.reduced_frequency(case), vibration.highest()
    ratio, most = vibration.ratio(case), vibration.BEYOND
    damped = vibration.damped_set(case.finger)
    if reduced > highest * (1 + 1e-9):
        reason = (
            f"frequency x thickness / wave speed = {reduced:.2g} > {highest:g}: no finger was "
            f"measured beyond; stay below {_rounded(frequency * highest / reduced)} Hz{damped}"
        )
        yield Reason("motion.frequency", reason)
    elif ratio > most:
        reason = (
            f"frequency / frequency of the last mode = {ratio:.2g} > {most:g}: the modes that "
            f"are computed reach some {_rounded(frequency * most / ratio)} Hz; stay below, or "
            f"take stiffer tissue{damped}"
        )
        yield Reason("motion.frequency", reason)


def _too_coarse(motion: Motion) -> Iterator[Reason]:
    frequency, rate = motion.highest_frequency, motion.sample_rate
    if frequency is not None and rate is not None and rate < SAMPLED * frequency:
        reason = (
            f"samples per s / highest frequency = {rate:.4g} / {frequency:.3g} Hz = "
            f"{rate / frequency:.2g} < {SAMPLED:g}: straight lines between the samples distort it; "
            "sample the motion more finely, or filter its noise"
        )
        yield Reason("motion.time", reason)


def _rounded(value: float) -> str:
    """Return two digits of a frequency, rounded down."""
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.floor(value / step) * step:.12g}"


def _base(finger: Finger) -> ModuleType:
    """Return the mechanics that answers without inertia."""
    return pressed if stiffens(finger) else condensed


def cost(case: Situation) -> float:
    """Return the expected CPU time in s, less where modes and operator are in the cache."""
    return _base(case.finger).cost(case) + costs.modal_seconds(case)


def once(case: Situation) -> float:
    """Return the time in s of building what is kept for the next run; 0 where at hand."""
    return _base(case.finger).once(case) + costs.modal_once(case)


def error(case: Situation, quantity: str = "force") -> tuple[float, str]:
    """Return the expected relative error, and its source: without inertia, and of the modes."""
    error, source = _base(case.finger).error(case, quantity)
    left = vibration.modal_error(case)
    return math.hypot(error, left), f"{source}; {vibration.sentence(case)}"


def coarser(scene: Scene) -> Finger | None:
    """Return the finger on the next coarser mesh, if that is at hand."""
    return _base(scene.finger).coarser(scene)


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Answer the scene with inertia; operator and modes are built if not at hand."""
    from fefinger.mechanics.press import modal_response

    notes = tuple(note for note in _base(scene.finger).NOTES if note != QUASISTATIC)
    answer = modal_response.respond(
        *(scene, progress),
        mechanics=name,
        notes=(*notes, INERTIA),
        geometric_share=vibration.geometric_share,
    )
    return replace(answer, notes=(*answer.notes, *vibration.notes(Situation.of(scene))))
