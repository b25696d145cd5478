"""Simulation of units of the family `recorded`: from drives at end organs to spike trains."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.neural.checked_signals import (
    checked_signals,
    checked_types,
    coarse_remarks,
    count_changes,
    counted,
    organ_columns,
    unit_array,
    unit_delays,
    unit_names,
)
from fefinger.neural.membranes import IntegrateAndFire
from fefinger.neural.recorded import Recorded, parameters_of, units_of
from fefinger.neural.trains import SpikeTrains
from fefinger.neural.variation import Variation
from fefinger.support.arrays import Array
from fefinger.support.checks import choice, number
from fefinger.support.vocabulary import RECORDED_RULES


if TYPE_CHECKING:
    from fefinger.neural.recorded_compiled import Units


THRESHOLD = IntegrateAndFire().threshold
"""Current in µA/cm² that the threshold of every unit counts as: a nominal one, since only the
ratio of a current to the threshold matters."""

SPIKE_MV = 40.0
"""Potential in mV that the threshold counts as, as in `IntegrateAndFire`."""

LONGEST = {"SAI": 2e-4, "SAII": 2e-4, "FAI": 2e-4, "FAII": 1e-4}
"""Longest integration step in s of the units of a type."""


def simulate_recorded(
    time: ArrayLike,
    drive: ArrayLike,
    *,
    types: Sequence[str],
    unit: ArrayLike | None = None,
    lengths: ArrayLike = 1.0,
    rule: str = "max",
    delays: ArrayLike = 0.0,
    variation: Variation | None = None,
    parameters: Mapping[str, Recorded] | None = None,
    names: Sequence[str] | None = None,
    positions: ArrayLike | None = None,
    depths: ArrayLike | None = None,
    step: float | None = None,
    check: bool = True,
    exact: bool = False,
    since: float = -np.inf,
) -> SpikeTrains:
    """Simulate the spikes of units that fire as recorded ones do.

    Impulses are recorded a latency after threshold (`Recorded`), so none comes before its cause;
    those that it takes beyond the end of the series are left out.
    Times may be negative: a series that is shifted in time fires the same spikes, shifted, with the
    same noise.

    Parameters
    ----------
    time, drive, types, unit, delays, names, positions, depths
        As in `units.simulate_units`; by default each unit has one end organ.
    lengths
        (n_organs,) or one number: mm of x_in per unit of drive. x_in is the displacement of a round
        pin 1 mm wide that strains the end organ below it as much.
    rule
        Input of a unit with several end organs: "max", the largest of theirs at every time, or
        "mean".
    variation
        Unequal gains and noise in µA/cm² of a threshold of THRESHOLD; None: equal gains, and the
        fitted noise.
    parameters
        Parameters by type, where they are not the fitted ones.
    step
        Longest integration step in s; by default that of LONGEST.
    check, exact, since
        As in `units.simulate_units`.

    Raises
    ------
    InputError
        As in `units.simulate_units`.
    """
    types = checked_types(types)
    columns = organ_columns(np.arange(len(types)) if unit is None else unit, len(types))
    time, organs = checked_signals(time, drive, lengths, sum(map(len, columns)))
    names, later = unit_names(types, names), unit_delays(delays, len(types))
    positions = unit_array("positions", positions, (len(types), 3))
    depths = unit_array("depths", depths, (len(types),))
    x_in = combined(organs, columns, rule)
    variation = (variation or Variation(seed=0, noise=None)).for_units(types)
    chosen, noise = parameters_of(types, parameters), variation.noise
    units = units_of(
        chosen,
        factors=np.array([variation.gain(i, each.spread) for i, each in enumerate(chosen)]),
        noise=None if noise is None else noise / THRESHOLD,
        seed=variation.seed,
        numbers=variation.numbers,
        trial=variation.trial,
    )
    steps = np.array([LONGEST[kind] for kind in types])
    if step is not None:
        steps = np.full(len(types), number("step", step, above=0.0, at_most=1e-3, unit="s"))
    times, peaks, current = _fire(units, time, x_in, steps)
    notes = () if exact else tuple(coarse_remarks(time, x_in, types, names))
    if check:
        half, *_ = _fire(units, time, x_in, steps / 2)
        change = "the step of the membrane is halved"
        notes += count_changes(names, times, half, change, since - later)
    if check and not exact:
        thin = np.unique(np.append(np.arange(0, len(time), 2), len(time) - 1))
        coarse, *_ = _fire(units, time[thin], x_in[thin], steps)
        change = "only every second sample is used"
        notes += count_changes(names, times, coarse, change, since - later)
    return SpikeTrains(
        family="recorded",
        types=types,
        names=names,
        times=counted(times, later, since),
        t_start=max(float(time[0]), since),
        t_stop=float(time[-1] + later.max()),
        time=time,
        x_in=x_in,
        current=THRESHOLD * current,
        peak_mV=SPIKE_MV * peaks,
        block_seconds=np.zeros(len(types)),
        stimulus_driven=np.zeros(len(types), np.int64),
        delays=later.copy(),
        positions=positions,
        depths=depths,
        seed=variation.seed,
        trial=variation.trial,
        notes=notes,
    )


def combined(organs: Array, columns: Sequence[NDArray[np.intp]], rule: str) -> Array:
    """Combine inputs (n_t, n_organs) in mm of end organs to those (n_t, n_units) of their units."""
    choice("rule", rule, RECORDED_RULES)
    counts = [len(c) for c in columns]
    organs, starts = organs[:, np.concatenate(columns)], np.cumsum([0, *counts])[:-1]
    if rule == "max":
        return np.asarray(np.maximum.reduceat(organs, starts, axis=1))
    return np.asarray(np.add.reduceat(organs, starts, axis=1) / counts)


def _fire(
    units: "Units", time: Array, x_in: Array, steps: Array
) -> tuple[list[Array], Array, Array]:
    """Spike times of units from rest in s, highest potentials and currents over threshold.

    Within, time counts from the first sample, as that of stepped units does, so that the noise does
    not depend on where zero is.
    """
    from fefinger.neural.recorded_compiled import PEAK, fire, rested

    states = rested(units, x_in[0])
    times, current = fire(units, states, time - time[0], x_in, steps)
    return [time[0] + each for each in times], states[:, PEAK], current
