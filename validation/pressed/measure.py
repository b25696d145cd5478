"""Measure what `pressed` errs by against `solid` on the same mesh, and what it costs.

Run as `python -m fefinger.validation.pressed.measure reports`; about half an hour on one core.
Scenes that are in the report already, of the same format, are not run again. The scenes are four
draws, the deep built-in scenes, and light touches.
"""

import sys
import time
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.empty_cache import empty_cache
from fefinger.validation.evidence.press_errors import curve, norm
from fefinger.validation.provenance import save, saved
from numpy.random import Generator
from scipy.spatial import cKDTree

from fefinger.mechanics import pressed, solid
from fefinger.mechanics.press.problem import Press
from fefinger.mechanics.press.tabulated_press import (
    METHOD,
    TabulatedPress,
    table_of,
    tabulated_response,
)
from fefinger.mechanics.pressed import retreats
from fefinger.results.records import Response
from fefinger.scene import builtin
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.library import calibrated_name
from fefinger.scene.motion import Motion
from fefinger.scene.motions import RampHold, RampSinusoid, Sinusoid, Trapezoid
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.progress import Stages


TABULATION = "pressed-error.json"

TABULATION_SETS = ("rules", "held-out", "deep", "standard", "built-in", "light")
"""Sets of scenes in which `pressed` was compared with `solid`: four draws, built-in ones, and light
touches that retreat."""

SAME_PLACE = 1e-9
"""Distance in mm of points of the pad that are one."""


def compared(scene: Scene) -> dict[str, Any]:
    """Return the errors of `pressed` in a scene, as fractions; or the reason of a refusal."""
    row: dict[str, Any] = {
        "scene": {key: value for key, value in scene.to_dict().items() if key != "ask"},
        "part": scene.motion.peak / scene.finger.thickness,
        "relaxing": 1.0 - scene.finger.prony.long_time,
        "retreats": retreats(scene.motion),
    }
    try:
        true = solid.respond(scene)
    except (InputError, ConvergenceError) as error:
        return row | {"refused": str(error)}
    row["part"] = float(true.depth.max()) / scene.finger.thickness
    by_force = scene.motion.by_force
    row |= errors(true, pressed.respond(scene), by_force)
    if not by_force:
        phases = errors(true, relaxed_as_one(scene), by_force)
        row["relaxed as one"] = {
            phase: phases[phase]["force"] for phase in ("loading", "retreat") if phases[phase]
        }
    return row


def relaxed_as_one(scene: Scene) -> Response:
    """Answer a scene with a force that relaxes as at small strain: a work ratio of 1."""
    stages = Stages()
    press = Press.of(scene, METHOD, stages, mechanics=pressed.name, notes=())
    table = table_of(press, stages)
    tabulated = TabulatedPress.of(press, replace(table, work=np.ones_like(table.work)))
    return tabulated_response(tabulated, tabulated.along(press.time), stages)


def errors(true: Response, quick: Response, by_force: bool) -> dict[str, Any]:
    """Return the errors at the largest force, and the largest through time, in two phases.

    "peak": of highest pressure over 1 mm², area and strain when the force is largest; "loading" and
    "retreat": the largest until the indenter first retreats, and after, of the peak of each.
    Force (or depth, where the force is prescribed); strain as a Frobenius norm over the end organs;
    pressure in L2 over the pad.
    """
    names = ("depth",) if by_force else ("force",)
    quantities = {name: (getattr(true, name), getattr(quick, name)) for name in names}
    quantities["area"] = (true.contact_area, quick.contact_area)
    quantities["strain"] = (true.strain, quick.strain)
    quantities["pressure in L2"] = (true.pressure, _on_pad(quick, true))
    quantities["pressure"] = (curve(true, "pressure"), curve(quick, "pressure"))
    top = int(np.argmax(true.force))
    back = np.flatnonzero(np.diff(true.depth) < 0)
    turn = len(true.time) if not len(back) or by_force else int(back[0]) + 1
    errors_by_phase: dict[str, Any] = {"peak": {}, "loading": {}, "retreat": {}}
    for name, (right, wrong) in quantities.items():
        apart, size = norm(wrong - right), norm(right)
        errors_by_phase["peak"][name] = float(apart[top] / size[top])
        errors_by_phase["loading"][name] = float(apart[:turn].max() / size.max())
        if turn < len(true.time):
            errors_by_phase["retreat"][name] = float(apart[turn:].max() / size.max())
    return errors_by_phase


