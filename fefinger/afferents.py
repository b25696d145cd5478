"""Spikes from the strain at the end organs, and a check of their counts on a coarser mesh.

`scene/population.py` describes a population, `mechanics/press/sites.py` places it under the
skin. This module adds the published anatomy, and lets the units of a family fire
(`neural/family.py`).
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.mechanics.evidence import costs
from fefinger.scene.innervation import innervation
from fefinger.scene.population import Grid, Layout
from fefinger.support import processes
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError, choice, number
from fefinger.support.registry import AFFERENTS
from fefinger.support.threads import one_thread
from fefinger.support.vocabulary import TYPES


if TYPE_CHECKING:
    from fefinger.mechanics import Mechanics
    from fefinger.neural.drives import Reference
    from fefinger.neural.trains import SpikeTrains
    from fefinger.results.records import Response, Sites
    from fefinger.scene.ask import Ask
    from fefinger.scene.scene import Scene


SILENT = "ask.trial: the units have no noise, so that every trial is the same."
"""Note on another trial of units without noise."""


def fire(ask: "Ask", response: "Response", *, since: float = 0.0, **options: Any) -> "SpikeTrains":
    """Simulate the spikes of the population that `ask` describes, or of one unit of each type.

    Spikes before `since` s do not count. Further options as of `fire` of the family that
    `ask.afferents` names.

    Raises InputError for a response without strain, or without the end organs of the population.
    """
    from fefinger.neural.variation import Variation

    strain, sites, reference = _strain_at_sites(ask, response)
    family, options["since"] = AFFERENTS[ask.afferents], since
    units: dict[str, Any] = {
        "types": sites.types,
        "positions": sites.points,
        "depths": sites.depths,
    }
    notes: tuple[str, ...] = ()
    if ask.population is not None:
        units, notes = _population(ask, ask.population, sites)
    elif family.noisy:
        units["variation"] = Variation(seed=0, noise=None, trial=ask.trial)
    if "generator" in family.choices:
        units["generator"] = ask.generator
    x_in = family.x_in(strain, sites.normals, sites.types, reference, ask.drives)
    rule = None if ask.population is None else ask.population.rule
    units |= {"rule": rule or family.rules[0]} | options
    trains = family.fire(response.time, x_in, **units)
    if since > response.time[0]:
        notes = (f"Spikes count from {since:.6g} s on; those before it are left out.", *notes)
    noise = None if ask.population is None else ask.population.noise
    if ask.trial and not (family.noisy if noise is None else noise > 0.0):
        notes += (SILENT,)
    return replace(trains, notes=(*notes, *family.notes(), *trains.notes))


@contextmanager
def mesh_check(
    mechanics: "Mechanics", scene: "Scene", seconds: float
) -> "Iterator[Callable[[SpikeTrains], SpikeTrains]]":
    """Yield a function that adds to spike trains notes on their counts on the coarser mesh.

    It adds none where the mechanics has no mesh, or no coarser one is available. If the answer is
    expected to take `costs.BESIDE` seconds or more, another process computes the counts meanwhile.
    """
    finger = mechanics.coarser(scene) if scene.ask.spikes else None
    if finger is None:
        yield lambda spikes: spikes
        return
    lean = replace(scene, finger=finger, ask=replace(scene.ask, fields=False, pressure=False))
    case, mesh = (mechanics.name, lean), f"the mesh is {finger.mesh}"

    def checked(coarser: "Callable[[], SpikeTrains]", spikes: "SpikeTrains") -> "SpikeTrains":
        try:
            notes = _count_changes(spikes, coarser(), mesh)
        except Exception as error:  # of any kind: the answer itself is finished
            notes = (f"Spike counts could not be checked when {mesh}: {error}",)
        return replace(spikes, notes=spikes.notes + notes)

    if costs.beside(seconds):
        with processes.in_background(_spikes, case) as coarser:
            yield partial(checked, coarser)
    else:
        yield partial(checked, partial(_spikes, case))


@one_thread  # of BLAS, as in a process beside another
def _spikes(case: "tuple[str, Scene]") -> "SpikeTrains":
    """Answer a scene by the named mechanics, and return the spikes."""
    from fefinger.mechanics import get

    name, scene = case
    return fire(scene.ask, get(name).respond(scene), since=scene.motion.recorded_from)


def delays(types: Sequence[str], distance: float) -> Array:
    """Return the conduction delays (n,) in s of units of types over `distance` mm of nerve."""
    distance = number("distance", distance, at_least=0.0, unit="mm")
    rows = innervation()
    return np.array([1e-3 * distance / rows[choice("types", t, rows)].velocity for t in types])


def _strain_at_sites(ask: "Ask", response: "Response") -> "tuple[Array, Sites, Reference]":
    """Return strain, end organs and reference press of a response; InputError if one is missing."""
    strain, sites, reference = response.strain, response.sites, response.reference
    field = "ask.spikes" if ask.population is None else "ask.population"
    if strain is None or sites is None or reference is None:
        msg = f"{field}: {response.mechanics!r} gives no strain under the skin to make spikes from"
        raise InputError(msg)
    if ask.population is not None and sites.unit is None:
        raise InputError(f"{field}: {response.mechanics!r} has no end organs of a population")
    return strain, sites, reference


def _population(
    ask: "Ask", layout: Layout, sites: "Sites"
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return arguments of the simulation for the units of a population, and notes on lost places.

    The place of a unit is the mean of the places of its end organs.
    """
    from fefinger.neural.variation import Variation, numbered

    assert sites.unit is not None
    count = np.bincount(sites.unit)
    first = np.searchsorted(sites.unit, np.arange(len(count)))
    types = tuple(sites.types[i] for i in first)
    numbers = numbered(types) if sites.number is None else sites.number[first]
    names, notes = _grid_names(layout, ask.spikes, types, numbers)
    variation = Variation(
        seed=layout.seed,
        spread=layout.spread,
        noise=layout.noise,
        numbers=tuple(numbers.tolist()),
        trial=ask.trial,
    )
    alike = not (AFFERENTS[ask.afferents].noisy or layout.spread or layout.noise)
    units = {
        "types": types,
        "unit": sites.unit,
        "delays": delays(types, layout.distance),
        "variation": None if alike else variation,
        "names": names,
        "positions": np.add.reduceat(sites.points, first) / count[:, None],
        "depths": sites.depths[first],
    }
    return units, notes


