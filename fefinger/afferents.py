"""Spikes from the strain at the end organs, and a check of their counts on a coarser mesh.

`scene/ask.py` describes a population, `mechanics/press/sites.py` places it under the
skin. This module adds the published anatomy, and lets the units of a family fire
(`neural/family.py`).
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.mechanics.evidence import costs
from fefinger.mechanics.evidence.costs import units_of
from fefinger.results.candidate import MECHANICS
from fefinger.scene.ask import Disc, Grid, Layout, innervation
from fefinger.support import processes
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError, choice, number
from fefinger.support.processes import one_thread
from fefinger.support.registry import AFFERENTS
from fefinger.support.vocabulary import TYPES


if TYPE_CHECKING:
    from fefinger.mechanics import Mechanics
    from fefinger.neural.drives import Reference
    from fefinger.neural.trains import SpikeTrains
    from fefinger.results.records import Response, Sites
    from fefinger.scene.ask import Ask
    from fefinger.scene.scene import Scene


KEPT = (
    "Strain is kept at one end organ of each unit, the most compressed, of {}; ask.strain = true "
    "keeps all."
)
"""Note on the strain of a population whose units have several end organs."""

ORGANS = "end_organs"
"""Number in a response: of the end organs of a population, of which strain is kept at fewer."""

EDGES = 0.6
"""Least over largest spike count of a unit among meshes under a texture or a path: FAI fire 52, 58
and 38 impulses at the default grating of 3 mm on the coarse, standard and fine mesh, and 3 or 5
under a bar that slides. Under smooth objects meshes differ by one impulse."""

UNCHECKED = "Spike counts are not compared on a coarser mesh (ask.check = false)."
"""Note on spikes of a scene that leaves the comparison out."""

SILENT = "ask.trial: the units have no noise, so that every trial is the same."
"""Note on another trial of units without noise."""


def of_units(response: "Response") -> "Response":
    """Return a response with the strain of one end organ of each unit: the most compressed."""
    sites, strain = response.sites, response.strain
    if sites is None or sites.unit is None or strain is None or response.harmonic is not None:
        return response
    units, first = np.unique(sites.unit, return_index=True)
    if len(units) == len(sites.unit):
        return response
    from fefinger.support.tensors import extremes  # compiled

    order = np.lexsort((extremes(strain)[0].min(axis=0), sites.unit))
    kept = order[first]
    chosen = replace(
        sites,
        points=sites.points[kept],
        normals=sites.normals[kept],
        depths=sites.depths[kept],
        types=tuple(sites.types[i] for i in kept),
        unit=units,
        number=None if sites.number is None else sites.number[kept],
    )
    return replace(
        response,
        sites=chosen,
        strain=strain[:, kept],
        notes=(*response.notes, KEPT.format(len(order))),
        numbers={**response.numbers, ORGANS: float(len(order))},
    )


def reduced(response: "Response") -> bool:
    """Return whether strain is kept at fewer end organs than units have (`of_units`)."""
    return ORGANS in response.numbers


def fire(
    ask: "Ask",
    response: "Response",
    *,
    since: float = 0.0,
    again: "SpikeTrains | None" = None,
    **options: Any,
) -> "SpikeTrains":
    """Simulate the spikes of the population that `ask` describes, or of one unit of each type.

    Spikes before `since` s do not count. `again`: trains of the same units, whose input fires them
    once more, instead of the strain. Further options as of `fire` of the family that
    `ask.afferents` names.

    Raises InputError for a response without strain, or without the end organs of the population.
    """
    from fefinger.neural.variation import Variation

    family, options["since"] = AFFERENTS[ask.afferents], since
    if again is None:
        strain, sites, reference = _strain_at_sites(ask, response)
        x_in = family.x_in(strain, sites.normals, sites.types, reference, ask.drives)
    else:
        assert response.sites is not None  # its spikes were fired under them
        sites, x_in = response.sites, again.x_in
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
    if again is not None:
        units |= {"unit": None, "positions": again.positions}
    if "generator" in family.choices:
        units["generator"] = ask.generator
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
    meshed = scene.ask.spikes and MECHANICS[mechanics.name].meshed
    bounded = partial(_scattered, scene=scene) if meshed else _as_they_are
    finger = mechanics.coarser(scene) if scene.ask.spikes else None
    if finger is None:
        yield bounded
        return
    if not scene.ask.check:
        yield lambda spikes: bounded(replace(spikes, notes=(*spikes.notes, UNCHECKED)))
        return
    lean = replace(scene, finger=finger, ask=replace(scene.ask, fields=False, pressure=False))
    case, mesh = (mechanics.name, lean), f"the mesh is {finger.mesh}"
    from fefinger.neural.trains import Rerun

    def checked(coarser: "Callable[[], SpikeTrains]", spikes: "SpikeTrains") -> "SpikeTrains":
        try:
            notes, counts = _count_changes(spikes, coarser(), mesh)
        except Exception as error:  # of any kind: the answer itself is finished
            notes, counts = (f"Spike counts could not be checked when {mesh}: {error}",), None
        reruns = () if counts is None else (Rerun(mesh, counts),)
        return bounded(replace(spikes, notes=spikes.notes + notes).beside(*reruns))

    if costs.beside(seconds):
        with processes.in_background(_spikes, case) as coarser:
            yield partial(checked, coarser)
    else:
        yield partial(checked, partial(_spikes, case))


def _as_they_are(spikes: "SpikeTrains") -> "SpikeTrains":
    return spikes


def _scattered(spikes: "SpikeTrains", scene: "Scene") -> "SpikeTrains":
    """Return spike trains with the counts that other meshes were found to give beside them."""
    from fefinger.neural.trains import FEW, Rerun

    counts, change = spikes.count(), "another mesh, as meshes were found to differ"
    if scene.motion.slides or scene.indenter.feature < math.inf:
        ends = np.floor(EDGES * counts), np.ceil(counts / EDGES)
    elif len(spikes) <= FEW:
        ends = np.maximum(counts - 1, 0), np.where(counts > 0, counts + 1, 0)
    else:  # in the sum over many units single impulses average out
        return spikes
    return spikes.beside(*(Rerun(change, np.asarray(each, np.int64)) for each in ends))


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
    names, notes = _names(layout, ask.spikes, types, numbers)
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


def _names(
    layout: Layout, kinds: Sequence[str], types: tuple[str, ...], numbers: Integers
) -> tuple[tuple[str, ...] | None, tuple[str, ...]]:
    """Return names of units, None for default names, and a note on those beside the skin.

    Names count the requested units of a type, so that a name is the same unit on every mesh.
    """
    from fefinger.neural.populations import squares

    if isinstance(layout, Grid):
        total = len(squares(layout.spacing, layout.radius)) * len(kinds)
    elif isinstance(layout, Disc):
        total = sum(map(round, units_of(layout, kinds).values()))
    else:
        return None, ()
    codes = [TYPES.index(kind) for kind in types]
    # Results saved before units were numbered by type hold places among all units of the scene.
    by_type = np.array_equal(numbers % len(TYPES), codes)
    places = numbers // (len(TYPES) if by_type else len(kinds))
    names = tuple(f"{kind}-{place + 1}" for kind, place in zip(types, places, strict=True))
    if total == len(types):
        return (names if isinstance(layout, Grid) else None), ()
    note = (
        f"ask.population: {total - len(types)} of the {total} units would lie beside the skin of "
        "the pad, and are left out."
    )
    return names, (note,)


def _count_changes(
    spikes: "SpikeTrains", coarser: "SpikeTrains", mesh: str
) -> tuple[tuple[str, ...], Integers]:
    """Return notes on the counts of units that are on the skin of both meshes, and the counts.

    Units are compared by name; one that is not on the coarser mesh has its own count.
    """
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
    own = {name: len(times) for name, times in zip(spikes.names, spikes.times, strict=True)}
    own |= {name: len(times) for name, times in zip(names, coarse, strict=True)}
    return changes, np.array([own[name] for name in spikes.names], np.int64)
