"""Afferent units under a pad, with the published anatomy: the sites that a mechanics is asked for.

`neural/populations.py` places them; here the pad and the library's numbers meet it.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger import library
from fefinger.checks import InputError, choice, number


if TYPE_CHECKING:
    from fefinger.neural.populations import Population, Surface
    from fefinger.neural.trains import SpikeTrains
    from fefinger.neural.units import Variation
    from fefinger.records import Pad, Response, Sites


def surface(pad: "Pad") -> "Surface":
    """Return the skin of a pad."""
    from fefinger.neural.populations import Surface

    return Surface(pad.points, pad.normals, pad.areas)


def fingertip(
    pad: "Pad",
    types: Sequence[str],
    *,
    seed: int,
    densities: Mapping[str, float] | None = None,
    depths: Mapping[str, float] | None = None,
    branched: bool = True,
) -> "Population":
    """Return units of these types scattered over a pad at their published densities.

    densities (per cm²) and depths (mm) replace those of `library.innervation` and
    `library.receptors` for the types that they name; without `branched` every unit has one end
    organ. A half model's pad gives the units of that half. InputError as `neural.populations`.
    """
    from fefinger.neural.populations import scatter

    known = library.innervation()
    wanted = {
        kind: (densities or {}).get(kind, known[choice("types", kind, known)].density)
        for kind in types
    }
    kinds, places = scatter(surface(pad), wanted, seed=seed)
    return placed(pad, kinds, places, seed=seed, depths=depths, branched=branched)


def placed(
    pad: "Pad",
    types: Sequence[str],
    places: ArrayLike,
    *,
    seed: int | None = None,
    depths: Mapping[str, float] | None = None,
    branched: bool = False,
) -> "Population":
    """Return one unit of each type at each place (n_units, 3) mm, with the published anatomy.

    As `fingertip` otherwise; `branched` needs a seed to draw the end organs from.
    """
    from fefinger.neural.populations import populate

    known = library.innervation()
    return populate(
        surface(pad),
        types,
        places,
        depths={kind: row.depth for kind, row in library.receptors().items()} | dict(depths or {}),
        organs={kind: row.organs for kind, row in known.items()} if branched else None,
        fields={kind: row.field for kind, row in known.items() if row.field is not None},
        seed=seed,
    )


def sites(population: "Population") -> "Sites":
    """Return the sites of all end organs: what a mechanics gives the strain at."""
    from fefinger.records import Sites

    return Sites(
        points=population.sites,
        normals=population.organ_normals,
        depths=population.organ_depths,
        types=population.organ_types,
    )


def delays(types: Sequence[str], distance: float) -> NDArray[np.float64]:
    """Return the conduction delay in s of units of these types over `distance` mm of nerve."""
    distance = number("distance", distance, at_least=0.0, unit="mm")
    known = library.innervation()
    return np.array([1e-3 * distance / known[choice("types", t, known)].velocity for t in types])


def fire(
    response: "Response",
    population: "Population",
    *,
    distance: float = 0.0,
    rule: str = "mean",
    variation: "Variation | None" = None,
    drives: Mapping[str, str] | None = None,
    **options: Any,
) -> "SpikeTrains":
    """Return the spikes of a population from the strain of a response at its end organs.

    distance: mm of nerve to where the spikes are recorded. rule, variation and the other options
    as in `neural.units.simulate_units`, drives as in `neural.afferents.from_strain`.

    Raises
    ------
    InputError
        A response without strain, or with strain at other sites than those of the population.
    """
    from fefinger.neural.afferents import displacements
    from fefinger.neural.units import simulate_units

    reference, found = response.reference, response.sites
    if response.strain is None or found is None or reference is None:
        msg = f"response: expected strain at end organs, {response.mechanics!r} gives none"
        raise InputError(msg)
    if found.types != population.organ_types or not np.allclose(found.points, population.sites):
        msg = (
            f"response: expected strain at the {len(population.unit)} end organs of the "
            f"population, received it at {len(found.types)} other sites; ask for "
            "population.sites(...)"
        )
        raise InputError(msg)
    x_in = displacements(
        response.strain,
        found.normals,
        found.types,
        reference_depth=reference.depth,
        reference_types=reference.types,
        reference_strain=reference.strain,
        reference_normals=reference.normals,
        drives=drives,
    )
    return simulate_units(
        response.time,
        x_in,
        types=population.types,
        unit=population.unit,
        rule=rule,
        delays=delays(population.types, distance),
        variation=variation,
        positions=population.centers,
        depths=population.depths,
        **options,
    )
