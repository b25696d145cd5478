"""What a loop is made of: its options, what they can do, and the contact that they prepare."""

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from fefinger.fem.contact.obstacle import OwnObstacle
from fefinger.mechanics import condensed
from fefinger.mechanics import pressed as finite_strain
from fefinger.mechanics.press import elastic_press, prepared, prepared_contacts, tabulated_press
from fefinger.mechanics.press.notes import (
    elastic_hard_parts_reasons,
    friction_reasons,
    relaxing_object_reasons,
    separate_relaxation_reasons,
    soft_reasons,
    stiffens,
)
from fefinger.mechanics.press.prepared import Precision, Prepared
from fefinger.mechanics.press.problem import Press
from fefinger.mechanics.situation import Situation
from fefinger.mesh.store import mesh_problem
from fefinger.results.records import Sites
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import STANDARD, Flat
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.checks import InputError, choice, instance, number, numbers, shown
from fefinger.support.progress import Stages
from fefinger.support.text import percent
from fefinger.support.vocabulary import TYPES


PRESSED, CONDENSED, MODAL = MECHANICS = ("pressed", "condensed", "modal")

SUBSTEP = 1e-4
"""Longest step in s in which modes move, by default: all modes that are kept then do."""


A_FINGER = 'a Finger, as ff.Finger.subject("a.h.")'
SOME_SITES = "end organs, as the `sites` of a result"
"""What is expected in messages."""


@dataclass(frozen=True)
class LoopOptions:
    """What a loop is made with; fields as the parameters of `ff.Loop`.

    Raises
    ------
    InputError
        For a value that cannot be, or a mechanics that cannot do what is asked.
    """

    finger: Finger
    indenter: Indenter | OwnObstacle = STANDARD
    mechanics: str = PRESSED
    deepest: float = 1.5
    reach: float | None = None
    angles: tuple[float, float] | None = None
    sites: Sites | None = None
    substep: float = SUBSTEP
    precision: Precision = "double"
    stiffening: Callable[[float], float] | None = None

    def __post_init__(self) -> None:
        """Check every option, and that the mechanics can do it."""
        instance("finger", self.finger, Finger, A_FINGER)
        if self.sites is not None:
            instance("sites", self.sites, Sites, SOME_SITES)
        law: object = self.stiffening
        if not (law is None or callable(law)):
            msg = f"stiffening: expected a function of the depth, received {shown(law)}"
            raise InputError(msg)
        choice("mechanics", self.mechanics, MECHANICS)
        choice("precision", self.precision, ("double", "single"))
        self._set("deepest", number("deepest", self.deepest, above=0, unit="mm"))
        self._set("substep", number("substep", self.substep, above=0, unit="s"))
        given: object = self.indenter
        if not (isinstance(given, OwnObstacle) or hasattr(given, "mirrored")):
            self._set("indenter", OwnObstacle(given))
        if self.angles is not None:
            self._set("angles", _range(self.angles))
        if self.reach is not None:
            self._set("reach", number("reach", self.reach, at_least=0, unit="mm"))
        elif self.angles is None and self.mechanics == CONDENSED and self._friction:
            self._set("reach", 0.0)
        for refusal in self._refusals():
            raise InputError(refusal)

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    @property
    def known(self) -> Indenter | None:
        """The object, unless it is a user's own obstacle."""
        return None if isinstance(self.indenter, OwnObstacle) else self.indenter

    @property
    def _friction(self) -> float:
        return 0.0 if self.known is None else self.known.friction

    def _refusals(self) -> Iterator[str]:
        """Yield what the mechanics cannot do of what is asked."""
        own = self.known is None
        if self.known is not None and self.known.place is not None:
            at, reach = self.known.place, max(self.known.half_sides)
            if problem := mesh_problem(self.finger, at=at, reach=reach):
                yield problem  # before the minutes that a mesh may take
        moves = self.reach is not None or self.angles is not None
        if self.mechanics != CONDENSED:
            if self.known is not None:
                for reason in friction_reasons(self.known):
                    yield f"{reason.text}; use mechanics='condensed'"
            if moves:
                name = "reach" if self.angles is None else "angles"
                yield (
                    f"{name}: expected none with mechanics={self.mechanics!r}, under which the "
                    "object moves along its axis alone; use mechanics='condensed'"
                )
            if self.stiffening is not None:
                yield "stiffening: expected none but with mechanics='condensed', received one"
        if own and (self.mechanics == PRESSED or moves):
            yield (
                "indenter: expected an ff.Indenter where the object slides or turns, and for "
                f"finite strain, received {self.indenter!r}; use mechanics='condensed' or 'modal' "
                "without `reach`"
            )
        if self.angles is not None and (self.reach is not None or self._friction):
            yield (
                "angles: expected a plate that rolls without friction and does not slide, received "
                "`reach` or friction as well; leave one of them out"
            )
        if self.known is not None and (self.mechanics == PRESSED or self.angles is not None):
            for reason in soft_reasons(self.known):
                yield f"{reason.text}; use mechanics='condensed' or 'modal' without `angles`"
        if self.known is not None and self.mechanics == MODAL:
            for reason in relaxing_object_reasons(self.known):
                yield f"{reason.text}; use mechanics='condensed'"
        if self.mechanics == PRESSED:
            fixed = separate_relaxation_reasons, elastic_hard_parts_reasons
            for reason in (each for reasons in fixed for each in reasons(self.finger)):
                yield f"{reason.text}; use the mechanics 'solid'"


