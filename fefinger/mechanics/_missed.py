"""What is said where an object misses the vertices of the pad: none, or too few, are under it."""

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
