"""Units of the family `recorded` in real time: strain in, spikes out, one time step at a time."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.neural import recorded_streaming_step as compiled
from fefinger.neural.checked_signals import checked_types, organ_columns
from fefinger.neural.recorded import Recorded, parameters_of, units_of
from fefinger.neural.recorded_compiled import rested
from fefinger.neural.recorded_simulation import LONGEST
from fefinger.neural.recorded_vectorized import blocks_of
from fefinger.neural.streaming import ROOM, SteppedUnits, drive_code, planes
from fefinger.neural.streaming_step import REFUSED
from fefinger.neural.variation import numbered
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, integer


class RecordedAfferents(SteppedUnits):
    """Units of the family `recorded`, advanced with the strain at their end organs.

    An impulse is reported in the step that contains its time, a latency after threshold; those
    still to come after the last step are never reported.

    Parameters
    ----------
    types, normals
        Afferent type of each unit, and unit normals (n_organs, 3) of the skin above its end organs.
    unit
        (n_organs,) index of the unit of each end organ, ascending; by default one each. The largest
        of their inputs is the unit's.
    parameters
        Parameters by type, where they are not the fitted ones.
    factors
        (n_units,) or one number: factors on the gains, 0 or more.
    seed
        Seed of the noise.

    Raises
    ------
    InputError
        No units, unknown types, normals of another shape or length, end organs out of the order of
        their units, a drive without a compiled form, or factors or a seed that cannot be used.
    """

    family, seconds = "recorded", 1.0

    def __init__(
        self,
        types: Sequence[str],
        normals: ArrayLike,
        *,
        unit: ArrayLike | None = None,
        parameters: Mapping[str, Recorded] | None = None,
        factors: ArrayLike | None = None,
        seed: int = 0,
    ) -> None:
        types = checked_types(types)
        n = len(types)
        owner = np.arange(n) if unit is None else np.asarray(unit)
        columns = organ_columns(owner, n)
        if np.any(np.diff(owner) < 0):
            raise InputError(
                f"unit: expected indices that never decrease, received {owner.tolist()}"
            )
        across = planes(normals, len(owner))
        chosen = parameters_of(types, parameters)
        self.units = units_of(
            chosen,
            factors=None if factors is None else _gains(factors, n),
            seed=integer("seed", seed),
            numbers=numbered(types),
        )
        whole = "neural.recorded_simulation"
        self._organs = (
            np.array([drive_code("drive", each.drive, whole) for each in chosen], np.int64),
            np.array([each.length for each in chosen]),
            np.cumsum([0, *map(len, columns)]),
            across,
        )
        longest = np.array([LONGEST[kind] for kind in types])
        blocks = blocks_of(longest)
        self._blocks = (
            np.concatenate(blocks),
            np.cumsum([0, *map(len, blocks)]),
            np.array([longest[block[0]] for block in blocks]),
        )
        # No delay from threshold to impulse is longer than twice the latency.
        late = int((2.0 * self.units.latency / self.units.refractory).max()) + 2
        self._queue = np.empty((n, late + ROOM)), np.zeros(n, np.int64)
        self.longest = (ROOM - 1) * float(self.units.refractory.min())
        super().__init__(types, len(owner), np.empty((n, ROOM)), np.zeros(n, np.int64))

    def rest(self) -> None:
        """Set all units to rest, at time 0."""
        self._states = rested(self.units, np.zeros(len(self.types)))
        self._queue[1][:], self._counts[:], self._clock = 0, 0, 0.0

    def advance(self, strain: NDArray[np.floating], dt: float, share: float) -> int:
        """Advance by `dt` s, at most `longest`; return the number of spikes, or REFUSED."""
        span, spikes = (self._clock, self._clock + dt), (self._spikes, self._counts)
        setup = self._organs, self._blocks, self._queue
        fired = compiled.step(self.units, self._states, span, strain, share, *setup, *spikes)
        if fired != REFUSED:
            self._clock = span[1]
        return int(fired)


def _gains(factors: ArrayLike, n: int) -> Array:
    """Check factors on the gains of n units."""
    gains = np.asarray(factors, float)
    if gains.shape not in ((), (n,)) or not np.all((gains >= 0) & np.isfinite(gains)):
        msg = f"factors: expected one or {n} finite numbers of 0 or more, received {factors!r}"
        raise InputError(msg)
    return gains
