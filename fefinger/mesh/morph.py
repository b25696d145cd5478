"""Morph of a shipped mesh to another finger: surfaces onto its surfaces, the inside by extension.

The template keeps its cells, facets and numbering. A vertex of a surface keeps its place on it, by
the station along the finger and the angle around it; the displacement of the vertices inside is
the harmonic extension. Nothing is random, so that a recipe has one mesh.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.interpolate import PchipInterpolator

from fefinger.geometry.finger_mesh import BONE, FingerMesh, interfaces, triangle_areas, volumes
from fefinger.mesh import finger_shape, smooth
from fefinger.mesh.finger_shape import Shape, touch_within
from fefinger.mesh.mesh_record import SCANNED, STRICT, gate, record
from fefinger.mesh.recipe import STRETCH, Recipe, Touch
from fefinger.mesh.shell import Shell
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import ConvergenceError


Pair = tuple[float, float]
Stations = Callable[[Array, Array], Array]
"""New x of points at x and at a height, over that of the section: -1 on the palm, 1 on the back."""

BONE_SHELL = smooth.ON_SHELLS.index("bone")


@dataclass(frozen=True)
class Draft:
    """A template with its vertices moved to another shape, before any is improved.

    Attributes
    ----------
    template, source : the mesh and its shape.
    points : (n, 3) places of its vertices on the shape wanted, mm.
    constraints : surfaces and fixed coordinates of the vertices there.
    poor : number of cells with a worse dihedral angle than the template has.
    stretch : ratio of facet sizes to the template's, in the fine half of the pad.

    """

    template: FingerMesh
    source: Shape
    points: Array
    constraints: smooth.Supports
    poor: int
    stretch: float


def draft(template: FingerMesh, source: Shape, target: Shape, touch: Touch = None) -> Draft:
    """Move the vertices of a template of the shape `source` to the shape `target`.

    touch: center of the fine facets of both, as in `Recipe`.
    """
    facets = _facets(template)
    constraints = smooth.supports(target, len(template.points), facets)
    moves = _surface_moves(template, source, target, constraints, touch)
    held = ~constraints.free | (constraints.surface >= 0)[:, None]
    points = template.points + extension(template.points, template.cells, moves, held)
    poor = np.sum(smooth.sines(points[template.cells]).min(axis=1) < _wanted(template))
    return Draft(template, source, points, constraints, int(poor), _stretch(template, points))


def finished(made: Draft, target: Shape, recipe: Recipe, *, name: str = "finger") -> FingerMesh:
    """Improve the cells of a draft and return the mesh; raise ConvergenceError if it is not good.

    The worst dihedral angle is raised to the template's, where possible. A parametric finger whose
    pad would be coarser than its resolution is not good; of a scan, which has one mesh however
    often it is built, a note says so.
    """
    template, free = made.template, made.constraints.free
    if made.stretch > STRETCH and recipe.surface is None:
        message = f"mesh: the template {template.name} would be stretched {made.stretch:.2f} times"
        raise ConvergenceError(message)
    first = np.flatnonzero(np.all(template.points == 0.0, axis=1))
    points = smooth.improve(
        made.points, template.cells, made.constraints, wanted=_wanted(template), pinned=first
    )
    bone = template.cells[template.region == BONE]
    share = volumes(template.points, bone).sum() / made.source.volumes["bone"]
    on_bone = (made.constraints.surface == BONE_SHELL)[:, None] & free
    points = smooth.bone_of_volume(target, points, bone, on_bone, share * target.volumes["bone"])
    mesh = record(
        target, recipe, points, template.cells, template.region, template.facets, name=name
    )
    gate(mesh.quality, STRICT if recipe.surface is None else SCANNED)
    quality = mesh.quality | {"template": template.name}
    if made.stretch > STRETCH:
        coarser = (
            f"The facets of this pad are {made.stretch:.2g} times as large as its resolution has "
            "elsewhere: the finger is wider than those of the shipped meshes."
        )
        quality["notes"] = [*quality.get("notes", ()), coarser]
    return replace(mesh, quality=quality)


def _wanted(template: FingerMesh) -> float:
    """Sine of the worst dihedral angle of a template, less what rounding changes."""
    return float(smooth.sines(template.points[template.cells]).min()) * (1.0 - 1e-6)


def _stretch(template: FingerMesh, points: Array) -> float:
    """Ratio of facet sizes to the template's in the fine half of the pad, at points (n, 3)."""
    pad = template.facets["pad"]
    before, after = (triangle_areas(places[pad]) for places in (template.points, points))
    fine = before <= np.median(before)
    return float(np.sqrt(after[fine].sum() / before[fine].sum()))


def extension(points: Array, cells: Integers, moves: Array, held: Flags) -> Array:
    """Return displacements (n, 3) that are `moves` where `held` (n, 3), and harmonic elsewhere.

    Linear elements: exact for an affine displacement whose normal derivative vanishes where it is
    not held.
    """
    from scipy.sparse.linalg import splu

    matrix = _laplacian(points, cells)
    extended = np.where(held, moves, 0.0)
    for axis in range(3):
        free = ~held[:, axis]
        rows = matrix[free]
        load = -rows[:, ~free] @ extended[~free, axis]
        extended[free, axis] = splu(rows[:, free].tocsc()).solve(load)
    return extended


