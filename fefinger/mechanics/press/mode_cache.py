"""Where the user's cache keeps the modes of fingers: under the hash of what decides them."""

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from fefinger.mechanics.press.operator_cache import identity, parities
from fefinger.scene.finger import Finger
from fefinger.support import cache
from fefinger.support.checks import InputError


FORMAT = 3
"""Raised when the mass matrix, the solver or the files change, so that modes are computed again."""

COUNT = 150
"""Modes that are computed and kept of each parity: those of half a finger of 34 kPa below 1000 Hz,
with relaxed tissue, and a few more."""

MESH_OF_INERTIA = {"coarse": "coarse", "standard": "coarse", "fine": "standard"}
"""Mesh on which the change by inertia is computed in tissue that stiffens."""


def at_hand(finger: Finger, *, half: bool, continued: bool = False) -> bool:
    """Return whether the modes of a finger are in the cache and need not be computed."""
    if not os.path.isdir(cache.root() / "modes"):  # then not even the name of the mesh is needed
        return False
    try:
        keys = [identity(finger, odd=odd, continued=continued) for odd in parities(half=half)]
    except InputError:  # no mesh can be made for a finger of this size
        return False
    return all(each is not None and os.path.isdir(folder(finger, each)) for each in keys)


def identity_of(finger: Finger, operator: dict[str, Any]) -> dict[str, Any]:
    """Return all that decides the modes of one parity, given that of its operator."""
    ratio = finger.subcutaneous.density / finger.skin.density
    return operator | {"modes": COUNT, "modes_format": FORMAT, "density_ratio": ratio}


def folder(finger: Finger, operator: dict[str, Any]) -> Path:
    """Return where the cache keeps the modes of one parity."""
    key = json.dumps(identity_of(finger, operator), sort_keys=True)
    return cache.root() / "modes" / hashlib.sha256(key.encode()).hexdigest()[:16]
