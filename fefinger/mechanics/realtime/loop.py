"""What fingers in real time share: base, result of a step, a warning of soft tissue."""

import math
import warnings
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fefinger.fem.condensation import Operator
from fefinger.fem.contact.obstacle import Rigid
from fefinger.mechanics import condensed
from fefinger.mechanics.press import operator, problem
from fefinger.mechanics.press.notes import friction_reasons, stiffens
from fefinger.mechanics.press.reference import reference_press
from fefinger.mechanics.situation import Situation
from fefinger.neural.reference import Reference
from fefinger.neural.streaming import Afferents, RecordedAfferents
from fefinger.results.records import Sites
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice, number
from fefinger.support.text import counted, percent
from fefinger.support.vocabulary import FAMILIES


SPEED = 10.0
"""Speed in mm/s of the press whose error is looked up; that of small strain does not depend on
it."""


@dataclass(slots=True)
class Step:
    """Result of a step; the arrays are those of the finger, and change with its next step.

    depth mm, force N, x and y mm of the center of pressure (nan without contact); pressure (n,) kPa
    at the candidate vertices, strain (n_sites, 6), positive in tension, with the components xx yy
    zz xy yz xz of the tensor. contact_area mm²: of `Condensed` the summed area of the vertices
    under pressure, which jumps with each of them, where `Response.contact_area` follows the rim
    within an element.
    """

    depth: float
    force: float
    contact_area: float
    x: float
    y: float
    pressure: Array
    strain: NDArray[np.floating]

    @classmethod
    def at_rest(cls, pressure: Array, strain: NDArray[np.floating]) -> Self:
        """Return the result of no step, on the arrays of a finger."""
        return cls(0.0, 0.0, 0.0, np.nan, np.nan, pressure, strain)

    def __repr__(self) -> str:
        """Show the numbers with their units, not the arrays."""
        x, y = (round(each, 4) + 0.0 for each in (self.x, self.y))
        name, force = type(self).__name__, f"{self.force:.4g} N at {self.depth:.4g} mm"
        return f"<{name}: {force}, {self.contact_area:.4g} mm² about x {x:g}, y {y:g} mm>"


class Loop:
    """Base of the fingers in real time: their checks, their text and their afferents.

    finger; deepest: depth in mm that the pad has to answer; solid: the body that is solved; sites:
    the end organs at which the strain is read; shown: what its text says besides.
    """

    solid: Operator
    sites: Sites
    shown: tuple[str, ...] = ()

    def __init__(self, finger: object, deepest: float) -> None:
        """Check finger and depth, which all take; InputError as of the class."""
        if not isinstance(finger, Finger):
            msg = f'finger: expected a Finger, as ff.Finger.subject("a.h."), received {finger!r}'
            raise InputError(msg)
        self.finger = finger
        self.deepest = number("deepest", deepest, above=0, unit="mm")

    def __repr__(self) -> str:
        """Show finger, object, depth and end organs, not the arrays."""
        finger, touched = self.finger, getattr(self, "indenter", None)
        who = finger.subject_name or f"{finger.width:g} x {finger.thickness:g} mm"
        under = f", under {touched}" if touched is not None else ""
        organs = f"strain at {counted(self.sites.types)}"
        parts = "; ".join([f"to {self.deepest:g} mm", *self.shown, organs])
        tissue = f"{finger.tissue or 'own'} tissue, {finger.mesh} mesh"
        return f"<{type(self).__name__}: finger {who}, {tissue}{under}; {parts}>"

    def afferents(
        self, *, family: str = FAMILIES[0], **options: Any
    ) -> Afferents | RecordedAfferents:
        """Return the units of the sites, to be stepped with the strain of every step.

        Family "thesis": one per site, `options` as for `neural.streaming.Afferents`, scaled by a
        reference press. "recorded": those of the sites, `options` as for
        `neural.streaming.RecordedAfferents`. InputError for another family, or as these.
        """
        sites = self.sites
        if choice("family", family, FAMILIES) == "recorded":
            types = sites.types
            if sites.unit is not None:
                types = tuple(types[i] for i in np.unique(sites.unit, return_index=True)[1])
            return RecordedAfferents(types, sites.normals, unit=sites.unit, **options)
        return Afferents.of(sites.types, sites.normals, self._reference(), **options)

    def _reference(self) -> Reference:
        """Return the press that scales the strain at the sites for units of the thesis."""
        ask = Ask(spikes=tuple(dict.fromkeys(self.sites.types)))
        plate = problem.reference_plate(self.finger, self.solid, ask)
        return reference_press(self.solid, plate, operator.METHOD)


def check_frictionless(indenter: Indenter) -> None:
    """Raise InputError for friction, which a finger that is only pressed leaves out."""
    for reason in friction_reasons(indenter):
        raise InputError(f"{reason.text}; use ff.Sliding")


def quick_number(name: str, value: Any, least: float = -math.inf, *, unit: str) -> float:
    """Check a finite number of at least `least` as `checks.number`, in no time if it is one."""
    if isinstance(value, float) and least <= value < math.inf and value > -math.inf:
        return value
    return number(name, value, at_least=None if least == -math.inf else least, unit=unit)


def warn_of_softness(finger: Finger, indenter: Indenter | Rigid, deepest: float) -> None:
    """Warn that tissue stiffens, which a finger at small strain leaves out, with the error of it.

    The error is that of the force in a press to `deepest` mm, where it is known.
    """
    if not stiffens(finger):
        return
    known = ""
    if not isinstance(indenter, Rigid):
        with suppress(InputError):  # a press that no scene can have has no known error
            scene = Scene(finger=finger, indenter=indenter, motion=Ramp(SPEED, deepest))
            error, source = condensed.error(Situation.of(scene))
            if np.isfinite(error):
                wrong = f"its force at {deepest:g} mm is wrong by some {percent(error)}"
                known = f"; {wrong} ({source})"
    warnings.warn(
        f"finger.tissue: {finger.tissue or 'this tissue'} stiffens with strain, but this finger is "
        f"as soft as at first touch{known}. Use ff.Pressed or ff.run for it, or tissue that does "
        'not stiffen, such as tissue="maeno1998"',
        stacklevel=3,
    )