def mapped(points: Array, source: Shell, target: Shell, stations: Stations) -> Array:
    """Return points (n, 3) on a shell moved to their stations on another, at the same angle."""
    sizes = source.heights(points[:, 0])
    height = points[:, 2] - source.middle
    least = 1e-9  # size in mm of a section that counts as a point
    above = height / np.maximum(np.where(height < 0.0, sizes[1], sizes[2]), least)
    x = stations(points[:, 0], above)
    # At the tip, where all sections shrink to a point, any ratio is right.
    pairs = zip(sizes, target.heights(x), strict=True)
    side, low, high = (np.maximum(to, least) / np.maximum(at, least) for at, to in pairs)
    height *= np.where(height < 0.0, low, high)
    return np.column_stack([x, points[:, 1] * side, target.middle + height])


def _facets(mesh: FingerMesh) -> dict[str, Integers]:
    """Return the facet sets as `smooth.supports` takes them."""
    between, _, outer = interfaces(mesh.cells, mesh.region)
    pad = np.concatenate([mesh.facets["pad"], mesh.facets["nail"]])
    layers = between[(outer != 0) & (outer != BONE)]
    return {**mesh.facets, "pad": pad, "skin-subcutaneous": layers}


def _surface_moves(
    template: FingerMesh,
    source: Shape,
    target: Shape,
    constraints: smooth.Supports,
    touch: Touch,
) -> Array:
    """Displacements (n, 3) mm of the vertices on surfaces and planes; zero at the others.

    A vertex moves as the foot of its perpendicular, and so keeps its distance from the surface: on
    the bone it is not 0, which gives the bone its volume.
    """
    points, free = template.points, constraints.free
    moves = np.zeros_like(points)
    moves[~free[:, 0], 0] = target.cut - source.cut
    for number, stations in enumerate(_stations(source, target, touch)):
        on = np.flatnonzero(constraints.surface == number)
        foot = source.shells[number].project(points[on], free=free[on])
        there = mapped(foot, source.sections[number], target.sections[number], stations)
        there = np.where(free[on], there, foot + moves[on])
        moves[on] = target.shells[number].project(there, free=free[on]) - foot
    moves[np.all(points == 0.0, axis=1)] = 0.0  # first touch
    return moves


def _stations(source: Shape, target: Shape, touch: Touch) -> Iterator[Stations]:
    """Yield the map of x along each shell, which takes cut, touches, nail and tip to the others.

    Touches are on the palm and the nail is on the back; between them the map changes smoothly.
    """
    touches = [np.zeros((2, 3))]
    if touch is not None:
        touches.append(np.stack([touch_within(shape, touch, np.inf) for shape in (source, target)]))
    nail = [(source.nail.start, target.nail.start), (source.nail.end, target.nail.end)]
    pairs = zip(source.sections, target.sections, strict=True)
    for number, (one, other) in enumerate(pairs):
        ends = [(source.cut, target.cut), (one.tip, other.tip)]
        feet = [_feet(source, target, number, points) for points in touches]
        bone = number == BONE_SHELL
        yield _blended(_map(ends, [] if bone else feet), _map(ends, [] if bone else nail))


def _map(ends: list[Pair], knots: list[Pair]) -> Callable[[Array], Array]:
    """Return an increasing map with the given values, without knots close to one another."""
    chosen = list(ends)
    for knot in knots:
        apart = np.subtract(chosen, knot)
        # Stations that a map is fixed at are 1 mm apart or more.
        if np.abs(apart).min() > 1.0 and (apart[:, 0] * apart[:, 1] > 0.0).all():
            chosen.append(knot)
    x, moved = np.array(sorted(chosen)).T
    return PchipInterpolator(x, moved, extrapolate=True)


def _blended(palm: Callable[[Array], Array], back: Callable[[Array], Array]) -> Stations:
    """Return the map that is `palm` well below the widest level and `back` well above it."""

    def stations(x: Array, above: Array) -> Array:
        share = finger_shape.smooth(above + 0.5)
        return np.asarray((1.0 - share) * palm(x) + share * back(x))

    return stations


def _feet(source: Shape, target: Shape, number: int, points: Array) -> tuple[float, float]:
    """Stations of a shell below points (2, 3) of the skins of source and target, mm."""
    shells = (source.shells[number], target.shells[number])
    one, other = (
        shell.project(point[None])[0, 0] for shell, point in zip(shells, points, strict=True)
    )
    return float(one), float(other)


def _laplacian(points: Array, cells: Integers) -> sparse.csr_array:
    """Stiffness of the Laplacian by linear tetrahedra, (n, n) sparse."""
    corners = np.concatenate([np.ones((len(cells), 4, 1)), points[cells]], axis=2)
    gradients = np.linalg.inv(corners)[:, 1:]
    local = volumes(points, cells)[:, None, None] * np.einsum("mki,mkj->mij", gradients, gradients)
    rows, columns = np.repeat(cells, 4, axis=1), np.tile(cells, (1, 4))
    return sparse.csr_array((local.ravel(), (rows.ravel(), columns.ravel())))
