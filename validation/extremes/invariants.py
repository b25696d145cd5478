"""Invariants of a contact, which the response to every scene must fulfill."""

from dataclasses import fields as fields_of

import numpy as np
from fefinger.validation.extremes.trial import Findings
from numpy.typing import ArrayLike

from fefinger.geometry.finger_mesh import locate
from fefinger.geometry.profiles import frame
from fefinger.results.pressure import net, pressed
from fefinger.results.records import Pad, Response
from fefinger.scene.indenter import Indenter, direction
from fefinger.scene.indenters import STANDARD
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.units import NEWTON_PER_MILLINEWTON


ROUNDING = 1e-9
"""Of the largest value, for what holds to rounding."""

SUNK, FACET = 0.25, 0.8
"""Depth of a vertex of the pad in the obstacle: this part of the depth, and the sag of a facet of
so many mm on what is round, FACET² / 4R. Contact is exact in the weighted gaps, and between them
the coarse mesh sags."""

QUADRATURE = 2e-3
"""Of peak force times peak depth: the error of the trapezoidal rule for the work of a cycle."""


CUTS = 4
"""Parts of an edge of a facet, for the integral of how a round object leans against it."""

LEANING = 3e-3
"""Of the peak force, for the balance on round objects: that integral is over flat facets, the
solver's over the curved skin. In these scenes they differ by up to 2.5e-4, and by 1.1e-3 where a
single vertex carries a point of 1 mm radius; on plates and in finite strain by rounding alone."""


FAINT = 1e-3
"""Of the peak force, below which a contact area is not compared with that of the points pressed.

It is measured to a fraction of an element, and each point stands for a whole one: in these scenes
it is 0.67 to 1.5 times theirs. In finite strain it is that of the deformed skin, and is not
compared."""


def not_finite(*arrays: ArrayLike) -> tuple[float, float]:
    """Count the numbers that are not finite; none may be."""
    return float(sum(np.sum(~np.isfinite(np.asarray(a, float))) for a in arrays)), 0.0


def off(computed: ArrayLike, expected: ArrayLike, limit: float) -> tuple[float, float]:
    """Return the largest difference over the largest expected value."""
    computed, expected = np.asarray(computed, float), np.asarray(expected, float)
    scale = float(np.abs(expected).max()) or 1.0
    worst = float(np.abs(computed - expected).max()) / scale
    return (worst if np.isfinite(worst) else np.inf), limit


def falling(values: ArrayLike, limit: float = ROUNDING) -> tuple[float, float]:
    """Return by how much values fall that should rise, over the largest."""
    values = np.asarray(values, float)
    scale = float(np.abs(values).max()) or 1.0
    return float(max(0.0, -np.diff(values).min(initial=0.0))) / scale, limit


def invariants(scene: Scene, response: Response) -> Findings:
    """Evaluate every invariant that a response allows."""
    findings = {
        "finite": _finite(response),
        "no pull": _pull(response),
        "asked": _asked(scene, response),
    }
    if response.pressure is not None:
        findings["balance"] = _balance(scene, response)
        findings["area"] = _area(response)
    if response.pressure is not None and response.gap is not None and not response.finite:
        findings["area of pressure"] = _spread(response)
    if response.gap is not None:
        findings["no penetration"] = _sunk(scene, response)
    findings |= _of_motion(scene, response)
    return findings


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
    followed = scene.motion.control.of(response.depth, response.force)
    return off(followed, scene.motion.value(response.time), 1e-7)


def _balance(scene: Scene, response: Response) -> tuple[float, float]:
    """Relative difference of the integral of the pressure from the force.

    Half-spaces and finite strain give the pressure across the travel, and a plate lies across it.
    In small strain the pressure on a round object acts along its normal, of which a part is along.
    """
    assert response.pad is not None
    assert response.pressure is not None
    areas, limit = response.pad.areas, ROUNDING
    if response.gap is None:
        limit = 1e-6
    elif not (response.finite or scene.indenter.flat is not None):
        areas, limit = _across(scene.indenter, response), LEANING
    carried = response.pressure @ areas * NEWTON_PER_MILLINEWTON
    peak = float(response.force.max()) or 1.0
    return float(np.abs(carried - response.force).max()) / peak, limit


