"""What every answer to a scene has to fulfil, whatever the scene: the invariants of a contact."""

from dataclasses import fields as fields_of

import numpy as np
from fefinger.validation.extremes_trial import Findings
from numpy.typing import ArrayLike, NDArray

from fefinger.mechanics._evidence import smallest_radius
from fefinger.records import Response
from fefinger.scene import Scene


Array = NDArray[np.float64]

ROUNDING = 1e-9
"""Of the largest value, for what holds to rounding."""

SUNK, FACET = 0.25, 0.8
"""Depth of a vertex of the pad in the obstacle: this part of the depth, and the sag of a facet of
so many mm on what is round, FACET² / 4R. Contact is exact in the weighted gaps, and between them
the coarse mesh sags."""

QUADRATURE = 2e-3
"""Of peak force times peak depth: the error of the trapezoidal rule for the work of a cycle."""


def not_finite(*arrays: ArrayLike) -> tuple[float, float]:
    """Return how many numbers are not finite; none may be."""
    return float(sum(np.sum(~np.isfinite(np.asarray(a, float))) for a in arrays)), 0.0


def off(found: ArrayLike, expected: ArrayLike, limit: float) -> tuple[float, float]:
    """Return the largest difference over the largest expected value."""
    found, expected = np.asarray(found, float), np.asarray(expected, float)
    scale = float(np.abs(expected).max()) or 1.0
    worst = float(np.abs(found - expected).max()) / scale
    return (worst if np.isfinite(worst) else np.inf), limit


def falling(values: ArrayLike, limit: float = ROUNDING) -> tuple[float, float]:
    """Return by how much values fall that should rise, over the largest."""
    values = np.asarray(values, float)
    scale = float(np.abs(values).max()) or 1.0
    return float(max(0.0, -np.diff(values).min(initial=0.0))) / scale, limit


def invariants(scene: Scene, response: Response) -> Findings:
    """Return what was found of every invariant that can be seen in a response."""
    found = {
        "finite": _finite(response),
        "no pull": _pull(response),
        "asked": _asked(scene, response),
    }
    if response.pressure is not None:
        found["balance"] = _balance(response)
        found["area"] = _area(response)
    if response.gap is not None:
        found["no penetration"] = _sunk(scene, response)
    found |= _of_motion(scene, response)
    return found


def _finite(response: Response) -> tuple[float, float]:
    """Count what is not finite; the centroid has a right to nan out of contact alone."""
    arrays = [
        value
        for field in fields_of(response)
        if field.name != "centroid"
        and isinstance(value := getattr(response, field.name), np.ndarray)
    ]
    count = not_finite(*arrays)[0]
    if response.centroid is not None:
        count += not_finite(response.centroid[response.force > 0])[0]
    return count, 0.0


def _pull(response: Response) -> tuple[float, float]:
    peak = float(response.force.max()) or 1.0
    worst = max(0.0, -float(response.force.min()) / peak)
    if response.pressure is not None:
        most = float(response.pressure.max()) or 1.0
        worst = max(worst, -float(response.pressure.min()) / most)
    return worst, 1e-12


def _asked(scene: Scene, response: Response) -> tuple[float, float]:
    followed = response.depth if scene.motion.control == "depth" else response.force
    return off(followed, scene.motion.value(response.time), 1e-7)


def _balance(response: Response) -> tuple[float, float]:
    """Return how far the pressure is from carrying the force.

    On a sphere or a curved pad the pressure is of its own surface, larger than what is across.
    """
    assert response.pad is not None
    assert response.pressure is not None
    carried = response.pressure @ response.pad.areas * 1e-3
    peak = float(response.force.max()) or 1.0
    if response.gap is None:
        return float(np.abs(carried - response.force).max()) / peak, 1e-6
    return max(0.0, float((response.force - carried).max()) / peak), ROUNDING


def _area(response: Response) -> tuple[float, float]:
    """Return in how many steps force and contact area are not there together."""
    assert response.contact_area is not None
    differ = (response.force > 0) != (response.contact_area > 0)
    return float(differ.sum() + (response.contact_area < 0).sum()), 0.0


def _sunk(scene: Scene, response: Response) -> tuple[float, float]:
    """Return how far the pad is in the obstacle, in mm."""
    assert response.gap is not None
    around = min(smallest_radius(scene.indenter), 0.5 * scene.finger.thickness)
    limit = SUNK * float(response.depth.max()) + FACET**2 / (4 * around)
    return max(0.0, -float(response.gap.min())), limit


def _of_motion(scene: Scene, response: Response) -> dict[str, tuple[float, float]]:
    """Return what theory says of some motions: rising, relaxing, work that is not negative."""
    depth, force, kind = response.depth, response.force, scene.motion.kind
    found = {}
    if kind == "ramp":
        found["rising"] = falling(force)
    if kind in ("ramp", "force-ramp", "force-ramp-hold"):
        found["deeper"] = falling(depth, 1e-7)
    if kind == "ramp-hold":
        held = response.time >= max(scene.motion.breaks[:-1])
        found["relaxing"] = falling(-force[held])
    if abs(depth[-1] - depth[0]) <= ROUNDING * depth.max() and depth.max() > 0:
        work = float(np.sum((force[1:] + force[:-1]) / 2 * np.diff(depth)))
        scale = float(force.max() * depth.max()) or 1.0
        found["work"] = max(0.0, -work / scale), QUADRATURE
    return found
