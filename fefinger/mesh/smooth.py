"""Vertices moved onto their smooth surfaces, the volume of the bone, and the worst tetrahedra."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fefinger.geometry.finger_mesh import volumes
from fefinger.mesh.finger_shape import Shape, SmoothSurface
from fefinger.support.arrays import Array, Flags, Integers


ON_SHELLS = ("pad", "skin-subcutaneous", "bone")
"""Facet sets on the outer surfaces of skin, subcutaneous tissue and bone; the nail is pad here."""


@dataclass(frozen=True)
class Supports:
    """Geometric constraints of the vertices: surfaces and fixed coordinates.

    Attributes
    ----------
    surface : (n,) index of the surface that it lies on, -1 for none.
    free : (n, 3) coordinates that may change (not y on the medial plane, not x at the cut).
    surfaces : the smooth surfaces.

    """

    surface: Integers
    free: Flags
    surfaces: tuple[SmoothSurface, ...]

    def place(self, points: Array, which: Integers) -> Array:
        """Project `points` (k, 3) onto the surfaces of the vertices `which` (k,)."""
        placed = points.copy()
        for number, surface in enumerate(self.surfaces):
            on = self.surface[which] == number
            if on.any():
                placed[on] = surface.project(points[on], free=self.free[which][on])
        return placed


def supports(shape: Shape, count: int, facets: Mapping[str, Integers]) -> Supports:
    """Constraints of each vertex: the surface of a shell, the medial plane, the cut."""
    on = np.full(count, -1)
    for number, name in enumerate(ON_SHELLS):
        on[np.unique(facets[name])] = number
    free = np.ones((count, 3), dtype=bool)
    free[np.unique(facets["medial"]), 1] = False
    free[np.unique(np.concatenate([facets["cut"], facets["bone-cut"]])), 0] = False
    return Supports(on, free, shape.shells)


def bone_of_volume(
    shape: Shape, points: Array, bone: Integers, free: Flags, volume: float
) -> Array:
    """Offset the bone's surface so that its cells (m, 4) have the volume, mm^3.

    The bone is thin and strongly curved: facets with vertices on it would lose 2 to 3 %.
    `free` (n, 3): the coordinates that may change; all are False beside the surface of the bone.
    """
    on = free.any(axis=1)
    moves = np.zeros_like(points)
    moves[on] = shape.bone.normals(points[on]) * free[on]
    offset = 0.01  # offset in mm of the bone's surface from which its volume is extrapolated
    present, trial = (volumes(points + step * moves, bone).sum() for step in (0.0, offset))
    return points + offset * (volume - present) / (trial - present) * moves


def sines(corners: Array) -> Array:
    """Return the sines of the six dihedral angles of tetrahedra (..., 4, 3) with the volume's sign.

    sin = 3 V l / (2 A B), with l the edge and A, B the areas of the faces that meet there.
    """
    a, b, c, d = (corners[..., i, :] for i in range(4))
    volume = np.einsum("...i,...i->...", np.cross(b - a, c - a), d - a) / 6.0
    areas = [
        np.linalg.norm(np.cross(q - p, r - p), axis=-1) / 2.0
        for p, q, r in ((b, c, d), (a, c, d), (a, b, d), (a, b, c))
    ]
    # Edge (i, j) is shared by the faces opposite to the other two corners (k, l).
    ends = ((a, b, 2, 3), (a, c, 1, 3), (a, d, 1, 2), (b, c, 0, 3), (b, d, 0, 2), (c, d, 0, 1))
    parts = [
        1.5 * volume * np.linalg.norm(q - p, axis=-1) / np.maximum(areas[k] * areas[m], 1e-30)
        for p, q, k, m in ends
    ]
    return np.stack(parts, axis=-1)


def fit(
    points: Array, cells: Integers, supports: Supports, *, wanted: float, pinned: Integers
) -> Array:
    """Move vertices onto their surfaces and the sines of dihedral angles above `wanted`.

    Vertices that cannot reach their surface yet stay inside the mesher's envelope until others
    have moved; `pinned` vertices do not move.
    """
    for share in (0.15, 0.3, 0.45, 0.6):
        points = settle(points, cells, supports, least=share * wanted, pinned=pinned)
        points = improve(points, cells, supports, wanted=wanted, pinned=pinned)
    return settle(points, cells, supports, least=0.6 * wanted, pinned=pinned)


def settle(
    points: Array, cells: Integers, supports: Supports, *, least: float, pinned: Integers
) -> Array:
    """Move vertices onto their surfaces, except where that would cause a sine below `least`."""
    everyone = np.arange(len(points))
    target = supports.place(points, everyone)
    held = np.isin(everyone, pinned)
    before = sines(points[cells]).min(axis=1)
    for _ in range(10):
        moved = np.where(held[:, None], points, target)
        after = sines(moved[cells]).min(axis=1)
        bad = (after < least) & (after < before)
        if not (bad & ~held[cells].all(axis=1)).any():
            break
        held[cells[bad]] = True
    return moved


def improve(
    points: Array,
    cells: Integers,
    supports: Supports,
    *,
    wanted: float,
    pinned: Integers,
    sweeps: int = 8,
) -> Array:
    """Move vertices to raise the sines of dihedral angles above `wanted`, where possible.

    The vertices of bad tetrahedra try seeded random positions on their supports; the one with the
    best worst angle around it is taken (Freitag and Ollivier-Gooch, Int. J. Numer. Methods Eng.
    40:3979, 1997, with random search).
    """
    random = np.random.default_rng(0)
    points = points.copy()
    order = np.argsort(cells.ravel(), kind="stable")
    ends = np.cumsum(np.bincount(cells.ravel(), minlength=len(points)))[:-1]
    around = np.split(order // 4, ends)  # the cells of each vertex
    for sweep in range(sweeps):
        worst = sines(points[cells]).min(axis=1)
        vertices = np.setdiff1d(cells[worst < wanted], pinned)
        if not len(vertices):
            break
        for vertex in random.permutation(vertices):
            _move(points, cells[around[vertex]], vertex, supports, random, 0.3 * 0.75**sweep)
    return points


def _move(
    points: Array,
    star: Integers,
    vertex: int,
    supports: Supports,
    random: np.random.Generator,
    reach: float,
) -> None:
    """Move one vertex, in place, to the trial with the best worst angle in its star (k, 4)."""
    here = points[vertex]
    size = np.sqrt(np.mean(np.sum((points[star] - here) ** 2, axis=2)))
    # Random positions tried for a vertex in one sweep; about one in four moves then helps.
    trials = 24
    steps = random.normal(size=(trials, 3)) * size * reach * random.random((trials, 1))
    steps[:, ~supports.free[vertex]] = 0.0
    places = supports.place(here + steps, np.full(trials, vertex))
    places[:, ~supports.free[vertex]] = here[~supports.free[vertex]]
    places = np.concatenate([here[None], places])
    corners = np.repeat(points[star][None], len(places), axis=0)
    corners[:, star == vertex] = places[:, None]
    points[vertex] = places[np.argmax(sines(corners).min(axis=(1, 2)))]
