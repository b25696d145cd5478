"""Errors measured under many objects: of the mesh at finite strain, and of all that is cheaper.

`reports/press-mesh.json` holds presses of the calibrated fingers, in which finite strain on each
mesh is compared with a finer one; and presses of published tissue under objects that the trade-off
does not have, in which every mechanics is compared with finite strain. A scene has the largest
error of the presses that its object lies between, at its depth over the thickness of the finger.
"""

import math
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from fefinger.mechanics.evidence import reached_depth
from fefinger.mechanics.evidence.table import PRESS_MESH, Measured, read, table
from fefinger.mechanics.evidence.tradeoff import BEYOND, NEAR
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.scene import library
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import INDENTERS
from fefinger.support.text import percent


MAIN = "a.h."
"""Subject whose finger was pressed by every object."""

SAME = 1e-9
"""Relative difference of sizes that are the same."""


class Known(NamedTuple):
    """An error and its source; not a number where it is not known, and the source says why."""

    error: float
    source: str


UNKNOWN = Known(math.nan, "not known: it was not measured")


def error(candidate: Candidate, case: Situation, quantity: str = "force") -> Known:
    """Return the measured error of a quantity: of finite strain that of its mesh."""
    names, reason = between(case.indenter)
    parts = _presses(candidate, case, quantity, names)
    if len(parts) < len(names) and _aside(case.indenter):
        parts = []  # the missing press is the one that is like it
    flat = case.indenter.flat
    if flat is not None and not flat.tilt and not _deep_enough(parts):
        parts = _presses(candidate, case, quantity, around(flat.angle)) or parts
    if not parts:
        return Known(math.nan, f"not known: {reason or 'nothing like it was pressed'}")
    if not _deep_enough(parts):
        press, part = max(parts, key=lambda each: each[0].part[-1])
        return Known(
            math.nan,
            f"not known: it goes to {part:.2g} of the finger's thickness, and presses like it were "
            f"measured to {press.part[-1]:.2g}",
        )
    finite, subject = MECHANICS[candidate.mechanics].finite, _subject(case)
    largest = max(_largest(press, part) for press, part in parts)
    others = any(press.press.partition("/")[0] != subject for press, _ in parts)
    margin = _other_fingers(candidate, quantity) if finite and others else 0.0
    pressed = " and ".join(press.press for press, _ in parts)
    source = f"reports/{PRESS_MESH}, {pressed}: {percent(largest)}"
    if margin:
        source += f", and {percent(margin)} for another finger"
    return Known(largest + margin, source)


def _aside(indenter: Indenter) -> bool:
    """Return whether an object is tilted, or away from the middle of the pad."""
    away = float(np.hypot(*(indenter.place or (0.0, 0.0)))) > NEAR
    return away or bool(indenter.plate is not None and indenter.plate.tilt)


def _subject(case: Situation) -> str:
    """Return the subject whose calibrated finger is that of the scene; "" for others."""
    return (case.finger.subject_name or "") if reached_depth.calibrated(case.finger) else ""


def _presses(
    candidate: Candidate, case: Situation, quantity: str, names: Iterable[str]
) -> list[tuple[Measured, float]]:
    """Return the presses of some objects, and the depth over thickness that a scene is in each."""
    finite = MECHANICS[candidate.mechanics].finite
    tissue = MAIN if finite else library.PUBLISHED
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    found = []
    for name in names:
        own, label = f"{_subject(case)}/{name}", f"{tissue}/{name}"
        press = presses.get(own) if finite and own in presses else presses.get(label)
        if press is not None:
            found.append((press, _reached(press, case)))
    return found


def _deep_enough(parts: list[tuple[Measured, float]]) -> bool:
    return any(part <= BEYOND * press.part[-1] for press, part in parts)


def _reached(press: Measured, case: Situation) -> float:
    """Return the depth of a scene over the thickness, by the force of a press."""
    force = table().presses(PRESS_MESH, "force", Candidate("solid"))[press.press]
    return case.depth_over_thickness(force)


def _largest(press: Measured, part: float) -> float:
    """Return the error of a press at a depth over thickness: constant beyond those measured."""
    return float(np.interp(part, press.part, press.values))


@cache
def _other_fingers(candidate: Candidate, quantity: str) -> float:
    """Return by how much the error was larger in the presses of other fingers, at most."""
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    more = [0.0]
    for name, press in presses.items():
        subject, _, object_ = name.partition("/")
        main = presses.get(f"{MAIN}/{object_}")
        if main is not None and subject not in (MAIN, library.PUBLISHED):
            parts = press.part[press.part <= main.part[-1]]
            more += [_largest(press, part) - _largest(main, part) for part in parts]
    return max(more)


@cache
def objects() -> Mapping[str, Indenter]:
    """Return the objects that were pressed, by name."""
    found = {}
    for label, row in read(PRESS_MESH)["rows"].items():
        found[label.partition("/")[2]] = _object(row["indenter"])
    return found


