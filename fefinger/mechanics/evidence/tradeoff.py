"""The measured presses of the trade-off, and where an object lies among them.

A plate lies among them by its angle, a ball by its curvature, of which that of the 30 degree plate
is 0. Each press holds errors over its depth, of what its mesh does ("numerical") and of what its
mechanics leaves out ("model").
"""

from collections.abc import Mapping
from functools import cache
from json import loads
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Flat, Indenter, Sphere
from fefinger.support.package_data import report


Array = NDArray[np.float64]

REPORT = "tradeoff.json"

CONTRAST = 1.1
"""Factor of the ratio of the moduli within which a finger counts as measured, a convention."""

POISSON = 0.005
"""Distance from the measured Poisson's ratios, likewise."""

LAW = "neo-hookean"

HELD = ("rigid", None, "fixed")
"""Bone, nail and cut of the fingers that were measured."""

KINDS = ("numerical", "model")

BEYOND = 1.06
"""Depth over that of the deepest press up to which its errors are taken to grow on as they did."""

MEANT = {
    "force": "the force",
    "pressure": "the highest pressure over 1 mm²",
    "area": "the contact area",
    "strain": "the strain at the end organs, as a Frobenius norm",
}
"""What errors are stated of, as far as a mechanics gives it: of the force the largest through time,
of its peak; of the rest that when the force is largest."""

STATED = tuple(MEANT)

NEAR = 2.0
"""Distance in mm of a ball from the middle of the pad within which it counts as measured."""


class Place(NamedTuple):
    """Where a press lies among the measured ones: "angle" in degrees, or "curvature" in 1/mm."""

    axis: str
    value: float


@cache
def read() -> dict[str, Any]:
    """Return the report."""
    measured: dict[str, Any] = loads(report(REPORT))
    return measured


def rules() -> dict[str, Any]:
    """Return the rules of the report."""
    found: dict[str, Any] = read()["rules"]
    return found


def place(angle: float | None, radius: float | None) -> Place:
    """Return the place of a plate by its angle, or of a ball by its radius."""
    if radius is not None:
        return Place("curvature", 1 / radius)
    assert angle is not None
    return Place("angle", angle)


def total(candidate: Mapping[str, Any], quantity: str) -> Array:
    """Return the sum (n,) of numerical and model error of a candidate in a press."""
    return np.add(candidate["numerical"][quantity], candidate["model"][quantity])


def neighbors(presses: Mapping[str, Any], where: Place) -> dict[str, float]:
    """Return the presses on either side of a place, or the one at it, with their weights.

    Beyond all, that is the last.
    """
    known: dict[str, float] = {}
    for name, row in presses.items():
        own = place(row["angle"], row["radius"])
        if own.axis == where.axis:
            known[name] = own.value
        elif where.axis == "curvature" and row["angle"] == 30:
            known[name] = 0.0
    below = [name for name in known if known[name] <= where.value]
    above = [name for name in known if known[name] >= where.value]
    if not below or not above:
        return {min(known, key=lambda name: abs(known[name] - where.value)): 1.0}
    low, high = max(below, key=known.__getitem__), min(above, key=known.__getitem__)
    if low == high:
        return {low: 1.0}
    part = (where.value - known[low]) / (known[high] - known[low])
    return {low: 1 - part, high: part}


def reach(row: Mapping[str, Any]) -> float:
    """Return the largest depth over thickness that a press was measured at."""
    return float(row["depth_mm"][-1] / row["thickness_mm"])


def interpolated(
    presses: Mapping[str, Any], candidate: str, where: Place, part: float, quantity: str = "force"
) -> tuple[float, float] | None:
    """Return numerical and model error of a quantity at a place, between those of its neighbors.

    None where no neighbor was pressed so deep; one that was not counts with those at its deepest.
    """
    weights = neighbors(presses, where)
    names = [name for name in weights if gives(presses[name], candidate, quantity)]
    if not any(part <= BEYOND * reach(presses[name]) for name in names):
        return None
    whole = sum(weights[name] for name in names)
    parts = [
        weights[name] / whole * errors_at(presses[name], candidate, part, quantity)
        for name in names
    ]
    numerical, model = np.sum(parts, axis=0).tolist()
    return numerical, model


