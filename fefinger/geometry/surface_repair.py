"""A surface in one piece, closed and oriented outward: repairs of what a scanner leaves.

Also the signed distance of such a surface, sampled on a grid.
"""

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.height_map import load
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import InputError
from fefinger.support.inputs import check_input


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
    spans = np.linalg.svd(mesh.vertices - mesh.vertices.mean(axis=0), compute_uv=False)
    plane = 1e-3  # least ratio of the extents of a surface; less is one plane
    if spans[-1] < plane * spans[0]:
        raise InputError(
            f"{field}: expected a surface around a volume, the points of {file.name} lie in one "
            "plane; check how it was exported"
        )
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
    if not mesh.is_winding_consistent:
        surface = pv.PolyData.from_regular_faces(mesh.vertices, mesh.faces)
        oriented = surface.compute_normals(split_vertices=False, consistent_normals=True)
        mesh.faces = np.array(oriented.regular_faces)
    # By the volume: VTK looks at the outermost triangle, which on a flat end face rounding decides.
    if mesh.volume < 0:
        mesh.faces = mesh.faces[:, ::-1].copy()  # mesh.invert() keeps normals that it had computed
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


FOLD = 3
"""Edges between triangles that cross each other up to which that is a fold of the surface."""


def crossings(mesh: "Trimesh") -> Array | None:
    """Find a self-intersection: a point (3,) where an edge passes through a triangle, or None.

    Triangles that share a vertex, and nearly coplanar ones, do not count; nor do folds between
    triangles up to FOLD edges apart, which are noise of a scan.
    """
    # Of a finger one unit wide: the tolerances of the intersection are absolute.
    wide = float(np.sort(mesh.extents)[1])
    faces = mesh.faces
    corners = ((mesh.vertices - mesh.bounds[0]) / wide)[faces]
    pairs = _neighbors(corners)
    low, high = corners.min(axis=1), corners.max(axis=1)
    overlap = (low[pairs[:, 0]] <= high[pairs[:, 1]]) & (low[pairs[:, 1]] <= high[pairs[:, 0]])
    pairs = pairs[overlap.all(axis=1)]
    shared = (faces[pairs[:, 0]][:, :, None] == faces[pairs[:, 1]][:, None, :]).any(axis=(1, 2))
    pairs = pairs[~shared]
    for one, other in ((0, 1), (1, 0)):
        edge, plane = corners[pairs[:, one]], corners[pairs[:, other]]
        for k in range(3):
            hit = _pierced(edge[:, k], edge[:, (k + 1) % 3], plane)
            for which in np.flatnonzero(hit):
                if not _is_fold(mesh, faces[pairs[which, 0]], faces[pairs[which, 1]]):
                    return np.asarray(mesh.bounds[0] + wide * plane[which].mean(axis=0))
    return None


def _is_fold(mesh: "Trimesh", one: Integers, other: Integers) -> bool:
    """Whether two triangles (3,) are up to FOLD edges apart along the surface."""
    edges, reached = mesh.edges, np.zeros(len(mesh.vertices), dtype=bool)
    reached[one] = True
    for _ in range(FOLD):
        reached[edges[reached[edges[:, 0]], 1]] = True
    return bool(reached[other].any())


def _neighbors(corners: Array) -> Integers:
    """Pairs (k, 2) of triangles (n, 3, 3) that are near enough to meet.

    Sorted by size, so that the few long triangles of a cut end do not make all of them near.
    """
    from scipy.spatial import cKDTree

    centers = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centers[:, None], axis=2).max(axis=1)
    octave = np.floor(np.log2(radii.max() / radii)).astype(int)
    sizes = [np.flatnonzero(octave == one) for one in np.unique(octave)]
    trees = [cKDTree(centers[members]) for members in sizes]
    pairs = []
    for i, members in enumerate(sizes):
        largest = radii[members].max()
        same = trees[i].query_pairs(2.0 * largest, output_type="ndarray")
        pairs.append(members[same])
        for tree, smaller in zip(trees[i + 1 :], sizes[i + 1 :], strict=True):
            reach = largest + radii[smaller].max()
            near = trees[i].sparse_distance_matrix(tree, reach, output_type="ndarray")
            pairs.append(np.column_stack([members[near["i"]], smaller[near["j"]]]))
    return np.concatenate(pairs)


def _pierced(start: Array, end: Array, triangle: Array) -> Flags:
    """Whether segments pass through the inside of their triangles: a + first u + second v."""
    a, b, c = triangle.transpose(1, 0, 2)
    along, u, v = end - start, b - a, c - a
    size = np.linalg.norm(along, axis=1) * np.linalg.norm(np.cross(u, v), axis=1)
    system = np.stack([u, v, -along], axis=2)
    steep = np.abs(np.linalg.det(system)) > 1e-6 * size
    system[~steep] = np.eye(3)
    first, second, place = np.linalg.solve(system, (start - a)[..., None])[..., 0].T
    small = 1e-9
    # An edge counts as a part of the triangle: symmetric surfaces cross edge on edge.
    inside = (first > -small) & (second > -small) & (first + second < 1 + small)
    return np.asarray(steep & inside & (place > small) & (place < 1 - small))


def grid(low: Array, high: Array, pitch: float) -> tuple[Array, tuple[int, int, int]]:
    """Return the points (n, 3) mm of a grid from one corner to beyond the other, and its shape.

    InputError for more points than fit.
    """
    count = np.maximum(np.ceil((high - low) / pitch).astype(int) + 1, 2)
    most = 20_000_000  # points of a grid, some 80 MB of distances
    if np.prod(count.astype(float)) > most:
        raise InputError(
            f"pitch: expected at most {most:,} points of a grid, received "
            f"{' x '.join(map(str, count.tolist()))} at {pitch:g} mm; take a coarser pitch",
            field="pitch",
        )
    axes = [corner + pitch * np.arange(n) for corner, n in zip(low, count, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return points, tuple(count.tolist())


def sampled_surface(path: str | Path, pitch: float, margin: float) -> tuple[Array, Array]:
    """Sample the signed distance of a closed surface, on a grid that goes `margin` mm beyond it.

    Returns the distances (nx, ny, nz) mm, negative inside, and the first point (3,) mm.

    Raises InputError if there is no such file, it holds no surface, or the surface is open or
    inside out.
    """
    import pyvista as pv
    import trimesh

    check_input("mesh", path, "a closed surface in mm, such as an STL file")
    file = Path(path)
    try:
        mesh = trimesh.load_mesh(file)
        corners, triangles = np.asarray(mesh.vertices, float), np.asarray(mesh.faces)
    except Exception as error:  # each format fails in its own way
        message = f"mesh: expected a surface such as an STL, received {file.name}: {error}"
        raise InputError(message, field="mesh") from error
    if not len(triangles) or not np.isfinite(corners).all():
        message = f"mesh: expected triangles with finite corners, received none in {file.name}"
        raise InputError(message, field="mesh")
    if not mesh.is_watertight:
        raise InputError(
            f"mesh: expected a closed surface, received one with holes in {file.name}; fill them",
            field="mesh",
        )
    if mesh.volume <= 0.0:
        raise InputError(
            f"mesh: expected triangles whose normals point outward, received {file.name}, which "
            "is inside out; turn its triangles",
            field="mesh",
        )
    low, high = mesh.bounds[0] - margin, mesh.bounds[1] + margin
    points, shape = grid(low, high, pitch)
    faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
    cloud = pv.PolyData(points).compute_implicit_distance(pv.PolyData(corners, faces))
    return np.asarray(cloud["implicit_distance"], float).reshape(shape), np.asarray(low)
