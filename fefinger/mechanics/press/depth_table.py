"""Table over depth of the elastic contact of a relaxed finger with one object, at finite strain.

The displacements of all depths are stored as a few modes, from which any strain and field is read.
Tables are files, shipped with the package or in the cache of the user. A table depends on the mesh,
the object and the tissues up to one modulus, not on the relaxation nor on the motion but for its
depth.
"""

import hashlib
import json
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.laws import LAWS
from fefinger.mechanics.press.mesh_limits import needs_continuation, refinement_location
from fefinger.mechanics.press.sites import REFERENCE_DEPTH
from fefinger.mesh.recipe import data_folder
from fefinger.mesh.store import sha256
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.motion import Motion
from fefinger.support import cache
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


Value = TypeVar("Value")

SHALLOWEST = 0.0016
"""Depth of the first row over the thickness of the finger, in tables that other motions share."""

PARTS = 5
"""Steps between two depths of a table, equal in the root, as for the contact radius of a ball."""

STEP, LEVELS = 3e-5, 32767
"""Displacement in mm to which modes are rounded, and the most steps of one: 16 bits."""

FORMAT = 7
"""Raised when the solver, the depths or the files change, so that tables are solved again."""

PREFIX = "press-"
"""Of the names of shipped tables, which end with the first DIGITS of their key."""

DIGITS = 16  # of a hexadecimal key: 64 bits keep tables apart in short names

FILE = "table.npz"
"""File of a cached table."""

EXACT = ("depth", "force", "moment", "area", "stiffening", "work")
ROUNDED = ("pressure", "gap")
"""Arrays that are stored in double and in single precision."""


@dataclass(frozen=True)
class DisplacementBasis:
    """Displacements as a few modes: fields (n, m) = amplitudes (n, r) @ shapes (r, m).

    The shapes are whole numbers of steps, which files hold in few bits.
    """

    amplitudes: Array
    shapes: NDArray[np.int16]

    @classmethod
    def of(cls, fields: Array) -> Self:
        """Return the modes of fields (n, m) mm, from their singular values, rounded."""
        # By the products of the fields: a tenth of the time of a decomposition of the fields.
        square, left = np.linalg.eigh(fields @ fields.T)
        rank = 1e-6  # least singular value of a mode over the largest
        kept = square > rank**2 * square[-1]
        amplitudes, shapes = left[:, kept] * np.sqrt(square[kept]), left[:, kept].T @ fields
        shapes /= np.sqrt(square[kept])[:, None]
        step = STEP / np.abs(amplitudes).max(axis=0)
        step = np.maximum(step, np.abs(shapes).max(axis=1) / LEVELS)
        return cls(amplitudes * step, np.rint(shapes / step[:, None]).astype(np.int16))


