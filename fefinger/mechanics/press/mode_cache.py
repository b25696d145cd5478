"""Paths of the modes of fingers in the user's cache, by a hash of all inputs."""

import hashlib
import json
from functools import partial
from pathlib import Path
from typing import Any

from fefinger.mechanics.press import operator_cache
from fefinger.scene.finger import Finger
from fefinger.support import cache


FORMAT = 3
"""Raised when the mass matrix, the solver or the files change, so that modes are computed again."""

COUNT = 150
"""Number of modes of each parity that are computed and cached: those of half a finger of 34 kPa,
with relaxed tissue, below 1000 Hz, and a few more."""

MESH_OF_INERTIA = {"coarse": "coarse", "standard": "coarse", "fine": "standard"}
"""Mesh on which the change by inertia is computed in tissue that stiffens."""


def at_hand(finger: Finger, *, half: bool, continued: bool = False) -> bool:
    """Return whether the modes of a finger are in the cache and need not be computed."""
    place = partial(folder, finger)
    return operator_cache.at_hand(finger, half=half, continued=continued, place=place)


def identity_of(finger: Finger, operator: dict[str, Any]) -> dict[str, Any]:
    """Return the inputs of the modes of one parity, from those of its operator."""
    ratio = finger.subcutaneous.density / finger.skin.density
    return operator | {"modes": COUNT, "modes_format": FORMAT, "density_ratio": ratio}


def folder(finger: Finger, operator: dict[str, Any]) -> Path:
    """Return the path of the modes of one parity in the cache."""
    key = json.dumps(identity_of(finger, operator), sort_keys=True)
    return cache.root() / "modes" / hashlib.sha256(key.encode()).hexdigest()[:16]
