"""Shape of a fingertip from a surface file (STL, PLY, OBJ, ...); skin and bone are added inside.

The file gives the outer skin in mm; its axes are found from its shape (`geometry/scan_axes.py`).
The surface is the mean of the scan and its mirror image; a large asymmetry is an error.
The skin has the given thickness, the bone is the parametric one for the given width and thickness.
"""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.scan_fit import SmoothSkin
from fefinger.geometry.surface_file import (
    FOUND,
    SAMPLING,
    SurfaceFile,
    read_surface,
    used_length,
)
from fefinger.geometry.surface_repair import read_closed
from fefinger.mesh import finger_shape
from fefinger.mesh import shell as surface
from fefinger.mesh.cloud import SPACING, Cloud, smoothed
from fefinger.mesh.finger_shape import ALONG, PLATE_NORMAL, Shape, SmoothSurface, fitted_radii
from fefinger.mesh.parametric import parametric, patch_points
from fefinger.mesh.recipe import Recipe
from fefinger.mesh.shell import Shell, Table, Triangles, offset
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from trimesh import Trimesh


STATIONS, LAST = 60, 0.15
"""Points of a profile, and the root of the last one's share of the length from the tip."""

NARROWED = 0.92
"""Least width at the cut over the largest, which is 1 in a parametric finger; a scan that narrows
more toward its proximal end is cut where it has that. There capsules 21 to 26 mm long are pressed
with forces within 1.0 % of a capsule without an end, and 2.8 % where they have 0.97 of their width:
a finger that ends nearer the pad is stiffer. Ellipsoids 1.7 times as long as wide, whose nail needs
0.95, are long enough, and more of the shipped meshes have good cells in them."""

SLIM = (1.0, 0.9, 0.8, 0.7, 0.6)
"""Widths and heights of a parametric bone that are tried in turn, over the usual ones."""

ASYMMETRY = 0.15
"""Largest mean distance of a scan, or of its bone, from its mirror image, over half its width."""

AVERAGED = 0.1
"""Mean distance in mm of a surface from its mirror image from which on a note states it."""

PRESSED, FORCE_POWER = 1.0, 2.0
"""Depth in mm of the plate whose force the noise of a scan is stated for, and the power of depth by
which the force of a fingertip grows: some 1.5 (Hertz) to 2.5 (tissue that stiffens)."""


def shape_of(recipe: Recipe) -> Shape:
    """Build the shape of a recipe, parametric or from its surface file; raises their errors."""
    if recipe.surface is None:
        return parametric(recipe)
    same = replace(recipe, resolution="standard", touch=None)  # of all meshes of a scan
    return _scanned(same, same.key())


@lru_cache(maxsize=2)
def _scanned(recipe: Recipe, _key: str) -> Shape:
    """Return the shape of a scan whose files have a hash: a plan and the mesh ask for the same."""
    return scanned(recipe)


def scanned(recipe: Recipe) -> Shape:
    """Build the shape of a fingertip from the surface file of a recipe.

    Raises InputError for a file that is missing, is no closed surface, has another unit or frame,
    is far from symmetric, or leaves no room for the bone.
    """
    file = _read(recipe)
    averaged = _check_symmetry(file, recipe)
    points, normals = file.skin.sampled(SAMPLING)
    behind = 0.5  # distance in mm of the cut from the proximal end of the skin
    end = max(file.start + behind, float(points[:, 0].max()) - used_length(recipe.width))
    points, normals = (each[points[:, 0] > end - behind] for each in (points, normals))
    touch = _first_touch(Cloud.of(points, normals))
    skin = Cloud.of(points - touch, normals)
    under = replace(skin, inset=recipe.skin_thickness)
    tip, _, top = (float(value) for value in skin.points.max(axis=0))
    cut = end - float(touch[0])
    level, tables = _profiles(skin, cut)
    cut, shortened = _wide_cut(file, recipe, tables, cut)
    if shortened:
        level, tables = _profiles(skin, cut)
    inset = {name: offset(table, recipe.skin_thickness) for name, table in tables.items()}
    try:
        back = level + _lowest_back(recipe, tables["dorsal"], tip)
        _check_length(recipe, tip - cut)
        bone, near_bone, of_bone = _bone(
            file, recipe, under, origin=touch, cut=cut, tip=tip, top=back
        )
        inside = _half(bone, near_bone, finger_shape.FINE)
        finger_shape.check_room(under, surface.without_caps(inside)[0], recipe)
    except InputError as error:
        raise _repaired(error, file) from None
    radii = fitted_radii(patch_points(skin))
    shells = (skin, under, bone)
    near = (Shell.of(level, cut=cut, **tables), Shell.of(level, cut=cut, **inset), near_bone)
    soft = zip(shells[:2], near[:2], strict=True)
    halves = [*(_half(*pair, finger_shape.FINE) for pair in soft), inside]
    return Shape(
        skin=skin,
        subcutaneous=under,
        bone=bone,
        cut=cut,
        radii=radii,
        nail=finger_shape.nail_of(
            recipe, tip=tip, middle=level, side=lambda x: np.interp(x, *tables["side"])
        ),
        triangles=lambda step: [
            _half(skin, near[0], step),
            *(
                surface.without_caps(_half(*pair, step, overhang=1.0))
                for pair in zip(shells[1:], near[1:], strict=True)
            ),
        ],
        sections=near,
        volumes=finger_shape.region_volumes(*map(surface.volume, halves)),
        notes=(
            *file.notes,
            *_noise(file.skin, touch, radii),
            *averaged,
            *shortened,
            *_lowered(recipe, top - back),
            *of_bone,
        ),
    )


