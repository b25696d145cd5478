"""Units of a population placed on the skin, and the end organs below them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural import populations
from fefinger.neural.populations import Population, Surface
from fefinger.neural.variation import numbered
from fefinger.results.records import Sites
from fefinger.scene.ask import Ask, Disc, Grid, Layout, Line, Places, innervation
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError


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
