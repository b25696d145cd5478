"""Record of a finger mesh: its quality, the check of it, and its files for ParaView.

The .vtu holds two cell blocks: the tetrahedra with their region, and the triangles of the named
facets with a tag; a tetrahedron has facet tag 0 and a triangle region 0. The sidecar names the
tags and records recipe, versions, quality and the hash of the .vtu.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.finger_mesh import (
    BONE,
    FACETS,
    REGIONS,
    FingerMesh,
    Halves,
    edges,
    faces,
    parts,
    triangle_areas,
    volumes,
)
from fefinger.mesh.finger_shape import PATCH_CENTER, PATCH_RADIUS, PLATE_NORMAL, Shape, fitted_radii
from fefinger.mesh.recipe import Recipe
from fefinger.support import VERSION
from fefinger.support.arrays import Array, Integers
from fefinger.support.atomic_write import in_place
from fefinger.support.checks import ConvergenceError, InputError


if TYPE_CHECKING:
    from meshio import Mesh


MIN_DIHEDRAL = 8.0
"""Degrees; below it the condition of a Taylor-Hood element grows as 1/sin of the angle."""


@dataclass(frozen=True)
class Bounds:
    """What facets may leave out of smooth surfaces.

    Attributes
    ----------
    volume : largest relative error of a region's volume.
    radius : largest relative error of the pad's curvature radii at P30.
    first_touch : largest distance in mm of a vertex before the origin, toward the 30-degree plate.

    """

    volume: float
    radius: float
    first_touch: float


STRICT = Bounds(volume=0.02, radius=0.05, first_touch=1e-6)
"""Bounds of parametric fingers, and those beyond which a note states what is left out of a scan."""

SCANNED = Bounds(volume=0.08, radius=np.inf, first_touch=0.02)
"""Bounds of scans: a radius within 2 mm of one point is one of their bumps."""


def dihedral_angles(points: Array, cells: Integers) -> Array:
    """Return the six dihedral angles of each tetrahedron, (m, 6) degrees."""
    corners = points[faces(cells)]
    normals = np.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=2), 1e-30)[:, :, None]
    pairs = [(i, j) for i in range(4) for j in range(i + 1, 4)]
    cosines = [-np.einsum("ij,ij->i", normals[:, i], normals[:, j]) for i, j in pairs]
    return np.degrees(np.arccos(np.clip(np.stack(cosines, axis=1), -1.0, 1.0)))


def measured_radii(mesh: FingerMesh) -> tuple[float, float]:
    """Return the radii (R', R'') mm at P30, measured on the pad vertices; a half is mirrored."""
    pad = mesh.points[np.unique(mesh.facets["pad"])]
    if mesh.half:
        pad = Halves.of(pad).vectors(pad)
    return fitted_radii(pad)


def record(
    shape: Shape,
    recipe: Recipe,
    points: Array,
    cells: Integers,
    region: NDArray[np.int8],
    facets: Mapping[str, Integers],
    *,
    name: str,
) -> FingerMesh:
    """Make the mesh record, with smooth normals and measured quality; facets as in FACETS."""
    sets = {key: facets[key] for key in FACETS}
    pad = np.unique(sets["pad"])
    gap = float(np.abs(shape.skin.level(points[pad])).max())
    normals = np.zeros_like(points)
    normals[pad] = shape.skin.normals(points[pad])
    mesh = FingerMesh(
        points, cells, region, sets, normals, half=True, name=name, recipe=recipe.to_dict()
    )
    quality = measure(mesh, radii=shape.radii, surface_volumes=shape.volumes, gap=gap)
    left_out = () if recipe.surface is None else scan_notes(quality)
    if shape.notes or left_out:
        quality["notes"] = [*shape.notes, *left_out]
    return replace(mesh, quality=quality)


def measure(
    mesh: FingerMesh, *, radii: tuple[float, float], surface_volumes: dict[str, float], gap: float
) -> dict[str, Any]:
    """Return the quality figures of a mesh; angles in degrees, lengths mm, volumes mm^3.

    `radii` are the wanted ones, `surface_volumes` those inside the smooth surfaces by region name,
    `gap` the largest distance of a pad vertex from the smooth skin.
    """
    points, cells = mesh.points, mesh.cells
    angles = dihedral_angles(points, cells)
    smallest = angles.min(axis=1)
    volume = volumes(points, cells)
    by_region = {name: float(volume[mesh.region == k].sum()) for name, k in REGIONS.items()}
    soft = cells[mesh.region != BONE]
    vertices, lines = len(np.unique(soft)), len(edges(soft))
    pad = np.unique(mesh.facets["pad"])
    patch = _patch_edges(mesh)
    bone = points[np.unique(mesh.facets["bone"])]
    measured = measured_radii(mesh)
    return {
        "n_points": len(points),
        "n_cells": len(cells),
        "n_pad_vertices": len(pad),
        "soft_vertices": vertices,
        "taylor_hood_unknowns": 3 * (vertices + lines) + vertices,
        "parts": {name: parts(cells[mesh.region == k]) for name, k in REGIONS.items()},
        "min_volume": float(volume.min()),
        "min_dihedral_deg": float(smallest.min()),
        "dihedral_1pct_deg": float(np.percentile(smallest, 1.0)),
        "max_dihedral_deg": float(angles.max()),
        "volumes": by_region,
        "surface_volumes": {name: float(value) for name, value in surface_volumes.items()},
        "volume_errors": {k: by_region[k] / surface_volumes[k] - 1.0 for k in surface_volumes},
        "radii": list(measured),
        "radii_wanted": [float(value) for value in radii],
        "radii_errors": [float(f / w - 1.0) for f, w in zip(measured, radii, strict=True)],
        "surface_gap": gap,
        "first_touch": float(np.max(points[pad] @ PLATE_NORMAL)),
        "pulp_thickness": float(np.linalg.norm(bone, axis=1).min()),
        "pad_edge_mean": float(patch.mean()),
        "pad_edge_max": float(patch.max()),
        "nail_area": float(triangle_areas(points[mesh.facets["nail"]]).sum()) * (1 + mesh.half),
    }


def gate(quality: dict[str, Any], bounds: Bounds = STRICT) -> None:
    """Raise ConvergenceError that lists every figure out of bounds."""
    faults = []
    if quality["min_volume"] <= 0.0:
        faults.append(f"a cell of volume {quality['min_volume']:.2g} mm3 (inverted or flat)")
    if not quality["min_dihedral_deg"] >= MIN_DIHEDRAL:
        angle = quality["min_dihedral_deg"]
        faults.append(f"a dihedral angle of {angle:.2f} degrees, wanted {MIN_DIHEDRAL:g} or more")
    for name, count in quality["parts"].items():
        if count != 1:
            faults.append(f"{name} in {count} parts, wanted one")
    # Largest distance in mm of a pad vertex from the smooth skin, which defines the contact gap.
    surface_gap = 1e-5
    if not quality["surface_gap"] <= surface_gap:
        faults.append(f"a pad vertex {quality['surface_gap']:.2g} mm off the smooth skin")
    faults += _off(quality, bounds)
    if faults:
        raise ConvergenceError(f"mesh: the quality check found {'; '.join(faults)}")


def _off(quality: dict[str, Any], bounds: Bounds) -> list[str]:
    """List the differences between facets and smooth surfaces that are out of bounds."""
    faults = []
    for name, error in quality["volume_errors"].items():
        if not abs(error) <= bounds.volume:
            faults.append(
                f"a {name} volume {error:+.1%} off its surface's, wanted {bounds.volume:.0%} or "
                "less"
            )
    for name, error in zip(("along", "across"), quality["radii_errors"], strict=True):
        if not abs(error) <= bounds.radius:
            faults.append(
                f"a pad radius {name} the finger {error:+.1%} off, wanted {bounds.radius:.0%}"
            )
    if not abs(quality["first_touch"]) <= bounds.first_touch:
        faults.append(f"a first touch {quality['first_touch']:.2g} mm before the origin")
    return faults


def scan_notes(quality: dict[str, Any]) -> tuple[str, ...]:
    """Note on what the facets leave out of a scan, beyond what they do of a parametric finger."""
    faults = _off(quality, STRICT)
    if not faults:
        return ()
    product = float(np.prod(1.0 + np.array(quality["radii_errors"])))
    light = "The pad is hollow there in one of the two, which leaves a light touch unknown; "
    if product > 0.0:
        light = (
            f"By the pad's radii the force of a light touch is {product**0.25 - 1.0:+.1%} off "
            "(Hertz), that of a deep press less; "
        )
    return (
        f"The facets of the mesh leave details of the scan out: {', '.join(faults)}. {light}"
        "a finer mesh (finger.resolution) has more of them.",
    )


def _patch_edges(mesh: FingerMesh) -> Array:
    """Return the lengths of the pad's edges within the contact patch, mm."""
    pad = mesh.facets["pad"]
    close = np.linalg.norm(mesh.points - PATCH_CENTER, axis=1) < PATCH_RADIUS
    pad = pad[close[pad].all(axis=1)]
    return np.asarray(np.linalg.norm(np.diff(mesh.points[edges(pad)], axis=1)[:, 0], axis=1))


LAYOUT = 1
"""Version of the file layout; a reader refuses another."""

TAGS = {name: number for number, name in enumerate(FACETS, start=1)}
"""Numbers of the facet sets in a file."""

NEEDED = ("name", "half", "facet_tags", "sha256", "recipe", "quality")
"""Fields that a sidecar must have."""

TOOLS = ("pytetwild", "numpy", "scipy")
"""Libraries whose version affects the mesh, besides fefinger's own."""


def write(mesh: FingerMesh, path: str | Path) -> Path:
    """Write a mesh to `path` (.vtu) and its sidecar; each appears whole or not at all.

    Raises InputError, which names the file, where it cannot be written.
    """
    import meshio

    path = _checked(path)
    sets = {name: mesh.facets.get(name, np.empty((0, 3), dtype=np.int64)) for name in TAGS}
    tags = np.repeat(list(TAGS.values()), [len(part) for part in sets.values()])
    triangles = np.concatenate(list(sets.values()))
    region = [mesh.region.astype(np.int8), np.zeros(len(triangles), dtype=np.int8)]
    facet = [np.zeros(len(mesh.cells), dtype=np.int8), tags.astype(np.int8)]
    content = meshio.Mesh(
        mesh.points,
        [("tetra", mesh.cells.astype(np.int32)), ("triangle", triangles.astype(np.int32))],
        point_data={"pad_normal": mesh.pad_normals},
        cell_data={"region": region, "facet": facet},
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    with in_place(path) as new:
        meshio.write(str(new), content, file_format="vtu")
    sidecar = {
        "layout": LAYOUT,
        "name": mesh.name,
        "half": mesh.half,
        "frame": "x distal, y radial, z dorsal, mm; origin at first touch of a 30-degree plate",
        "facet_tags": TAGS,
        "sha256": _hash(path),
        "recipe": mesh.recipe,
        "versions": {"fefinger": VERSION, **{tool: version(tool) for tool in TOOLS}},
        "quality": mesh.quality,
    }
    text = json.dumps(sidecar, indent=1) + "\n"
    with in_place(sidecar_path(path)) as new:
        new.write_text(text, encoding="utf-8")
    return path


def read(path: str | Path) -> FingerMesh:
    """Read a mesh from a .vtu file and its sidecar.

    Raises InputError if either is missing or the .vtu is not the one the sidecar was written for.
    """
    import meshio

    path = _checked(path)
    for part in (path, sidecar_path(path)):
        if not part.is_file():
            message = f"mesh: expected the file {part}, which does not exist; build the mesh again"
            raise InputError(message)
    sidecar = _sidecar(sidecar_path(path))
    sha256 = _hash(path)
    if sha256 != sidecar["sha256"]:
        raise InputError(
            f"mesh: expected {path} to have the hash {sidecar['sha256'][:12]}... of its sidecar, "
            f"received {sha256[:12]}...; one of the two was changed, build the mesh again"
        )
    return _mesh(meshio.read(path, file_format="vtu"), sidecar)


def sidecar_path(path: Path) -> Path:
    """Return the path of the sidecar of a mesh file."""
    return path.with_suffix(".json")


def _sidecar(path: Path) -> dict[str, Any]:
    """Read a sidecar; raise InputError if it has another layout or lacks a field."""
    try:
        sidecar = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise InputError(f"mesh: expected JSON in {path}, received {error}") from error
    layout = sidecar.get("layout") if isinstance(sidecar, dict) else None
    if layout != LAYOUT:
        raise InputError(
            f"mesh: expected layout {LAYOUT} in {path}, received {layout!r}; build the mesh again"
        )
    missing = [name for name in NEEDED if name not in sidecar]
    if missing:
        message = f"mesh: expected {missing[0]!r} in {path}, received none; build the mesh again"
        raise InputError(message)
    return dict(sidecar)


def _mesh(content: "Mesh", sidecar: dict[str, Any]) -> FingerMesh:
    """Make the mesh record from a meshio mesh and its sidecar."""
    cells = np.asarray(content.cells_dict["tetra"], dtype=np.int64)
    triangles = np.asarray(content.cells_dict["triangle"], dtype=np.int64)
    tags = content.cell_data_dict["facet"]["triangle"]
    facets = {name: triangles[tags == tag] for name, tag in sidecar["facet_tags"].items()}
    return FingerMesh(
        np.asarray(content.points, dtype=np.float64),
        cells,
        np.asarray(content.cell_data_dict["region"]["tetra"], dtype=np.int8),
        {name: part for name, part in facets.items() if len(part)},
        np.asarray(content.point_data["pad_normal"], dtype=np.float64),
        half=bool(sidecar["half"]),
        name=str(sidecar["name"]),
        recipe=sidecar["recipe"],
        quality=sidecar["quality"],
        source_sha256=str(sidecar["sha256"]),
    )


def _checked(path: str | Path) -> Path:
    """Check that a path ends in .vtu."""
    path = Path(path)
    if path.suffix != ".vtu":
        raise InputError(f"mesh: expected a file name that ends in .vtu, received {path.name!r}")
    return path


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
