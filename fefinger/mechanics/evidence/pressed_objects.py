"""Objects pressed in `reports/press-mesh.json`: neighbors of an object, depths under a force."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from fefinger.mechanics.evidence.table import MAIN, PRESS_MESH, Measured, read, table
from fefinger.mechanics.press.notes import stiffens
from fefinger.results.candidate import Candidate
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import INDENTERS


PLATE = "flat-30"
"""The plate that counts as a ball without curvature."""

SAME = 1e-9
"""Relative difference below which sizes count as equal."""

NEAR = 2.0
"""Distance in mm of an object from the middle of the pad within which it counts as measured."""


@cache
def objects() -> Mapping[str, Indenter]:
    """Return the objects that were pressed, by name."""
    indenters = {}
    for label, row in read(PRESS_MESH)["rows"].items():
        fields = dict(row["indenter"])
        kind = INDENTERS[fields.pop("kind")]
        given: dict[str, Any] = {
            key: tuple(x) if isinstance(x, list) else x for key, x in fields.items()
        }
        indenters[label.partition("/")[2]] = kind(**given)
    return indenters


def neighbor_presses(indenter: Indenter) -> tuple[tuple[str, ...], str]:
    """Return the names of the measured presses next to an object; without any, the reason.

    Neighbors of a plate are plates of the next smaller and larger angle; those of a ball are balls
    of the next curvatures, the 30 degree plate having 0; those of an object with edges are all of
    its kind that are as sharp or sharper.
    """
    if indenter.flat is not None:
        return _plates(*indenter.flat)
    return _edges(indenter) if indenter.sharp else _round(indenter)


def presses_of_same_object(indenter: Indenter) -> tuple[str, ...]:
    """Return the names of the measured presses with the very same object."""
    return tuple(name for name, each in objects().items() if each == indenter)


def neighbors_without_itself(indenter: Indenter) -> tuple[str, ...]:
    """Return the measured presses next to a plate or ball, without its own; none for others."""
    where = axis_and_value(indenter)
    if where is None:
        return ()
    axis, here = where
    places = {name: value_on_axis(axis, name) for name in objects()}
    others = {name: there for name, there in places.items() if there is not None and there != here}
    return _beside(others, here)


def _plates(angle: float, tilt: float) -> tuple[tuple[str, ...], str]:
    plates = {name: each.flat for name, each in objects().items() if each.flat is not None}
    names = _beside({name: plate.angle for name, plate in plates.items() if not plate.tilt}, angle)
    if not tilt:
        return names, ""
    tilted = {name: plate.tilt for name, plate in plates.items() if plate.tilt >= abs(tilt)}
    if not tilted:
        most = max(plate.tilt for plate in plates.values())
        return (), f"indenter.tilt is measured to {most:g} degrees"
    return (*names, min(tilted, key=tilted.__getitem__)), ""


def _round(indenter: Indenter) -> tuple[tuple[str, ...], str]:
    """Return the neighboring balls of a round object, by its smallest and its largest radius."""
    balls = {
        name: 1 / each.ball_radius
        for name, each in objects().items()
        if each.ball_radius is not None and each.place is None
    }
    sharpest, away = max(balls.values()), distance(indenter)
    curvatures = [1 / radius for radius in indenter.hertzian or (indenter.least_radius,)]
    if max(curvatures) > sharpest * (1 + SAME):
        return (), f"round objects are measured to radii of {1 / sharpest:g} mm"
    curvature_by_name = balls | {PLATE: 0.0}
    names = [name for each in curvatures for name in _beside(curvature_by_name, each)]
    if away > NEAR:
        aside = {
            name: distance(each)
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
    """Return the presses by objects of the same kind that are as sharp or sharper, or blunter.

    Blunter ones unless one as sharp was pressed; of several angles, those on either side.
    """
    kind = {name: each for name, each in objects().items() if each.kind == indenter.kind}
    if not kind:
        return (), f"no object of kind {indenter.kind!r} was pressed"
    sharper = {name: each for name, each in kind.items() if _as_sharp(each, indenter)}
    if not sharper:
        sharp = min(kind.values(), key=lambda each: each.narrowest)
        return (), (
            f"objects of kind {indenter.kind!r} are measured to widths of {sharp.narrowest:g} mm "
            f"and radii of {sharp.least_radius:.3g} mm"
        )
    plate = indenter.plate
    if distance(indenter) > NEAR:
        return (), f"objects with edges are measured to {NEAR:g} mm from the middle of the pad"
    same = any(_as_sharp(indenter, each) for each in sharper.values())
    blunter = () if same else tuple(kind.keys() - sharper.keys())
    if plate is None:
        return (*sharper, *blunter), ""
    angles = {name: each.plate.angle for name, each in sharper.items() if each.plate is not None}
    if plate.tilt or not min(angles.values()) <= plate.angle <= max(angles.values()):
        low, high = min(angles.values()), max(angles.values())
        return (), f"they are measured at angles of {low:g} to {high:g} degrees, without tilt"
    return (*_beside(angles, plate.angle), *blunter), ""


def _as_sharp(one: Indenter, other: Indenter) -> bool:
    """Whether an object with edges is as sharp as another, or sharper."""
    radius, width = other.least_radius * (1 + SAME), other.narrowest * (1 + SAME)
    return one.least_radius <= radius and one.narrowest <= width


def _beside(values: Mapping[str, float], value: float) -> tuple[str, ...]:
    """Return the names on either side of a value, or at it; beyond all values, the last."""
    return tuple(dict.fromkeys((_last(values, value, -1), _last(values, value, 1))))


def _last(values: Mapping[str, float], value: float, side: int) -> str:
    """Return the name nearest to a value on one side of it; without any, the nearest of all."""
    there = [name for name, each in values.items() if side * (each - value) >= -SAME]
    return min(there or values, key=lambda name: abs(values[name] - value))


def tilted_or_off_center(indenter: Indenter) -> bool:
    """Whether an object is tilted, or away from the middle of the pad."""
    return distance(indenter) > NEAR or bool(indenter.plate is not None and indenter.plate.tilt)


def distance(indenter: Indenter) -> float:
    """Return the distance in mm of an object from the middle of the pad."""
    return float(np.hypot(*(indenter.place or (0.0, 0.0))))


def axis_and_value(indenter: Indenter) -> tuple[str, float] | None:
    """Return the axis on which an object is interpolated, and its value there; None without one.

    The axis of a plate is "angle" in degrees, that of a ball "curvature" in 1/mm, on which the 30
    degree plate has 0. Objects that are tilted or off center, and all others, have none.
    """
    if tilted_or_off_center(indenter):
        return None
    if indenter.flat is not None:
        return "angle", indenter.flat.angle
    if indenter.ball_radius is not None and indenter.place is None:
        return "curvature", 1 / indenter.ball_radius
    return None


def value_on_axis(axis: str, name: str) -> float | None:
    """Return the value of a pressed object on an axis; None if it has none."""
    if (axis, name) == ("curvature", PLATE):
        return 0.0
    place = axis_and_value(objects()[name])
    return place[1] if place is not None and place[0] == axis else None


def curves(finger: Finger, indenter: Indenter) -> tuple[Measured, ...]:
    """Return the force over the depth in presses of the finger's tissue by objects like this one.

    Without a press of that tissue, those of MAIN, whose tissue stiffens in nearly the same way;
    without any object like it, the press by the plate of the subjects.
    """
    forces = table().presses(PRESS_MESH, "force", Candidate("solid"))
    tissue = library.fitted_to(finger.tissue) or (MAIN if stiffens(finger) else library.PUBLISHED)
    names, _ = neighbor_presses(indenter)
    for owner in (tissue, MAIN) if stiffens(finger) else (tissue,):
        presses = [forces[f"{owner}/{name}"] for name in names if f"{owner}/{name}" in forces]
        if presses:
            return tuple(presses)
    return (forces[f"{tissue}/{PLATE}"],)


def under_force(finger: Finger, force: float, measured: Sequence[Measured]) -> float:
    """Return the largest depth over the thickness under a force in N, by curves of presses.

    Forces scale with the modulus and the square of the size. Beyond the largest force the depth is
    extrapolated linearly, an upper bound.
    """
    return max(_under(finger, force, each) for each in measured)


def _under(finger: Finger, force: float, measured: Measured) -> float:
    assert measured.depth is not None
    stiffer = finger.subcutaneous.modulus / measured.conditions["subcutaneous_kPa"]
    thickness = float(measured.conditions["thickness_mm"])
    scaled = force / stiffer / (finger.thickness / thickness) ** 2
    forces, depths = np.array([0.0, *measured.values]), np.array([0.0, *measured.depth])
    beyond = max(scaled - forces[-1], 0.0)
    slope = (depths[-1] - depths[-2]) / (forces[-1] - forces[-2])
    return float(np.interp(scaled, forces, depths) + slope * beyond) / thickness
