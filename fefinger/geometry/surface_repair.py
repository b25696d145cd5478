"""A surface in one piece, closed and oriented outward: repairs of what a scanner leaves."""

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.surface_load import load
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from trimesh import Trimesh


def read_closed(
    path: str | Path, field: str, place: Array | None = None
) -> "tuple[Trimesh, tuple[str, ...]]":
    """Read a surface in one piece, closed and oriented outward; also return notes on repairs.

    place: (4, 4) transform of its points. Raises InputError for a file that is no such surface and
    cannot safely be repaired.
    """
    mesh, notes = read_welded(path, field)
    if place is not None:
        mesh.apply_transform(place)
    low, high = mesh.bounds[:, 0]
    problem = f"{field}: expected a closed surface, {Path(path).name}"
    back = 0.25  # proximal share of the length where the surface of a bone may be open
    more, _ = close(mesh, problem, low + back * (high - low), place)
    return mesh, (*notes, *more)


def read_welded(path: str | Path, field: str) -> "tuple[Trimesh, tuple[str, ...]]":
    """Read a surface in one piece, with or without holes; also return notes on repairs.

    Raises InputError for a file that is none.
    """
    mesh, said = load(path, field)
    file, notes = Path(path), [*said]
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    faces = len(mesh.faces)
    mesh.update_faces(mesh.nondegenerate_faces() & mesh.unique_faces())
    mesh.remove_unreferenced_vertices()
    if len(mesh.faces) < faces:
        dropped = faces - len(mesh.faces)
        notes.append(f"{dropped} flat or double triangles of {file.name} were dropped.")
    if len(mesh.faces) == 0:
        raise InputError(f"{field}: expected a surface, {file.name} has only flat triangles")
    parts = mesh.body_count
    if parts > 1:
        notes.append(_largest(mesh, parts, file, field))
    return mesh, tuple(notes)


def _largest(mesh: "Trimesh", parts: int, file: Path, field: str) -> str:
    """Leave out small pieces, in place; return a note, or raise InputError if they are large."""
    from trimesh.graph import connected_component_labels

    label = connected_component_labels(mesh.face_adjacency, node_count=len(mesh.faces))
    areas = np.bincount(label, weights=mesh.area_faces)
    share = 1.0 - float(areas.max() / areas.sum())
    # Largest share of the area in pieces apart from the largest one, which are left out.
    piece = 0.02
    if share > piece:
        raise InputError(
            f"{field}: expected one connected surface, {file.name} has {parts} separate ones; keep "
            "only the skin"
        )
    mesh.update_faces(label == np.argmax(areas))
    mesh.remove_unreferenced_vertices()
    return (
        f"{len(areas) - 1} pieces of {file.name} apart from the skin, {share:.1%} of its area, "
        "were left out."
    )


def close(
    mesh: "Trimesh", problem: str, behind: float, place: Array | None = None
) -> tuple[tuple[str, ...], float]:
    """Close a surface and orient it outward, in place; return notes, and x where its skin begins.

    Holes are filled where they are small or lie proximal of x = `behind` mm. `problem` begins the
    message of an InputError; place: (4, 4) transform that the file's points were moved by.
    """
    notes, start = [], float(mesh.bounds[0, 0])
    pinched = _without_pinches(mesh)
    if pinched:
        notes.append(f"{pinched} triangles at edges with more than two of them were left out.")
    back = np.asarray(np.eye(4) if place is None else np.linalg.inv(place), dtype=float)
    for loop in _holes(mesh, problem, behind, back):
        rim = mesh.vertices[np.unique(loop)]
        if _is_wide(rim, mesh):
            start = max(start, float(rim[:, 0].max()))
        notes.append(_filled(mesh, loop, back))
    if _face_outward(mesh):
        notes.append("Triangles that faced inward were turned outward.")
    if not mesh.is_watertight or mesh.volume <= 0:
        raise InputError(
            f"{problem} has edges that do not join two triangles; close it in the program that "
            "made it"
        )
    return tuple(notes), start


def _without_pinches(mesh: "Trimesh") -> int:
    """Leave out triangles at edges that join more than two, in place; return their number."""
    from trimesh.graph import connected_component_labels

    dropped = 0
    for _ in range(3):
        _, inverse, count = np.unique(
            mesh.edges_sorted, axis=0, return_inverse=True, return_counts=True
        )
        bad = (count[inverse.ravel()] > 2).reshape(-1, 3).any(axis=1)
        if not bad.any():
            break
        dropped += int(bad.sum())
        mesh.update_faces(~bad)
        label = connected_component_labels(mesh.face_adjacency, node_count=len(mesh.faces))
        areas = np.bincount(label, weights=mesh.area_faces)
        mesh.update_faces(label == np.argmax(areas))
        mesh.remove_unreferenced_vertices()
    return dropped