def _across(indenter: Indenter, response: Response) -> Array:
    """Project the areas (n_pad,) mm² of the pad's points on the direction of a round object.

    The hats of the points that are pressed are integrated over their facets, times the cosine
    between the object's normal there and its travel.
    """
    assert response.pad is not None
    assert response.pressure is not None
    pad = pressed(response.pad, np.any(response.pressure > 0, axis=0))
    origin, axis = _touch(indenter.place, response.pad)
    between, loads = net(pad, CUTS)
    sideways = frame(axis, indenter.turn)[:2]
    _, slope, _ = indenter.profile.height((between @ pad.points - origin) @ sideways.T)
    return np.asarray(loads.T @ (1 / np.sqrt(1 + np.sum(slope**2, axis=-1))))


def _touch(at: tuple[float, float] | None, pad: Pad) -> tuple[Array, Array]:
    """Return a point (3,) mm on the way of a round object that touches the pad `at`, and its way.

    That is the inward normal of the pad there, interpolated in the triangle of which it is part.
    """
    if at is None:
        return np.zeros(3), direction(STANDARD)
    palmar = pad.triangles[pad.normals[pad.triangles][:, :, 2].max(axis=1) < 0]
    (best,), (weights,) = locate(pad.points[palmar][:, :, :2], np.array([at], dtype=float))
    normal = weights @ pad.normals[palmar[best]]
    return weights @ pad.points[palmar[best]], -normal / np.linalg.norm(normal)


def _area(response: Response) -> tuple[float, float]:
    """Return in how many steps force and contact area are not there together."""
    assert response.contact_area is not None
    differ = (response.force > 0) != (response.contact_area > 0)
    return float(differ.sum() + (response.contact_area < 0).sum()), 0.0


def _spread(response: Response) -> tuple[float, float]:
    """Return by how many octaves the contact area differs from the area of the points pressed."""
    assert response.pad is not None
    assert response.pressure is not None
    assert response.contact_area is not None
    there = response.force > FAINT * response.force.max()
    of_points = (response.pressure[there] > 0) @ response.pad.areas
    octaves = np.log2(response.contact_area[there] / of_points)
    return float(np.abs(octaves).max(initial=0.0)), 1.0


def _sunk(scene: Scene, response: Response) -> tuple[float, float]:
    """Largest penetration of the pad into the obstacle, in mm."""
    assert response.gap is not None
    around = min(scene.indenter.least_radius, 0.5 * scene.finger.thickness)
    limit = SUNK * float(response.depth.max()) + FACET**2 / (4 * around)
    return max(0.0, -float(response.gap.min())), limit


def _of_motion(scene: Scene, response: Response) -> dict[str, tuple[float, float]]:
    """Evaluate the invariants of some motions: rising, relaxing, work that is not negative."""
    depth, force, kind = response.depth, response.force, scene.motion.kind
    findings = {}
    if kind == "ramp":
        findings["rising"] = falling(force)
    if kind in ("ramp", "force-ramp", "force-ramp-hold"):
        findings["deeper"] = falling(depth, 1e-7)
    if kind == "ramp-hold":
        held = response.time >= max(scene.motion.breakpoints[:-1])
        findings["relaxing"] = falling(-force[held])
    if abs(depth[-1] - depth[0]) <= ROUNDING * depth.max() and depth.max() > 0:
        work = float(np.sum((force[1:] + force[:-1]) / 2 * np.diff(depth)))
        scale = float(force.max() * depth.max()) or 1.0
        findings["work"] = max(0.0, -work / scale), QUADRATURE
    return findings
