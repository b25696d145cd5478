"""Simulation of afferent units: from skin displacement or strain at end organs to spike trains."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.neural.drives import DEFAULT_DRIVE, DRIVE_BY_NAME
from fefinger.neural.membranes import LARGEST_STEP, Membrane
from fefinger.neural.trains import SpikeTrains
from fefinger.neural.units import simulate_units
from fefinger.support.checks import InputError, choice, number
from fefinger.support.vocabulary import DRIVES, TYPES


Array = NDArray[np.float64]

SMALLEST_REFERENCE = 0.02
"""Smallest reference drive over the norm of the reference strain; below, the length is noise."""


def simulate(
    time: ArrayLike,
    drive: ArrayLike,
    *,
    types: Sequence[str],
    lengths: ArrayLike = 1.0,
    generator: str = "saturating",
    membrane: Membrane | None = None,
    names: Sequence[str] | None = None,
    positions: ArrayLike | None = None,
    dt: float = LARGEST_STEP,
    tolerance: float | None = None,
    check: bool = True,
) -> SpikeTrains:
    """Simulate the spikes of afferent units with one end organ each.

    The chain: x_in = length * drive, end-organ filter, half-wave rectification, generator,
    membrane. The drive is linear between its samples and the filter exact for that, so the sampling
    may be uneven. `units.simulate_units` is for units with many end organs.

    Parameters
    ----------
    time
        (n_t,) s, not decreasing; a repeated time is a jump. The drive is zero before `time[0]`.
    drive
        (n_t, n_units), dimensionless; or mm of skin displacement with the default length 1.
    types
        Afferent type of each unit.
    lengths
        (n_units,) or one number: mm of skin displacement per unit of drive.
    generator
        "saturating" or "linear".
    membrane
        Default HodgkinHuxley() with rates / 6.
    names, positions
        Names of the units (default: types, numbered where they repeat) and (n_units, 3) mm.
    dt, tolerance
        Longest integration step in s; or allowed error of spike times in s, from which integrator
        and step (`HodgkinHuxley.integrator`) and the sampling of the current are chosen.
    check
        Repeat with half the step and with half of the samples; differences of counts become notes.

    Raises
    ------
    InputError
        Arrays that do not fit, unknown names, values that are not finite, times that decrease.
    """
    return simulate_units(
        time,
        drive,
        types=types,
        unit=np.arange(len(types)),
        lengths=lengths,
        generator=generator,
        membrane=membrane,
        names=names,
        positions=positions,
        dt=dt,
        tolerance=tolerance,
        check=check,
    )


def from_strain(
    time: ArrayLike,
    strain: ArrayLike,
    normals: ArrayLike,
    types: Sequence[str],
    *,
    reference_depth: float,
    reference_types: Sequence[str],
    reference_strain: ArrayLike,
    reference_normals: ArrayLike,
    drives: Mapping[str, str] | None = None,
    generator: str = "saturating",
    names: Sequence[str] | None = None,
    positions: ArrayLike | None = None,
    dt: float = LARGEST_STEP,
    tolerance: float | None = None,
    check: bool = True,
) -> SpikeTrains:
    """Simulate the spikes of afferent units from the strain at their end organs.

    Parameters
    ----------
    time, strain, normals, types
        (n_t,) s; (n_t, n_units, 3, 3); unit normals (n_units, 3); afferent type of each unit.
    reference_depth, reference_types, reference_strain, reference_normals
        A small flat press of the same finger: depth in mm and, for each of n types, strain
        (n, 3, 3) and normal (n, 3) at the central site. The length of a type is the depth divided
        by its drive there, so that a flat probe gives the one-dimensional case of the thesis.
    drives
        Drive per type, where it is not DEFAULT_DRIVE.
    generator, names, positions, dt, tolerance, check
        As in `simulate`.

    Raises
    ------
    InputError
        As in `simulate`; also a type without a reference, or with a reference drive that is not
        clearly above zero.
    """
    x_in = displacements(
        strain,
        normals,
        types,
        reference_depth=reference_depth,
        reference_types=reference_types,
        reference_strain=reference_strain,
        reference_normals=reference_normals,
        drives=drives,
    )
    return simulate(
        time,
        x_in,
        types=types,
        generator=generator,
        names=names,
        positions=positions,
        dt=dt,
        tolerance=tolerance,
        check=check,
    )


def displacements(
    strain: ArrayLike,
    normals: ArrayLike,
    types: Sequence[str],
    *,
    reference_depth: float,
    reference_types: Sequence[str],
    reference_strain: ArrayLike,
    reference_normals: ArrayLike,
    drives: Mapping[str, str] | None = None,
) -> Array:
    """Convert strain at end organs to equivalent skin displacement x_in (n_t, n_sites) in mm.

    x_in is the drive of each site's type times its length; parameters and errors as in
    `from_strain`, with sites, one per end organ, for units.
    """
    lengths = reference_lengths(
        types,
        reference_depth=reference_depth,
        reference_types=reference_types,
        reference_strain=reference_strain,
        reference_normals=reference_normals,
        drives=drives,
    )
    chosen = {**DEFAULT_DRIVE, **(drives or {})}
    strain, normals = np.asarray(strain, float), np.asarray(normals, float)
    n = len(types)
    if strain.ndim != 4 or strain.shape[1:] != (n, 3, 3) or normals.shape != (n, 3):
        msg = (
            f"strain, normals: expected (n_t, {n}, 3, 3) and ({n}, 3) for {n} sites, received "
            f"{strain.shape} and {normals.shape}"
        )
        raise InputError(msg)
    if not np.isfinite(strain).all():
        msg = "strain: expected finite values"
        raise InputError(msg)
    x_in = np.empty(strain.shape[:2])
    for kind, length in lengths.items():
        of_kind = np.array([other == kind for other in types])
        x_in[:, of_kind] = length * DRIVE_BY_NAME[chosen[kind]](
            strain[:, of_kind], normals[of_kind]
        )
    return x_in


def reference_lengths(
    types: Sequence[str],
    *,
    reference_depth: float,
    reference_types: Sequence[str],
    reference_strain: ArrayLike,
    reference_normals: ArrayLike,
    drives: Mapping[str, str] | None = None,
) -> dict[str, float]:
    """Skin displacement L in mm per unit of drive, by type; parameters as in `from_strain`."""
    for kind in types:
        choice("types", kind, TYPES)
    chosen = {**DEFAULT_DRIVE, **(drives or {})}
    for kind, name in chosen.items():
        choice("drives", kind, TYPES)
        choice(f"drives.{kind}", name, DRIVES)
    return _lengths(
        {kind: chosen[kind] for kind in types},
        reference_depth,
        tuple(reference_types),
        np.asarray(reference_strain, float),
        np.asarray(reference_normals, float),
    )


def _lengths(
    drives: Mapping[str, str], depth: float, types: tuple[str, ...], strain: Array, normals: Array
) -> dict[str, float]:
    """Skin displacement L in mm per unit of drive, by type: reference depth / reference drive."""
    depth, n = number("reference_depth", depth, above=0.0, unit="mm"), len(types)
    if strain.shape != (n, 3, 3) or normals.shape != (n, 3):
        msg = (
            f"reference_strain, reference_normals: expected ({n}, 3, 3) and ({n}, 3) for {n} "
            f"types, received {strain.shape} and {normals.shape}"
        )
        raise InputError(msg)
    lengths = {}
    for kind, name in drives.items():
        if kind not in types:
            msg = f"reference_types: expected every type in use, {kind} is missing"
            raise InputError(msg)
        i = types.index(kind)
        value = float(DRIVE_BY_NAME[name](strain[i : i + 1], normals[i : i + 1])[0])
        norm = float(np.linalg.norm(strain[i]))
        if not value > SMALLEST_REFERENCE * norm:
            msg = (
                f"drives.{kind}: the drive {name!r} is {value:.3g} at the site of {kind} in the "
                f"reference press of {depth:g} mm, against a strain of {norm:.3g}; expected it "
                "clearly above zero; choose another drive or another depth of the site"
            )
            raise InputError(msg)
        lengths[kind] = depth / value
    return lengths
