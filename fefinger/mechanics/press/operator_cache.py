"""Folders of operators and modes of fingers in the user's cache, named by a hash of all inputs.

An operator depends on the ratio of the moduli only: it is built for a skin of 1 kPa and scaled.
Modes depend on the ratio of the densities as well.
"""

import hashlib
import json
import os
from functools import partial
from pathlib import Path
from typing import Any

from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.scene.finger import Finger
from fefinger.support import cache
from fefinger.support.checks import InputError


FORMAT, MODES_FORMAT = 1, 3
"""Raised when the elements, the mass matrix, a solver or the files change, so that operators and
modes are computed again."""

MODES = 150
"""Number of modes of each parity that are computed and cached: those of half a finger of 34 kPa,
with relaxed tissue, below 1000 Hz, and a few more."""

MESH_OF_INERTIA = {"coarse": "coarse", "standard": "coarse", "fine": "standard"}
"""Mesh on which the change by inertia is computed in tissue that stiffens."""


def identity(
    finger: Finger, *, odd: bool, mesh: FingerMesh | None = None, with_continuation: bool = False
) -> dict[str, Any] | None:
    """Return the inputs of an operator as plain values; None where the mesh has no file.

    `mesh` is the one that it is built on; by default the shipped or cached one, with or without a
    continuation behind its proximal cut.
    """
    from fefinger.mesh.store import sha256

    source = (
        sha256(finger, with_continuation=with_continuation) if mesh is None else mesh.source_sha256
    )
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


def description(finger: Finger, identity: dict[str, Any], mechanics: str) -> str:
    """Describe the operator or the modes of one parity in a line, for the list of the cache."""
    size = f"{finger.width:g} x {finger.thickness:g} mm, {finger.resolution}"
    loads = {"even": "equal", "odd": "opposite"}[identity["parity"]]
    stiff = f"pulp {identity['modulus_ratio']:.3g} times as stiff as skin"
    ratios = " and ".join(f"{value:g}" for value in identity["poisson"])
    return (
        f"finger of {size}, for `{mechanics}`: {loads} loads on both sides, {stiff}, Poisson's "
        f"ratios {ratios}"
    )


def modes_identity(finger: Finger, operator: dict[str, object]) -> dict[str, Any]:
    """Return the inputs of the modes of one parity, from the inputs of its operator."""
    ratio = finger.subcutaneous.density / finger.skin.density
    return operator | {"modes": MODES, "modes_format": MODES_FORMAT, "density_ratio": ratio}


def folder(identity: dict[str, object], kind: str = "operators") -> Path:
    """Return the path of an operator, or of "modes", in the cache."""
    key = hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()
    return cache.root() / kind / key[:16]


def modes_folder(finger: Finger, operator: dict[str, object]) -> Path:
    """Return the path of the modes of one parity in the cache."""
    return folder(modes_identity(finger, operator), "modes")


def available(
    finger: Finger, *, half: bool, with_continuation: bool = False, modes: bool = False
) -> bool:
    """Return whether the operators of a finger, or its modes, are cached."""
    place = partial(modes_folder, finger) if modes else folder
    if not os.path.isdir(place({}).parent):  # then not even the name of the mesh is needed
        return False
    try:
        keys = [
            identity(finger, odd=odd, with_continuation=with_continuation)
            for odd in parities(half=half)
        ]
    except InputError:  # no mesh can be made for a finger of this size
        return False
    return all(each is not None and os.path.isdir(place(each)) for each in keys)
