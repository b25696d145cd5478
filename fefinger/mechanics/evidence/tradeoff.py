"""Force of the measured presses of the trade-off, and the neighbors of an object among them.

Plates are compared by their angle, balls by their curvature, where the 30 degree plate has 0. They
tell how deep a scene goes under a given force, and what tissue counts as measured.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fefinger.mechanics.evidence import table
from fefinger.mechanics.evidence.table import Measured
from fefinger.results.candidate import Candidate
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter


REPORT = table.TRADEOFF

CONTRAST = 1.1
"""Factor of the ratio of the moduli within which a finger counts as measured, a convention."""

POISSON = 0.005
"""Distance from the measured Poisson's ratios, likewise."""

LAW = "neo-hookean"

HELD = ("rigid", None, "fixed")
"""Bone, nail and cut of the fingers that were measured."""

BEYOND = 1.06
"""Depth over that of the deepest press up to which the errors there count."""

STATED = ("force", "pressure", "area", "strain")
"""Quantities with stated errors: of the force the largest error through time over the peak, of the
others (highest pressure over 1 mm², contact area, strain at the end organs as a Frobenius norm)
the error when the force is largest."""

NEAR = 2.0
"""Distance in mm of a ball from the middle of the pad within which it counts as measured."""


class Place(NamedTuple):
    """Axis of comparison and value: "angle" in degrees, or "curvature" in 1/mm."""

    axis: str
    value: float


def forces() -> dict[str, Measured]:
    """Return the force of `solid` over the depth, by press."""
    return table.table().presses(REPORT, "force", Candidate("solid"))


def _sizes(name: str) -> list[float]:
    """Return the angles, or the radii, of the objects of the presses."""
    values = [press.conditions[name] for press in forces().values()]
    return [value for value in values if value is not None]


def place(angle: float | None, radius: float | None) -> Place:
    """Return the axis and value of a plate with an angle, or of a ball with a radius."""
    if radius is not None:
        return Place("curvature", 1 / radius)
    assert angle is not None
    return Place("angle", angle)


def neighbors(where: Place) -> tuple[str, ...]:
    """Return the presses on either side of a place, or the one at it; beyond all, the last one."""
    known: dict[str, float] = {}
    for name, press in forces().items():
        angle, radius = press.conditions["angle"], press.conditions["radius"]
        own = place(angle, radius)
        if own.axis == where.axis:
            known[name] = own.value
        elif where.axis == "curvature" and angle == 30:
            known[name] = 0.0
    below = [name for name in known if known[name] <= where.value]
    above = [name for name in known if known[name] >= where.value]
    if not below or not above:
        return (min(known, key=lambda name: abs(known[name] - where.value)),)
    sides = max(below, key=known.__getitem__), min(above, key=known.__getitem__)
    return tuple(dict.fromkeys(sides))


def place_of(indenter: Indenter) -> Place | None:
    """Return axis and value of an object; None without comparable presses."""
    if not _plate_or_ball(indenter):
        return None
    flat, radius = indenter.flat, indenter.ball_radius
    if flat is not None:
        angles = _sizes("angle")
        return place(flat.angle, None) if min(angles) <= flat.angle <= max(angles) else None
    assert radius is not None
    return place(None, radius) if radius >= min(_sizes("radius")) else None


def _plate_or_ball(indenter: Indenter) -> bool:
    """Whether an object is a plate without tilt, or a ball near the middle of the pad."""
    if indenter.flat is not None:
        return not indenter.flat.tilt
    away = float(np.hypot(*(indenter.place or (0.0, 0.0))))
    return indenter.ball_radius is not None and away <= NEAR


def measured_tissue(finger: Finger) -> bool:
    """Whether the tissues of a finger are, but for a common factor, those that were measured."""
    known = next(iter(forces().values())).conditions["tissue"]
    contrast = finger.skin.modulus / finger.subcutaneous.modulus / known["skin_over_subcutaneous"]
    layers = (finger.skin, finger.subcutaneous)
    nu = [known["poisson"][name] for name in ("skin", "subcutaneous")]
    thin, thick = known["skin_over_thickness"]
    share = (finger.skin.thickness or 0.0) / finger.thickness
    return (
        finger.surface is None
        and (finger.tip_tissue, finger.tip_radius) == (None, None)
        and thin / CONTRAST <= share <= thick * CONTRAST
        and max(contrast, 1 / contrast) <= CONTRAST
        and all(abs(x.poisson - value) <= POISSON for x, value in zip(layers, nu, strict=True))
        and all(x.law == LAW and x.prony is None for x in layers)
        and finger.relaxation == "whole"
        and (finger.bone, finger.nail, finger.cut) == HELD
    )


def soft_skin(finger: Finger) -> bool:
    """Whether the skin is softer, against the tissue below it, than that of the presses."""
    known = next(iter(forces().values())).conditions["tissue"]["skin_over_subcutaneous"]
    return finger.skin.modulus / finger.subcutaneous.modulus < known / CONTRAST


def published(finger: Finger) -> Finger:
    """Return a finger of the measured tissue, with the size and the modulus below the skin of one.

    The skin is as thick as its own, within the measured range.
    """
    known = next(iter(forces().values())).conditions["tissue"]
    tissues = library.tissue_set(library.PUBLISHED)
    stiffer = finger.subcutaneous.modulus / tissues.subcutaneous.modulus
    thin, thick = (share * finger.thickness for share in known["skin_over_thickness"])
    skin, below = (
        replace(layer, modulus=stiffer * layer.modulus)
        for layer in (tissues.skin, tissues.subcutaneous)
    )
    return Finger(
        finger.width,
        finger.thickness,
        pad_radius=finger.pad_radius,
        tissue=library.PUBLISHED,
        skin=replace(skin, thickness=min(max(finger.skin.thickness or 0.0, thin), thick)),
        subcutaneous=below,
        prony=finger.prony,
        resolution=finger.resolution,
    )