@dataclass(frozen=True)
class DepthTable:
    """Elastic contact of a relaxed finger, a row per depth; the first depth is 0.

    depth (n,) mm; force (n,) N of the whole finger; moment (n, 3) mN mm of the meshed part; area
    (n,) mm²; stiffening (n,): mean exponent b (I1 - 3) of the energies of the tissues; work (n, n):
    ratios of `elastic_press.work_ratios`; pressure (n, n_candidates) kPa; gap (n, n_seen) mm;
    modes: displacements (n, n_displacements) mm at the depths and, unless one of them is it, of the
    reference press; reach mm: of the candidates; modulus kPa: of the skin, which forces and
    pressures grow with.
    """

    depth: Array
    force: Array
    moment: Array
    area: Array
    stiffening: Array
    work: Array
    pressure: Array
    gap: Array
    modes: DisplacementBasis
    reach: float
    modulus: float

    @property
    def deepest(self) -> float:
        """Largest depth in mm."""
        return float(self.depth[-1])

    @property
    def at_depths(self) -> Array:
        """Amplitudes (n, r) of the modes at the depths, without the reference press."""
        return self.modes.amplitudes[: len(self.depth)]

    def unknowns(self, amplitudes: Array, count: int) -> Array:
        """Unknowns (..., count) of a body for amplitudes (..., r); its pressures are not stored."""
        unknowns = np.zeros((*amplitudes.shape[:-1], count))
        unknowns[..., : self.modes.shapes.shape[1]] = amplitudes @ self.modes.shapes
        return unknowns

    def reference(self, count: int) -> Array:
        """Unknowns (count,) of a body in the reference press."""
        amplitudes = self.modes.amplitudes
        at = -1
        if len(amplitudes) == len(self.depth):
            at = int(np.flatnonzero(self.depth == REFERENCE_DEPTH)[0])
        return self.unknowns(amplitudes[at], count)

    def of_modulus(self, modulus: float) -> "DepthTable":
        """Return the table of a finger with all moduli scaled, to this one in kPa of the skin."""
        factor = modulus / self.modulus
        return replace(
            self,
            modulus=modulus,
            force=self.force * factor,
            moment=self.moment * factor,
            pressure=self.pressure * factor,
        )

    @cached_property
    def nodes(self) -> Array:
        """Depths (n_nodes,) mm between which `pressed` interpolates linearly.

        All depths of the table are among them, so that deeper rows change none of them.
        """
        root, part = np.sqrt(self.depth), np.arange(PARTS) / PARTS
        nodes = (root[:-1, None] + np.diff(root)[:, None] * part).ravel() ** 2
        nodes[::PARTS] = self.depth[:-1]
        return np.append(nodes, self.deepest)

    @cached_property
    def measure(self) -> Array:
        """Measure (n_nodes,) mm of the depth at the nodes, in which the finger relaxes on retreat.

        sqrt(d F) exp(s), but for a factor: the geometric mean of the force F, with which all of the
        finger would recover as one, and of d exp(2 s), which of tissue that does not stiffen is the
        depth d, as in the theory of a linear body. s is the mean exponent of the energies. Of
        fourteen such means it has, on retreat, the smallest error of force or depth (2.4 % in root
        mean square) and of strain (8.3 %, as two others) in the scenes "rules" of
        `fefinger.validation.pressed.measure` and 20 trapezoids of force; the scenes "held-out" had
        no part in the choice.
        """
        exponent = np.maximum.accumulate(np.maximum(self.bounded(self.stiffening), 0.0))
        secant = np.append(0.0, self.force_at_nodes[1:] / self.nodes[1:])
        # Secant stiffness over that at the largest depth, at depths where a mesh resolves no
        # contact.
        unresolved = 1e-9
        part = np.maximum(secant / secant[-1], unresolved)
        return np.asarray(self.nodes * np.exp(exponent) * np.sqrt(part))

    @cached_property
    def force_at_nodes(self) -> Array:
        """Force (n_nodes,) N at the nodes: without overshoot, on logarithmic axes.

        There it is almost straight. Vertices come into contact one by one: the force of pressures
        that are interpolated each is up to 7 % off between depths, this one within 0.5 % from the
        third depth on (standard mesh, plate at 30 degrees).
        """
        from scipy.interpolate import PchipInterpolator

        first = int(np.argmax(self.force > 0))
        depth, force = np.log(self.depth[first:]), np.log(self.force[first:])
        nodes, borne = self.nodes, np.zeros(len(self.nodes))
        resolved = nodes >= self.depth[first]
        borne[resolved] = np.exp(PchipInterpolator(depth, force)(np.log(nodes[resolved])))
        # A mesh does not resolve the first touch: a power of the depth, as it goes on.
        before = self.depth[first - 1]
        power = (force[1] - force[0]) / (depth[1] - depth[0])
        touching = ~resolved & (nodes > before)
        part = (nodes[touching] - before) / (self.depth[first] - before)
        borne[touching] = self.force[first] * part**power
        borne[::PARTS] = self.force
        return borne

    @cached_property
    def work_at_nodes(self) -> Array:
        """Work ratios (n_nodes, n_nodes) at the nodes, linear in the root of both depths."""
        root = np.sqrt(self.depth)
        hats = np.array([np.interp(np.sqrt(self.nodes), root, each) for each in np.eye(len(root))])
        return np.asarray(hats.T @ self.work @ hats)

    @cached_property
    def between(self) -> Array:
        """Weights (n_nodes, n) of the depths at the nodes, by splines in the root of the depth."""
        from scipy.interpolate import CubicSpline

        splines = CubicSpline(np.sqrt(self.depth), np.eye(len(self.depth)))
        return np.asarray(splines(np.sqrt(self.nodes)))

    def bounded(self, values: Array) -> Array:
        """Interpolate (n, ...) to the nodes without overshoot, so that no pressure pulls."""
        from scipy.interpolate import PchipInterpolator

        return np.asarray(PchipInterpolator(np.sqrt(self.depth), values)(np.sqrt(self.nodes)))


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
        [*map(repr, (finger.bone, finger.nail, finger.cut)), indenter.signature],
    ]
    if not half:
        parts.append("whole")
    own = [layer for layer in layers if layer.law not in LAWS.shipped]
    parts += [LAWS[layer.law].fingerprint(layer.law_values) for layer in own]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def key_on(finger: Finger, indenter: Indenter, mesh: FingerMesh) -> str:
    """Key of a table on a mesh."""
    return key(finger, indenter, mesh.source_sha256 or mesh.fingerprint, half=mesh.half)


