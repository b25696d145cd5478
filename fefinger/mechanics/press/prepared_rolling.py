"""A plate that rolls over half a finger, prepared for steps in real time."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy import sparse
from scipy.spatial import ConvexHull

from fefinger.contact.readout import readout
from fefinger.contact.rolling import RollingContact
from fefinger.fem.body import Solid
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.contact.patch import Patch, patch, smooth_places
from fefinger.fem.elements.recovery import recovered_strain_at
from fefinger.fem.elements.spaces import trace
from fefinger.mechanics.press import operator, placement, problem
from fefinger.mechanics.press.prepared import (
    Precision,
    Prepared,
    organs_under,
    reference_of,
    unfolded,
)
from fefinger.mechanics.press.unit_fields import at_small_strain
from fefinger.results.records import Sites
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import direction
from fefinger.scene.indenters import Flat
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.progress import Stages


MEDIAL = (0, 2)
"""Components of the normal of a plate that rolls: it turns about y."""


def rolled(
    finger: Finger,
    angles: Sequence[float],
    deepest: float,
    sites: Sites | None,
    precision: Precision,
    stages: Stages,
) -> Prepared:
    """Prepare half a finger under a plate that turns about y between `angles` in degrees.

    Errors as `prepared.pressed`.
    """
    with stages.stage("factor") as report:
        solid = operator.operator(finger, half=True, progress=report)
    obstacle = placement.obstacle(Flat(float(np.mean(angles))), solid)
    chosen = sites or organs_under(finger, obstacle)
    every = [
        patch(solid.space, solid.pad, solid.normals, Obstacle(axis, np.zeros(3)), np.inf)
        for axis in np.eye(3)[list(MEDIAL)]
    ]
    surface = trace(solid.space, solid.pad)
    skin = smooth_places(solid.space.points, solid.normals, surface)[..., MEDIAL].reshape(-1, 2)
    outline = skin[ConvexHull(skin).vertices]
    under = _under_plates(solid, every[0], outline, angles, problem.REACH * deepest)
    on = _both_directions(every, under)

    def strains(points: Array) -> Array:
        probe = partial(recovered_strain_at, solid.space, solid.folded(points), solid.planes)
        found = operator.reduced(finger, solid, on, points, probe).strain_operator
        return unfolded(solid, points, found)

    folded = solid.folded(chosen.points)
    probe = partial(recovered_strain_at, solid.space, folded, solid.planes)
    reduced = operator.reduced(finger, solid, on, folded, probe)
    n, weights = int(under.sum()), every[0].areas[under]
    moments = np.array([each.gap[under] for each in every])
    along = -every[1].moment[under, 1] / every[1].projected[under]
    rim = np.flatnonzero(_on_rim(solid, every[0].vertices[under]))
    flexibility = reduced.flexibility.reshape(2, n, 2, n)
    return Prepared(
        finger=finger,
        solid=solid,
        sites=chosen,
        contact=RollingContact(flexibility, moments, weights, outline, rim, finger.prony.branches),
        readout=readout(
            2 * weights,
            weights,
            2 * weights * np.stack([along, np.zeros(n)]),
            unfolded(solid, chosen.points, reduced.strain_operator).T,
            np.float32 if precision == "single" else np.float64,
        ),
        touch=obstacle.origin,
        shown=(f"a plate from {min(angles):g} to {max(angles):g} degrees",),
        reduced=reduced,
        strains=strains,
        reference=partial(reference_of, finger, solid, chosen),
        fields=partial(at_small_strain, finger, solid, on),
    )


def medial_normal(angle: float) -> tuple[float, float]:
    """Return the normal (x, z) of a plate at an angle in degrees, in the plane of rolling."""
    x, z = direction(Flat(angle))[list(MEDIAL)].tolist()
    return x, z


def _under_plates(
    solid: Solid, every: Patch, outline: Array, angles: Sequence[float], reach: float
) -> Flags:
    """Flag the vertices that any of the plates is within `reach` mm of at first touch."""
    points = solid.space.points[every.vertices][:, MEDIAL]
    nearest = np.full(len(points), np.inf)
    for angle in np.arange(min(angles), max(angles) + 1.0, 1.0):
        normal = np.array(medial_normal(min(float(angle), max(angles))))
        nearest = np.minimum(nearest, points @ normal - float((outline @ normal).min()))
    return nearest <= reach


def _both_directions(every: Sequence[Patch], chosen: Flags) -> Patch:
    """Return the patch of chosen vertices with unit loads along both axes of the medial plane."""
    loads, places = (
        sparse.hstack([getattr(each, name)[:, chosen] for each in every]).tocsc()
        for name in ("loads", "places")
    )
    vertices = np.tile(every[0].vertices[chosen], 2)
    seen = replace(every[0].neighborhood, vertices=vertices)
    return replace(every[0], vertices=vertices, loads=loads, places=places, neighborhood=seen)


def _on_rim(solid: Solid, vertices: Integers) -> Flags:
    """Flag the candidates next to pad vertices that are none, or on the border of the pad."""
    inside = np.isin(solid.pad, vertices)
    beside = solid.pad[inside.any(axis=1) & ~inside.all(axis=1)]
    return np.isin(vertices, beside) | np.isin(vertices, placement.border(solid))
