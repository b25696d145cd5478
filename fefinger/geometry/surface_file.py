"""Read the surface of a fingertip from a file; find its axes, repair and check it.

The file is in mm, with any axes and wherever its origin.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.scan_axes import Axes, fingertip_axes
from fefinger.geometry.scan_fit import SmoothSkin, smooth_skin
from fefinger.geometry.surface_repair import close, crossings, read_welded
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.inputs import check_input


if TYPE_CHECKING:
    from trimesh import Trimesh


WIDTHS, USUAL = (6.0, 40.0), 15.0
"""Range in mm of the width of a fingertip, outside of which the unit is wrong, and a usual one."""

UNITS = {"m": 1e3, "cm": 10.0, "inches": 25.4, "micrometers": 1e-3}
"""mm per unit, to suggest the unit of a file that is not in mm."""

LENGTH, WIDE = 24.0, 1.7
"""Length in mm from the tip that is meshed and that width and thickness are measured on, and its
least part of the width, for wide fingers."""

SAMPLING, BEYOND = 0.35, 1.0
"""Distance in mm between points of a smooth surface, and length that it has behind the one used."""

MISFIT, APART = 0.06, 0.1
"""Largest root mean square distance from a fingertip of closed form, over the width, and largest
share of the surface that is none of it."""

FOUND, FILE = "shape", "file"
"""Where the axes of a finger come from."""

LOOK = "look at it with `fefinger mesh --picture`."

FLAT, FACING = 0.15, 5.0
"""Largest share of the skin that faces one way, within so many degrees.

