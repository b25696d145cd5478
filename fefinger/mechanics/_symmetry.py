"""Which scenes are their own mirror image, so that half a finger answers them."""

from fefinger.scene.scene import Scene


def symmetric(scene: Scene) -> bool:
    """Return whether the scene is its own mirror image in the medial plane y = 0."""
    return scene.indenter.mirrored
