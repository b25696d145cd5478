"""The measured trade-off between speed and accuracy: stated errors and costs of every candidate.

A scene is placed between the presses of `reports/tradeoff.json`: a plate by its angle, a ball by
its curvature, of which that of the 30 degree plate is 0; and by its depth over the thickness of
the finger. The stated error lies between those of its neighbors, numerical and model error added,
with margins for what lies between presses, for motions, for other fingers and for the draw of the
mesh. So it is for the force and for what else is STATED.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import cache
from json import loads
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fefinger.mechanics.evidence import reached_depth
from fefinger.mechanics.evidence.mesh_scatter import DRAWN, scatter
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Flat, Indenter, Sphere
from fefinger.scene.motion import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.package_data import report
from fefinger.support.text import percent


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

FARTHEST = 1.25
"""Depth over that of the deepest press beyond which what other reports tell is not taken either.

At 30 degrees the forces of `solid` on the coarse and the standard mesh are 0.7 % apart there, 1 %
above it and 1.3 % at 1.58."""

PRESSED = "a.h."
"""Subject on whose finger the presses are."""

NEAR = 2.0
"""Distance in mm of a ball from the middle of the pad within which it counts as measured."""


class Place(NamedTuple):
    """Where a press lies among the measured ones: "angle" in degrees, or "curvature" in 1/mm."""

    axis: str
    value: float


class Stated(NamedTuple):
    """A stated error with its margins, its two parts, and the source."""

    error: float
    numerical: float
    model: float
    source: str


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


def told(
    presses: Mapping[str, Any], candidate: str, where: Place, part: float, quantity: str = "force"
) -> tuple[float, float] | None:
    """Return numerical and model error of a quantity at a place, between those of its neighbors.

    None where no neighbor was pressed so deep; one that was not tells what it was at its deepest.
    """
    weights = neighbors(presses, where)
    names = [name for name in weights if gives(presses[name], candidate, quantity)]
    if not any(part <= BEYOND * reach(presses[name]) for name in names):
        return None
    whole = sum(weights[name] for name in names)
    parts = [weights[name] / whole * at(presses[name], candidate, part, quantity) for name in names]
    numerical, model = np.sum(parts, axis=0).tolist()
    return numerical, model


def worst(
    presses: Mapping[str, Any], candidate: str, where: Place, part: float, quantity: str
) -> tuple[float, float] | None:
    """Return the errors that the worst of all plates tells of a plate, or of two balls of a ball.

    So it is on fingers of which no press is known but by its force: which points of their meshes
    bear the pressure of a rim, and how a flat pad is rounded, is their own.
    """
    if told(presses, candidate, where, part, quantity) is None:
        return None
    names = [name for name, row in presses.items() if row["radius"] is None]
    if where.axis == "curvature":
        names = list(neighbors(presses, where))
    rows = [presses[name] for name in names if gives(presses[name], candidate, quantity)]
    numerical, model = max((at(row, candidate, part, quantity) for row in rows), key=sum).tolist()
    return numerical, model


def gives(row: Mapping[str, Any], candidate: str, quantity: str) -> bool:
    """Return whether a candidate gave a quantity in a press."""
    return quantity in row["candidates"].get(candidate, {}).get("model", ())


def at(row: Mapping[str, Any], candidate: str, part: float, quantity: str) -> Array:
    """Return numerical and model error (2,) in a press at a depth over thickness.

    Beyond its deepest they grow on as before it, up to BEYOND.
    """
    parts = np.array(row["depth_mm"]) / row["thickness_mm"]
    known = np.array([row["candidates"][candidate][kind][quantity] for kind in KINDS])
    further = np.clip(part - parts[-1], 0.0, (BEYOND - 1) * parts[-1])
    growth = np.maximum(known[:, -1] - known[:, -2], 0.0) / (parts[-1] - parts[-2])
    return np.array([np.interp(part, parts, each) for each in known]) + growth * further


def where(scene: Scene) -> Place | None:
    """Return the place of a scene, None where no press is like it."""
    if _other(scene.indenter):
        return None
    flat, radius = scene.indenter.flat, scene.indenter.ball_radius
    presses = rules()["presses"].values()
    if flat is not None:
        angles = [row["angle"] for row in presses if row["angle"] is not None]
        return place(flat.angle, None) if min(angles) <= flat.angle <= max(angles) else None
    assert radius is not None
    smallest = min(row["radius"] for row in presses if row["radius"] is not None)
    return place(None, radius) if radius >= smallest else None


def _other(indenter: Indenter) -> str:
    """Return in which way an object is none that was pressed; empty if it is a plate or ball."""
    if indenter.flat is not None:
        tilt = indenter.flat.tilt
        return f"indenter.tilt = {tilt:g} degrees" if tilt else ""
    if indenter.ball_radius is not None:
        away = float(np.hypot(*(indenter.place or (0.0, 0.0))))
        said = f"a ball {away:.2g} mm away from the middle of the pad"
        return said if away > NEAR else ""
    return f"indenter.kind = {indenter.kind!r}"


def unlike(scene: Scene) -> str:
    """Return in which way a scene that has no stated error is like no press of the report."""
    said = _other(scene.indenter)
    if said:
        return said
    if where(scene) is None:
        flat = scene.indenter.flat
        plate = f"a plate at {flat.angle:g} degrees" if flat is not None else ""
        return plate or f"a ball of {scene.indenter.ball_radius:g} mm"
    if not like(scene.finger):
        surface = scene.finger.surface is not None
        return f"a finger {'from a surface' if surface else 'of other tissue, bone or nail'}"
    return "a press so deep, or its object on this mesh"


def like(finger: Finger) -> bool:
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


def part(scene: Scene, press: str) -> float:
    """Return depth over thickness, of a motion under force control when the finger has crept."""
    row = rules()["presses"][press]
    return reached_depth.part(scene, row, row["force_N"])


def stated(candidate: str, scene: Scene, quantity: str = "force") -> Stated | None:
    """Return the stated error of a quantity.

    None where the scene is not like a measured press, or the candidate does not give it.
    """
    place_ = where(scene)
    if place_ is None or not like(scene.finger):
        return None
    known, mechanics = rules(), candidate.split()[0]
    names = list(neighbors(known["presses"], place_))
    deepest = max(part(scene, name) for name in names)
    own = _own(scene.finger, known["presses"][names[0]])
    tell = told if own or quantity == "force" else worst
    found = tell(known["presses"], candidate, place_, deepest, quantity)
    if found is None:
        return None
    numerical = found[0] + known["steps"][mechanics][quantity]
    model = found[1] * known["directs"][mechanics][quantity]
    model *= known["fingers"][mechanics] if quantity == "force" and not own else 1.0
    margins = known["margins"][candidate][quantity]
    margin = moving(margins["motion"], names) * sum(found)
    margin += 0.0 if own and len(names) == 1 else margins["between"]
    margin += DRAWN * scatter(candidate, deepest, quantity)
    source = (
        f"reports/{REPORT}, {' and '.join(names)}: {percent(numerical)} of mesh and steps, "
        f"{percent(model)} of the model, {percent(margin)} of margin"
    )
    return Stated(numerical + model + margin, numerical, model, source)


def moving(shares: Mapping[str, float], names: Collection[str]) -> float:
    """Return by which share presses tell too little of motions: the largest of all, if unknown."""
    known = names if all(name in shares for name in names) else shares
    return max((shares[name] for name in known), default=0.0)


def others(candidate: str, scene: Scene) -> dict[str, float]:
    """Return the stated errors of what is STATED beside the force, as far as they are known."""
    found = {quantity: stated(candidate, scene, quantity) for quantity in STATED[1:]}
    return {quantity: each.error for quantity, each in found.items() if each is not None}


def spikes(candidate: str, scene: Scene) -> dict[str, float]:
    """Return how far spikes were off at worst in the base scenes, of one unit of each type.

    "spike count": missing or extra ones over all, relative; "first spike": in s. Empty for a scene
    that is like no press.
    """
    if where(scene) is None or not like(scene.finger):
        return {}
    alike = candidate.replace("fine", "standard")
    rows = [each["candidates"].get(alike, {}).get("spikes") for each in read()["scenes"].values()]
    known = [row for row in rows if row]
    if not known:
        return {}
    first = max(row["first_ms"] for row in known if row["first_ms"] is not None)
    return {"spike count": max(row["count"] for row in known), "first spike": 1e-3 * first}


def instead(candidate: str, scene: Scene, error: float, source: str) -> tuple[float, str]:
    """Return an error that another report tells, with those of steps and motions; and the reason.

    That was measured under another object, or of another finger: no margin is known for that. It
    is no smaller than what is stated of the nearest plate or ball that was pressed. Not a number
    far beyond the depths of the presses.
    """
    deep, deepest = _deep(scene)
    if deep > FARTHEST * deepest and math.isfinite(error):
        return float("nan"), (
            f"not known: it goes to {deep:.2g} of the finger's thickness, and presses like it were "
            f"measured to {deepest:.2g}"
        )
    mechanics, margins = candidate.split()[0], rules()["margins"]
    own = (each["force"]["motion"] for name, each in margins.items() if mechanics in name.split())
    shares = [share for each in own for share in each.values()]
    error = error * (1 + max(shares, default=0.0)) + rules()["steps"][mechanics]["force"]
    near = stated(candidate, replace(scene, indenter=_nearest(scene.indenter)))
    if near is not None and near.error > error:
        error, source = near.error, near.source
    least = _least(candidate, scene)
    if least is not None and least.error > error:
        error, source = least.error, least.source
    return error, f"{source} (reports/{REPORT} has none for {unlike(scene)})"


def _least(candidate: str, scene: Scene) -> Stated | None:
    """Return what is stated of the measured press that is next to a scene, as deep or nearly so.

    Nothing that is known less of has a smaller error, and no smaller margins.
    """
    nearest = _nearest(scene.indenter)
    pressed = nearest.flat is not None or nearest.ball_radius is not None
    indenter = nearest if pressed else Flat(30)
    own = replace(scene, finger=Finger.subject(PRESSED), indenter=indenter)
    at = where(own)
    if at is None:
        return None
    presses = rules()["presses"]
    names = neighbors(presses, at)
    deep = min(*(part(scene, name) for name in names), *(reach(presses[name]) for name in names))
    motion = Ramp(60.0, deep * own.finger.thickness, corner=0.0)
    return stated(candidate, replace(own, motion=motion))


def _deep(scene: Scene) -> tuple[float, float]:
    """Return depth over thickness, and that of the deepest press next to the scene's.

    Of an object unlike all plates and balls, those of all presses.
    """
    presses = rules()["presses"]
    at = where(replace(scene, indenter=_nearest(scene.indenter)))
    names = neighbors(presses, at) if at is not None else presses
    press = max(names, key=lambda name: reach(presses[name]))
    return part(scene, press), reach(presses[press])


def _nearest(indenter: Indenter) -> Indenter:
    """Return the plate or ball next to one that was not pressed; another object as it is."""
    presses = rules()["presses"].values()
    if indenter.flat is not None:
        return Flat(min(indenter.flat.angle, max(row["angle"] or 0.0 for row in presses)))
    if indenter.ball_radius is not None:
        return Sphere(max(indenter.ball_radius, min(row["radius"] or np.inf for row in presses)))
    return indenter


def _own(finger: Finger, row: Mapping[str, Any]) -> bool:
    """Return whether a finger has the size of the one that was pressed."""
    size = (finger.width, finger.thickness, finger.pad_radius)
    return size == (row["width_mm"], row["thickness_mm"], row["pad_radius_mm"])