def _is_wide(rim: Array, mesh: "Trimesh") -> bool:
    """Whether a rim (n, 3) is too wide for a hole in the skin, as the open proximal end."""
    hole = 0.2  # largest diameter of a hole that is filled, over the finger's width
    return float(np.ptp(rim, axis=0).max()) > hole * float(np.sort(mesh.extents)[1])


def _face_outward(mesh: "Trimesh") -> bool:
    """Orient all triangles outward, in place; return whether some were not."""
    import pyvista as pv

    if mesh.is_winding_consistent and mesh.volume > 0:
        return False
    surface = pv.PolyData.from_regular_faces(mesh.vertices, mesh.faces)
    oriented = surface.compute_normals(
        split_vertices=False, consistent_normals=True, auto_orient_normals=True
    )
    mesh.faces = np.array(oriented.regular_faces)
    return True


def _holes(mesh: "Trimesh", problem: str, behind: float, back: Array) -> list[Integers]:
    """Rims of the holes that may be filled: small ones, and those proximal of x = `behind`.

    A rim holds the edges (n, 2) in the direction of their triangles.
    """
    from trimesh.graph import connected_component_labels
    from trimesh.grouping import group_rows

    rim = mesh.edges[group_rows(mesh.edges_sorted, require_count=1)]
    label = connected_component_labels(rim, node_count=len(mesh.vertices))[rim[:, 0]]
    loops = [rim[label == one] for one in np.unique(label)]
    for loop in loops:
        points = mesh.vertices[np.unique(loop)]
        if _is_wide(points, mesh) and not (points[:, 0] < behind).all():
            across = float(np.ptp(points, axis=0).max())
            x, y, z = back[:3] @ np.append(points.mean(axis=0), 1.0)
            raise InputError(
                f"{problem} has a hole {across:.3g} mm wide near ({x:.3g}, {y:.3g}, {z:.3g}) mm; "
                "close it in the program that made it"
            )
    return loops


def _filled(mesh: "Trimesh", loop: Integers, back: Array) -> str:
    """Close a hole by rings of triangles about its center; return a note on it.

    In the skin they follow the surface around it: a flat lid of a hole in the pad leaves an edge,
    and a plate that presses there meets the edge. The open proximal end gets a flat lid.
    """
    rim, ends = np.unique(loop, return_inverse=True)
    a, b = ends.reshape(loop.shape).T
    points = mesh.vertices[rim]
    middle = points.mean(axis=0)
    across = float(np.ptp(points, axis=0).max())
    if _is_wide(points, mesh):
        lid = middle[None]
    else:
        around = np.linalg.norm(mesh.vertices - middle, axis=1) < across
        # As far apart as the points of the rim.
        lid = _lid(points, mesh.vertices[around], rings=max(1, round(len(loop) / (2 * np.pi))))
    number = len(mesh.vertices)
    inner = number + np.arange(len(lid) - 1).reshape(-1, len(rim))
    rows = [rim, *inner]
    fans = [[rows[-1][b], rows[-1][a], np.full(len(loop), number + len(lid) - 1)]]
    for far, near in pairwise(rows):
        fans += [[far[b], far[a], near[a]], [far[b], near[a], near[b]]]
    mesh.vertices = np.vstack([mesh.vertices, lid])
    mesh.faces = np.vstack([mesh.faces, *(np.column_stack(fan) for fan in fans)])
    x, y, z = back[:3] @ np.append(middle, 1.0)
    return f"A hole of {len(loop)} edges near ({x:.3g}, {y:.3g}, {z:.3g}) mm was filled."


def _lid(rim: Array, near: Array, rings: int) -> Array:
    """Points (n, 3) in a hole with a rim (m, 3): its rings inward of the rim, and its center.

    They lie on the quadric through the points `near` the hole, by least squares over its plane, and
    come to the rim where that is off the quadric.
    """
    middle = rim.mean(axis=0)
    frame = np.linalg.svd(rim - middle, full_matrices=False)[2]
    size = float(np.linalg.norm(rim - middle, axis=1).max())

    def terms(uv: Array) -> Array:
        u, v = uv.T
        return np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=1)

    flat, around = ((each - middle) @ frame.T / size for each in (rim, near))
    fit = np.linalg.lstsq(terms(around[:, :2]), around[:, 2])[0]
    off = flat[:, 2] - terms(flat[:, :2]) @ fit
    points = [np.array([[0.0, 0.0, fit[0]]])]
    for share in np.arange(1, rings) / rings:
        uv = share * flat[:, :2]
        points.insert(0, np.column_stack([uv, terms(uv) @ fit + share**2 * off]))
    return np.asarray(middle + size * np.concatenate(points) @ frame)