def _on_pad(response: Response, other: Response) -> Array:
    """Return the pressure of a response at the points of another pad of the same finger."""
    assert response.pad is not None
    assert other.pad is not None
    assert response.pressure is not None
    assert other.pressure is not None
    distance, at = cKDTree(other.pad.points).query(response.pad.points)
    shared, out = distance < SAME_PLACE, np.zeros_like(other.pressure)
    out[:, at[shared]] = response.pressure[:, shared]
    return out


def costs() -> dict[str, Any]:
    """Return CPU seconds on half a finger of a.h., by mesh: of a new press, and of a scene."""
    from fefinger.scene import builtin

    rows = {}
    # No press of these angles is shipped; they share a mesh. The first compiles.
    for mesh, angle in (("coarse", 29.5), ("coarse", 30.5), ("standard", 30.5)):
        changes = {"finger.resolution": mesh, "indenter.angle": angle}
        scene = builtin.load("flat-press", changes)
        with empty_cache():
            build, response = _timed(scene)
            again, _ = _timed(scene)
        steps = response.seconds["motion"] / len(response.time)
        rows[mesh] = {
            "build_seconds": build - again,
            "setup_seconds": again - response.seconds["motion"],
            "step_seconds": steps,
        }
    return rows


def _timed(scene: Scene) -> tuple[float, Response]:
    started = time.process_time()
    response = pressed.respond(scene)
    return time.process_time() - started, response


def main(folder: Path) -> None:
    """Measure all sets and the costs, and write the report after each scene."""
    path = folder / TABULATION
    before = saved(path)
    report = {key: before.get(key, {}) for key in (*TABULATION_SETS, "costs")}
    for name in TABULATION_SETS:
        for scene in drawn(name):
            if scene.name not in report[name]:
                report[name][scene.name] = compared(scene)
                save(path, _short(report))
                print(scene.name, report[name][scene.name].get("loading"), flush=True)
    report["costs"] = costs()
    save(path, _short(report))


