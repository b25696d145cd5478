"""Afferent units in real time: strain in, spikes out, one time step at a time.

Drives, end organs and generators as in `afferent_units`; membranes are integrate-and-fire or
Hodgkin-Huxley. The steps are compiled and allocate no array.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.neural import streaming_step as compiled
from fefinger.neural.checked_signals import checked_types, organ_columns
from fefinger.neural.drives import DEFAULT_DRIVE, Reference
from fefinger.neural.endorgans import END_ORGANS, GAINS, LARGEST_CURRENT, modes_of
from fefinger.neural.membranes import METHODS, HodgkinHuxley, IntegrateAndFire, vectorized
from fefinger.neural.membranes.equations import Stepping
from fefinger.neural.recorded import LONGEST, Recorded, parameters_of, units_of
from fefinger.neural.recorded_compiled import blocks_of, rested
from fefinger.neural.stepped import ROOM, SteppedUnits, drive_code, planes
from fefinger.neural.variation import numbered
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice, integer, number


SUBSTEPS = 4  # samples of the generator current in one step


class _Leaky:
    """Integrate-and-fire membranes, advanced step by step."""

    def __init__(self, membrane: IntegrateAndFire, n: int) -> None:
        self.units = np.zeros((n, 3))
        self.numbers = membrane.numbers
        fastest = membrane.rate(LARGEST_CURRENT)
        self.longest = (ROOM - 1) / fastest if fastest else math.inf

    def reset(self) -> None:
        self.units[:] = 0.0

    def step(self, state: compiled.State, dt: float) -> int:
        return int(compiled.integrate_and_fire(state, self.units, self.numbers, dt))


class _Axons:
    """Hodgkin-Huxley membranes in blocks of LANES units, advanced step by step."""

    def __init__(self, membrane: HodgkinHuxley, n: int, method: str, dt: float | None) -> None:
        choice("method", method, METHODS)
        splitting = method == "splitting"
        self.how = Stepping(membrane.step_ms(dt), splitting, membrane.speed, 1.0)
        self.rest, self.block = membrane.rest(), membrane.block
        per_ms = 0.5  # spikes in a ms, 2.5 times what a Hodgkin-Huxley membrane at 6.3 C fires
        self.longest = 1e-3 * (ROOM - 1) / (per_ms * max(1.0, membrane.speed))
        blocks = -(-n // vectorized.LANES)
        self.resting = vectorized.at_rest(self.rest)
        self.units, self.last = np.tile(self.resting, (blocks, 1)), np.zeros(blocks)

    def reset(self) -> None:
        self.units[:], self.last[:] = self.resting, 0.0

    def step(self, state: compiled.State, dt: float) -> int:
        numbers = self.how, self.rest, self.block
        return int(compiled.hodgkin_huxley(state, self.units, self.last, *numbers, dt))


class Afferents(SteppedUnits):
    """Afferent units that are advanced step by step with the strain at their end organs.

    Parameters
    ----------
    types, normals
        Afferent type of each unit, and unit normals (n, 3) of the skin above it.
    lengths
        Skin displacement in mm per unit of drive, by type.
    membrane
        An IntegrateAndFire (default, thesis 4.3.1) or a HodgkinHuxley.
    drives
        Drive per type, where it is not the default; "compressive" or "tangent".
    substeps
        Samples of the generator current in each step; it is linear between them.
    method, dt
        Integration of a HodgkinHuxley: "splitting" or "runge-kutta", and the longest step in s, as
        in `HodgkinHuxley.fire`.

    Raises
    ------
    InputError
        No units, unknown types, a drive or membrane without a compiled form, normals of another
        shape or length, a type without a length above 0, or no substep.
    """

    family, seconds = "thesis", 1e-3

    def __init__(
        self,
        types: Sequence[str],
        normals: ArrayLike,
        lengths: Mapping[str, float],
        *,
        membrane: IntegrateAndFire | HodgkinHuxley | None = None,
        drives: Mapping[str, str] | None = None,
        substeps: int = SUBSTEPS,
        method: str = "splitting",
        dt: float | None = None,
    ) -> None:
        types = checked_types(types)
        chosen = {**DEFAULT_DRIVE, **(drives or {})}
        n = len(types)
        across = planes(normals, n)
        self.membranes = _stepped(membrane or IntegrateAndFire(), n, method, dt)
        at_rest, share, pole = modes_of([END_ORGANS[kind] for kind in types])
        substeps = integer("substeps", substeps, at_least=1)
        codes = [
            drive_code(f"drives.{kind}", chosen[kind], "neural.afferent_units") for kind in types
        ]
        self.state = compiled.State(
            drive=np.array(codes),
            across=across,
            length=np.array([_length(kind, lengths) for kind in types]),
            gain=np.array([GAINS[kind] for kind in types]),
            at_rest=at_rest,
            share=share,
            pole=pole,
            modes=np.zeros((n, 2)),
            x=np.zeros(n),
            levels=np.zeros((substeps + 1, n)),
            spikes=np.zeros((n, ROOM)),
            counts=np.zeros(n, dtype=np.int64),
            clock=np.zeros(1),
        )
        self.longest = self.membranes.longest
        super().__init__(types, n, self.state.spikes, self.state.counts)

    @classmethod
    def of(
        cls,
        types: Sequence[str],
        normals: ArrayLike,
        reference: Reference,
        **options: Any,
    ) -> Self:
        """Build units with lengths from a small flat press, as `equivalent_displacements`."""
        lengths = reference.lengths(types, options.get("drives"))
        return cls(types, normals, lengths, **options)

    def rest(self) -> None:
        """Set all units to rest, at time 0."""
        for name in ("modes", "x", "levels", "counts", "clock"):
            getattr(self.state, name)[...] = 0
        self.membranes.reset()

    def advance(self, strain: NDArray[np.floating], dt: float, share: float) -> int:
        """Advance by `dt` s; return the number of spikes, REFUSED or CROWDED."""
        if not compiled.currents(self.state, strain, 1e3 * dt, share):
            return compiled.REFUSED
        return self.membranes.step(self.state, 1e3 * dt)


def _stepped(membrane: object, n: int, method: str, dt: float | None) -> _Leaky | _Axons:
    """Create the stepped form of a membrane for n units."""
    if isinstance(membrane, IntegrateAndFire):
        return _Leaky(membrane, n)
    if isinstance(membrane, HodgkinHuxley):
        return _Axons(membrane, n, method, dt)
    raise InputError(
        "membrane: expected IntegrateAndFire or HodgkinHuxley for stepped units, received "
        f"{type(membrane).__name__}; use neural.afferent_units on the whole strain"
    )


def _length(kind: str, lengths: Mapping[str, float]) -> float:
    """Length in mm of a type, checked."""
    if kind not in lengths:
        raise InputError(
            f"lengths: expected a length in mm for every type of the units, {kind} is missing"
        )
    return number(f"lengths.{kind}", lengths[kind], above=0.0, unit="mm")


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
        whole = "neural.recorded"
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
        fired = compiled.recorded(self.units, self._states, span, strain, share, *setup, *spikes)
        if fired != compiled.REFUSED:
            self._clock = span[1]
        return int(fired)


def _gains(factors: ArrayLike, n: int) -> Array:
    """Check factors on the gains of n units."""
    gains = np.asarray(factors, float)
    if gains.shape not in ((), (n,)) or not np.all((gains >= 0) & np.isfinite(gains)):
        msg = f"factors: expected one or {n} finite numbers of 0 or more, received {factors!r}"
        raise InputError(msg)
    return gains
