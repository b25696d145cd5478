"""Read the surface of a fingertip from a file; repair and check it.

The file is in mm with x distal, y radial and z dorsal, wherever its origin.
"""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.crossings import crossings
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError
from fefinger.support.inputs import check_input


if TYPE_CHECKING:
    from pyvista import DataSet
    from trimesh import Trimesh


WIDTHS = (6.0, 40.0)
"""Range in mm of the smaller sides of a fingertip's bounding box; outside, the unit is wrong."""

UNITS = {"m": 1e3, "cm": 10.0, "inches": 25.4, "micrometers": 1e-3}
"""mm per unit, to suggest the unit of a file that is not in mm."""

HOLE = 0.2
"""Largest diameter of a hole that is filled, over the finger's width."""

BACK = 0.25
"""Proximal share of the length where the surface may be open; the mesh is cut distal of it."""

LENGTH = 24.0
"""Length in mm from the tip that is meshed and that width and thickness are measured on."""

OPEN_END = 0.8
"""Smallest diameter of a hole, over the finger's width, that may be an open proximal end."""

TURNS = {
    (0, 1): "z by 180",
    (1, 0): "z by -90",
    (1, 1): "z by 90",
    (2, 0): "y by 90",
    (2, 1): "y by -90",
}
"""Turns that bring an end, at the low (0) or high (1) side of an axis, to the smaller x."""

VTK = (".vtk", ".vtp", ".vtu")
FORMATS = (".stl", ".obj", ".ply", *VTK)
"""Endings of surface files; other formats, as archives, have no bound on what they unpack to."""

FARTHEST = 1e6
"""Bound of coordinates in mm; squares of larger ones overflow in areas and volumes."""

SHORTEST = 0.9
"""Smallest length over width or thickness: a thick fingertip cut behind its nail."""

THICKEST = 1.1
"""Largest thickness over width; it is 0.7 to 0.85 in the subjects' fingers."""

AHEAD = 0.01
"""Largest offset of the center of mass toward the tip from the middle of the box, over the length.

It is -0.015 to -0.12 in the subjects' fingers, cut 1.1 to 2 widths from the tip, squarely or 20
degrees askew, with 0.1 mm of noise or without: their wider, cut end is proximal.
"""


TILTED, LONG = (10.0, 45.0), 0.9
"""Range in degrees of a tilt that is told, and the largest radius of gyration about the long axis,
over that about the next, that shows one; fingers bend up to 14 degrees about -y, by their pads."""

FLAT, FACING = 0.15, 5.0
"""Largest share of the skin that faces one way, within so many degrees.

It is at most 0.1 in fingers and capsules, however coarse their triangles, and 0.2 in a box.
"""

CELL = 0.1
"""Side of the cubes into which unit normals are sorted: one normal of each is tried as a facing."""


@dataclass(frozen=True)
class SurfaceFile:
    """A closed surface: `mesh` (trimesh), width and thickness in mm, notes on size and repairs."""

    mesh: "Trimesh"
    width: float
    thickness: float
    notes: tuple[str, ...]


def read_surface(path: str | Path, field: str = "surface") -> SurfaceFile:
    """Read and check the closed surface of a finger from an STL, OBJ, PLY or VTK file.

    Raises InputError if the file is missing, empty or no surface; the surface is open, intersects
    itself, has a flat side, or is not in mm and in the frame x distal, y radial, z dorsal.
    """
    mesh, notes = read_closed(path, field)
    file = Path(path)
    name = f"{field}: {file.name}"
    crossing = crossings(mesh)
    if crossing is not None:
        x, y, z = crossing
        raise InputError(
            f"{name} crosses itself near ({x:.3g}, {y:.3g}, {z:.3g}){_unit(mesh)}; expected a "
            "simple closed surface: remesh it or remove the overlap in the program that made it"
        )
    size = _check_size(mesh.extents, name)
    tip = mesh.vertices[:, 0] > mesh.bounds[1, 0] - LENGTH
    width, thickness = (float(np.ptp(mesh.vertices[tip, k])) for k in (1, 2))
    _check_frame(mesh, width, thickness, name)
    _check_round(mesh, name)
    stated = (
        f"Surface {file.name}: {len(mesh.faces)} triangles in a box of {size} mm, taken as mm with "
        f"x distal, y radial and z dorsal; {width:.3g} mm wide and {thickness:.3g} mm thick. That "
        "the nail is up (z) is not checked: look at it with `fefinger mesh --picture`."
    )
    return SurfaceFile(mesh, width, thickness, (stated, *notes))


