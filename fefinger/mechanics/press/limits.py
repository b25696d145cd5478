"""Limits of a press: no vertex under the object, its rim reached, too deep for the mesh."""

from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.geometry.profiles import Profile
from fefinger.scene.motion import Motion
from fefinger.support.arrays import Flags
from fefinger.support.checks import BeyondError, InputError


if TYPE_CHECKING:
    from fefinger.fem.body import Solid
    from fefinger.fem.contact.obstacle import Obstacle

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
