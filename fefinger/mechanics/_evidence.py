"""What the reports have measured of each mechanics: the source of its stated cost and error."""

import json
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fefinger.data import report
from fefinger.mechanics._symmetry import symmetric
from fefinger.mechanics._timeline import time_grid
from fefinger.scene import (
    Bar,
    Cylinder,
    Ellipsoid,
    Flat,
    Grating,
    Indenter,
    Relief,
    Scene,
    Sphere,
)


LINEAR_STRAIN = 0.5
"""Depth over half the thickness of the finger, beyond which small strain is refused for accuracy.
A convention of the field's rule of thumb (mean compression of a quarter), until finite strain
measures it."""

LINEAR_RADIUS = 2.0
"""Radius of an indenter in mm below which the mesh error of `linear` has not been measured."""

LINEAR_EDGE = 0.5
"""Radius of an edge, ridge or crest in mm below which the mesh error has not been measured."""

LINEAR_REPORT = "linear-mesh.json"

LAYERED_REPORT = "layered-force.json"

SOLID_REPORT = "solid-force.json"

SOLID_SUBJECT = "a.h."
"""The subject on whose finger the errors of `solid` and `linear` are measured."""

LAYERED_PRESSES = {"sphere-2": 2.0, "sphere-5": 5.0, "flat-30": float("inf")}
"""Objects under which `layered` was measured against `linear`, and their radii in mm."""

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
    """Return the measured error of the force against the extrapolated mesh, and its source.

    The error is that of the measured press next to the scene's: by angle for a plate, by the
    smallest radius for a round indenter.
    """
    errors: dict[str, float | None] = linear()[scene.finger.resolution]["force_error"]
    press = linear_press(scene.indenter, tuple(errors))
    error = errors[press]
    source = f"reports/{LINEAR_REPORT}, {press}: of the mesh, not of the model"
    return float("inf") if error is None else error, source


def linear_radius(scene: Scene) -> float:
    """Return the smallest radius in mm for which the mesh error of `linear` is measured."""
    sharp = isinstance(scene.indenter, Bar | Grating | Relief)
    return LINEAR_EDGE if sharp else LINEAR_RADIUS


def linear_press(indenter: Indenter, presses: tuple[str, ...]) -> str:
    """Return which of the measured presses is next to that of an indenter."""
    if isinstance(indenter, Flat):
        angles = {press: float(press[5:]) for press in presses if press.startswith("flat-")}
        return min(angles, key=lambda press: abs(angles[press] - indenter.angle))
    if isinstance(indenter, Bar):
        return "edge"
    if isinstance(indenter, Grating | Relief):
        return "grating"
    return "sphere-5" if smallest_radius(indenter) >= 5 else "sphere-2"


@cache
def layered() -> dict[str, Any]:
    """Return the force of `layered` against `linear`, by press and depth, and its timing."""
    measured: dict[str, Any] = json.loads(report(LAYERED_REPORT))
    return measured


def layered_seconds(scene: Scene) -> float:
    """Return the expected wall time of `layered` in s, from the times in the report."""
    steps = len(time_grid(scene.motion, fast="FAII" in scene.ask.spikes))
    return float(layered()["setup_seconds"]) + steps * float(layered()["step_seconds"])


def layered_error(indenter: Indenter, depth: float) -> tuple[float, str]:
    """Return the measured error of the force of `layered` at `depth` mm, and its source.

    It is linear between the measured depths, and constant beyond their ends.
    """
    press = layered_press(indenter)
    row = layered()["presses"][press]
    depths, errors = row["depth_mm"], row["force_error"]
    source = f"reports/{LAYERED_REPORT}, {press}: against linear, on the finger of a.h."
    return float(np.interp(depth, depths, errors)), source


def layered_depth(indenter: Indenter) -> float:
    """Return the largest depth in mm at which `layered` was measured under such an indenter."""
    return float(layered()["presses"][layered_press(indenter)]["depth_mm"][-1])


def layered_press(indenter: Indenter) -> str:
    """Return the measured press whose object is next blunter, because the error grows with it."""
    radius = smallest_radius(indenter)
    if isinstance(indenter, Ellipsoid):
        a, b, c = indenter.radii
        radius = max(a, b) ** 2 / c
    blunter = [press for press, measured in LAYERED_PRESSES.items() if measured >= radius]
    return min(blunter, key=LAYERED_PRESSES.__getitem__)


def smallest_radius(indenter: Indenter) -> float:
    """Return the smallest radius of curvature in mm of what the pad meets of an indenter.

    That of a ball is at its foremost point, that of a relief the one at its sharpest crest.
    """
    if isinstance(indenter, Sphere | Cylinder):
        return indenter.radius
    if isinstance(indenter, Ellipsoid):
        a, b, c = indenter.radii
        return min(a, b) ** 2 / c
    if isinstance(indenter, Bar):
        return indenter.corner
    if isinstance(indenter, Grating | Relief):
        _, _, curvature = indenter.profile.height(_crests(indenter))
        return float(1 / max(np.linalg.eigvalsh(curvature).max(), 1e-12))
    return float("inf")


def _crests(indenter: Grating | Relief) -> NDArray[np.float64]:
    """Return places (n, 2) mm that are close enough to find the sharpest crest within 1 %."""
    if isinstance(indenter, Grating):
        return np.column_stack([np.linspace(0, indenter.period, 401), np.zeros(401)])
    fine = (
        np.interp(np.arange(0, len(x) - 1, 0.2), np.arange(len(x)), x)
        for x in (indenter.x, indenter.y)
    )
    return np.stack(np.meshgrid(*fine, indexing="ij"), axis=-1).reshape(-1, 2)


def solid_seconds(scene: Scene) -> float:
    """Return the expected wall time of `solid` in s."""
    return 10 * linear_seconds(scene)


def solid_error(scene: Scene) -> tuple[float, str]:
    """Return the measured error of the force against the extrapolated mesh, and its source."""
    return linear_error(scene)