def _object(fields: Mapping[str, Any]) -> Indenter:
    given: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value
        for key, value in fields.items()
        if key != "kind"
    }
    return INDENTERS[fields["kind"]](**given)


def between(indenter: Indenter) -> tuple[tuple[str, ...], str]:
    """Return the names of the presses that an object lies between, and why there are none.

    A plate lies between plates by its angle, a ball by its curvature, of which that of the 30
    degree plate is 0; an object with edges is like those of its kind that are as sharp or sharper.
    """
    if indenter.flat is not None:
        return _plates(indenter)
    if not indenter.sharp:
        return _round(indenter)
    return _edges(indenter)


def around(angle: float) -> tuple[str, ...]:
    """Return the plates next to an angle in degrees on either side, without one at it."""
    plates = {
        name: each.flat.angle
        for name, each in objects().items()
        if each.flat is not None and not each.flat.tilt
    }
    return _beside({name: own for name, own in plates.items() if own != angle}, angle)


def _plates(indenter: Indenter) -> tuple[tuple[str, ...], str]:
    assert indenter.flat is not None
    angle, tilt = indenter.flat
    plates = {name: each.flat for name, each in objects().items() if each.flat is not None}
    names = _beside({name: own.angle for name, own in plates.items() if not own.tilt}, angle)
    if not tilt:
        return names, ""
    tilted = {name: own.tilt for name, own in plates.items() if own.tilt >= abs(tilt)}
    if not tilted:
        most = max(own.tilt for own in plates.values())
        return (), f"indenter.tilt is measured to {most:g} degrees"
    return (*names, min(tilted, key=tilted.__getitem__)), ""


def _round(indenter: Indenter) -> tuple[tuple[str, ...], str]:
    """Return the balls next to a round object, by its smallest and its largest radius."""
    balls = {
        name: 1 / each.ball_radius
        for name, each in objects().items()
        if each.ball_radius is not None and each.place is None
    }
    sharpest, away = max(balls.values()), float(np.hypot(*(indenter.place or (0.0, 0.0))))
    curvatures = [1 / radius for radius in indenter.hertzian or (indenter.least_radius,)]
    if max(curvatures) > sharpest * (1 + SAME):
        return (), f"round objects are measured to radii of {1 / sharpest:g} mm"
    known = balls | {"flat-30": 0.0}
    names = [name for each in curvatures for name in _beside(known, each)]
    if away > NEAR:
        aside = {
            name: float(np.hypot(*each.place))
            for name, each in objects().items()
            if each.ball_radius is not None and each.place is not None
        }
        far = [name for name, each in aside.items() if each >= away * (1 - SAME)]
        if not far:
            most = max(aside.values(), default=NEAR)
            return (), f"round objects are measured to {most:g} mm from the middle of the pad"
        names.append(min(far, key=aside.__getitem__))
    if indenter.ball_radius is None:
        names += [
            name
            for name, each in objects().items()
            if each.kind == indenter.kind and each.least_radius <= indenter.least_radius
        ]
    return tuple(dict.fromkeys(names)), ""


def _edges(indenter: Indenter) -> tuple[tuple[str, ...], str]:
    """Return the presses by objects of a kind that are as sharp or sharper, at angles around."""
    kind = {name: each for name, each in objects().items() if each.kind == indenter.kind}
    if not kind:
        return (), f"no object of kind {indenter.kind!r} was pressed"
    sharper = {
        name: each
        for name, each in kind.items()
        if each.least_radius <= indenter.least_radius * (1 + SAME)
        and each.narrowest <= indenter.narrowest * (1 + SAME)
    }
    if not sharper:
        sharp = min(kind.values(), key=lambda each: each.narrowest)
        return (), (
            f"objects of kind {indenter.kind!r} are measured to widths of {sharp.narrowest:g} mm "
            f"and radii of {sharp.least_radius:.3g} mm"
        )
    plate, place = indenter.plate, indenter.place
    if place is not None and float(np.hypot(*place)) > NEAR:
        return (), f"objects with edges are measured to {NEAR:g} mm from the middle of the pad"
    if plate is None:
        return tuple(sharper), ""
    angles = {name: each.plate.angle for name, each in sharper.items() if each.plate is not None}
    if plate.tilt or not min(angles.values()) <= plate.angle <= max(angles.values()):
        low, high = min(angles.values()), max(angles.values())
        return (), f"they are measured at angles of {low:g} to {high:g} degrees, without tilt"
    return _beside(angles, plate.angle), ""


def _beside(known: Mapping[str, float], value: float) -> tuple[str, ...]:
    """Return the names on either side of a value, or those at it; the last beyond all."""
    return tuple(dict.fromkeys((_last(known, value, -1), _last(known, value, 1))))


def _last(known: Mapping[str, float], value: float, side: int) -> str:
    """Return the name next to a value on one side of it, or the nearest of all."""
    there = [name for name, each in known.items() if side * (each - value) >= -SAME]
    candidates: Iterable[str] = there or known
    return min(candidates, key=lambda name: abs(known[name] - value))