def _loaded(file: Path, field: str) -> "Trimesh":
    """Load the triangles of a file; raise InputError if it has none."""
    import trimesh

    try:
        if file.suffix.lower() not in FORMATS:
            raise ValueError(f"of an unknown format, {file.suffix!r}")
        if file.suffix.lower() in VTK:
            outer = _read_vtk(file).extract_surface(algorithm=None).triangulate()
            points = np.array(outer.points, dtype=float)
            mesh = trimesh.Trimesh(points, np.array(outer.regular_faces))
        else:
            with np.errstate(over="ignore", invalid="ignore"):
                mesh = trimesh.load_mesh(file)
        count = len(mesh.faces)
    except Exception as error:
        raise InputError(
            f"{field}: expected a triangle surface (STL, OBJ, PLY or VTK), received "
            f"{str(file)!r}, which cannot be read as one; export it again"
        ) from error
    if count == 0:
        raise InputError(f"{field}: expected a surface, {file.name} has no triangles")
    if not (np.abs(mesh.vertices) < FARTHEST).all():
        raise InputError(
            f"{field}: expected finite coordinates, below {FARTHEST:g} mm, {file.name} has others"
        )
    return mesh


def _read_vtk(file: Path) -> "DataSet":
    """Read a VTK file; what VTK prints about a bad one besides its exception is left out."""
    import pyvista as pv

    vtk = pv.PolyData()  # any object of VTK switches the messages of all
    shown = vtk.GetGlobalWarningDisplay()
    vtk.SetGlobalWarningDisplay(0)
    try:
        with pv.vtk_verbosity("off"):
            return pv.read(file)
    finally:
        vtk.SetGlobalWarningDisplay(shown)


def read_closed(path: str | Path, field: str) -> "tuple[Trimesh, tuple[str, ...]]":
    """Read a surface in one piece, closed and oriented outward; also return notes on repairs.

    Raises InputError for a file that is no such surface and cannot safely be repaired.
    """
    check_input(field, path, "a surface file")
    file, notes = Path(path), []
    mesh = _loaded(file, field)
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
        raise InputError(
            f"{field}: expected one connected surface, {file.name} has {parts} separate ones; keep "
            "only the skin"
        )
    for loop in _holes(mesh, file, field):
        notes.append(_filled(mesh, loop))
    if _face_outward(mesh):
        notes.append(f"Triangles of {file.name} that faced inward were turned outward.")
    if not mesh.is_watertight or mesh.volume <= 0:
        raise InputError(
            f"{field}: expected a closed surface, {file.name} has edges that do not join two "
            "triangles; close it in the program that made it"
        )
    return mesh, tuple(notes)


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


def _holes(mesh: "Trimesh", file: Path, field: str) -> list[Integers]:
    """Rims of the holes that may be filled: small ones, and the open proximal end.

    A rim holds the edges (n, 2) in the direction of their triangles.
    """
    from trimesh.graph import connected_component_labels
    from trimesh.grouping import group_rows

    rim = mesh.edges[group_rows(mesh.edges_sorted, require_count=1)]
    label = connected_component_labels(rim, node_count=len(mesh.vertices))[rim[:, 0]]
    low, high = mesh.bounds
    quarter, wide = BACK * (high[0] - low[0]), float(np.sort(high - low)[1])
    loops = [rim[label == one] for one in np.unique(label)]
    for loop in loops:
        points = mesh.vertices[np.unique(loop)]
        across = float(np.ptp(points, axis=0).max())
        behind = bool((points[:, 0] < low[0] + quarter).all())
        if not behind and across > HOLE * wide:
            x, y, z = points.mean(axis=0)
            unit = _unit(mesh)
            message = (
                f"{field}: expected a closed surface, {file.name} has a hole {across:.3g}"
                f"{unit} wide near ({x:.3g}, {y:.3g}, {z:.3g}){unit}; close it in the program that "
                "made it"
            )
            turn = _open_end(points, mesh.bounds) if across > OPEN_END * wide else None
            if turn is not None:
                message += f", or if it is the proximal end, turn the finger about {turn} degrees"
            raise InputError(message)
    return loops


def _open_end(rim: Array, bounds: Array) -> str | None:
    """Turn that brings a rim (n, 3) in an end quarter of the box to the smaller x, if any."""
    size = bounds[1] - bounds[0]
    share = (rim - bounds[0]) / np.where(size > 0, size, 1.0)  # a flat surface has no thickness
    for (axis, side), turn in TURNS.items():
        away = np.abs(share[:, axis] - side)
        if (away < BACK).all() and axis == int(np.argmax(np.ptp(bounds, axis=0))):
            return turn
    return None


