"""Afferent units under a pad, with the published anatomy: the sites that a mechanics is asked for.

`layout.py` is what a scene says of them, `neural/populations.py` places them on a skin; here the
two meet the library's numbers.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger import library
from fefinger.checks import InputError, choice, number
from fefinger.layout import Grid, Layout, Line, Places, Scatter


if TYPE_CHECKING:
    from fefinger.ask import Ask
    from fefinger.neural.populations import Population, Surface
    from fefinger.neural.trains import SpikeTrains
    from fefinger.records import Response, Sites


Array = NDArray[np.float64]


def place(ask: "Ask", skin: "Surface", axis: ArrayLike) -> "Population":
    """Return the units that a scene asks for, under a skin.

    axis (3,): the inward normal at the first touch, which is the origin. InputError for places
    beside the skin, and as `neural.populations`.
    """
    from fefinger.neural.populations import populate

    layout, known = ask.population, library.innervation()
    if layout is None:
        msg = "ask.population: expected one, received none"
        raise InputError(msg)
    types, places = _places(layout, ask.spikes, skin, np.asarray(axis, float))
    depths = {kind: row.depth for kind, row in library.receptors().items()}
    return populate(
        skin,
        types,
        places,
        depths=depths | dict(ask.depths),
        organs={kind: row.organs for kind, row in known.items()} if layout.branched else None,
        fields={kind: row.field for kind, row in known.items() if row.field is not None},
        seed=layout.seed,
    )


def _places(
    layout: Layout, types: Sequence[str], skin: "Surface", axis: Array
) -> tuple[tuple[str, ...], Array]:
    """Return type and place (n, 3) mm of every unit."""
    from fefinger.neural import populations

    if isinstance(layout, Scatter):
        known = library.innervation()
        wanted = {kind: layout.densities.get(kind, known[kind].density) for kind in types}
        kinds, flat = populations.scatter(wanted, layout.radius, axis, seed=layout.seed)
        points, on = populations.settled(skin, flat, axis)
        if not on.all():
            msg = (
                f"ask.population.radius: {np.count_nonzero(~on)} of {len(on)} units within "
                f"{layout.radius:g} mm lie beside the skin of the pad; choose a smaller radius"
            )
            raise InputError(msg)
        return kinds, points
    if isinstance(layout, Grid):
        points = populations.grid(skin, layout.spacing, layout.radius)
    elif isinstance(layout, Line):
        points = populations.line(skin, layout.start, layout.stop, layout.count)
    elif isinstance(layout, Places):
        name = "ask.population.places"
        points = populations.over(skin, layout.places, name, "move them towards the first touch")
    else:
        msg = f"ask.population: expected a layout of the package, received {layout!r}"
        raise InputError(msg)
    return tuple(np.tile(types, len(points)).tolist()), np.repeat(points, len(types), axis=0)


def sites(population: "Population") -> "Sites":
    """Return the sites of all end organs: what a mechanics gives the strain at."""
    from fefinger.records import Sites

    return Sites(
        points=population.sites,
        normals=population.organ_normals,
        depths=population.organ_depths,
        types=population.organ_types,
        unit=population.unit,
    )


def delays(types: Sequence[str], distance: float) -> Array:
    """Return the conduction delay in s of units of these types over `distance` mm of nerve."""
    distance = number("distance", distance, at_least=0.0, unit="mm")
    known = library.innervation()
    return np.array([1e-3 * distance / known[choice("types", t, known)].velocity for t in types])


def fire(response: "Response", ask: "Ask", **options: Any) -> "SpikeTrains":
    """Return the spikes of a population from the strain of a response at its end organs.

    Further options as in `neural.units.simulate_units`. A unit is where its end organs are in the
    mean.

    Raises
    ------
    InputError
        A response without strain, or without the end organs of the population.
    """
    from fefinger.neural.afferents import displacements
    from fefinger.neural.units import Variation, simulate_units

    reference, found, layout = response.reference, response.sites, ask.population
    if response.strain is None or found is None or reference is None:
        msg = f"ask.population: {response.mechanics!r} gives no strain under the skin to fire from"
        raise InputError(msg)
    if layout is None or found.unit is None:
        msg = f"ask.population: {response.mechanics!r} has no end organs of a population"
        raise InputError(msg)
    x_in = displacements(
        response.strain,
        found.normals,
        found.types,
        reference_depth=reference.depth,
        reference_types=reference.types,
        reference_strain=reference.strain,
        reference_normals=reference.normals,
        drives=ask.drives,
    )
    count = np.bincount(found.unit)
    first = np.searchsorted(found.unit, np.arange(len(count)))
    types = tuple(found.types[i] for i in first)
    drawn = Variation(seed=layout.seed, spread=layout.spread, noise=layout.noise)
    return simulate_units(
        response.time,
        x_in,
        types=types,
        unit=found.unit,
        rule=layout.rule,
        delays=delays(types, layout.distance),
        variation=drawn if layout.random else None,
        generator=ask.generator,
        positions=np.add.reduceat(found.points, first) / count[:, None],
        depths=found.depths[first],
        **options,
    )
