"""Condensed operator of a finger: read from the cache, or built and cached."""

import hashlib
import json
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from fefinger.fem import condensation as reduction
from fefinger.fem.body import Reduced, prescribed, solid
from fefinger.fem.condensation import Compliance, Operator, Part, condense, mirrored
from fefinger.fem.contact.patch import Patch
from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.linalg.dissection import Front
from fefinger.fem.linalg.multifrontal import Eliminated
from fefinger.geometry.finger_mesh import FingerMesh, whole
from fefinger.mechanics.press.notes import own_relaxation_reasons
from fefinger.mechanics.press.operator_cache import description, folder, identity, parities
from fefinger.mechanics.press.problem import SolutionMethod, fixed_facets
from fefinger.mesh.extend import CONTINUATION
from fefinger.mesh.store import load_or_build
from fefinger.scene.finger import Finger
from fefinger.support import cache
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


STRAIN = "recovered"
"""How strain at points is read; a part of the key of what is cached."""

ARRAYS = ("order", "table", "rest", "values", "matrix")


def operator(
    finger: Finger,
    *,
    half: bool,
    with_continuation: bool = False,
    progress: Callable[[float], None] = lambda fraction: None,
) -> Operator:
    """Return the operator of a finger, or of half of it; it is built and cached if needed.

    `with_continuation`: of the finger that is longer behind its proximal cut.

    InputError if the tissues of the finger do not relax as one, so that no step of it would be
    right.
    """
    for reason in own_relaxation_reasons(finger):
        raise InputError(f"{reason.text}; use the mechanics 'solid'")
    mesh = load_or_build(finger, half=True, with_continuation=with_continuation)
    meshed = solid(mesh, (1, 2))
    body = meshed if half else solid(whole(mesh), (1, 2))
    parts: list[Part] = []
    wanted = parities(half=half)
    identities = tuple(identity(finger, odd=odd, mesh=mesh) for odd in wanted)
    for odd, identified in zip(wanted, identities, strict=True):
        compliance = _compliance(finger, mesh, identified, odd=odd)
        if half:
            unfold = sparse.eye(meshed.space.n_unknowns, format="csr")
        else:
            unfold = mirrored(body.space, meshed.space, odd=odd)
        parts.append(Part(compliance, unfold, 1.0 / (len(wanted) * finger.skin.modulus)))
        progress(len(parts) / len(wanted))
    return Operator(
        body.space, body.pad, body.normals, body.original, half, tuple(parts), identities
    )


def build(finger: Finger, mesh: FingerMesh, *, odd: bool) -> Compliance:
    """Condense the even or `odd` part of a finger from the mesh of its half, with skin of 1 kPa."""
    ratio = finger.subcutaneous.modulus / finger.skin.modulus
    tissues = {1: Elastic(1.0, finger.skin.poisson), 2: Elastic(ratio, finger.subcutaneous.poisson)}
    body = solid(mesh, tissues)
    return condense(body, tissues, prescribed(body, mesh, fixed_facets(finger), odd=odd))


def read(place: Path) -> Compliance:
    """Return the compliance in a folder, mapped into memory."""
    arrays = {name: np.load(place / f"{name}.npy", mmap_mode="r") for name in ARRAYS}
    return Compliance(
        np.array(arrays["order"]), tuple(_fronts(arrays)), arrays["matrix"].view(np.ndarray)
    )


def reduced(
    finger: Finger,
    solid: Operator,
    patch: Patch,
    points: Array,
    probe: Callable[[], sparse.csr_matrix],
) -> Reduced:
    """Return the operator reduced to a patch and to the strain at `points`, cached likewise.

    `probe` gives the strain at the points; it is called only where the cache lacks the answer.
    """
    digest = hashlib.sha256(json.dumps([solid.identities, finger.skin.modulus]).encode())
    on_pad = (patch.loads, patch.places)
    sparse_arrays = [array for each in on_pad for array in (each.indptr, each.indices, each.data)]
    for array in (*sparse_arrays, points):
        digest.update(np.ascontiguousarray(array).tobytes())
    names = ("flexibility", "strain", "normal_displacement")  # of the files, and in the key
    digest.update(f"{STRAIN}: {' '.join(names)}".encode())
    place = cache.root() / "patches" / digest.hexdigest()[:16]

    def read(folder: Path) -> Reduced:
        arrays = (np.load(folder / f"{name}.npy", mmap_mode="r") for name in names)
        return Reduced(patch, *(array.view(np.ndarray) for array in arrays))

    stored = cache.load(place, read)
    if stored is not None:
        return stored
    made = reduction.reduce(solid, patch, probe())
    if None not in solid.identities:
        what = f"object on a finger, for `condensed`: {len(patch.vertices)} points of the pad"
        with suppress(OSError), cache.appearing(place, what) as new:
            arrays = [made.flexibility, made.strain_operator, made.normal_displacement]
            for name, array in zip(names, arrays, strict=True):
                np.save(new / f"{name}.npy", array)
        cache.limit("patches")
    return made


def write(compliance: Compliance, place: Path, what: str) -> None:
    """Write a compliance into an entry of the cache, which `what` describes."""
    with cache.appearing(place, what) as new:
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


def _compliance(
    finger: Finger, mesh: FingerMesh, identified: dict[str, object] | None, *, odd: bool
) -> Compliance:
    """Return the compliance of the even or `odd` part: from the cache, or built and put there."""
    if identified is None:
        return build(finger, mesh, odd=odd)
    place = folder(identified)
    stored = cache.load(place, read)
    if stored is not None:
        return stored
    built = build(finger, mesh, odd=odd)
    with suppress(OSError):  # without room for it, it is built again the next time
        write(built, place, description(finger, identified, "condensed"))
        cache.limit("operators")
    return built


def _fronts(arrays: dict[str, Any]) -> Iterator[Eliminated]:
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


METHOD = SolutionMethod(
    lambda finger, mesh, report: operator(
        finger, half=mesh.half, with_continuation=CONTINUATION in mesh.recipe, progress=report
    ),
    reduction.reduce,
    reduction.displaced,
    lambda indenter: None,
)
"""Method of `condensed`: one mesh for all indenters, that of the 30 degree plate."""