def _wide_cut(
    file: SurfaceFile, recipe: Recipe, tables: dict[str, Table], cut: float
) -> tuple[float, tuple[str, ...]]:
    """Move the cut of a scan that is rounded at its proximal end to where it is wide, with a note.

    Raises InputError where too little is left.
    """
    x, side = tables["side"]
    wide = side / side.max()
    if wide[0] >= NARROWED:
        return cut, ()
    after = int(np.argmax(wide >= NARROWED))
    near = slice(after - 1, after + 1)
    cut = float(np.interp(NARROWED, wide[near], x[near]))
    length, least = x[-1] - cut, finger_shape.length_needed(recipe)
    name = Path(str(recipe.surface)).name
    if length < least:
        raise _repaired(
            InputError(
                f"finger.surface: {name} is rounded at its proximal end, as a ball, and "
                f"{length:.1f} mm long where it is wide; expected a fingertip that is cut "
                f"{least:.1f} mm from the tip or more"
            ),
            file,
        )
    # At that level alone: of a tapered finger that lies tilted it says nothing of the widest level.
    note = (
        f"{name} narrows toward its proximal end at the level of its tip: it was cut "
        f"{length:.1f} mm from the tip."
    )
    return cut, (note,)


def _repaired(error: InputError, file: SurfaceFile) -> InputError:
    """Return the error of a scan, after what was repaired in its file."""
    return InputError(" ".join([str(error), *(f"({note})" for note in file.notes[1:])]))


def _check_length(recipe: Recipe, length: float) -> None:
    """Raise InputError for a scan that has no length for a bone with a base."""
    ahead = finger_shape.BASE * recipe.width
    # Least tissue ahead of a bone, over the thickness, in a short scan; 0.42 or more elsewhere.
    shortest = 0.3
    if recipe.bone_surface is None and length < ahead + shortest * recipe.thickness:
        raise InputError(
            "finger.surface: expected a scan that is whole up to "
            f"{ahead + shortest * recipe.thickness:.1f} mm from its tip, for the tissue ahead of a "
            f"bone and its base, received one that is up to {length:.1f} mm; use a longer one"
        )


def _bone(
    file: SurfaceFile,
    recipe: Recipe,
    under: Cloud,
    *,
    origin: Array,
    cut: float,
    tip: float,
    top: float,
) -> tuple[SmoothSurface, Shell, tuple[str, ...]]:
    """Return the bone of a recipe, of its file or a parametric one, a shell near it, and notes."""
    if recipe.bone_surface is None:
        return _parametric_bone(recipe, under, cut=cut, tip=tip, top=top)
    closed, notes = read_closed(recipe.bone_surface, field="finger.bone_surface", place=file.place)
    cloud = _cloud(_refined(closed), origin)
    away, name = cloud.asymmetry(), Path(recipe.bone_surface).name
    if away > ASYMMETRY * recipe.width / 2.0:
        raise InputError(
            f"finger.bone_surface: expected a bone nearly symmetric about the middle of the skin, "
            f"received {name} with a mean distance of {away:.2f} mm from its mirror image there, "
            f"and the middle of its box {closed.bounds[:, 1].mean():.2f} mm aside (y): place it as "
            "the skin, or leave it out"
        )
    level, tables = _profiles(cloud, cut)
    return cloud, Shell.of(level, cut=cut, **tables), (*notes, *_averaged(name, away))


