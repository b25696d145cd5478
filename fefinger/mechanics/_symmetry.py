"""Which scenes are their own mirror image, so that half a finger answers them."""

from fefinger.scene import Ellipsoid, Flat, Indenter, Scene, Sphere


def symmetric(scene: Scene) -> bool:
    """Return whether the scene is its own mirror image in the medial plane y = 0."""
    return own_image(scene.indenter)


def own_image(indenter: Indenter) -> bool:
    """Return whether an indenter at its place is its own mirror image in the medial plane."""
    if isinstance(indenter, Flat):
        return indenter.tilt == 0
    return (
        not isinstance(indenter, Sphere | Ellipsoid) or indenter.at is None or indenter.at[1] == 0
    )
