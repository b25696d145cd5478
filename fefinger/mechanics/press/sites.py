"""Positions of the end organs, central ones or below the units of a population, and the skin.

Shared by all mechanics; needs no mesh. Their strain is read by `fem/elements/probe.py`.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fefinger.geometry.finger_mesh import Halves, triangle_areas
from fefinger.geometry.profiles import directions
from fefinger.neural import populations
from fefinger.neural.populations import Population, Surface
from fefinger.neural.variation import numbered
from fefinger.results.records import Sites
from fefinger.scene.ask import Ask, Disc, Grid, Layout, Line, Places, innervation
from fefinger.scene.indenter import direction
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from fefinger.neural.populations import Surface


REFERENCE_DEPTH = 0.5
"""Depth in mm of the small flat press that sets the length of a strain."""


def central_sites(ask: Ask, pulp: float, origin: Array, axis: Array) -> Sites:
    """Place one site per type of `ask` (all four where it names none) under the first touch.

    They lie at the depths of their types along the inward normal `axis` (3,) from `origin` (3,), in
    a tissue `pulp` mm thick.

    InputError for end organs that would lie in the bone.
    """
    depth_of = {kind: organ.depth for kind, organ in innervation().items()} | dict(ask.depths)
    types = ask.spikes or tuple(depth_of)
    depth = np.array([depth_of[kind] for kind in types])
    deepest = float(depth.max(initial=0.0))
    if deepest >= pulp:
        raise InputError(
            f"ask.depths: expected end organs above the bone, less than {pulp:g} mm deep, received "
            f"one at {deepest:g} mm; give depths that this finger has, or ask for the types of "
            "lesser depth alone"
        )
    points = origin + depth[:, None] * axis
    return Sites(points, np.tile(-axis, (len(depth), 1)), depth, tuple(types))


def end_organ_sites(
    ask: Ask, pulp: float, origin: Array, axis: Array, skin: "Callable[[], Surface]"
) -> Sites:
    """Place the end organs of the population of `ask` under the skin, or without one the central.

    The population lies about the first touch of the standard plate, wherever the indenter is.
    """
    if ask.population is None:
        return central_sites(ask, pulp, origin, axis)
    # Here, as a scene without a population loads none of the afferents.

    units = place_units(ask, skin(), direction(STANDARD))
    return of_population(units)


def meshed(points: Array, triangles: Integers, normals: Array, *, half: bool) -> "Surface":
    """Return the skin of a mesh: triangles (n, 3) of its pad, smooth outward normals (n_points, 3).

    That of a half model is mirrored.
    """
    from fefinger.neural.populations import Surface

    weights = np.repeat(triangle_areas(points[triangles]) / 3.0, 3)
    shares = np.bincount(triangles.ravel(), weights, len(points)).astype(np.float64)
    used = np.unique(triangles)
    used = used[np.linalg.norm(normals[used], axis=1) > 0.5]
    points, normals, shares = points[used], normals[used], shares[used]
    if half:
        halves = Halves.of(points)
        points, normals = halves.vectors(points), halves.vectors(normals)
        shares = halves.shares(shares)
    return Surface(points, normals / np.linalg.norm(normals, axis=1, keepdims=True), shares)


def spherical(radius: float, axis: Array) -> "Surface":
    """Return a pad of `radius` mm that touches the origin, where `axis` (3,) points inward."""
    from fefinger.neural.populations import Surface

    # A spherical pad ends where the sine of its slope is 0.9.
    reach = 0.9 * radius
    lattice = 0.4  # mm between the points of a spherical pad
    x = lattice * np.arange(-np.floor(reach / lattice), np.floor(reach / lattice) + 1)
    flat = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    flat = flat[np.linalg.norm(flat, axis=1) <= reach]
    depth = np.sqrt(radius**2 - np.sum(flat**2, axis=1))
    outward = flat @ directions(axis) - np.outer(depth, axis)
    return Surface(radius * axis + outward, outward / radius, lattice**2 * radius / depth)


def place_units(ask: Ask, skin: Surface, axis: ArrayLike) -> Population:
    """Return the requested units of a scene, placed under a skin.

    axis (3,): the inward normal at the first touch, which is the origin. InputError for places
    off the skin, and as `neural.populations`.
    """
    layout, rows = ask.population, innervation()
    if layout is None:
        raise InputError("ask.population: expected one, received none")
    types, places, numbers = _places(layout, ask.spikes, skin, np.asarray(axis, float))
    depths = {kind: row.depth for kind, row in rows.items()}
    return populations.populate(
        skin,
        types,
        places,
        depths=depths | dict(ask.depths),
        organs={kind: row.organs for kind, row in rows.items()} if layout.branched else None,
        fields={kind: row.field for kind, row in rows.items() if row.field is not None},
        numbers=numbers,
        seed=layout.seed,
    )


def _places(
    layout: Layout, types: Sequence[str], skin: Surface, axis: Array
) -> tuple[tuple[str, ...], Array, Integers]:
    """Return type, place (n, 3) mm and number of every unit.

    The number counts the type and the place among all requested ones of the type, wherever
    the skin ends.
    """
    if isinstance(layout, Disc):
        rows = innervation()
        wanted = {kind: layout.densities.get(kind, rows[kind].density) for kind in types}
        kinds, flat = populations.scatter(wanted, layout.radius, axis, seed=layout.seed)
        points, on = populations.settled(skin, flat, axis)
        if not on.any():
            raise InputError(
                f"ask.population.radius: expected units over the skin of the pad, received "
                f"{len(on)} within {layout.radius:g} mm, all beside it; choose a larger radius or "
                "density"
            )
        over = np.flatnonzero(on)
        return tuple(kinds[i] for i in over), points[over], numbered(kinds)[over]
    if isinstance(layout, Grid):
        points, which = populations.grid(skin, layout.spacing, layout.radius)
        each = tuple(types) * len(points)
        numbers = numbered(each, np.repeat(which, len(types)))
        return each, np.repeat(points, len(types), axis=0), numbers
    if isinstance(layout, Line):
        places = np.linspace(layout.start, layout.stop, layout.count)
        points = populations.over(skin, places, "start, stop", "bring the ends of the line closer")
    elif isinstance(layout, Places):
        name = "ask.population.places"
        points = populations.over(skin, layout.places, name, "move them toward the first touch")
    else:
        raise InputError(f"ask.population: expected a layout of the package, received {layout!r}")
    kinds = tuple(types) * len(points)
    return kinds, np.repeat(points, len(types), axis=0), numbered(kinds)


def of_population(population: Population) -> Sites:
    """Return the sites of all end organs, at which a mechanics computes the strain."""
    return Sites(
        points=population.sites,
        normals=population.organ_normals,
        depths=population.organ_depths,
        types=population.organ_types,
        unit=population.unit,
        number=population.numbers[population.unit],
    )
