"""Measure what `pressed` errs by against `solid` on the same mesh, and what it costs.

Run as `python -m fefinger.validation.pressed.measure reports`; about half an hour on one core.
Scenes that are in the report already, of the same format, are not run again.
"""

import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.empty_cache import empty_cache
from fefinger.validation.evidence.press_errors import curve, norm
from fefinger.validation.pressed.scenes import drawn
from fefinger.validation.provenance import save, saved
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
    with empty_cache():
        # No press of these angles is shipped; they share a mesh. The first compiles.
        for mesh, angle in (("coarse", 29.5), ("coarse", 30.5), ("standard", 30.5)):
            changes = {"finger.resolution": mesh, "indenter.angle": angle}
            scene = builtin.load("flat-press", changes)
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
