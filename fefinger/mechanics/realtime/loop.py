"""What fingers in real time share: the result of a step, units, text, a warning of soft tissue."""

import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fefinger.fem.contact.obstacle import Rigid
from fefinger.mechanics import condensed
from fefinger.mechanics.press.notes import friction_reasons, stiffens
from fefinger.mechanics.situation import Situation
from fefinger.neural.recorded_streaming import RecordedAfferents
from fefinger.neural.reference import Reference
from fefinger.neural.streaming import Afferents
from fefinger.results.records import Sites
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice
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

    def __repr__(self) -> str:
        """Show the numbers with their units, not the arrays."""
        x, y = (round(each, 4) + 0.0 for each in (self.x, self.y))
        name, force = type(self).__name__, f"{self.force:.4g} N at {self.depth:.4g} mm"
        return f"<{name}: {force}, {self.contact_area:.4g} mm² about x {x:g}, y {y:g} mm>"


def check_finger(finger: object) -> None:
    """Raise InputError for what is no Finger, such as the name of a subject."""
    if not isinstance(finger, Finger):
        msg = f'finger: expected a Finger, as ff.Finger.subject("a.h."), received {finger!r}'
        raise InputError(msg)


def check_frictionless(indenter: Indenter) -> None:
    """Raise InputError for friction, which a finger that is only pressed leaves out."""
    for reason in friction_reasons(indenter):
        raise InputError(f"{reason.text}; use ff.Sliding")


def units(
    sites: Sites, reference: Callable[[], Reference], *, family: str = FAMILIES[0], **options: Any
) -> Afferents | RecordedAfferents:
    """Return the units of sites, of a family of afferents.

    "thesis": one per site, `options` as for `neural.streaming.Afferents`, scaled by a `reference`
    press. "recorded": those of the sites, `options` as for
    `neural.recorded_streaming.RecordedAfferents`. InputError for an unknown family, or as these.
    """
    if choice("family", family, FAMILIES) == "recorded":
        types = sites.types
        if sites.unit is not None:
            types = tuple(types[i] for i in np.unique(sites.unit, return_index=True)[1])
        return RecordedAfferents(types, sites.normals, unit=sites.unit, **options)
    return Afferents.of(sites.types, sites.normals, reference(), **options)


def described(loop: Any, *more: str) -> str:
    """Text of a finger in real time: finger, object, depth, end organs, and `more` about it."""
    finger, touched = loop.finger, getattr(loop, "indenter", None)
    who = finger.subject_name or f"{finger.width:g} x {finger.thickness:g} mm"
    under = f", under {touched}" if touched is not None else ""
    organs = f"strain at {counted(loop.sites.types)}"
    parts = "; ".join([f"to {loop.deepest:g} mm", *more, organs])
    tissue = f"{finger.tissue or 'own'} tissue, {finger.mesh} mesh"
    return f"<{type(loop).__name__}: finger {who}, {tissue}{under}; {parts}>"


def warn_of_softness(finger: Finger, indenter: Indenter | Rigid, deepest: float) -> None:
    """Warn that tissue stiffens, which a finger at small strain leaves out, with the error of it.

    The error is that of the force in a press to `deepest` mm, where it is known.
    """
    if not stiffens(finger):
        return
    number = ""
    if not isinstance(indenter, Rigid):
        with suppress(InputError):  # a press that no scene can have has no known error
            scene = Scene(finger=finger, indenter=indenter, motion=Ramp(SPEED, deepest))
            error, source = condensed.error(Situation.of(scene))
            if np.isfinite(error):
                wrong = f"its force at {deepest:g} mm is wrong by some {percent(error)}"
                number = f"; {wrong} ({source})"
    warnings.warn(
        f"finger.tissue: {finger.tissue or 'this tissue'} stiffens with strain, but this finger is "
        f"as soft as at first touch{number}. Use ff.Pressed or ff.run for it, or tissue that does "
        'not stiffen, such as tissue="maeno1998"',
        stacklevel=3,
    )