def _unit(mesh: "Trimesh") -> str:
    """Return the unit of lengths in messages: mm where the box has the size of a finger in mm."""
    smaller = float(np.sort(mesh.extents)[1])
    return " mm" if WIDTHS[0] <= smaller <= WIDTHS[1] else " units"


def _filled(mesh: "Trimesh", loop: Integers) -> str:
    """Close a hole by rings of triangles about its center; return a note on it.

    In the skin they follow the surface around it: a flat lid of a hole in the pad leaves an edge,
    and a plate that presses there meets the edge. The open proximal end gets a flat lid.
    """
    rim, ends = np.unique(loop, return_inverse=True)
    a, b = ends.reshape(loop.shape).T
    points = mesh.vertices[rim]
    middle = points.mean(axis=0)
    across = float(np.ptp(points, axis=0).max())
    if across > HOLE * float(np.sort(mesh.extents)[1]):
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
    x, y, z = middle
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


def _check_size(extents: Array, name: str) -> str:
    """Format the size of the box; raise InputError, with the likely unit, if it is not in mm."""
    size = " x ".join(f"{value:.4g}" for value in extents)
    smaller = float(np.sort(extents)[1])
    if WIDTHS[0] <= smaller <= WIDTHS[1]:
        return size
    fits = [unit for unit, scale in UNITS.items() if WIDTHS[0] <= smaller * scale <= WIDTHS[1]]
    guess = f"; it seems to be in {fits[0]}: scale it by {UNITS[fits[0]]:g}" if fits else ""
    raise InputError(
        f"{name} has a box of {size}; expected a fingertip in mm, {WIDTHS[0]:g} to "
        f"{WIDTHS[1]:g} mm wide{guess}"
    )


def _check_frame(mesh: "Trimesh", width: float, thickness: float, name: str) -> None:
    """Raise InputError where box or center of mass do not fit a finger along x.

    width, thickness: of the LENGTH behind the tip, in mm. Whether the nail is up is not checked.
    """
    length, middle = mesh.extents[0], mesh.bounds[:, 0].mean()
    turn = None
    if length < SHORTEST * max(width, thickness):
        axis, other = ("y", "z") if width > thickness else ("z", "y")
        turn = f"is longest along {axis}", f"{other} by 90 or -90 degrees"
    elif thickness > THICKEST * width:
        turn = "is thicker along z than it is wide along y", "x by 90 or -90 degrees"
        turn = tilt(mesh, "y") or turn
    elif mesh.center_mass[0] > middle + AHEAD * length:
        turn = "has its narrower end, the tip, at the smaller x", "z by 180 degrees"
    if turn is not None:
        shape, back = turn
        message = f"{name} {shape}; expected x distal, y radial and z dorsal: turn it about {back}"
        raise InputError(message)


def tilt(mesh: "Trimesh", axis: str) -> tuple[str, str] | None:
    """Describe a tilt of the long axis of a closed surface about y or z, and the turn back, if any.

    The long axis is the principal one with the least moment of inertia.
    """
    moments, axes = np.linalg.eigh(mesh.moment_inertia)
    x, y, z = axes[:, 0] * np.copysign(1.0, axes[0, 0])
    angle = float(np.degrees(np.arctan2(-z if axis == "y" else y, x)))
    low, high = TILTED
    if not low <= abs(angle) <= high or moments[0] > LONG**2 * moments[1]:
        return None
    seems = f"seems to be tilted about {axis} by about {angle:.0f} degrees, by its principal axes"
    return seems, f"{axis} by about {-angle:.0f} degrees"


def _check_round(mesh: "Trimesh", name: str) -> None:
    """Raise InputError where much of the skin is flat, as the sides of a box: no mesh follows it.

    The proximal end face is no skin.
    """
    x, normals, areas = mesh.triangles_center[:, 0], mesh.face_normals, mesh.area_faces
    low, high = mesh.bounds[:, 0]
    end = (normals[:, 0] < -0.7) & (x < low + BACK * (high - low))
    skin = (x > high - LENGTH) & ~end
    normals, areas = normals[skin], areas[skin]
    ways = normals[np.unique(np.floor(normals / CELL), axis=0, return_index=True)[1]]
    least = np.cos(np.radians(FACING))
    shares = [areas[normals @ way > least].sum() / areas.sum() for way in ways]
    most = int(np.argmax(shares))
    if shares[most] > FLAT:
        facing = ", ".join(f"{value:.2g}" for value in ways[most].round(2) + 0.0)
        raise InputError(
            f"{name} has a flat side, as a box: {shares[most]:.0%} of it face ({facing}) within "
            f"{FACING:g} degrees; expected a fingertip, round but for its proximal end, with at "
            f"most {FLAT:.0%}"
        )