def largest(
    presses: Mapping[str, Any], candidate: str, where: Place, part: float, quantity: str
) -> tuple[float, float] | None:
    """Return the largest errors over all measured plates for a plate, over two balls for a ball.

    An upper bound for fingers that were measured by their force alone: which points of their
    meshes bear the pressure of a rim, and how a flat pad is rounded, differs between fingers.
    """
    if interpolated(presses, candidate, where, part, quantity) is None:
        return None
    names = [name for name, row in presses.items() if row["radius"] is None]
    if where.axis == "curvature":
        names = list(neighbors(presses, where))
    rows = [presses[name] for name in names if gives(presses[name], candidate, quantity)]
    numerical, model = max(
        (errors_at(row, candidate, part, quantity) for row in rows), key=sum
    ).tolist()
    return numerical, model


def gives(row: Mapping[str, Any], candidate: str, quantity: str) -> bool:
    """Return whether a candidate gave a quantity in a press."""
    return quantity in row["candidates"].get(candidate, {}).get("model", ())


def errors_at(row: Mapping[str, Any], candidate: str, part: float, quantity: str) -> Array:
    """Return numerical and model error (2,) in a press at a depth over thickness.

    Beyond its deepest they grow on as before it, up to BEYOND.
    """
    parts = np.array(row["depth_mm"]) / row["thickness_mm"]
    known = np.array([row["candidates"][candidate][kind][quantity] for kind in KINDS])
    further = np.clip(part - parts[-1], 0.0, (BEYOND - 1) * parts[-1])
    growth = np.maximum(known[:, -1] - known[:, -2], 0.0) / (parts[-1] - parts[-2])
    return np.array([np.interp(part, parts, each) for each in known]) + growth * further


def place_of(indenter: Indenter) -> Place | None:
    """Return the place of an object among the presses, None where no press is like it."""
    if other_object(indenter):
        return None
    flat, radius = indenter.flat, indenter.ball_radius
    presses = rules()["presses"].values()
    if flat is not None:
        angles = [row["angle"] for row in presses if row["angle"] is not None]
        return place(flat.angle, None) if min(angles) <= flat.angle <= max(angles) else None
    assert radius is not None
    smallest = min(row["radius"] for row in presses if row["radius"] is not None)
    return place(None, radius) if radius >= smallest else None


def other_object(indenter: Indenter) -> str:
    """Return in which way an object is none that was pressed; empty if it is a plate or ball."""
    if indenter.flat is not None:
        tilt = indenter.flat.tilt
        return f"indenter.tilt = {tilt:g} degrees" if tilt else ""
    if indenter.ball_radius is not None:
        away = float(np.hypot(*(indenter.place or (0.0, 0.0))))
        return f"a ball {away:.2g} mm away from the middle of the pad" if away > NEAR else ""
    return f"indenter.kind = {indenter.kind!r}"


def measured_tissue(finger: Finger) -> bool:
    """Return whether the tissues of a finger are, up to one modulus, those that were measured."""
    known = rules()["tissue"]
    contrast = finger.skin.modulus / finger.subcutaneous.modulus / known["skin_over_subcutaneous"]
    layers = (finger.skin, finger.subcutaneous)
    nu = [known["poisson"][name] for name in ("skin", "subcutaneous")]
    thin, thick = known["skin_over_thickness"]
    share = (finger.skin.thickness or 0.0) / finger.thickness
    return (
        finger.surface is None
        and thin / CONTRAST <= share <= thick * CONTRAST
        and max(contrast, 1 / contrast) <= CONTRAST
        and all(abs(x.poisson - value) <= POISSON for x, value in zip(layers, nu, strict=True))
        and all(x.law == LAW and x.prony is None for x in layers)
        and finger.relaxation == "whole"
        and (finger.bone, finger.nail, finger.cut) == HELD
    )


def nearest(indenter: Indenter) -> Indenter:
    """Return the plate or ball next to one that was not pressed; another object as it is."""
    presses = rules()["presses"].values()
    if indenter.flat is not None:
        return Flat(min(indenter.flat.angle, max(row["angle"] or 0.0 for row in presses)))
    if indenter.ball_radius is not None:
        return Sphere(max(indenter.ball_radius, min(row["radius"] or np.inf for row in presses)))
    return indenter


def measured_size(finger: Finger, row: Mapping[str, Any]) -> bool:
    """Return whether a finger has the size of the one that was pressed."""
    size = (finger.width, finger.thickness, finger.pad_radius)
    return size == (row["width_mm"], row["thickness_mm"], row["pad_radius_mm"])
