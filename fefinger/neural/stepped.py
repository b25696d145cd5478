"""Afferent units in real time, of any family: checks of a step, and the spikes of the last one."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.neural import streaming_step as compiled
from fefinger.neural.checked_signals import checked_types
from fefinger.neural.drives import driven_displacements, in_plane
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError, number
from fefinger.support.text import counted
from fefinger.support.vocabulary import LONGEST_RUN


STREAMED = ("compressive", "tangent")
"""Drives with a compiled form: the default ones."""

ROOM = 8  # largest number of spikes of one unit in one step, or in one part of a long step


class SteppedUnits:
    """Base class of stepped afferent units: input checks and the spikes of the last step.

    shape: shape of the strain. longest: time in s within which no unit has more than ROOM spikes.
    spikes (n_units, ROOM), in units of `seconds`, and counts (n_units,), which `advance` fills: the
    last step, or the last part of a longer one.
    """

    family: str
    seconds: float
    longest: float

    def __init__(
        self, types: tuple[str, ...], organs: int, spikes: Array, counts: Integers
    ) -> None:
        self.types, self.shape = types, (organs, 6)
        self._spikes, self._counts = spikes, counts
        self._before: list[tuple[int, float]] = []
        self.reset()
        self.step(np.zeros(self.shape), 1e-3)  # compiles the step now, so that no later one waits
        self.reset()

    def __repr__(self) -> str:
        """Show the units, not the arrays."""
        return f"<Afferents ({self.family}) of {counted(self.types)}>"

    def reset(self) -> None:
        """Set all units to rest, at time 0."""
        self._before.clear()
        self.rest()

    def rest(self) -> None:
        """Set the state of all units to rest, at time 0."""
        raise NotImplementedError

    def advance(self, strain: NDArray[np.floating], dt: float, share: float) -> int:
        """Advance by `dt` s, at most `longest`, by a share of the way to the strain.

        Returns the number of spikes, REFUSED or CROWDED.
        """
        raise NotImplementedError

    def step(self, strain: NDArray[np.floating], dt: float) -> int:
        """Advance by `dt` s to the strain (n_organs, 6), xx yy zz xy yz xz; return the spikes.

        The inputs of the units are linear within the step; a step of `dt` 0 is a jump. A step
        longer than `longest` is taken in equal parts, so that none of its spikes is lost.

        Raises InputError for a strain of another shape or not finite, or an invalid `dt`: the state
        is then unchanged.
        """
        if not 0.0 <= dt < math.inf:
            number("dt", dt, at_least=0, unit="s")
        if dt > LONGEST_RUN:
            number("dt", dt, at_most=LONGEST_RUN, unit="s")
        if getattr(strain, "shape", None) != self.shape:
            raise InputError(
                f"strain: expected an array {self.shape} of xx yy zz xy yz xz for {self.shape[0]} "
                f"units, received {getattr(strain, 'shape', type(strain).__name__)}; give one row "
                "per unit, as the steps of a finger with these sites do"
            )
        strain = np.ascontiguousarray(strain)  # one layout, which is compiled once
        parts = 1 if dt <= self.longest else math.ceil(dt / self.longest)
        part = dt / parts
        before: list[tuple[int, float]] = []
        for left in range(parts, 1, -1):
            fired = self._advanced(strain, part, 1.0 / left)
            before += self._latest()
        fired = self._advanced(strain, part, 1.0)
        self._before = before
        return fired + len(before)

    def _advanced(self, strain: NDArray[np.floating], dt: float, share: float) -> int:
        """Advance by `dt` s; return the number of spikes, or raise InputError."""
        fired = self.advance(strain, dt, share)
        if fired == compiled.REFUSED:
            raise InputError(
                f"strain: expected finite numbers up to {compiled.LARGEST_STRAIN:g}, received "
                f"{np.abs(strain).max():g}; the state of the units is unchanged"
            )
        if fired == compiled.CROWDED:
            raise InputError(
                f"membrane: expected at most {ROOM} spikes of a unit in {dt:g} s, received more, "
                "faster than any membrane can follow; take shorter steps"
            )
        return fired

    def fired(self) -> list[tuple[int, float]]:
        """List (index of the unit, time in s) of every spike of the last step, unit by unit."""
        latest = self._latest()
        return sorted(self._before + latest) if self._before else latest

    def _latest(self) -> list[tuple[int, float]]:
        """List the spikes of the last step, or of its last part."""
        units = np.flatnonzero(self._counts).tolist()
        return [
            (i, self.seconds * t)
            for i in units
            for t in self._spikes[i, : self._counts[i]].tolist()
        ]


def planes(normals: ArrayLike, organs: int) -> Array:
    """Vectors (n_organs, 2, 3) in the skin across its normals, checked."""
    normals = np.asarray(normals, float)
    if normals.shape != (organs, 3):
        raise InputError(
            f"normals: expected ({organs}, 3) for {organs} end organs, received {normals.shape}"
        )
    return np.stack(in_plane(normals), axis=1)


def drive_code(name: str, drive: str, whole: str) -> int:
    """Index of a drive in STREAMED; InputError, with the module `whole`, for any other."""
    if drive not in STREAMED:
        raise InputError(
            f"{name}: expected one of {', '.join(STREAMED)} for stepped units, received {drive!r}; "
            f"use {whole} on the whole strain"
        )
    return STREAMED.index(drive)


class UnitStepper(Protocol):
    """What advances the units of a family of a user's own by one step."""

    def reset(self) -> None:
        """Set all units to rest."""

    def step(self, x_in: Array, dt: float) -> Iterable[tuple[int, float]]:
        """Advance by `dt` s to x_in (n_units,); return (index of the unit, s from the start)."""


