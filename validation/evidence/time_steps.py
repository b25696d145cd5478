"""Measure what shorter time steps change; write the report that stated errors read.

Run as `python -m fefinger.validation.evidence.time_steps reports`, some minutes. The finger of
a.h. on the coarse mesh is pressed by the plate at 30 degrees: fast and deep with a hold, and by a
sinusoid that unloads to first touch. An error is the larger of the two.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.evidence.press_errors import curve, norm
from fefinger.validation.provenance import save

from fefinger.mechanics.evidence.stated_errors import STATED
from fefinger.mechanics.evidence.table import TIME_STEPS
from fefinger.mechanics.press import finite_strain, small_strain
from fefinger.results.candidate import MECHANICS
from fefinger.results.records import Response
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.motion import Motion
from fefinger.scene.motions import RampHold, Sinusoid
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array


MOTIONS: tuple[Motion, ...] = (RampHold(60.0, 1.5, hold=1.0), Sinusoid(0.5, 2.0, 2))

REFINED = {"linear": 4, "solid": 2}
"""By how much the time steps of each mechanics are divided."""


def row(mechanics: str) -> dict[str, float]:
    """Return the errors of what is stated by the time steps of a mechanics."""
    errors = [
        changes(respond(mechanics, motion), respond(mechanics, motion, REFINED[mechanics]))
        for motion in MOTIONS
    ]
    return {name: float(f"{max(each[name] for each in errors):.3g}") for name in STATED}


def respond(mechanics: str, motion: Motion, refine: int = 1) -> Response:
    """Return the response to a motion, with time steps that are divided by `refine`."""
    solver = finite_strain if MECHANICS[mechanics].finite else small_strain
    return solver.respond(_scene(motion), mechanics=mechanics, notes=(), refine=refine)


def changes(response: Response, finer: Response) -> dict[str, float]:
    """Return the relative errors against a response with finer steps.

    Of the force the largest through time, of its peak; of the rest that when the force is largest.
    """
    top = int(np.argmax(finer.force))
    force = np.interp(finer.time, response.time, response.force)
    errors = {"force": float(np.abs(force - finer.force).max() / finer.force.max())}
    for name in STATED[1:]:
        ours, true = (_at(each, name, float(finer.time[top])) for each in (response, finer))
        errors[name] = float(norm(ours - true)[0] / norm(true)[0])
    return errors


def _at(response: Response, name: str, time: float) -> Array:
    """Return a quantity (1, m) of a response at a time."""
    values = curve(response, name).reshape(len(response.time), -1)
    return np.array([[np.interp(time, response.time, column) for column in values.T]])


def _scene(motion: Motion) -> Scene:
    finger = Finger.subject("a.h.", resolution="coarse")
    ask = Ask(pressure=True, strain=True, fields=False)
    return Scene(finger=finger, indenter=Flat(30), motion=motion, ask=ask)


def report() -> dict[str, Any]:
    """Return the report; `condensed` has the time steps of `linear`."""
    rows = {name: row(name) for name in REFINED}
    rows["condensed"] = rows["linear"]
    return {"rows": rows}


if __name__ == "__main__":
    save(Path(sys.argv[1]) / TIME_STEPS, report())
