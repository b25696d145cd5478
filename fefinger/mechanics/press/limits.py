"""What is said where an object misses the vertices of the pad: none, or too few, are under it."""

import numpy as np
from numpy.typing import NDArray

from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.hyperelastic.continuum import Continuum
from fefinger.geometry.finger_mesh import REGIONS, FingerMesh
from fefinger.mechanics.press.materials import NAIL
from fefinger.scene.scene import Scene
from fefinger.support.checks import InputError


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


Array = NDArray[np.float64]


def most_pressed(elements: Continuum, values: Array) -> tuple[float, Array, str]:
    """Return the smallest principal stretch in a body, the place (3,) mm at rest, and the tissue.

    `values` (n_unknowns,) are those of the body.
    """
    space = elements.space
    moved = values[space.unknowns[:, :30]].reshape(-1, 10, 3)
    deformation = np.eye(3) + np.einsum(
        "eni,qnk,ekj->eqij", moved, elements.reference, elements.jacobians
    )
    stretch = np.linalg.svd(deformation, compute_uv=False)[..., -1].min(axis=1)
    cell = int(np.argmin(stretch))
    place = space.points[space.vertices[cell]].mean(axis=0)
    names = {number: name for name, number in REGIONS.items()} | {NAIL: "nail"}
    name = names[int(space.tissue[cell])]
    return float(stretch[cell]), place, "subcutaneous tissue" if name == "subcutaneous" else name


def told(error: Exception, elements: Continuum, values: Array | None) -> str:
    """Return the sentence on a press that found no equilibrium after `values`, if there are any."""
    if values is None:
        return str(error)
    stretch, (x, y, z), tissue = most_pressed(elements, values)
    return (
        f"{error}. At the last equilibrium the {tissue} at x = {x:.1f}, y = {y:.1f}, z = {z:.1f} "
        f"mm is pressed to {stretch:.2g} of its length: press less deep, or take another mesh "
        "(finger.resolution) or tissue"
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


def check_depth(scene: Scene, mesh: FingerMesh, touch: Obstacle) -> None:
    """Raise InputError for a depth that leaves no tissue over the bone."""
    bone = mesh.points[np.unique(mesh.facets["bone"])]
    pulp = float(np.min(np.linalg.norm(bone - touch.origin, axis=1)))
    if scene.motion.control == "depth" and scene.motion.peak >= pulp:
        message = (
            f"motion.depth: expected less than the {pulp:.3g} mm of tissue over the bone, "
            f"received {scene.motion.peak:g} mm"
        )
        raise InputError(message)
