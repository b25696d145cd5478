"""What the reports have measured of each mechanics: the source of its stated cost and error."""

import json
from functools import cache
from typing import Any

from fefinger.data import report
from fefinger.mechanics._symmetry import symmetric
from fefinger.mechanics._timeline import time_grid
from fefinger.scene import Scene


LINEAR_STRAIN = 0.5
"""Depth over half the thickness of the finger, beyond which small strain is refused for accuracy.
A convention of the field's rule of thumb (mean compression of a quarter), until finite strain
measures it."""

LINEAR_REPORT = "linear-mesh.json"

WHOLE = 3.0
"""Cost of a whole finger against half of one: twice the unknowns and loads, a larger factor."""


@cache
def linear() -> dict[str, Any]:
    """Return the mesh convergence and timing of `linear`, by resolution."""
    measured: dict[str, Any] = json.loads(report(LINEAR_REPORT))["resolutions"]
    return measured


def linear_seconds(scene: Scene) -> float:
    """Return the expected wall time of `linear` in s, from the times in the report."""
    row = linear()[scene.finger.resolution]
    steps = len(time_grid(scene.motion, fast="FAII" in scene.ask.spikes))
    setup = float(row["setup_seconds"]) * (1.0 if symmetric(scene) else WHOLE)
    return setup + steps * float(row["step_seconds"])


def linear_error(scene: Scene) -> tuple[float, str]:
    """Return the measured error of the force against the extrapolated mesh, and its source."""
    row = linear()[scene.finger.resolution]
    return float(row["force_error"]), f"reports/{LINEAR_REPORT} (mesh only, not the model)"
