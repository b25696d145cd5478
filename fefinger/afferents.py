"""Afferent units under a pad, with the published anatomy: the sites that a mechanics is asked for.

`layout.py` is what a scene says of them, `neural/populations.py` places them on a skin; here the
two meet the library's numbers.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fefinger.scene import library
from fefinger.scene.population import Grid, Layout
from fefinger.support.checks import InputError, choice, number


if TYPE_CHECKING:
    from fefinger.neural.trains import SpikeTrains
    from fefinger.results.records import Response
    from fefinger.scene.ask import Ask


Array = NDArray[np.float64]
Integers = NDArray[np.int64]


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
    from fefinger.neural.units import simulate_units
    from fefinger.neural.variation import Variation

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
        reference,
        drives=ask.drives,
    )
    count = np.bincount(found.unit)
    first = np.searchsorted(found.unit, np.arange(len(count)))
    types = tuple(found.types[i] for i in first)
    numbers = np.arange(len(types)) if found.number is None else found.number[first]
    drawn = Variation(
        seed=layout.seed,
        spread=layout.spread,
        noise=layout.noise,
        numbers=tuple(numbers.tolist()),
    )
    names, notes = _told(layout, ask.spikes, types, numbers)
    trains = simulate_units(
        response.time,
        x_in,
        types=types,
        unit=found.unit,
        rule=layout.rule,
        delays=delays(types, layout.distance),
        variation=drawn if layout.random else None,
        generator=ask.generator,
        names=names,
        positions=np.add.reduceat(found.points, first) / count[:, None],
        depths=found.depths[first],
        **options,
    )
    return replace(trains, notes=notes + trains.notes)


def _told(
    layout: Layout, asked: Sequence[str], types: tuple[str, ...], numbers: Integers
) -> tuple[tuple[str, ...] | None, tuple[str, ...]]:
    """Return the names of units, where they have their own, and a note on places left out.

    The units of a grid are named after the places of the whole grid, so that a name is the same
    unit on every mesh, whichever places lie beside its skin.
    """
    if not isinstance(layout, Grid):
        return None, ()
    from fefinger.neural.populations import squares

    places = numbers // len(asked)
    names = tuple(f"{kind}-{place + 1}" for kind, place in zip(types, places, strict=True))
    total, kept = len(squares(layout.spacing, layout.radius)), len(np.unique(places))
    if kept == total:
        return names, ()
    note = (
        f"ask.population: {total - kept} of the {total} places of the grid lie beside the skin of "
        "the pad and have no units."
    )
    return names, (note,)
