"""The operator of a finger: built once, kept in the user's cache under the hash of its content.

An operator depends on the ratio of the moduli only; it is built for a skin of 1 kPa and scaled.
"""

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from fefinger.checks import InputError
from fefinger.fem.body import prescribed, solid
from fefinger.fem.condense import PALMAR, Compliance, Operator, Part, condense, mirrored
from fefinger.fem.forms import Elastic
from fefinger.fem.multifrontal import Eliminated, Front
from fefinger.mesh.ready import ready
from fefinger.mesh.record import FingerMesh
from fefinger.scene import Finger


FORMAT = 1
"""Raised when the elements, the solver or the files change, so that operators are built again."""

ARRAYS = ("order", "table", "rest", "values", "matrix")


def operator(
    finger: Finger, *, half: bool, progress: Callable[[float], None] = lambda fraction: None
) -> Operator:
    """Return the operator of a finger, or of half of it, from the cache or built and put there.

    Raises
    ------
    InputError
        If the cache holds something else under the hash of this finger.
    """
    mesh = ready(finger, half=True)
    own = solid(mesh, (1, 2))
    body = own if half else solid(ready(finger, half=False), (1, 2))
    parts = []
    for number, odd in enumerate((False,) if half else (False, True)):
        compliance = _compliance(finger, mesh, odd=odd)
        if half:
            unfold = sparse.eye(own.space.n_unknowns, format="csr")
        else:
            unfold = mirrored(body.space, own.space, odd=odd)
        parts.append(Part(compliance, unfold, (1.0 if half else 0.5) / finger.skin.modulus))
        progress((number + 1) / (1 if half else 2))
    return Operator(body.space, body.pad, body.normals, body.original, half, tuple(parts))


def at_hand(finger: Finger, *, half: bool) -> bool:
    """Return whether the operator of a finger is in the cache and need not be built."""
    mesh = ready(finger, half=True)
    parities = (False,) if half else (False, True)
    return all(folder(identity(finger, mesh, odd=odd)).is_dir() for odd in parities)


def held(finger: Finger) -> tuple[str, ...]:
    """Return the facets that do not move."""
    return ("bone", "nail", "cut") if finger.cut == "fixed" else ("bone", "nail")


def identity(finger: Finger, mesh: FingerMesh, *, odd: bool) -> dict[str, Any]:
    """Return all that decides an operator."""
    facets = hashlib.sha256(mesh.pad_normals.tobytes())
    for name in ("pad", "medial", *held(finger)):
        facets.update(mesh.facets[name].tobytes())
    return {
        "format": FORMAT,
        "element": "Taylor-Hood, P2 and P1 per tissue",
        "solver": "multifrontal, pad last",
        "mesh": mesh.fingerprint,
        "facets": facets.hexdigest(),
        "held": list(held(finger)),
        "palmar": PALMAR,
        "modulus_ratio": finger.subcutaneous.modulus / finger.skin.modulus,
        "poisson": [finger.skin.poisson, finger.subcutaneous.poisson],
        "parity": "odd" if odd else "even",
    }


def folder(identity: dict[str, Any]) -> Path:
    """Return where the user's cache keeps an operator."""
    from platformdirs import user_cache_path

    key = hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()
    return user_cache_path("fefinger") / "operators" / key[:16]


def read(place: Path, identity: dict[str, Any]) -> Compliance:
    """Return the compliance in a folder, mapped into memory.

    Raises
    ------
    InputError
        If the folder is damaged, or what it holds was built from something else.
    """
    advice = f"delete the folder {str(place)!r}, and it is built again"
    try:
        found = json.loads((place / "identity.json").read_text(encoding="utf-8"))
        arrays = {name: np.load(place / f"{name}.npy", mmap_mode="r") for name in ARRAYS}
    except (OSError, ValueError) as error:
        message = f"operator: expected {len(ARRAYS)} arrays and their identity ({error}); {advice}"
        raise InputError(message) from None
    for name, value in identity.items():
        if found.get(name) != value:
            message = (
                f"operator: expected one with {name} = {value!r}, received one with "
                f"{found.get(name)!r}; {advice}"
            )
            raise InputError(message)
    return Compliance(
        np.array(arrays["order"]), tuple(_fronts(arrays)), arrays["matrix"].view(np.ndarray)
    )


def write(compliance: Compliance, place: Path, identity: dict[str, Any]) -> None:
    """Write a compliance into a folder, which appears complete or not at all."""
    place.parent.mkdir(parents=True, exist_ok=True)
    with _scratch(place.parent) as new:
        (new / "identity.json").write_text(json.dumps(identity, indent=1), encoding="utf-8")
        fronts = compliance.fronts
        np.save(new / "order.npy", compliance.order)
        np.save(new / "matrix.npy", compliance.matrix)
        np.save(new / "rest.npy", np.concatenate([f.front.rest for f in fronts]))
        rows = [(f.front.start, f.front.pressure, f.front.stop, len(f.front.rest)) for f in fronts]
        np.save(new / "table.npy", np.array(rows, dtype=np.int64))
        size = sum(f.lower.size + f.below.size for f in fronts)
        values = np.lib.format.open_memmap(new / "values.npy", "w+", np.float64, (size,))
        start = 0
        for front in fronts:
            for block in (front.lower, front.below):
                values[start : start + block.size] = block.ravel(order="F")
                start += block.size
        values.flush()
        del values
        with suppress(OSError):  # another process was faster
            os.rename(new, place)


def _compliance(finger: Finger, mesh: FingerMesh, *, odd: bool) -> Compliance:
    """Return one parity of a finger with a skin of 1 kPa."""
    identified = identity(finger, mesh, odd=odd)
    place = folder(identified)
    if place.is_dir():
        return read(place, identified)
    ratio = finger.subcutaneous.modulus / finger.skin.modulus
    tissues = {1: Elastic(1.0, finger.skin.poisson), 2: Elastic(ratio, finger.subcutaneous.poisson)}
    own = solid(mesh, tissues)
    built = condense(own, tissues, prescribed(own, mesh, held(finger), odd=odd))
    with suppress(OSError):  # without room for it, it is built again the next time
        write(built, place, identified)
    return built


def _fronts(arrays: dict[str, Any]) -> Iterator[Eliminated]:
    """Yield the fronts as views of the file."""
    rest, values = np.array(arrays["rest"]), arrays["values"].view(np.ndarray)
    first = start = 0
    for begin, pressure, stop, below in arrays["table"].tolist():
        n = stop - begin
        front = Front(begin, pressure, stop, rest[first : first + below], ())
        lower = values[start : start + n * n].reshape((n, n), order="F")
        start += n * n
        under = values[start : start + below * n].reshape((below, n), order="F")
        start, first = start + below * n, first + below
        signs = np.ones((n, 1))
        signs[pressure - begin :] = -1.0
        yield Eliminated(front, lower, under, signs)


@contextmanager
def _scratch(parent: Path) -> Iterator[Path]:
    """Yield a new folder in `parent` that is removed, unless it was renamed."""
    path = Path(tempfile.mkdtemp(dir=parent, prefix=".building-"))
    try:
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)
