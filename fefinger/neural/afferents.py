"""Simulation of afferent units: from skin displacement or strain at end organs to spike trains."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.drives import DEFAULT_DRIVE, DRIVE_BY_NAME
from fefinger.neural.membranes import LARGEST_STEP, Membrane
from fefinger.neural.reference import Reference
from fefinger.neural.trains import SpikeTrains
from fefinger.neural.units import simulate_units
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


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
    reference: Reference,
    *,
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
    reference
        A small flat press of the same finger. The length of a type is the depth over the drive of
        that type in it, so that a flat probe gives the one-dimensional case of the thesis.
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
    x_in = equivalent_displacements(strain, normals, types, reference, drives=drives)
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


def equivalent_displacements(
    strain: ArrayLike,
    normals: ArrayLike,
    types: Sequence[str],
    reference: Reference,
    *,
    drives: Mapping[str, str] | None = None,
) -> Array:
    """Convert strain at end organs to equivalent skin displacement x_in (n_t, n_sites) in mm.

    x_in is the drive of each site's type times its length; parameters and errors as in
    `from_strain`, with sites, one per end organ, for units.
    """
    lengths = reference.lengths(types, drives)
    chosen = {**DEFAULT_DRIVE, **(drives or {})}
    return driven_displacements(strain, normals, types, chosen, lengths)


def driven_displacements(
    strain: ArrayLike,
    normals: ArrayLike,
    types: Sequence[str],
    drives: Mapping[str, str],
    lengths: Mapping[str, float],
) -> Array:
    """Convert strain at end organs to x_in (n_t, n_sites) in mm: drive times length, by type.

    InputError for arrays that do not fit the types, or strain that is not finite.
    """
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
    for kind in dict.fromkeys(types):
        of_kind = np.array([other == kind for other in types])
        x_in[:, of_kind] = lengths[kind] * DRIVE_BY_NAME[drives[kind]](
            strain[:, of_kind], normals[of_kind]
        )
    return x_in