def prepare(options: LoopOptions, stages: Stages) -> Prepared:
    """Prepare the contact of a loop.

    Raises
    ------
    InputError
        If the object misses the pad or leaves it before `deepest`, a site lies outside the soft
        tissue, or the tissues do not relax as one.
    ConvergenceError
        If an equilibrium of the elastic press is not reached, or the modes do not converge.
    """
    if options.mechanics == PRESSED:
        return _tabulated(options, stages)
    finger, indenter, deepest = options.finger, options.indenter, options.deepest
    if options.stiffening is None:
        _warn_of_softness(finger, _rolling_plate(options) or indenter, deepest)
    how = options.sites, options.precision, stages
    if options.mechanics == MODAL:
        return prepared.inertial(finger, indenter, deepest, *how, options.substep)
    if options.angles is not None:
        return prepared_contacts.rolled(finger, options.angles, deepest, *how)
    if options.reach is not None and options.known is not None:
        return prepared.slid(finger, options.known, deepest, options.reach, *how)
    return prepared.pressed(finger, indenter, deepest, *how)


def _tabulated(options: LoopOptions, stages: Stages) -> Prepared:
    """Prepare the tabulated press of `mechanics.pressed`: it is read, or solved once and kept."""
    finger, indenter, deepest = options.finger, options.known, options.deepest
    assert indenter is not None  # a user's own obstacle is refused
    motion = Ramp(1.0, deepest, corner=0.0)
    scene = Scene(finger=finger, indenter=indenter, motion=motion, ask=Ask(spikes=TYPES))
    name, notes = finite_strain.name, finite_strain.NOTES
    press = Press.of(scene, tabulated_press.METHOD, stages, mechanics=name, notes=notes)
    table = elastic_press.load_or_solve(press, deepest, stages)
    tabulated = tabulated_press.TabulatedPress.of(press, table)
    return prepared_contacts.prepared(tabulated, deepest, options.sites)


def _range(angles: Sequence[float]) -> tuple[float, float]:
    """Return the least and the largest of some angles of a plate in degrees."""
    angles = numbers("angles", angles, unit="degrees")
    if not angles:
        message = "angles: expected the degrees between which the plate turns, received none"
        raise InputError(message)
    turned = [Flat(angle).angle for angle in angles]
    return min(turned), max(turned)


def _rolling_plate(options: LoopOptions) -> Flat | None:
    """Return the plate amid the angles of one that rolls."""
    return None if options.angles is None else Flat(float(np.mean(options.angles)))


def _warn_of_softness(finger: Finger, indenter: Indenter | OwnObstacle, deepest: float) -> None:
    """Warn that tissue stiffens, which a finger at small strain leaves out, with the error of it.

    It is the error of the force in a press to `deepest` mm, where that is known.
    """
    if not stiffens(finger):
        return
    known = ""
    if not isinstance(indenter, OwnObstacle):
        with suppress(InputError):  # a press that no scene can have has no known error
            # Speed in mm/s of the press whose error is looked up; that of small strain does not
            # depend on it.
            speed = 10.0
            scene = Scene(finger=finger, indenter=indenter, motion=Ramp(speed, deepest))
            error, source = condensed.error(Situation.of(scene))
            if np.isfinite(error):
                wrong = f"its force at {deepest:g} mm is wrong by some {percent(error)}"
                known = f"; {wrong} ({source})"
    warnings.warn(
        f"finger.tissue: {finger.tissue or 'this tissue'} stiffens with strain, but this finger is "
        f"as soft as at first touch{known}. Use mechanics='pressed' or ff.run for it, or tissue "
        'that does not stiffen, such as tissue="maeno1998"',
        stacklevel=4,
    )
