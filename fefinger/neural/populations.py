"""Placement of afferent units and end organs under a pad of points, normals and areas."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.drives import in_plane
from fefinger.neural.variation import numbered
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import InputError, choice, integer, number
from fefinger.support.vocabulary import TYPES


if TYPE_CHECKING:
    from scipy.spatial import cKDTree


NEIGHBORS = 8
"""Number of surface points that a projection interpolates between."""

BESIDE = 0.5
"""Largest distance in mm of a place from the skin, across its axis; independent of the mesh, so
that all meshes keep the same places of a grid."""


@dataclass(frozen=True)
class Surface:
    """A piece of skin: points (n, 3) mm, unit outward normals (n, 3), areas (n,) mm² per point.

    Raises InputError for fewer points than NEIGHBORS, arrays that do not fit, normals that are not
    unit vectors, areas that are negative or all zero.
    """

    points: Array
    normals: Array
    areas: Array

    def __post_init__(self) -> None:
        n = len(self.points)
        shapes = (np.shape(self.points), np.shape(self.normals), np.shape(self.areas))
        if n < NEIGHBORS or shapes != ((n, 3), (n, 3), (n,)):
            raise InputError(
                f"surface: expected {NEIGHBORS} points or more with normals, (n, 3), and areas, "
                f"(n,); received {shapes}"
            )
        unit = np.abs(np.linalg.norm(self.normals, axis=1) - 1.0).max() < 1e-6
        finite = np.isfinite(self.points).all() and np.isfinite(self.areas).all()
        if not (unit and finite and np.all(self.areas >= 0.0) and self.areas.sum() > 0.0):
            msg = "surface: expected finite points, unit normals and areas of 0 or more, not all 0"
            raise InputError(msg)

    @cached_property
    def _tree(self) -> "cKDTree":
        from scipy.spatial import cKDTree

        return cKDTree(self.points)

    @property
    def spacing(self) -> float:
        """Mean distance of the points in mm: the square root of the mean area."""
        return float(np.sqrt(self.areas.mean()))

    def project(self, places: ArrayLike) -> tuple[Array, Array, Flags]:
        """Project places (n, 3) mm onto the skin: points, normals, and flags of places over it.

        The flag is true within one spacing of the points. Between points the skin is interpolated:
        the chord to a neighbor is perpendicular to the sum of both normals, which is exact on a
        sphere, averaged over NEIGHBORS points with weights 1/distance⁴.
        """
        q = np.array(places, float)
        for _ in range(4):
            distance, near = self._tree.query(q, k=NEIGHBORS)
            weight = 1.0 / (distance + 1e-6 * self.spacing) ** 4
            weight /= weight.sum(axis=1, keepdims=True)
            normals = np.einsum("ik,ikj->ij", weight, self.normals[near])
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            both = self.normals[near] + normals[:, None]
            height = np.einsum("ikj,ikj->ik", q[:, None] - self.points[near], both)
            height /= np.einsum("ikj,ij->ik", both, normals)
            q -= np.einsum("ik,ik->i", weight, height)[:, None] * normals
        apart = np.linalg.norm(self.points[near] - q[:, None], axis=2).min(axis=1)
        on = apart <= np.sqrt(self.areas[near].max(axis=1))
        return q, normals, on


@dataclass(frozen=True, kw_only=True)
class Population:
    """Units and their end organs.

    types (n_units,); depths (n_units,) mm of the end organs; numbers (n_units,): of the units, by
    `numbered` of all requested ones. skin (n_organs, 3) mm: point of the skin above each end organ,
    organ_normals (n_organs, 3) there, unit (n_organs,): index of its unit.
    """

    types: tuple[str, ...]
    depths: Array
    numbers: Integers
    skin: Array
    organ_normals: Array
    unit: Integers

    @property
    def organ_depths(self) -> Array:
        """Depth of each end organ in mm, (n_organs,)."""
        return self.depths[self.unit]

    @property
    def sites(self) -> Array:
        """Places (n_organs, 3) mm of the end organs, below the skin along its normal."""
        return self.skin - self.organ_depths[:, None] * self.organ_normals

    @property
    def organ_types(self) -> tuple[str, ...]:
        """Type of the unit of each end organ, (n_organs,)."""
        return tuple(self.types[i] for i in self.unit)


def scatter(
    densities: Mapping[str, float], radius: float, normal: ArrayLike, *, seed: int
) -> tuple[tuple[str, ...], Array]:
    """Draw types and places (n, 3) mm of units at random in a disc about the origin.

    densities: units per cm² by type; radius in mm; normal (3,): of the disc. The number of units is
    the density times the area, rounded. Each type has its own random stream, so that leaving one
    out does not move the others; the surface has no influence, so that another mesh moves none.

    Raises InputError for an unknown type, a density that is not above 0, or a disc too small for
    one unit.
    """
    area = 0.01 * np.pi * number("radius", radius, above=0.0, unit="mm") ** 2
    types: list[str] = []
    places = [np.empty((0, 3))]
    for kind, density in densities.items():
        choice("densities", kind, TYPES)
        density = number(f"densities.{kind}", density, above=0.0, unit="per cm²")
        count = round(density * area)
        if count == 0:
            raise InputError(
                f"densities.{kind}: {density:g} per cm² leaves no unit on {area:.3g} cm² of skin; "
                "raise the density or the radius, or give the place of one"
            )
        rng = np.random.default_rng([integer("seed", seed), TYPES.index(kind)])
        places.append(_disc(rng, np.asarray(normal, float), radius, count))
        types += [kind] * count
    return tuple(types), np.concatenate(places)


def settled(surface: Surface, places: ArrayLike, axis: ArrayLike) -> tuple[Array, Flags]:
    """Move places (n, 3) mm along an axis (3,) to the skin; a flag says which reach it.

    A place beside the skin does not: it would have to move across the axis by more than BESIDE.
    """
    wanted, axis = np.asarray(places, float), np.asarray(axis, float)
    points, _, on = surface.project(lifted(surface, wanted, axis))
    moved = points - wanted
    across = np.linalg.norm(moved - np.outer(moved @ axis, axis), axis=1)
    return points, on & (across <= BESIDE)


def lifted(surface: Surface, places: ArrayLike, axis: ArrayLike) -> Array:
    """Move places (n, 3) mm along an axis (3,) to the skin nearest to their line."""
    places, axis = np.asarray(places, float), np.asarray(axis, float)
    flat = surface.points - np.outer(surface.points @ axis, axis)
    out = np.empty_like(places)
    for i, place in enumerate(places):
        # Of the points near the line, the first along the axis: the near side of the finger.
        apart = np.linalg.norm(flat - (place - (place @ axis) * axis), axis=1)
        near = apart <= max(float(apart.min()), surface.spacing)
        facing = near & (surface.normals @ axis < 0.0)
        chosen = np.flatnonzero(facing if facing.any() else near)
        j = chosen[np.argmin(surface.points[chosen] @ axis)]
        height = (surface.points[j] - place) @ surface.normals[j]
        slope = float(axis @ surface.normals[j])
        out[i] = place + (height / slope if abs(slope) > 0.2 else 0.0) * axis
    return out


def squares(spacing: float, radius: float) -> Array:
    """Places (n, 2) mm of a square grid in x and y, `spacing` mm apart, within `radius` mm of 0, 0.

    The place 0, 0 is one of them.
    """
    spacing = number("spacing", spacing, above=0.0, unit="mm")
    radius = (1.0 + 1e-9) * number("radius", radius, above=0.0, unit="mm")  # 3 * 0.4 is above 1.2
    most = np.floor(radius / spacing)
    x = spacing * np.arange(-most, most + 1)
    places = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    return places[np.linalg.norm(places, axis=1) <= radius]


def grid(surface: Surface, spacing: float, radius: float) -> tuple[Array, Integers]:
    """Points (n, 3) of a surface at the places of `squares`, and their indices (n,) there.

    Places beside the skin are left out; InputError where all are.
    """
    return _on_skin(surface, squares(spacing, radius), f"a grid of {spacing:g} mm")


def over(surface: Surface, places: ArrayLike, name: str, advice: str) -> Array:
    """Points (n, 3) of a surface at places (n, 2) mm; InputError for a place beside it."""
    wanted = np.asarray(places, float)
    points, on = _on_skin(surface, wanted, name)
    beside = np.delete(wanted, on, axis=0)
    if len(beside):
        shown = 3  # number of places beside the skin that a message lists
        listed = ", ".join(f"[{x:.4g}, {y:.4g}]" for x, y in beside[:shown])
        more = ", ..." if len(beside) > shown else ""
        raise InputError(
            f"{name}: expected places over the skin, received {len(beside)} beside it, at "
            f"{listed}{more} mm; {advice}"
        )
    return points


def populate(
    surface: Surface,
    types: Sequence[str],
    places: ArrayLike,
    *,
    depths: Mapping[str, float],
    organs: Mapping[str, tuple[int, int]] | None = None,
    fields: Mapping[str, float] | None = None,
    numbers: ArrayLike | None = None,
    seed: int | None = None,
) -> Population:
    """Build a population of units of these types at these places.

    Parameters
    ----------
    surface
        The skin that the places are projected onto.
    types, places
        (n_units,) and (n_units, 3) mm.
    depths
        mm of the end organs under the skin, by type.
    organs
        Smallest and largest number of end organs by type, drawn uniformly; by default one.
    fields
        Diameter in mm of the disc over which the end organs of a unit are spread uniformly, by
        type. A single end organ lies at the place of the unit.
    numbers
        (n_units,) whole numbers that select the random stream of each unit; default `numbered`.
    seed
        Seed of the random draws; needed where there are any.

    Raises
    ------
    InputError
        No units, an unknown type, a place beside the skin, a type without a depth, or a field
        larger than the skin.
    """
    types = tuple(choice("types", kind, TYPES) for kind in types)
    centers, normals = _centers(surface, types, places)
    missing = sorted(set(types) - set(depths))
    if missing:
        raise InputError(f"depths: expected one for each type, {', '.join(missing)} is missing")
    streams = np.asarray(numbered(types) if numbers is None else numbers, np.int64)
    skin, skin_normals, unit = [], [], []
    for i, kind in enumerate(types):
        low, high = (organs or {}).get(kind, (1, 1))
        if not 1 <= low <= high:
            raise InputError(
                f"organs.{kind}: expected a smallest number of 1 or more and a largest, received "
                f"{(low, high)!r}"
            )
        if high == 1:
            points, upward = centers[i : i + 1], normals[i : i + 1]
        else:
            rng = np.random.default_rng([integer("seed", seed), len(TYPES), streams[i]])
            diameter = number(f"fields.{kind}", (fields or {}).get(kind), above=0.0, unit="mm")
            count = int(rng.integers(low, high + 1))
            points, upward = _spread(surface, rng, centers[i], normals[i], count, diameter, kind)
        skin.append(points)
        skin_normals.append(upward)
        unit += [i] * len(points)
    return Population(
        types=types,
        depths=np.array([number(f"depths.{k}", depths[k], above=0.0, unit="mm") for k in types]),
        skin=np.concatenate(skin),
        organ_normals=np.concatenate(skin_normals),
        unit=np.array(unit, np.int64),
        numbers=streams,
    )


def _centers(surface: Surface, types: tuple[str, ...], places: ArrayLike) -> tuple[Array, Array]:
    """Project the places of units onto the skin: points and normals; InputError beside it."""
    wanted = np.asarray(places, float)
    if not types or wanted.shape != (len(types), 3) or not np.isfinite(wanted).all():
        raise InputError(
            f"places: expected finite (n, 3) mm for {len(types)} units, one or more, received "
            f"{wanted.shape}"
        )
    centers, normals, on = surface.project(wanted)
    if not on.all():
        first = np.flatnonzero(~on)[0]
        raise InputError(
            f"places: {np.count_nonzero(~on)} of {len(on)} lie beside the skin, the first is "
            f"{types[first]} at {np.round(wanted[first], 3).tolist()} mm"
        )
    return centers, normals


def _spread(
    surface: Surface,
    rng: np.random.Generator,
    center: Array,
    normal: Array,
    count: int,
    diameter: float,
    kind: str,
) -> tuple[Array, Array]:
    """Draw `count` random points of the skin around a center, with normals."""
    points, normals = np.empty((0, 3)), np.empty((0, 3))
    # After 200 draws around a unit the pad is too small for the field.
    for _ in range(200):
        around = center + _disc(rng, normal, 0.5 * diameter, count - len(points))
        drawn, upward, on = surface.project(around)
        points, normals = np.concatenate([points, drawn[on]]), np.concatenate([normals, upward[on]])
        if len(points) == count:
            return points, normals
    raise InputError(
        f"fields.{kind}: the skin is too small for {count} end organs within {diameter:g} mm; "
        "narrow the field"
    )


def _disc(rng: np.random.Generator, normal: Array, radius: float, count: int) -> Array:
    """Draw vectors (count, 3), uniformly over a disc perpendicular to the normal (3,)."""
    first, second = in_plane(normal)
    angle = rng.uniform(0.0, 2.0 * np.pi, count)[:, None]
    # The square root: the area of a disc grows with the square of its radius.
    length = radius * np.sqrt(rng.uniform(size=count))[:, None]
    return length * (np.cos(angle) * first + np.sin(angle) * second)


def _on_skin(surface: Surface, places: Array, what: str) -> tuple[Array, Integers]:
    """Move places (n, 2) mm along z to the skin; return points (m, 3) and indices of the hits."""
    side = np.sign(surface.areas @ surface.normals[:, 2]) or 1.0
    above = np.column_stack([places, np.zeros(len(places))])
    points, on = settled(surface, above, np.array([0.0, 0.0, -side]))
    if not on.any():
        msg = f"places: {what} puts no place on the skin; narrow it, or move it over the pad"
        raise InputError(msg)
    return points[on], np.flatnonzero(on)
