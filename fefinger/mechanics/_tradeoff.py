"""The measured trade-off between speed and accuracy: stated errors and costs of every candidate.

A scene is placed between the presses of `reports/tradeoff.json`: a plate by its angle, a ball by
its curvature, of which that of the 30 degree plate is 0; and by its depth over the thickness of
the finger. The stated error is interpolated between the neighbors, numerical and model error
added, times the margin that the report has for what lies between.
"""

from collections.abc import Mapping
from functools import cache
from json import loads
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fefinger.data import report
from fefinger.scene import Finger, Flat, Scene, Sphere


Array = NDArray[np.float64]

REPORT = "tradeoff.json"

CONTRAST = 1.1
"""Factor of the ratio of the moduli within which a finger counts as measured, a convention."""

POISSON = 0.005
"""Distance from the measured Poisson's ratios, likewise."""

LAW = "neo-hookean"

NEAR = 2.0
"""Distance in mm of a ball from the middle of the pad within which it counts as measured."""


class Place(NamedTuple):
    """Where a press lies among the measured ones: "angle" in degrees, or "curvature" in 1/mm."""

    axis: str
    value: float


class Stated(NamedTuple):
    """A stated error: its parts, the margin that their sum is multiplied by, and the source."""

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


def neighbors(presses: Mapping[str, Any], where: Place) -> list[tuple[str, float]]:
    """Return the presses on either side of a place, with the weight of each; beyond, the last."""
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
        end = below or above
        return [(min(end, key=lambda name: abs(known[name] - where.value)), 1.0)] if end else []
    low, high = max(below, key=known.__getitem__), min(above, key=known.__getitem__)
    if low == high:
        return [(low, 1.0)]
    part = (where.value - known[low]) / (known[high] - known[low])
    return [(low, 1 - part), (high, part)]


def reach(row: Mapping[str, Any]) -> float:
    """Return the largest depth over thickness that a press was measured at."""
    return float(row["depth_mm"][-1] / row["thickness_mm"])


def predicted(
    presses: Mapping[str, Any], candidate: str, where: Place, part: float, kind: str = ""
) -> float | None:
    """Return the error of the force between the presses, None where there is none so deep.

    `kind` is "numerical" or "model"; without it, their sum. A neighbor that was not pressed so
    deep, or that the candidate refused, leaves the other one to tell.
    """
    found: list[tuple[float, float]] = []
    for name, weight in neighbors(presses, where):
        row = presses[name]
        if candidate not in row["candidates"] or part > reach(row) * (1 + 1e-9):
            continue
        own = row["candidates"][candidate]
        errors = own[kind]["force"] if kind else total(own, "force")
        parts = np.array(row["depth_mm"]) / row["thickness_mm"]
        found.append((float(np.interp(part, parts, errors)), weight))
    weights = sum(weight for _, weight in found)
    if weights <= 0:
        return None
    return sum(error * weight for error, weight in found) / weights


def where(scene: Scene) -> Place | None:
    """Return the place of a scene, None where no press is like it."""
    indenter = scene.indenter
    if isinstance(indenter, Flat) and not indenter.tilt:
        place_, known = Place("angle", indenter.angle), "angle"
    elif isinstance(indenter, Sphere) and np.hypot(*(indenter.at or (0.0, 0.0))) <= NEAR:
        place_, known = Place("curvature", 1 / indenter.radius), "radius"
    else:
        return None
    values = [row[known] for row in rules()["presses"].values() if row[known] is not None]
    value = indenter.angle if isinstance(indenter, Flat) else indenter.radius
    beyond = value > max(values) and known == "angle"
    return None if value < min(values) or beyond else place_


def like(finger: Finger) -> bool:
    """Return whether the tissues of a finger are, up to one modulus, those that were measured."""
    known = rules()["tissue"]
    contrast = finger.skin.modulus / finger.subcutaneous.modulus / known["skin_over_subcutaneous"]
    layers = (finger.skin, finger.subcutaneous)
    nu = [known["poisson"][name] for name in ("skin", "subcutaneous")]
    return (
        finger.surface is None
        and max(contrast, 1 / contrast) <= CONTRAST
        and all(abs(x.poisson - value) <= POISSON for x, value in zip(layers, nu, strict=True))
        and all(x.law == LAW and x.prony is None for x in layers)
        and finger.relaxation == "whole"
    )


def part(scene: Scene, press: str) -> float:
    """Return depth over thickness, of a motion under force control when the finger has crept.

    Forces scale with the modulus and the square of the size.
    """
    thickness = scene.finger.thickness
    if scene.motion.control == "depth":
        return scene.motion.peak / thickness
    row = rules()["presses"][press]
    stiffer = scene.finger.subcutaneous.modulus / row["subcutaneous_kPa"]
    larger = (thickness / row["thickness_mm"]) ** 2
    parts = np.array([0.0, *row["depth_mm"]]) / row["thickness_mm"]
    wanted = scene.motion.peak / stiffer / larger
    return float(np.interp(wanted, [0.0, *row["force_N"]], parts, right=np.inf))


def stated(candidate: str, scene: Scene) -> Stated | None:
    """Return the stated error of the force; None where the scene is not like a measured press."""
    place_ = where(scene)
    if place_ is None or not like(scene.finger):
        return None
    presses = rules()["presses"]
    names = [name for name, _ in neighbors(presses, place_)]
    deep = max(part(scene, name) for name in names)
    parts = [predicted(presses, candidate, place_, deep, kind) for kind in ("numerical", "model")]
    numerical, model = parts
    if numerical is None or model is None:
        return None
    margin = float(rules()["margins"][candidate])
    source = (
        f"reports/{REPORT}, {' and '.join(names)}: {numerical:.2g} of the mesh, {model:.2g} of "
        f"the model, margin {margin:.3g}"
    )
    return Stated((numerical + model) * margin, numerical, model, source)
