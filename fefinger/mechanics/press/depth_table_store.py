"""Files of the tables of `pressed`: shipped with the package, or in the user's cache.

A table depends on the mesh, the object and the tissues up to one modulus, not on the relaxation
nor on the motion but for its depth.
"""

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.mechanics.press.depth_table import DepthTable, DisplacementBasis
from fefinger.mechanics.press.discretization import continued, refinement_location
from fefinger.mesh.shipped import data_folder
from fefinger.mesh.store import sha256
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.motion import Motion
from fefinger.support import cache
from fefinger.support.atomic_write import moved
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from fefinger.geometry.finger_mesh import FingerMesh

FORMAT = 6
"""Raised when the solver, the depths or the files change, so that tables are solved again."""

PREFIX = "press-"
"""Of the names of shipped tables, which end with the first DIGITS of their key."""

DIGITS = 16

EXACT = ("depth", "force", "moment", "area", "stiffening", "work")
ROUNDED = ("pressure", "gap")
"""Arrays that are stored in double and in single precision."""


def key(finger: Finger, indenter: Indenter, mesh_sha256: str, *, half: bool = True) -> str:
    """Hash of all inputs of a table but its depth.

    A whole finger, mirrored from the mesh of its half, has tables of its own.
    """
    layers = (finger.skin, finger.subcutaneous)
    parts = [
        FORMAT,
        mesh_sha256,
        finger.subcutaneous.modulus / finger.skin.modulus,
        [[layer.poisson, layer.law, layer.exponent, layer.share] for layer in layers],
        [repr(part) for part in (finger.bone, finger.nail, finger.cut, indenter)],
    ]
    if not half:
        parts.append("whole")
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def key_on(finger: Finger, indenter: Indenter, mesh: "FingerMesh") -> str:
    """Key of a table on a mesh."""
    return key(finger, indenter, mesh.source_sha256 or mesh.fingerprint, half=mesh.half)


def deepest_at_hand(finger: Finger, indenter: Indenter, motion: Motion) -> tuple[float, float]:
    """Largest depth in mm and force in N of the shipped or cached tables; 0, 0 without any."""
    long = continued(finger, indenter, motion)
    try:
        source = sha256(finger, refinement_location(indenter), continued=long)
    except InputError:  # no mesh can be made for a finger of this size
        source = None
    if source is None:
        return 0.0, 0.0
    deepest = [(0.0, 0.0)]
    half = indenter.mirrored and motion.mirrored
    for path in _paths(key(finger, indenter, source, half=half)):
        with suppress(*cache.DAMAGED):
            ends = _read(path, ("depth", "force", "modulus"))
            scale = finger.skin.modulus / float(ends["modulus"])
            deepest.append((float(ends["depth"][-1]), float(ends["force"][-1]) * scale))
    return max(deepest)


def at_hand(finger: Finger, indenter: Indenter, mesh: "FingerMesh") -> DepthTable | None:
    """Read the deepest table that is shipped or cached; None where none is, or all are damaged."""
    tables = []
    for path in _paths(key_on(finger, indenter, mesh)):
        with suppress(*cache.DAMAGED):
            tables.append(read(path).of_modulus(finger.skin.modulus))
    return max(tables, key=lambda table: table.deepest, default=None)


def cached_path(name: str) -> Path:
    """Path of a table in the user's cache."""
    return cache.root() / "elastic" / f"{name[:DIGITS]}.npz"


def shipped(name: str) -> Iterator[Path]:
    """Shipped files of a table: one or none."""
    yield from data_folder().glob(f"{PREFIX}*-{name[:DIGITS]}.npz")


def _paths(name: str) -> Iterator[Path]:
    yield from shipped(name)
    place = cached_path(name)
    if os.path.isfile(place):
        cache.touch(place)
        yield place


def as_stored(table: DepthTable) -> DepthTable:
    """Round a table as its file does, so that the first answer is that of all later ones."""
    rounded = {name: getattr(table, name).astype(np.float32).astype(float) for name in ROUNDED}
    return replace(table, **rounded)


def write(table: DepthTable, place: Path) -> None:
    """Write a table to a file, which appears complete or not at all."""
    values: dict[str, Any] = {name: getattr(table, name) for name in EXACT}
    values |= {name: getattr(table, name).astype(np.float32) for name in ROUNDED}
    values |= {name: getattr(table, name) for name in ("reach", "modulus")}
    values |= {"amplitudes": table.modes.amplitudes, "shapes": table.modes.shapes}
    place.parent.mkdir(parents=True, exist_ok=True)
    with moved(place) as new:
        np.savez_compressed(new, **values)


def read(place: Path) -> DepthTable:
    """Read a table from a file; raises one of `cache.DAMAGED` where it cannot be read."""
    values = _read(place)
    return DepthTable(
        **{name: values[name].astype(float) for name in (*EXACT, *ROUNDED)},
        modes=DisplacementBasis(values["amplitudes"], values["shapes"]),
        reach=float(values["reach"]),
        modulus=float(values["modulus"]),
    )


def _read(place: Path, names: tuple[str, ...] = ()) -> dict[str, Any]:
    """Read arrays by name, all of them without names."""
    with place.open("rb") as opened, np.load(opened, allow_pickle=False) as stored:
        return {name: stored[name] for name in names or stored.files}
