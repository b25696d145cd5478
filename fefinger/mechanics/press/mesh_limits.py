"""What a scene asks of its mesh, and the limits at which a press leaves it.

A plate that comes near the cut needs a finger that is continued there.
"""

from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.geometry.profiles import Profile
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter, Plate, direction
from fefinger.scene.indenters import STANDARD
from fefinger.scene.motion import Motion
from fefinger.support.arrays import Flags
from fefinger.support.checks import BeyondError, InputError


if TYPE_CHECKING:
    from fefinger.fem.body import Solid
    from fefinger.fem.contact.obstacle import Obstacle


MESHED_PLACE, MESHED_NEAR = 2.0, 3.0
"""mm between the places for which meshes differ, and from the origin where none is needed."""

ALONG = 15.0
"""Degrees up to which a plate may come near the cut: at 10 it is 3.5 mm away from the finger of
a.h. there."""

FORCE_DEPTH = 0.22
"""First guess of the depth under force control, over the thickness of the finger."""

CLOSE = 0.75
"""Depth over the gap at the cut beyond which the finger is continued. Tissue that is fixed at the
cut makes the press stiffer: there by 2 (d.s.) to 5 % (d.p.), less at smaller depths.
"""

NEAR = 0.93
"""Depth over the gap at the cut from which contact may have reached it: on fingers of published
tissue at 0 and 5 degrees `linear` reached it at 0.94 to 0.99, on six other coarse meshes of d.p. at
1.05 to 1.15, `solid` at 0.97 to 0.99, on the tissue calibrated_ah at 1.19.
"""


def refinement_location(indenter: Indenter) -> float | tuple[float, float] | None:
    """Return where the mesh has to be fine: the angle of a plate, a place (x, y) mm, or None.

    Angles and places are rounded, so that neighboring scenes share a mesh; None is the mesh that is
    fine around the touch of the 30 degree plate.
    """
    if indenter.plate is not None:
        meshed_angle = 15.0  # degrees between the plates for which meshes differ
        angle = meshed_angle * round(indenter.plate.angle / meshed_angle)
        return None if angle == STANDARD.angle else float(angle)
    x, y = indenter.place or (0.0, 0.0)
    if np.hypot(x, y) <= MESHED_NEAR:
        return None
    return (
        float(MESHED_PLACE * round(x / MESHED_PLACE)),
        float(MESHED_PLACE * round(abs(y) / MESHED_PLACE)),
    )


def needs_continuation(finger: Finger, indenter: Indenter, motion: Motion) -> bool:
    """Whether a scene needs the finger of `mesh.extend`, longer behind the proximal cut.

    Under force control the depth is a guess.
    """
    plate = indenter.flat
    if plate is None or plate.angle > ALONG:
        return False
    deepest = motion.control.of(motion.peak, FORCE_DEPTH * finger.thickness)
    return deepest > CLOSE * gap(finger, plate)


def gap(finger: Finger, plate: Plate, *, with_continuation: bool = False) -> float:
    """Return the distance in mm of a plate at first touch from the skin at the proximal end."""
    from fefinger.mesh.extend import at_cut
    from fefinger.mesh.recipe import Recipe

    x, y, z = direction(plate).tolist()
    return at_cut(Recipe.of(finger), (x, y, z), with_continuation=with_continuation)


MESHLESS = "a mechanics without a mesh, if `fefinger explain` lists one that can"

NOTHING_UNDER = (
    "indenter: expected at least 3 vertices of the pad under it, received fewer; move it over the "
    f"pad, or take a larger indenter, a finer mesh (finger.resolution) or {MESHLESS}"
)

OUTSIDE = (
    "indenter: expected contact on the palmar part of the pad, received contact that reaches the "
    "sides of the finger; press less, or use the mechanics 'linear'"
)

FEWEST = 3
"""Vertices of the pad under a ball or another object that ends, below which it is not resolved."""


def check_under(motion: Motion, obstacle: "Obstacle", body: "Solid", beyond: Flags) -> None:
    """Raise InputError if an indenter has too few vertices of the pad of a body under it.

    beyond (n,): whether the indenter has ended at its candidates.
    """
    if len(beyond) and not (beyond.any() and (~beyond).sum() < FEWEST):
        return
    depth = motion.deepest
    raise InputError(NOTHING_UNDER if depth is None else untouched(obstacle, body, depth))


def untouched(obstacle: "Obstacle", body: "Solid", depth: float) -> str:
    """Error message for a press to `depth` mm that moves no vertex of the pad of a body."""
    pad = body.space.points[np.unique(body.pad)]
    under = np.isfinite(obstacle.gap(pad)[0]) & ~obstacle.beyond(pad)
    too_small = under.sum() < FEWEST  # however deep it goes
    return NOTHING_UNDER if too_small else unresolved(depth)


def rim_reached(count: int, profile: Profile | None = None) -> str:
    """Error message for contact that reaches the rim of an indenter over `count` vertices.

    profile: of the indenter; a relief lies where its file says.
    """
    lies, ends = "", None if profile is None else profile.ends
    if ends is not None:
        lies = (
            "; it covers x from {:.3g} to {:.3g} and y from {:.3g} to {:.3g} mm about the first "
            "touch of a plate, and with indenter.center = true the middle of its file lies there"
        ).format(*ends)
    return (
        f"indenter: expected contact inside its outline, but it reaches the rim, beyond which the "
        f"indenter turns away, with {count} vertices of the pad under it; press less, or take a "
        f"larger indenter or a finer mesh (finger.resolution){lies}"
    )


def unresolved(depth: float) -> str:
    """Error message for a contact at `depth` mm that is smaller than a facet."""
    return (
        f"motion: expected a contact that the mesh resolves, but at a depth of {depth:.3g} mm it "
        "is smaller than a facet of the pad; press deeper, or take a finer mesh "
        f"(finger.resolution) or {MESHLESS}"
    )


def spread_beyond(reach: float) -> str:
    """Error message for contact that spread beyond all candidates, to a gap of `reach` mm."""
    return (
        "contact: expected it inside the candidate vertices, but it spread beyond all within a gap "
        f"of {reach:.3g} mm at first touch, the most that are tried; press less"
    )


def check_reached(motion: Motion, pulp: float, deepest: float) -> None:
    """Raise BeyondError for a force that presses `deepest` mm, through `pulp` mm of tissue."""
    if reason := through(motion, pulp, deepest):
        todo = "press less, or slide where the object stays on the pad"
        raise BeyondError(f"{reason}; {todo if motion.slides else 'press less'}")


def through(motion: Motion, pulp: float, deepest: float) -> str:
    """Say that a force presses `deepest` mm, through `pulp` mm of tissue; "" if less deep."""
    if not motion.by_force or deepest < pulp:
        return ""
    return (
        f"motion.force: expected one that presses less deep than the {pulp:g} mm of tissue under "
        f"the pad, received {motion.peak:g} N, which presses {deepest:.3g} mm deep"
    )


def check_depth(motion: Motion, mesh: FingerMesh, obstacle: "Obstacle") -> None:
    """Raise InputError for a depth that leaves no tissue over the bone."""
    bone = mesh.points[np.unique(mesh.facets["bone"])]
    pulp = float(np.min(np.linalg.norm(bone - obstacle.first_touch, axis=1)))
    if motion.deepest is not None and motion.deepest >= pulp:
        raise InputError(
            f"motion.depth: expected less than the {pulp:.3g} mm of tissue over the bone, "
            f"received {motion.peak:g} mm"
        )
