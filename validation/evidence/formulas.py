"""Compare the elastic force of closed formulas and of the lumped law with presses at finite strain.

Run as `python -m fefinger.validation.evidence.formulas reports`, in seconds: the presses are those
of `press-mesh.json`, `tradeoff.json` and `solid-force.json`.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from fefinger.validation.evidence.press_mesh import MEASUREMENTS
from fefinger.validation.evidence.solid import REPORT as SOLID
from fefinger.validation.provenance import compact, provenance
from fefinger.validation.tradeoff import scenes

from fefinger.mechanics import get
from fefinger.mechanics.evidence.formulas import CALIBRATED
from fefinger.mechanics.evidence.pressed_objects import place
from fefinger.mechanics.evidence.table import FORMULAS, LUMPED, PRESS_MESH, TRADEOFF, read
from fefinger.mechanics.situation import Situation
from fefinger.scene import library
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.theory.lumped.spring import Spring
from fefinger.theory.relaxation import Prony


MAIN = "a.h."


class Pressed(NamedTuple):
    """A press at finite strain: finger, object, depths (n,) in mm and forces (n,) in N."""

    subject: str
    tissue: str
    finger: Finger
    indenter: Indenter
    depth: Array
    force: Array


def presses() -> Iterator[Pressed]:
    """Give the presses by plates, and by balls in the middle of the pad."""
    for name, row in read(PRESS_MESH)["rows"].items():
        measured = MEASUREMENTS[name]
        if "refused" not in row:
            tissue = measured.tissue or CALIBRATED
            yield _pressed(measured.subject, tissue, measured.finger, measured.indenter, row)
    for name, row in read(TRADEOFF)["rules"]["presses"].items():
        yield _published(MAIN, scenes.BASE[name].indenter, row, row["force_N"])
    for name, row in read(SOLID)["rows"].items():
        subject, _, object_ = name.partition("/")
        known = {"flat-30": Flat(30), "sphere-5": Sphere(5)}
        if subject != MAIN and object_ in known:
            yield _published(subject, known[object_], row, row["force_N"]["solid"])


def _published(subject: str, indenter: Indenter, row: dict[str, Any], force: Any) -> Pressed:
    finger = Finger.subject(subject, tissue=library.PUBLISHED)
    both = {"depth_mm": row["depth_mm"], "force_N": force}
    return _pressed(subject, library.PUBLISHED, finger, indenter, both)


def _pressed(
    subject: str, tissue: str, finger: Finger, indenter: Indenter, row: dict[str, Any]
) -> Pressed:
    depth, force = (np.array(row[key], float) for key in ("depth_mm", "force_N"))
    known = np.isfinite(force) & (force > 0)
    return Pressed(subject, tissue, finger, indenter, depth[known], force[known])


def ratios(pressed: Pressed) -> dict[str, list[float]]:
    """Return the log ratios (n,) of the force of each formula that is able to answer."""
    finger = replace(pressed.finger, prony=Prony((1.0,), ()))
    scene = Scene(
        finger=finger,
        indenter=pressed.indenter,
        motion=Ramp(60.0, float(pressed.depth[-1]), corner=0.0),
        ask=Ask(pressure=False, strain=False, fields=False),
    )
    found = {}
    for name in ("hertz", "layered"):
        try:
            if any(each.about == "ability" for each in get(name).refuse(Situation.of(scene))):
                continue
            response = get(name).respond(scene)
        except InputError:  # wider than its radius
            continue
        found[name] = np.interp(pressed.depth, response.depth, response.force)
    lumped = _lumped(pressed)
    if lumped is not None:
        found["lumped"] = lumped
    return {name: _short(np.log(force / pressed.force)) for name, force in found.items()}


def _lumped(pressed: Pressed) -> Array | None:
    """Return the relaxed force (n,) by the law of a finger: of Table 2.1, or as identified."""
    if pressed.tissue == CALIBRATED:
        row = library.pawluk_bulk()[pressed.subject]
        spring = Spring(row.b * row.prony.long_time, row.m)
    else:
        flat = pressed.indenter.flat
        laws = {(row["subject"], row["angle"]): row for row in read(LUMPED)["rows"]}
        law = laws.get((pressed.subject, flat.angle)) if flat is not None else None
        if law is None:
            return None
        spring = Spring(law["b"], law["m"])
    return np.array([float(spring.force(depth)) for depth in pressed.depth])


def _row(pressed: Pressed) -> dict[str, Any]:
    finger, flat = pressed.finger, pressed.indenter.flat
    where = dict([place(pressed.indenter) or ("", 0.0)])
    curvature = 0.0 if flat == (30.0, 0.0) else where.get("curvature")
    return {
        "subject": pressed.subject,
        "tissue": pressed.tissue,
        "angle": where.get("angle"),
        "curvature": curvature,
        "size_mm": [finger.width, finger.thickness, finger.pad_radius],
        "thickness_mm": finger.thickness,
        "subcutaneous_kPa": finger.subcutaneous.modulus,
        "depth_mm": _short(pressed.depth),
        "force_N": _short(pressed.force),
        "log_ratio": ratios(pressed),
    }


def _short(values: Array) -> list[float]:
    return [float(f"{value:.4g}") for value in values]


def _label(pressed: Pressed) -> str:
    axis, where = place(pressed.indenter) or ("", 0.0)
    object_ = f"flat-{where:g}" if axis == "angle" else f"sphere-{1 / where:g}"
    return f"{pressed.tissue}, {pressed.subject}, {object_}"


def report() -> dict[str, Any]:
    """Return the report: a row for every press."""
    rows = {_label(each): _row(each) for each in presses() if place(each.indenter) is not None}
    return provenance("python -m fefinger.validation.evidence.formulas reports") | {"rows": rows}


if __name__ == "__main__":
    text = compact(report())
    (Path(sys.argv[1]) / FORMULAS).write_text(text, encoding="utf-8")
