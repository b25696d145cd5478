"""Record of a finger mesh with its quality figures, and the check that rejects a bad mesh."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.finger_mesh import (
    BONE,
    FACETS,
    REGIONS,
    FingerMesh,
    edges,
    faces,
    parts,
    triangle_areas,
    volumes,
)
from fefinger.geometry.mirror import Halves
from fefinger.mesh.finger_shape import Shape
from fefinger.mesh.frame import PATCH_CENTER, PATCH_RADIUS, PLATE_NORMAL, fitted_radii
from fefinger.mesh.recipe import Recipe
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError


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
    touch = float(np.prod(1.0 + np.array(quality["radii_errors"]))) ** 0.25 - 1.0
    return (
        f"The facets of the mesh leave details of the scan out: {', '.join(faults)}. By the pad's "
        f"radii the force of a light touch is {touch:+.1%} off (Hertz), that of a deep press less; "
        "a finer mesh (finger.resolution) has more of them.",
    )


def _patch_edges(mesh: FingerMesh) -> Array:
    """Return the lengths of the pad's edges within the contact patch, mm."""
    pad = mesh.facets["pad"]
    close = np.linalg.norm(mesh.points - PATCH_CENTER, axis=1) < PATCH_RADIUS
    pad = pad[close[pad].all(axis=1)]
    return np.asarray(np.linalg.norm(np.diff(mesh.points[edges(pad)], axis=1)[:, 0], axis=1))