def _grid_names(
    layout: Layout, kinds: Sequence[str], types: tuple[str, ...], numbers: Integers
) -> tuple[tuple[str, ...] | None, tuple[str, ...]]:
    """Return names of the units of a grid, None for default names, and notes on lost places.

    Names count the places of the whole grid, so that a name is the same unit on every mesh.
    """
    if not isinstance(layout, Grid):
        return None, ()
    from fefinger.neural.populations import squares

    codes = [TYPES.index(kind) for kind in types]
    # Results saved before units were numbered by type hold places among all units of the scene.
    by_type = np.array_equal(numbers % len(TYPES), codes)
    places = numbers // (len(TYPES) if by_type else len(kinds))
    names = tuple(f"{kind}-{place + 1}" for kind, place in zip(types, places, strict=True))
    total, on_skin = len(squares(layout.spacing, layout.radius)), len(np.unique(places))
    if on_skin == total:
        return names, ()
    note = (
        f"ask.population: {total - on_skin} of the {total} places of the grid lie beside the skin "
        "of the pad and have no units."
    )
    return names, (note,)


def _count_changes(spikes: "SpikeTrains", coarser: "SpikeTrains", mesh: str) -> tuple[str, ...]:
    """Return notes on the counts of units that are on the skin of both meshes, by name."""
    from fefinger.neural.checked_signals import count_changes

    shared = set(coarser.names)
    names = [name for name in spikes.names if name in shared]
    fine, coarse = (
        [trains.times[trains.index(name)] for name in names] for trains in (spikes, coarser)
    )
    changes = count_changes(names, fine, coarse, mesh)
    if names and not changes:
        changes = (f"All spike counts are the same when {mesh}.",)
    alone = len(spikes.names) - len(names)
    if alone:
        what = f"{alone} of {len(spikes)} units, whose places lie beside the skin when {mesh}"
        changes = (*changes, f"Not compared: {what}.")
    return changes