class OwnAfferents(SteppedUnits):
    """Units of a family of a user's own, advanced with the strain at their end organs.

    types (n_organs,); normals (n_organs, 3); first (n_units,): the first end organ of each unit, of
    which those up to the next one are its own: the largest of their inputs is the unit's. drives
    and lengths (mm per strain): by type.
    """

    seconds, longest = 1.0, math.inf

    def __init__(
        self,
        family: str,
        stepper: UnitStepper,
        types: Sequence[str],
        normals: Array,
        first: Integers,
        drives: Mapping[str, str],
        lengths: Mapping[str, float],
    ) -> None:
        self.family, self.stepper, self.first = family, stepper, first
        self.organs, self.normals, self.drives, self.lengths = types, normals, drives, lengths
        self._clock = 0.0
        kinds = checked_types([types[i] for i in first])
        counts = np.zeros(len(kinds), dtype=np.int64)
        super().__init__(kinds, len(types), np.zeros((len(kinds), ROOM)), counts)

    def rest(self) -> None:
        """Set all units to rest, at time 0."""
        self._counts[:], self._clock = 0, 0.0
        self.stepper.reset()

    def advance(self, strain: NDArray[np.floating], dt: float, share: float) -> int:
        """Advance by `dt` s; return the number of spikes, REFUSED or CROWDED."""
        if not np.abs(strain).max(initial=0.0) <= compiled.LARGEST_STRAIN:
            return compiled.REFUSED
        tensors = strain[None][..., FULL]
        organs = driven_displacements(
            tensors, self.normals, self.organs, self.drives, self.lengths
        )[0]
        self._counts[:] = 0
        for unit, after in self.stepper.step(np.maximum.reduceat(organs, self.first), dt):
            if not (0 <= unit < len(self.types) and 0.0 <= after <= dt):
                raise InputError(
                    f"family {self.family!r}: expected spikes of units 0 to {len(self.types) - 1} "
                    f"within a step of {dt:g} s, received one of unit {unit} after {after!r} s"
                )
            if self._counts[unit] == ROOM:
                return compiled.CROWDED
            self._spikes[unit, self._counts[unit]] = self._clock + after
            self._counts[unit] += 1
        self._clock += dt
        return int(self._counts.sum())


FULL = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
"""Places of xx yy zz xy yz xz in the tensor."""
