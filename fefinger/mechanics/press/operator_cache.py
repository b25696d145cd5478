"""Folders of the operators of `condensed` in the user's cache, named by a hash of all inputs.

An operator depends on the ratio of the moduli only: it is built for a skin of 1 kPa and scaled.
"""

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fefinger.scene.finger import Finger
from fefinger.support import cache
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from fefinger.geometry.finger_mesh import FingerMesh

FORMAT = 1
"""Raised when the elements, the solver or the files change, so that operators are built again."""


def identity(
    finger: Finger, *, odd: bool, mesh: "FingerMesh | None" = None, continued: bool = False
) -> dict[str, Any] | None:
    """Return the inputs of an operator as plain values; None where the mesh has no file.

    `mesh` is the one that it is built on; by default the shipped or cached one, `continued` behind
    its proximal cut or not.
    """
    from fefinger.mesh.store import sha256

    source = sha256(finger, continued=continued) if mesh is None else mesh.source_sha256
    if not source:
        return None
    return {
        "format": FORMAT,
        "element": "Taylor-Hood, P2 and P1 per tissue",
        "solver": "multifrontal, pad last",
        "mesh_file_sha256": source,
        "cut": finger.cut,
        "modulus_ratio": finger.subcutaneous.modulus / finger.skin.modulus,
        "poisson": [finger.skin.poisson, finger.subcutaneous.poisson],
        "parity": "odd" if odd else "even",
    }


def parities(*, half: bool) -> tuple[bool, ...]:
    """Return the parities, odd or not, of half a finger (even) or of a whole one (both)."""
    return (False,) if half else (False, True)


def folder(identity: dict[str, Any]) -> Path:
    """Return the path of an operator in the cache."""
    key = hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()
    return cache.root() / "operators" / key[:16]


def at_hand(
    finger: Finger,
    *,
    half: bool,
    continued: bool = False,
    place: Callable[[dict[str, Any]], Path] = folder,
) -> bool:
    """Return whether the operators of a finger, or their modes by `place`, are cached."""
    if not os.path.isdir(place({}).parent):  # then not even the name of the mesh is needed
        return False
    try:
        keys = [identity(finger, odd=odd, continued=continued) for odd in parities(half=half)]
    except InputError:  # no mesh can be made for a finger of this size
        return False
    return all(each is not None and os.path.isdir(place(each)) for each in keys)
