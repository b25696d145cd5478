"""Limits of a press: no vertex under the object, its rim reached, too deep for the mesh."""

from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.scene.scene import Scene
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from fefinger.fem.contact.obstacle import Obstacle

NOTHING_UNDER = (
    "indenter: expected it over the pad, received one that no vertex of the pad is under; move it, "
    "or take a larger indenter or a finer mesh (finger.resolution)"
)


def check_under(scene: Scene, count: int) -> None:
    """Raise InputError if the indenter has `count` = 0 vertices of the pad under it."""
    if count == 0:
        by_depth = scene.motion.control == "depth"
        raise InputError(unresolved(scene.motion.peak) if by_depth else NOTHING_UNDER)


def rim_reached(count: int) -> str:
    """Return what to say when contact reaches the rim of an indenter over `count` vertices."""
    return (
        f"indenter: expected contact inside its outline, but it reaches the rim, beyond which the "
        f"indenter turns away, with {count} vertices of the pad under it; press less, or take a "
        "larger indenter or a finer mesh (finger.resolution)"
    )


def unresolved(depth: float) -> str:
    """Return what to say when a press to `depth` mm moves no vertex of the pad."""
    return (
        f"motion: expected a contact that the mesh resolves, but at a depth of {depth:.3g} mm it "
        "is smaller than a facet of the pad; press deeper, or take a finer mesh "
        "(finger.resolution) or hertz"
    )


def check_reached(scene: Scene, deepest: float) -> None:
    """Raise InputError for a force that presses the tissue to nothing, to `deepest` mm."""
    if scene.motion.control == "force" and deepest >= scene.finger.pulp:
        message = (
            f"motion.force: expected one that presses less deep than the {scene.finger.pulp:g} mm "
            f"of tissue under the pad, received {scene.motion.peak:g} N, which presses "
            f"{deepest:.3g} mm deep; press less"
        )
        raise InputError(message)


def check_depth(scene: Scene, mesh: FingerMesh, touch: "Obstacle") -> None:
    """Raise InputError for a depth that leaves no tissue over the bone."""
    bone = mesh.points[np.unique(mesh.facets["bone"])]
    pulp = float(np.min(np.linalg.norm(bone - touch.origin, axis=1)))
    if scene.motion.control == "depth" and scene.motion.peak >= pulp:
        message = (
            f"motion.depth: expected less than the {pulp:.3g} mm of tissue over the bone, "
            f"received {scene.motion.peak:g} mm"
        )
        raise InputError(message)
