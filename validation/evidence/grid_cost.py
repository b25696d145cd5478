"""Measure what answers of `layered` on a grid cost, and write the report that the planner reads.

Run as `python -m fefinger.validation.evidence.grid_cost reports`, some two minutes of one core.
"""

import math
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from fefinger.validation.evidence.cost_table import GRID
from fefinger.validation.provenance import save

from fefinger.mechanics import layered
from fefinger.mechanics.evidence import costs
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.scene import builtin
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Bar, Flat, Pin
from fefinger.scene.motions import RampHold
from fefinger.scene.scene import Scene
from fefinger.scene.texts import Braille
from fefinger.scene.textured import Dots, Grating
from fefinger.scene.tissue import Ridges


SOFT = Finger.subject("a.h.", tissue="maeno1998")

HELD: tuple[tuple[Indenter, bool], ...] = (
    (Bar(3.0, corner=0.5), False),
    (Pin(2.0), False),
    (Braille("a"), False),
    (Grating(3.0, 1.5, 0.4, edge=0.2), False),
    (Flat(), True),
    (Bar(3.0, corner=0.5, friction=0.4), False),
    (Flat(friction=0.4), True),
)
"""Objects that press for 0.3 s, and whether the skin has ridges."""

SLID = (
    ("slide-dots", 4.0, 0.0, False, 1.0),
    ("slide-dots", 8.0, 0.0, False, 0.5),
    ("slide-dots", 3.0, 0.0, True, 1.0),
    ("slide-letters", 4.0, 0.0, False, 1.0),
    ("slide-grating", 4.0, 0.0, False, 1.0),
    ("slide-dots", 3.0, 0.4, False, 1.0),
    ("slide-dots", 1.5, 0.4, True, 1.0),
)
"""Scenes with their path in mm, coefficient of friction, ridges, and spacing of units in mm."""


def pressed(finger: Finger, indenter: Indenter, hold: float) -> Scene:
    """Return a press that is held for some s."""
    ask = Ask(fields=False, spikes=("SAI", "FAI"))
    motion = RampHold(20, 0.6, hold=hold)
    return Scene(finger=finger, indenter=indenter, motion=motion, ask=ask)


def scenes() -> dict[str, Scene]:
    """Return the scenes by name."""
    found = {}
    for indenter, ridges in HELD:
        finger = replace(SOFT, ridges=Ridges() if ridges else None)
        name = f"{indenter.kind}, friction {indenter.friction:g}, ridges {ridges}"
        found[name] = pressed(finger, indenter, 0.3)
    for scene, path, friction, ridges, apart in SLID:
        changes = {
            "motion.distance": path,
            "indenter.friction": friction,
            "ask.population.spacing": apart,
        }
        asked = builtin.load(scene, changes)
        finger = replace(asked.finger, ridges=Ridges() if ridges else None)
        name = f"{scene}, {path:g} mm, friction {friction:g}, ridges {ridges}"
        found[name] = replace(asked, finger=finger)
    return found


def row(scene: Scene) -> dict[str, Any]:
    """Return the CPU seconds of an answer, and the work that it was."""
    started = time.process_time()
    response = layered.respond(scene)
    spent = time.process_time() - started
    feature = scene.indenter.feature if scene.motion.slides else math.inf
    return {
        "points": int(response.numbers["grid_points"]) ** 2,
        "steps": len(time_grid(scene.motion, fast=False, feature=feature)),
        "friction": bool(scene.indenter.friction),
        "organs": costs.organs(scene.ask) if scene.ask.population is not None else 0,
        "times": len(response.time),
        "seconds": round(spent, 3),
    }


def main(folder: Path) -> None:
    """Write the report; the first answers compile."""
    for indenter in (Bar(3.0, corner=0.5), Bar(3.0, corner=0.5, friction=0.4), Dots(3.0)):
        layered.respond(pressed(SOFT, indenter, 0.01))
    rows = {}
    for name, scene in scenes().items():
        rows[name] = row(scene)
        print(name, rows[name], flush=True)  # progress
    save(folder / GRID, {"rows": rows})


if __name__ == "__main__":
    main(Path(sys.argv[1]))
