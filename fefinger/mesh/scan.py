"""Shape of a fingertip from a surface file (STL, PLY, OBJ, ...); skin and bone are added inside.

The file gives the outer skin in mm in the frame x distal, y radial, z dorsal, wherever its origin.
The surface is the mean of the scan and its mirror image; a large asymmetry is an error.
The skin has the given thickness, the bone is the parametric one for the given width and thickness.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fefinger.geometry.surface_file import BACK, LENGTH, SurfaceFile, read_closed, read_surface
from fefinger.mesh import finger_shape
from fefinger.mesh import shell_triangles as surface
from fefinger.mesh.cloud import SPACING, Cloud, smoothed
from fefinger.mesh.finger_shape import Shape
from fefinger.mesh.frame import ALONG, PLATE_NORMAL, fitted_radii
from fefinger.mesh.parametric import patch_points
from fefinger.mesh.recipe import Recipe
from fefinger.mesh.shell import Array, Shell, Table, offset
from fefinger.mesh.shell_triangles import Triangles
from fefinger.support.checks import InputError


SIZE_ERROR = 0.35
"""Relative difference of a scan's width from the given one that indicates a wrong unit."""

STATIONS, LAST = 60, 0.15
"""Points of a profile, and the root of the last one's share of the length from the tip."""

ASYMMETRY = 0.15
"""Largest mean distance of a scan from its mirror image, over half its width."""


def scanned(recipe: Recipe) -> Shape:
    """Build the shape of a fingertip from the surface file of a recipe.

    Raises InputError for a file that is missing, is no closed surface, has another unit or frame,
    is far from symmetric, or leaves no room for the bone.
    """
    file = _read(recipe)
    mesh = _refined(file.mesh, open_behind=True)
    aside = np.array([0.0, mesh.bounds[:, 1].mean(), 0.0])
    mesh.apply_translation(-aside)
    skin = _cloud(mesh)
    touch = _first_touch(skin)
    mesh.apply_translation(-touch)
    origin = aside + touch
    skin = Cloud.of(skin.points - touch, skin.point_normals)
    under = replace(skin, inset=recipe.skin_thickness)
    _check_symmetry(skin, recipe)
    low, high = mesh.bounds
    tip, top = float(high[0]), float(high[2])
    cut = max(float(low[0]) + 0.5, tip - LENGTH)
    bone = _bone(recipe, origin, cut=cut, tip=tip, top=top)
    finger_shape.check_room(under, bone.points[bone.points[:, 0] > cut], recipe)
    middle = 0.5 * (float(low[2]) + top)
    nail = finger_shape.nail_of(recipe, tip=tip, middle=middle, side=lambda x: _side(skin, x))
    level, tables = _sections(skin, cut)
    inset = {name: offset(table, recipe.skin_thickness) for name, table in tables.items()}
    outer, inner = (_halved(mesh, cloud, cut) for cloud in (skin, under))
    around, within = (_volume(part, cut) for part in (outer, inner))
    return Shape(
        skin=skin,
        subcutaneous=under,
        bone=bone.surface,
        cut=cut,
        radii=fitted_radii(patch_points(skin)),
        nail=nail,
        triangles=lambda step: [
            outer,
            *_planes(mesh.bounds, cut),
            _halved(mesh, under, cut - 1.0),
            bone.triangles(step),
        ],
        sections=(
            Shell.of(level, cut=cut, **tables),
            Shell.of(level, cut=cut, **inset),
            bone.sections,
        ),
        volumes=finger_shape.region_volumes(around, within, bone.volume),
        notes=(*file.notes, *bone.notes),
    )


@dataclass(frozen=True)
class Bone:
    """A bone: smooth surface, points (n, 3) on it, triangles by step, volume of the half in mm³.

    sections: the shell of half ellipses near it.
    """

    surface: finger_shape.SmoothSurface
    points: Array
    triangles: Callable[[float], Triangles]
    sections: Shell
    volume: float
    notes: tuple[str, ...] = ()


def _bone(recipe: Recipe, origin: Array, *, cut: float, tip: float, top: float) -> Bone:
    """Return the bone of a recipe: that of its file, moved with the skin, or a parametric one."""
    if recipe.bone_surface is None:
        shell = finger_shape.distal_phalanx(recipe, cut=cut, tip=tip, top=top)
        points = surface.without_caps(surface.half(shell, 0.5))[0]
        return Bone(
            shell,
            points,
            lambda step: surface.without_caps(surface.half(shell, step, overhang=1.0)),
            shell,
            surface.volume(surface.half(shell, finger_shape.FINE)),
        )
    closed, notes = read_closed(recipe.bone_surface, field="bone_surface")
    mesh = _refined(closed)
    mesh.apply_translation(-origin)
    cloud = _cloud(mesh)
    part = _halved(mesh, cloud, cut - 1.0)
    volume = _volume(_halved(mesh, cloud, cut), cut)
    level, tables = _sections(cloud, cut)
    sections = Shell.of(level, cut=cut, **tables)
    return Bone(cloud, cloud.points, lambda step: part, sections, volume, notes)


