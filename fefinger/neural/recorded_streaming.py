"""Units of the family `recorded` in real time: strain in, spikes out, one time step at a time."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.neural.checked_signals import checked_types, organ_columns
from fefinger.neural.drives import in_plane
from fefinger.neural.recorded import Recorded, fitted, units_of
from fefinger.neural.recorded_simulation import LONGEST
from fefinger.neural.streaming import ROOM, STREAMED, unfit_strain
from fefinger.support.checks import InputError, number
from fefinger.support.text import counted


if TYPE_CHECKING:
    from fefinger.neural.recorded_compiled import Units


class RecordedAfferents:
    """Units of the family `recorded`, advanced with the strain at their end organs.

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
        (n_units,) factors on the gains.
    seed
        Seed of the noise.

    Raises
    ------
    InputError
        No units, unknown types, normals of another shape or length, end organs out of the order of
        their units, or a drive without a compiled form.
    """

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
        from fefinger.neural.recorded_compiled import SIZE

        self.types = checked_types(types)
        n = len(self.types)
        owner = np.arange(n) if unit is None else np.asarray(unit)
        columns = organ_columns(owner, n)
        if np.any(np.diff(owner) < 0):
            message = f"unit: expected indices that never decrease, received {owner.tolist()}"
            raise InputError(message)
        normals = np.asarray(normals, float)
        if normals.shape != (len(owner), 3):
            raise InputError(
                f"normals: expected ({len(owner)}, 3) for {len(owner)} end organs, received "
                f"{normals.shape}"
            )
        by_type = {**fitted(), **(parameters or {})}
        chosen = [by_type[kind] for kind in self.types]
        self.units: Units = units_of(
            chosen, factors=None if factors is None else np.asarray(factors, float), seed=seed
        )
        self._drive = np.array([_code(unit) for unit in chosen], np.int64)
        self._length = np.array([unit.length for unit in chosen])
        self._starts = np.cumsum([0, *map(len, columns)])
        self._across = np.stack(in_plane(normals), axis=1)
        self._longest = np.array([LONGEST[kind] for kind in self.types])
        self._states = np.zeros((n, SIZE))
        self._spikes = np.empty((n, ROOM))
        self._counts = np.zeros(n, np.int64)
        self._clock = 0.0
        self._shape = (len(owner), 6)
        self.step(np.zeros(self._shape), 1e-3)  # compiles the step now, so that no later one waits
        self.reset()

    def __repr__(self) -> str:
        """Show the units, not the arrays."""
        return f"<Afferents (recorded) of {counted(self.types)}>"

    def reset(self) -> None:
        """Set all units to rest, at time 0."""
        from fefinger.neural.recorded_compiled import rested

        self._states[:] = rested(self.units, np.zeros(len(self.types)))
        self._counts[:], self._clock = 0, 0.0

    def step(self, strain: NDArray[np.floating], dt: float) -> int:
        """Advance by `dt` s to the strain (n_organs, 6), xx yy zz xy yz xz; return the spikes.

        A step of `dt` 0 is a jump.

        Raises
        ------
        InputError
            A strain of another shape or not finite, or an invalid `dt`: the state is then
            unchanged. More than ROOM spikes of a unit.
        """
        from fefinger.neural import recorded_streaming_step as compiled
        from fefinger.neural.streaming_step import LARGEST_STRAIN

        if not 0.0 <= dt < math.inf:
            number("dt", dt, at_least=0, unit="s")
        if getattr(strain, "shape", None) != self._shape:
            raise InputError(unfit_strain(strain, self._shape))
        fired = int(
            compiled.step(
                self.units,
                self._states,
                (self._clock, self._clock + dt),
                strain,
                (self._drive, self._length, self._starts, self._across),
                self._longest,
                self._spikes,
                self._counts,
            )
        )
        if fired == compiled.REFUSED:
            raise InputError(
                f"strain: expected finite numbers up to {LARGEST_STRAIN:g}, received "
                f"{np.abs(strain).max():g}; the state of the units is unchanged"
            )
        self._clock += dt
        if self._counts.max() > ROOM:
            message = f"dt: expected steps with at most {ROOM} spikes of a unit, received {dt:g} s"
            raise InputError(message)
        return fired

    def fired(self) -> list[tuple[int, float]]:
        """List (index of the unit, time in s) of every spike of the last step."""
        units = np.flatnonzero(self._counts).tolist()
        return [(i, t) for i in units for t in self._spikes[i, : self._counts[i]].tolist()]


def _code(unit: Recorded) -> int:
    """Index of the drive of a unit in STREAMED; InputError for one without a compiled form."""
    if unit.drive not in STREAMED:
        raise InputError(
            f"drive: expected one of {', '.join(STREAMED)} for stepped units, received "
            f"{unit.drive!r}; use neural.recorded_simulation on the whole strain"
        )
    return STREAMED.index(unit.drive)
