"""Where the end organs lie, and the small flat press that they are measured against.

Shared by all mechanics; needs no mesh.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fefinger.results.records import Sites
from fefinger.scene.indenter import STANDARD, direction
from fefinger.scene.library import receptors
from fefinger.scene.scene import Scene
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from fefinger.neural.populations import Surface


Array = NDArray[np.float64]


REFERENCE_DEPTH = 0.5
"""Depth in mm of the small flat press that sets the length of a strain."""


def sites(scene: Scene, origin: Array, axis: Array) -> Sites:
    """Return one site per type asked for (all four when only strain is) under the first touch.

    They lie at the depths of their types along the inward normal `axis` (3,) from `origin` (3,).
    """
    known = {kind: organ.depth for kind, organ in receptors().items()} | dict(scene.ask.depths)
    types = scene.ask.spikes or tuple(known)
    depth = np.array([known[kind] for kind in types])
    check_sites(scene, depth)
    points = origin + depth[:, None] * axis
    return Sites(points, np.tile(-axis, (len(depth), 1)), depth, tuple(types))


def check_sites(scene: Scene, depths: Array) -> None:
    """Raise InputError for end organs (n,) mm deep that lie in the bone."""
    deepest = float(depths.max(initial=0.0))
    if deepest >= scene.finger.pulp:
        message = (
            f"ask.depths: expected end organs above the bone, less than {scene.finger.pulp:g} mm "
            f"deep, received one at {deepest:g} mm; give depths that this finger has, or ask for "
            "the types of lesser depth alone"
        )
        raise InputError(message)


def organs(scene: Scene, origin: Array, axis: Array, skin: "Callable[[], Surface]") -> Sites:
    """Return the sites of the scene's population under its skin, or without one the central ones.

    The population lies about the first touch of the standard plate, wherever the indenter is.
    """
    if scene.ask.population is None:
        return sites(scene, origin, axis)
    from fefinger.mechanics.press import population

    return population.sites(population.place(scene.ask, skin(), direction(STANDARD)))