def _sections(cloud: Cloud, cut: float) -> tuple[float, dict[str, Table]]:
    """Level of the foremost point, and profiles of a surface: palm and back in y = 0, sides there.

    Half ellipses with these profiles are near the surface.
    """
    start = cloud.points[np.argmax(cloud.points[:, 0])] * [1.0, 0.0, 1.0]
    tip, _, middle = cloud.project(start[None], free=np.array([[True, False, False]]))[0]
    x = tip - (tip - cut) * np.linspace(1.0, LAST, STATIONS) ** 2
    size = np.ptp(cloud.points, axis=0) / 2.0
    tables = {}
    for name, axis, sign in (("palmar", 2, -1.0), ("dorsal", 2, 1.0), ("side", 1, 1.0)):
        line = np.column_stack([x, 0.0 * x, np.full(len(x), middle)])
        line[:, axis] += sign * size[axis]
        free = np.tile(np.arange(3) == axis, (len(x), 1))
        half = sign * (cloud.project(line, free=free) - [0.0, 0.0, middle])[:, axis]
        tables[name] = np.append(x, tip), np.append(half, 0.0)
    return float(middle), tables


def _refined(closed: Any, *, open_behind: bool = False) -> Any:
    """Refine a surface to edges of at most SPACING; optionally remove its proximal end face.

    The end face, all faces of the proximal quarter with a normal toward -x, is not skin.
    """
    import trimesh

    points, faces = trimesh.remesh.subdivide_to_size(closed.vertices, closed.faces, SPACING)
    fine = trimesh.Trimesh(points, faces)
    back = fine.triangles_center[:, 0] < fine.bounds[0, 0] + BACK * fine.extents[0]
    if open_behind:
        fine.update_faces(~(back & (fine.face_normals[:, 0] < -0.7)))
        fine.remove_unreferenced_vertices()
    return fine


def _read(recipe: Recipe) -> SurfaceFile:
    """Return the surface file of a recipe; its width must be about that of the recipe."""
    file = read_surface(str(recipe.surface))
    if abs(file.width / recipe.width - 1.0) > SIZE_ERROR:
        message = (
            f"surface: expected a finger about {recipe.width:g} mm wide along y, received "
            f"{file.width:.4g}; the file must be in mm with x distal, y radial and z dorsal"
        )
        raise InputError(message)
    return file


def _cloud(mesh: Any) -> Cloud:
    """Return the smooth surface through the vertices of a mesh."""
    points = np.asarray(mesh.vertices, dtype=float)
    return Cloud.of(*smoothed(points, np.asarray(mesh.vertex_normals, dtype=float)))


def _first_touch(skin: Cloud) -> Array:
    """First touch of a 30-degree plate on the ridge y = 0, (3,) mm."""
    ridge = skin.points[np.abs(skin.points[:, 1]) < 2.0 * SPACING] * [1.0, 0.0, 1.0]
    free = np.tile([True, False, True], (len(ridge), 1))
    ridge = skin.project(ridge, free=free)
    best = ridge[np.argmax(ridge @ PLATE_NORMAL)]
    # Steps of 1 µm along the ridge: a point between them protrudes by less than 1e-7 mm.
    line = best + np.linspace(-0.4, 0.4, 801)[:, None] * ALONG
    line = skin.project(line, free=np.tile([True, False, True], (len(line), 1)))
    return np.asarray(line[np.argmax(line @ PLATE_NORMAL)])


def _check_symmetry(skin: Cloud, recipe: Recipe) -> None:
    """Raise InputError if the surface is far from its mirror image in y = 0."""
    away = skin.asymmetry()
    if away > ASYMMETRY * recipe.width / 2.0:
        message = (
            f"surface: expected a finger nearly symmetric in y, received one with a mean distance "
            f"of {away:.2f} mm from its mirror image; turn it about x until the pad faces down (-z)"
        )
        raise InputError(message)


def _side(skin: Cloud, x: Array) -> Array:
    """Return half the width at x, (n,) mm."""
    stations = np.linspace(skin.points[:, 0].min(), skin.points[:, 0].max(), 60)
    slot = np.digitize(skin.points[:, 0], stations)
    widest = [np.max(skin.points[slot == i, 1], initial=0.0) for i in range(1, len(stations))]
    return np.interp(x, (stations[1:] + stations[:-1]) / 2.0, widest)


def _halved(mesh: Any, cloud: Cloud, cut: float) -> Triangles:
    """Slice the surface to y >= 0, x >= cut; it is open at these planes."""
    from trimesh.intersections import slice_faces_plane

    points = cloud.project(cloud.points - cloud.inset * cloud.point_normals)
    faces = mesh.faces
    for normal, at in (((0.0, 1.0, 0.0), (0.0, 0.0, 0.0)), ((1.0, 0.0, 0.0), (cut, 0.0, 0.0))):
        points, faces, *_ = slice_faces_plane(points, faces, np.array(normal), np.array(at))
    return np.asarray(points, dtype=float), np.asarray(faces, dtype=np.int64)


def _planes(bounds: Array, cut: float) -> list[Triangles]:
    """Return rectangles on y = 0 and x = cut, larger than the finger."""
    (x, y, z), (far_x, far_y, far_z) = bounds + np.array([[-0.8], [0.8]])
    square = np.array([[0, 1, 2], [0, 2, 3]])
    medial = [(x, 0.0, z), (far_x, 0.0, z), (far_x, 0.0, far_z), (x, 0.0, far_z)]
    back = [(cut, y, z), (cut, far_y, z), (cut, far_y, far_z), (cut, y, far_z)]
    return [(np.array(medial), square), (np.array(back), square)]


def _volume(part: Triangles, cut: float) -> float:
    """Return the volume between an open half surface and the planes y = 0 and x = cut, mm^3."""
    points, faces = part
    return surface.volume((points - [cut, 0.0, 0.0], faces))