def deepest_at_hand(finger: Finger, indenter: Indenter, motion: Motion) -> tuple[float, float]:
    """Largest depth in mm and force in N of the shipped or cached tables; 0, 0 without any."""
    long = needs_continuation(finger, indenter, motion)
    try:
        source = sha256(finger, refinement_location(indenter), with_continuation=long)
    except InputError:  # no mesh can be made for a finger of this size
        source = None
    if source is None:
        return 0.0, 0.0
    deepest = [(0.0, 0.0)]
    half = indenter.mirrored and motion.mirrored
    read_ends = partial(_read, names=("depth", "force", "modulus"))
    for ends in _stored(key(finger, indenter, source, half=half), read_ends):
        scale = finger.skin.modulus / float(ends["modulus"])
        deepest.append((float(ends["depth"][-1]), float(ends["force"][-1]) * scale))
    return max(deepest)


def available(finger: Finger, indenter: Indenter, mesh: FingerMesh) -> DepthTable | None:
    """Read the deepest table that is shipped or cached; None where none is, or all are damaged."""
    tables = _stored(key_on(finger, indenter, mesh), read)
    deepest = max(tables, key=lambda table: table.deepest, default=None)
    return None if deepest is None else deepest.of_modulus(finger.skin.modulus)


def cached_path(name: str) -> Path:
    """Folder of a table in the user's cache."""
    return cache.root() / "elastic" / name[:DIGITS]


def shipped(name: str) -> Iterator[Path]:
    """Shipped files of a table: one or none."""
    yield from data_folder().glob(f"{PREFIX}*-{name[:DIGITS]}.npz")


def _stored(name: str, read: Callable[[Path], Value]) -> Iterator[Value]:
    """Yield what `read` makes of the shipped and cached files of a table that are not damaged."""
    for path in shipped(name):
        with suppress(*cache.DAMAGED):
            yield read(path)
    cached = cache.load(cached_path(name), lambda folder: read(folder / FILE))
    if cached is not None:
        yield cached


def keep(table: DepthTable, name: str) -> None:
    """Write a table into the cache, in place of a shallower one; OSError where it cannot be."""
    reach = f"{len(table.depth)} depths to {table.deepest:.3g} mm and {table.force[-1]:.3g} N"
    what = f"object on a finger, for `pressed`: table of {reach}"
    with cache.appearing(cached_path(name), what, replacing=True) as new:
        write(table, new / FILE)


def as_stored(table: DepthTable) -> DepthTable:
    """Round a table as its file does, so that the first answer equals all later ones."""
    rounded = {name: getattr(table, name).astype(np.float32).astype(float) for name in ROUNDED}
    return replace(table, **rounded)


def write(table: DepthTable, place: Path) -> None:
    """Write a table to a file."""
    values: dict[str, Any] = {name: getattr(table, name) for name in EXACT}
    values |= {name: getattr(table, name).astype(np.float32) for name in ROUNDED}
    values |= {name: getattr(table, name) for name in ("reach", "modulus")}
    values |= {"amplitudes": table.modes.amplitudes, "shapes": table.modes.shapes}
    np.savez_compressed(place, **values)


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
    with place.open("rb") as opened, np.load(opened, allow_pickle=False) as stored:
        return {name: stored[name] for name in names or stored.files}