def _short(value: Any) -> Any:
    """Round all numbers of a report to five digits."""
    if isinstance(value, dict):
        return {key: _short(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_short(each) for each in value]
    return float(f"{value:.5g}") if isinstance(value, float) else value


if __name__ == "__main__":
    main(Path(sys.argv[1]))


BUILT_IN = ("press-to-1N", "flat-sinusoid", "p5-quasi-static-array", "p9-ramp-hold-retract")
"""Built-in scenes deeper than 0.16 of the thickness: under the plate at 30 degrees, on a.h."""

SEEDS = {"rules": 24_01, "held-out": 24_02, "deep": 24_03, "standard": 24_04}
COUNTS = {"rules": 30, "held-out": 48, "deep": 8, "standard": 20}
STANDARD = {"rules": 2, "held-out": 4, "deep": 0, "standard": 20}
"""How many scenes of each set, the last, are on the standard mesh; others are on the coarse one."""

SUBJECTS = ("a.h.", "d.p.", "d.s.", "p.w.")
PUBLISHED = ("maeno1998", "saal2017")
KINDS = ("ramp-hold", "trapezoid", "ramp-sinusoid", "sinusoid", "force-ramp-hold")

PARTS = {
    "rules": (0.05, 0.16),
    "held-out": (0.05, 0.16),
    "deep": (0.16, 0.24),
    "standard": (0.05, 0.16),
}
"""Least and largest depth over the thickness of the finger."""

SPEED = (0.2, 500.0)
"""Least and largest speed in mm/s."""

OBJECTS: tuple[Indenter, ...] = (Flat(30), Sphere(5.0))
LIGHT, LIGHT_SPEEDS = (0.02, 0.03, 0.05, 0.07), (5.0, 20.0, 100.0)
"""Objects, depths over the thickness and speeds in mm/s of the light touches: few or no scenes are
drawn at these depths."""


def drawn(name: str) -> list[Scene]:
    """Return the scenes of a set, the same each time.

    "built-in" and "light" ones are on the coarse mesh.
    """
    if name == "built-in":
        coarse_mesh = {"finger.resolution": "coarse"}
        ask = Ask(fields=False)
        return [replace(builtin.load(each, coarse_mesh), ask=ask) for each in BUILT_IN]
    if name == "light":
        return [_light(*each) for each in product(OBJECTS, LIGHT, LIGHT_SPEEDS)]
    rng = np.random.default_rng(SEEDS[name])
    scenes = [_scene(rng, f"{name} {number}", PARTS[name]) for number in range(COUNTS[name])]
    coarse = COUNTS[name] - STANDARD[name]
    meshes = ["coarse"] * coarse + ["standard"] * STANDARD[name]
    return [
        replace(scene, finger=replace(scene.finger, resolution=mesh))
        for scene, mesh in zip(scenes, meshes, strict=True)
    ]


def _light(indenter: Indenter, part: float, speed: float) -> Scene:
    """Return a light touch on the coarse finger of a.h. that retreats after a short hold."""
    finger = Finger.subject("a.h.", resolution="coarse")
    motion = Trapezoid(speed, part * finger.thickness, hold=0.2)
    name = f"light {indenter.kind} {part:g} {speed:g}"
    return Scene(name=name, finger=finger, indenter=indenter, motion=motion, ask=Ask(fields=False))


def _scene(rng: Generator, name: str, part: tuple[float, float]) -> Scene:
    subject = str(rng.choice(SUBJECTS))
    calibrated = rng.random() < 0.75
    tissue = calibrated_name(subject) if calibrated else str(rng.choice(PUBLISHED))
    finger = Finger.subject(subject, tissue=tissue)
    indenter = _indenter(rng)
    deepest = float(rng.uniform(*part)) * finger.thickness
    motion = _motion(rng, str(rng.choice(KINDS)), deepest)
    return Scene(name=name, finger=finger, indenter=indenter, motion=motion, ask=Ask(fields=False))


def _indenter(rng: Generator) -> Indenter:
    """Return a plate within the angles of the shipped meshes, or a ball in their middle."""
    if rng.random() < 0.6:
        return Flat(angle=round(float(rng.uniform(23.0, 37.0)), 1))
    return Sphere(radius=round(float(rng.uniform(3.5, 8.0)), 1))


def _motion(rng: Generator, kind: str, deepest: float) -> Motion:
    speed = float(np.exp(rng.uniform(*np.log(SPEED))))
    hold = float(np.exp(rng.uniform(np.log(0.05), np.log(3.0))))
    if kind == "ramp-hold":
        return RampHold(speed=speed, depth=deepest, hold=hold)
    if kind == "trapezoid":
        return Trapezoid(speed=speed, depth=deepest, hold=hold)
    share = float(rng.uniform(0.1, 0.5))
    frequency = float(np.exp(rng.uniform(np.log(0.5), np.log(8.0))))
    if kind == "ramp-sinusoid":
        return RampSinusoid(
            speed=speed,
            depth=deepest * (1 - share),
            amplitude=deepest * share,
            frequency=frequency,
            cycles=2,
        )
    if kind == "sinusoid":
        return Sinusoid(amplitude=deepest / 2, frequency=frequency, cycles=2)
    return RampHold(
        loading_rate=float(np.exp(rng.uniform(np.log(0.2), np.log(5.0)))),
        force=float(rng.uniform(0.2, 1.0)),
        hold=hold,
    )