It is at most 0.1 in fingers and capsules, however coarse their triangles, and 0.2 in a box.
"""


END = 0.99
"""Share of the area of the end face that lies proximal of where the skin begins: single triangles
elsewhere face back by noise."""


@dataclass(frozen=True)
class SurfaceFile:
    """A closed surface with x distal, y radial from the middle, z dorsal, in mm.

    Attributes
    ----------
    mesh : the surface (trimesh).
    place : (4, 4) transform to these axes from the axes of the file.
    start : x in mm from which on the skin is whole, distal of the proximal end.
    skin : the smooth surface near that skin.
    width, thickness : of the smooth surface, in mm.
    notes : on axes, size and repairs.

    """

    mesh: "Trimesh"
    place: Array
    start: float
    skin: SmoothSkin
    width: float
    thickness: float
    notes: tuple[str, ...]


def read_surface(path: str | Path, field: str = "surface", axes: str = FOUND) -> SurfaceFile:
    """Read and check the closed surface of a finger from an STL, OBJ, PLY or VTK file.

    axes: "shape" finds them from the shape, "file" keeps the axes of the file.
    Raises InputError if the file is missing, empty or no surface; the surface is open, intersects
    itself, has a flat side, is no fingertip or is not in mm.
    """
    check_input(field, path, "a surface file")
    state = Path(path).stat()
    return _read(path, field, axes, (state.st_mtime_ns, state.st_size))


@lru_cache(maxsize=4)
def _read(path: str | Path, field: str, kept: str, _state: tuple[int, int]) -> SurfaceFile:
    """Read a file as it is in a state; a scene and its mesh ask for the same one."""
    mesh, welds = read_welded(path, field)
    file = Path(path)
    name = f"{field}: {file.name}"
    axes = fingertip_axes(mesh)
    size = _check_likeness(mesh, axes, name)
    said = _axes_note(axes)
    if kept == FILE:
        axes, said = _of_file(axes, name)
    mesh.apply_transform(axes.place)
    tip = float(mesh.bounds[1, 0])
    problem = f"{field}: expected a closed surface, {file.name}"
    whole = 1.05  # distance from the tip, over the width, up to which the skin has to be whole
    repairs, start = close(mesh, problem, tip - whole * axes.width, axes.place)
    crossing = crossings(mesh)
    if crossing is not None:
        x, y, z = np.linalg.inv(axes.place)[:3] @ [*crossing, 1.0]
        raise InputError(
            f"{name} crosses itself near ({x:.3g}, {y:.3g}, {z:.3g}) mm; expected a "
            "simple closed surface: remesh it or remove the overlap in the program that made it"
        )
    if start == mesh.bounds[0, 0]:
        start = _end_face(mesh, tip - whole * axes.width)
    begin = max(start, tip - used_length(axes.width))
    skin = _smooth(mesh, max(start, begin - BEYOND), axes)
    seen, _ = skin.sampled(SAMPLING)
    width, thickness = (float(np.ptp(seen[seen[:, 0] > begin, k])) for k in (1, 2))
    _check_round(mesh, name, start, tip - used_length(width))
    stated = (
        f"Surface {file.name}: {len(mesh.faces)} triangles in a box of {size} mm, taken as mm; "
        f"{width:.3g} mm wide and {thickness:.3g} mm thick. {said}"
    )
    notes = (stated, *welds, *repairs)
    return SurfaceFile(mesh, axes.place, start, skin, width, thickness, notes)


def _smooth(mesh: "Trimesh", begin: float, axes: Axes) -> SmoothSkin:
    """Return the smooth surface of the skin from x = begin mm on, seen from a width off the tip.

    From nearer the tip, fits to noise bend more there.
    """
    skin = mesh.vertices[mesh.vertices[:, 0] > begin]
    low, high = skin.min(axis=0), skin.max(axis=0)
    center = np.array([high[0] - axes.width, 0.0, (low[2] + high[2]) / 2.0])
    size = np.array([2.0 * axes.width, axes.width, axes.thickness]) / 2.0
    return smooth_skin(mesh, begin, center, size)


def used_length(width: float) -> float:
    """Length in mm from the tip that is meshed, of a scan that is as long."""
    return max(LENGTH, WIDE * width)


def _check_likeness(mesh: "Trimesh", axes: Axes, name: str) -> str:
    """Return the size of the box as text; InputError for no shape or no size of a fingertip."""
    size = " x ".join(f"{value:.4g}" for value in mesh.extents)
    if axes.misfit > MISFIT or axes.apart > APART:
        raise InputError(
            f"{name}, in a box of {size}, is not shaped as a fingertip: of its surface "
            f"{axes.apart:.0%} lies apart from the most similar one, and the rest "
            f"{axes.misfit:.1%} of its width from it in the mean; expected the skin of one "
            "fingertip that is cut behind the nail, 1.1 to 2 widths from the tip: cut it out of a "
            "scan of a hand"
        )
    if WIDTHS[0] <= axes.width <= WIDTHS[1]:
        return size
    unit = min(UNITS, key=lambda each: abs(np.log(axes.width * UNITS[each] / USUAL)))
    fits = WIDTHS[0] <= axes.width * UNITS[unit] <= WIDTHS[1]
    guess = f"; it seems to be in {unit}: scale it by {UNITS[unit]:g}" if fits else ""
    raise InputError(
        f"{name} has a box of {size}; expected a fingertip in mm, {WIDTHS[0]:g} to "
        f"{WIDTHS[1]:g} mm wide{guess}"
    )


def _of_file(axes: Axes, name: str) -> tuple[Axes, str]:
    """Return the axes of the file, with the origin of those found, and a note on both.

    Raises InputError where x is not distal, or z not dorsal.
    """
    askew = 45.0  # largest angle in degrees of the axes of a file from those of its shape
    if axes.turn > askew:
        raise InputError(
            f"{name} has its own axes {axes.turn:.0f} degrees off those of its shape; expected x "
            "about distal, y to the radial side and z to the nail: turn the scan, or leave "
            "finger.axes out, which finds them"
        )
    place = np.eye(4)
    place[:3, 3] = axes.place[:3, :3].T @ axes.place[:3, 3]
    note = f"Its axes are those of the file, {axes.turn:.1f} degrees off those of its shape; {LOOK}"
    return replace(axes, place=place), note


def _axes_note(axes: Axes) -> str:
    """Say how a surface was turned to the axes of a finger."""
    told = 0.5  # turn in degrees from the axes of the file from which on a note states it
    if axes.turn < told:
        return f"Its axes are x distal, y radial and z dorsal, by its shape; {LOOK}"
    x, y, z = axes.place[:3, :3]
    named = ", ".join(
        f"{what} ({', '.join(f'{value:.2f}' for value in axis + 0.0)})"
        for what, axis in (("the tip lies along", x), ("the radial side", y), ("the nail", z))
    )
    return (
        f"It was turned by {axes.turn:.0f} degrees, so that its sides are symmetric and its back "
        f"is level: in the file {named}; {LOOK}"
    )


def _end_face(mesh: "Trimesh", behind: float) -> float:
    """Return the largest x in mm of the proximal end face of a closed scan, which is no skin."""
    faces_back = -0.7  # largest x of the normals of the proximal end face
    end = (mesh.face_normals[:, 0] < faces_back) & (mesh.triangles_center[:, 0] < behind)
    if not end.any():
        return float(mesh.bounds[0, 0])
    ahead, areas = mesh.triangles[end][..., 0].max(axis=1), mesh.area_faces[end]
    order = np.argsort(ahead)
    share = np.cumsum(areas[order]) / areas.sum()
    return float(ahead[order][np.searchsorted(share, END)])


def _check_round(mesh: "Trimesh", name: str, start: float, used: float) -> None:
    """Raise InputError where much of the skin is flat, as a box: no mesh follows it."""
    x, normals, areas = mesh.triangles_center[:, 0], mesh.face_normals, mesh.area_faces
    skin = x > max(start, used)
    normals, areas = normals[skin], areas[skin]
    # Side of the cubes into which unit normals are sorted: one normal of each is tried as a facing.
    cell = 0.1
    ways = normals[np.unique(np.floor(normals / cell), axis=0, return_index=True)[1]]
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