def _parametric_bone(
    recipe: Recipe, under: Cloud, *, cut: float, tip: float, top: float
) -> tuple[SmoothSurface, Shell, tuple[str, ...]]:
    """Return a parametric bone twice, and notes: as slim, and as far ahead, as the skin needs."""
    notes: tuple[str, ...] = ()
    for slim in SLIM:
        shell = finger_shape.distal_phalanx(recipe, cut=cut, tip=tip, top=top, slim=slim)
        points = surface.without_caps(surface.half(shell, finger_shape.FINE))[0]
        if -float(under.level(points).max()) >= finger_shape.ROOM:
            break
    if slim < 1.0:
        notes = (f"The bone has {slim:g} of its usual width and height, to be inside this skin.",)
    if recipe.tip_tissue is not None and tip - shell.tip < recipe.tip_tissue - AVERAGED:
        notes += (
            f"The bone ends {tip - shell.tip:.1f} mm before the tip, not {recipe.tip_tissue:.3g} mm"
            f" as finger.tip_tissue says: the scan is whole up to {tip - cut:.1f} mm from its tip.",
        )
    return shell, shell, notes


def _lowest_back(recipe: Recipe, dorsal: Table, tip: float) -> float:
    """Least height of the back over the part of a parametric bone that is not rounded yet.

    The back of a scan is not level: nail, folds and the joint differ by a millimeter, more than the
    tissue between them and a bone under their highest point.
    """
    x, height = dorsal
    ahead = recipe.tip_tissue or finger_shape.BONE_AHEAD * recipe.thickness
    over = x <= tip - ahead - finger_shape.BONE_ROUNDED * recipe.width
    return float(height[over].min() if over.any() else height.max())


def _lowered(recipe: Recipe, down: float) -> tuple[str, ...]:
    """Note on a parametric bone that lies `down` mm lower than under the highest point."""
    if recipe.bone_surface is not None or down < AVERAGED:
        return ()
    return (
        f"The back of the scan is not level: the bone lies {down:.2g} mm lower than under its "
        "highest point, to be below all of the skin.",
    )


def _half(smooth: SmoothSurface, near: Shell, step: float, *, overhang: float = 0.0) -> Triangles:
    """Return the closed half of a smooth surface, as `shell.half` of a shell near it."""
    points, faces = surface.half(near, step, overhang=overhang)
    if smooth is near:
        return points, faces
    on_shell = 1e-6  # distance in mm from a shell up to which points are on it
    outer = np.abs(near.level(points)) < on_shell
    free = np.ones((int(outer.sum()), 3), dtype=bool)
    free[points[outer, 1] == 0.0, 1] = False
    free[points[outer, 0] == points[0, 0], 0] = False
    points[outer] = smooth.project(points[outer], free=free)
    return points, faces


def _profiles(cloud: Cloud, cut: float) -> tuple[float, dict[str, Table]]:
    """Level of the foremost point, and profiles of a surface: palm and back in y = 0, sides there.

    Half ellipses with these profiles are near the surface.
    """
    start = cloud.points[np.argmax(cloud.points[:, 0])] * [1.0, 0.0, 1.0]
    ahead = start + np.linspace(-SPACING, SPACING, 71)[:, None] * [0.0, 0.0, 1.0]
    ahead = cloud.project(ahead, free=np.arange(3) == 0)
    tip, _, middle = ahead[np.argmax(ahead[:, 0])]
    x = tip - (tip - cut) * np.linspace(1.0, LAST, STATIONS) ** 2
    size = np.ptp(cloud.points, axis=0) / 2.0
    tables = {}
    for name, axis, sign in (("palmar", 2, -1.0), ("dorsal", 2, 1.0), ("side", 1, 1.0)):
        line = np.column_stack([x, 0.0 * x, np.full(len(x), middle)])
        line[:, axis] += sign * size[axis]
        there = cloud.project(line, free=np.arange(3) == axis)
        half = sign * (there - [0.0, 0.0, middle])[:, axis]
        tables[name] = np.append(x, tip), np.append(half, 0.0)
    return float(middle), tables


