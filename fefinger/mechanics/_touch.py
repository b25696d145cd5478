"""Where the central end organs lie, and the small flat press that they are measured against.

Shared by all mechanics; needs no mesh.
"""

import numpy as np
from numpy.typing import NDArray

from fefinger.library import receptors
from fefinger.records import Sites
from fefinger.scene import Flat, Grating, Relief, Scene


Array = NDArray[np.float64]

STANDARD = Flat(angle=30.0)
"""The plate whose first touch is the origin, and whose small press is the reference of strain."""

REFERENCE_DEPTH = 0.5
"""Depth in mm of the small flat press that sets the length of a strain."""


def direction(flat: Flat | Grating | Relief) -> Array:
    """Return the unit normal (3,) of a plate towards the finger, which is its travel."""
    angle, tilt = np.radians(flat.angle), np.radians(flat.tilt)
    up = np.cos(angle)
    return np.array([-np.sin(angle), -np.sin(tilt) * up, np.cos(tilt) * up])


def sites(scene: Scene, origin: Array, axis: Array) -> Sites:
    """Return one site per type asked for (all four when only strain is) under the first touch.

    They lie at the depths of their types along the inward normal `axis` (3,) from `origin` (3,).
    """
    known = {kind: organ.depth for kind, organ in receptors().items()} | dict(scene.ask.depths)
    types = scene.ask.spikes or tuple(known)
    depth = np.array([known[kind] for kind in types])
    points = origin + depth[:, None] * axis
    return Sites(points, np.tile(-axis, (len(depth), 1)), depth, tuple(types))
