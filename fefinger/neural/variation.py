"""Random variation between units of a type, and membrane noise, reproducible by a seed."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError, choice, integer, number, set_integer
from fefinger.support.vocabulary import TYPES


def numbered(types: Sequence[str], places: ArrayLike | None = None) -> Integers:
    """Return numbers (n_units,) of units, by type and by place among the units of their type.

    Numbers select random streams: units of other types, and the order of the types, change none.
    places (n_units,): whole numbers, by default 0, 1, ... in each type.
    """
    codes = np.array([TYPES.index(choice("types", kind, TYPES)) for kind in types], np.int64)
    if places is None:
        following = {kind: itertools.count() for kind in TYPES}
        places = [next(following[kind]) for kind in types]
    return len(TYPES) * np.asarray(places, np.int64) + codes


@dataclass(frozen=True, kw_only=True)
class Variation:
    """Random gains and membrane noise; the same seed gives a unit the same values.

    spread: standard deviation of the logarithm of a unit's gain (Fig. 4-2 shows that units of one
    type differ; the amount is a choice of the user). noise: standard deviation in µA/cm² of the
    independent values of membrane noise; the noise through time, straight lines between them,
    deviates by sqrt(2/3) as much. None: as fitted for the unit's type. numbers: default `numbered`;
    a unit's draws depend on the seed, its number and the trial alone, not on the other units or the
    length of the run. trial: another trial has other noise, but the same gains.
    """

    seed: int
    spread: float | None = 0.0
    noise: float | None = 0.0
    numbers: tuple[int, ...] | None = None
    trial: int = 0

    def __post_init__(self) -> None:
        set_integer(self, "seed")
        set_integer(self, "trial")
        if self.spread is not None:
            number("spread", self.spread, at_least=0.0, at_most=3.0)
        if self.noise is not None:
            number("noise", self.noise, at_least=0.0, at_most=100.0, unit="µA/cm²")
        for index in self.numbers or ():
            integer("numbers", index)

    def for_units(self, types: Sequence[str]) -> "Variation":
        """Return the variation with the numbers of units of these types.

        InputError unless there are as many numbers as units, where there are numbers.
        """
        if self.numbers is None:
            return replace(self, numbers=tuple(numbered(types).tolist()))
        if len(self.numbers) != len(types):
            raise InputError(
                f"numbers: expected one for each of {len(types)} units, received "
                f"{len(self.numbers)}"
            )
        return self

    def gain(self, unit: int, spread: float = 0.0) -> float:
        """Random factor on the gain of a unit, of a type with this spread."""
        spread = spread if self.spread is None else self.spread
        return float(np.exp(spread * self._draw(unit, 0).normal()))

    def current(self, unit: int, at: Array, start: float, stop: float, branches: int) -> Array:
        """Return noise currents (n_at, branches) in µA/cm² at times from `start` to `stop` s."""
        knots = self.knots(start, stop)
        # Drawn time by time, so that a longer run begins with the values of a shorter one.
        values = (self.noise or 0.0) * self._draw(unit, 1, self.trial).normal(
            size=(len(knots), branches)
        )
        return np.column_stack([np.interp(at, knots, column) for column in values.T])

    def knots(self, start: float, stop: float) -> Array:
        """Return the times in s of the independent values of the noise."""
        # Time in s between independent values of membrane noise, which is linear in between: a
        # choice, near the open time of a channel and far below the time constants of the slowed
        # membrane.
        noise_step = 1e-3
        return start + noise_step * np.arange(np.ceil((stop - start) / noise_step) + 2)

    def _draw(self, unit: int, purpose: int, trial: int = 0) -> np.random.Generator:
        """Random generator of a unit for one purpose, 0 gain or 1 noise, in a trial."""
        stream = unit if self.numbers is None else self.numbers[unit]
        # numpy ignores zeros at the end of a seed: the final 1 separates these streams from places.
        return np.random.default_rng([self.seed, stream, purpose, 1, *([trial] if trial else [])])