def _refined(closed: "Trimesh") -> "Trimesh":
    """Refine a surface to edges of at most SPACING."""
    import trimesh

    points, faces = trimesh.remesh.subdivide_to_size(closed.vertices, closed.faces, SPACING)
    return trimesh.Trimesh(points, faces)


def _read(recipe: Recipe) -> SurfaceFile:
    """Read the surface file of a recipe; InputError for another width than the recipe's."""
    file = read_surface(str(recipe.surface), "finger.surface", recipe.axes or FOUND)
    # Relative difference of a scan's width from the given one that indicates a wrong unit.
    size_error = 0.35
    if abs(file.width / recipe.width - 1.0) > size_error:
        raise InputError(
            f"finger.surface: expected a finger about {recipe.width:g} mm wide, received one of "
            f"{file.width:.4g}; the file must be in mm"
        )
    return file


def _cloud(mesh: "Trimesh", origin: Array) -> Cloud:
    """Return the smooth surface through the vertices of a mesh, seen from an origin (3,) mm."""
    points = np.asarray(mesh.vertices, dtype=float) - origin
    return smoothed(points, np.asarray(mesh.vertex_normals, dtype=float))


def _first_touch(skin: Cloud) -> Array:
    """First touch of a 30-degree plate on the ridge y = 0, (3,) mm."""
    ridge = skin.points[np.abs(skin.points[:, 1]) < 2.0 * SPACING] * [1.0, 0.0, 1.0]
    ridge = skin.project(ridge, free=np.arange(3) != 1)
    best = ridge[np.argmax(ridge @ PLATE_NORMAL)]
    # Steps of 1 µm along the ridge: a point between them protrudes by less than 1e-7 mm.
    line = best + np.linspace(-0.4, 0.4, 801)[:, None] * ALONG
    line = skin.project(line, free=np.arange(3) != 1)
    return np.asarray(line[np.argmax(line @ PLATE_NORMAL)])


def _check_symmetry(file: SurfaceFile, recipe: Recipe) -> tuple[str, ...]:
    """Return the note on the mean of a surface and its mirror image in y = 0.

    Raises InputError if the two are far from each other.
    """
    away = file.skin.asymmetry
    if away > ASYMMETRY * recipe.width / 2.0:
        raise InputError(
            "finger.surface: expected a finger nearly symmetric about its middle, received one "
            f"with a mean distance of {away:.2f} mm from its best mirror image; cut the fingertip "
            "alone out of the scan"
        )
    return _averaged(Path(str(recipe.surface)).name, away)


def _averaged(name: str, away: float) -> tuple[str, ...]:
    """Note on a surface that is `away` mm from its mirror image in the mean; () if that is near."""
    if away < AVERAGED:
        return ()
    return (
        f"{name} lies {away:.2g} mm from its mirror image in the mean; the finger has the mean of "
        "both, since its mesh is symmetric.",
    )


def _noise(skin: SmoothSkin, touch: Array, radii: tuple[float, float]) -> tuple[str, ...]:
    """Note on what the noise of a scan leaves uncertain in a force; () if that is little.

    A bump that is small changes the force by its mean under the pressure of a flat punch on the
    area of contact (Hertz's, of a plate PRESSED mm deep), less that of the place touched first.
    """
    cosine, angle = np.meshgrid((np.arange(8) + 0.5) / 8, np.arange(16) * np.pi / 8)
    across = np.sqrt(1.0 - cosine**2) * np.stack([np.cos(angle), np.sin(angle)])
    along, aside = np.sqrt(PRESSED * np.array(radii))[:, None] * across.reshape(2, -1)
    points = touch + along[:, None] * ALONG + aside[:, None] * [0.0, 1.0, 0.0]
    weights = np.full(len(points) + 1, 1.0 / len(points))
    weights[-1] = -1.0
    share = FORCE_POWER / PRESSED * skin.spread(np.append(points, touch[None], axis=0), weights)
    told = 0.005  # share of the force that noise leaves uncertain from which on a note says so
    if share < told:
        return ()
    return (
        f"The noise of the scan, {skin.noise:.2g} mm at each vertex, leaves the force of a plate "
        f"{PRESSED:g} mm deep uncertain by {share:.1%}, deeper by less (a standard deviation): the "
        "stated errors leave this out; more points and a finer scan have less of it.",
    )
