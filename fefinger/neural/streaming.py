"""Afferent units in real time: strain in, spikes out, one time step at a time.

Drives, end organs and generators are those of `units`; membranes are integrate-and-fire or
Hodgkin-Huxley. The steps are compiled and allocate no array.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.neural.checked_signals import checked_types
from fefinger.neural.drives import DEFAULT_DRIVE, in_plane
from fefinger.neural.endorgans import END_ORGANS
from fefinger.neural.gains import GAINS
from fefinger.neural.membranes import METHODS, HodgkinHuxley, IntegrateAndFire
from fefinger.neural.reference import Reference
from fefinger.neural.streaming_step import State
from fefinger.support.checks import InputError, choice, number
from fefinger.support.text import counted


STREAMED = ("compressive", "tangent")
"""Drives with a compiled form: the default ones."""

ROOM = 8  # largest number of spikes of one unit in one step
SUBSTEPS = 4  # samples of the generator current in one step


class Stepped(Protocol):
    """Membranes of several units that are advanced step by step."""

    def reset(self) -> None:
        """Set all membranes to rest."""

    def step(self, state: State, dt: float) -> int:
        """Advance by dt ms; return the number of spikes, or -1 for more than ROOM of one unit."""


class _Leaky:
    """Integrate-and-fire membranes, advanced step by step."""

    def __init__(self, membrane: IntegrateAndFire, n: int) -> None:
        self.units = np.zeros((n, 3))
        self.numbers = (
            membrane.threshold,
            1e3 * membrane.time_constant,
            1e3 * membrane.refractory,
        )

    def reset(self) -> None:
        self.units[:] = 0.0

    def step(self, state: State, dt: float) -> int:
        from fefinger.neural import streaming_step as compiled

        return int(compiled.integrate_and_fire(state, self.units, self.numbers, dt))


class _Axons:
    """Hodgkin-Huxley membranes in blocks of LANES units, advanced step by step."""

    def __init__(self, membrane: HodgkinHuxley, n: int, method: str, dt: float | None) -> None:
        from fefinger.neural.membranes import vectorized

        choice("method", method, METHODS[:2])
        self.how = (membrane.step_ms(dt), method == "splitting", membrane.speed, 1.0)
        self.rest, self.block = membrane.rest(), membrane.block
        blocks = -(-n // vectorized.LANES)
        self.resting = vectorized.at_rest(self.rest)
        self.units, self.last = np.tile(self.resting, (blocks, 1)), np.zeros(blocks)

    def reset(self) -> None:
        self.units[:], self.last[:] = self.resting, 0.0

    def step(self, state: State, dt: float) -> int:
        from fefinger.neural import streaming_step as compiled

        numbers = self.how, self.rest, self.block
        return int(compiled.hodgkin_huxley(state, self.units, self.last, *numbers, dt))


class Afferents:
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
        self.types = checked_types(types)
        chosen = {**DEFAULT_DRIVE, **(drives or {})}
        n = len(self.types)
        normals = np.asarray(normals, float)
        if normals.shape != (n, 3):
            raise InputError(f"normals: expected ({n}, 3) for {n} units, received {normals.shape}")
        self.membranes = _stepped(membrane or IntegrateAndFire(), n, method, dt)
        organs = {kind: END_ORGANS[kind].partial_fractions() for kind in set(self.types)}
        share, pole = np.zeros((n, 2)), np.ones((n, 2))
        for i, kind in enumerate(self.types):
            _, c, p = organs[kind]
            share[i, : len(c)], pole[i, : len(p)] = c, p
        self._shape = (n, 6)
        self.state = State(
            drive=np.array([_code(kind, chosen[kind]) for kind in self.types]),
            across=np.stack(in_plane(normals), axis=1),
            length=np.array([_length(kind, lengths) for kind in self.types]),
            gain=np.array([GAINS[kind] for kind in self.types]),
            at_rest=np.array([organs[kind][0] for kind in self.types]),
            share=share,
            pole=pole,
            modes=np.zeros((n, 2)),
            x=np.zeros(n),
            levels=np.zeros((_whole(substeps) + 1, n)),
            spikes=np.zeros((n, ROOM)),
            counts=np.zeros(n, dtype=np.int64),
            clock=np.zeros(1),
        )
        self.step(np.zeros(self._shape), 1e-3)  # compiles the step now, so that no later one waits
        self.reset()

    def __repr__(self) -> str:
        """Show the units, not the arrays."""
        return f"<Afferents (thesis) of {counted(self.types)}>"

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

    def reset(self) -> None:
        """Set all units to rest, at time 0."""
        for name in ("modes", "x", "levels", "counts", "clock"):
            getattr(self.state, name)[...] = 0
        self.membranes.reset()

    def step(self, strain: NDArray[np.floating], dt: float) -> int:
        """Advance by `dt` s to the strain (n, 6), xx yy zz xy yz xz; return the number of spikes.

        The first step of `dt` 0 is a jump.

        Raises
        ------
        InputError
            A strain of another shape or not finite, or an invalid `dt`: the state is then
            unchanged. More than ROOM spikes of a unit.
        """
        from fefinger.neural import streaming_step as compiled

        if not 0.0 <= dt < math.inf:
            number("dt", dt, at_least=0, unit="s")
        if getattr(strain, "shape", None) != self._shape:
            raise InputError(unfit_strain(strain, self._shape))
        if not compiled.currents(self.state, strain, 1e3 * dt):
            raise InputError(
                f"strain: expected finite numbers up to {compiled.LARGEST_STRAIN:g}, received "
                f"{np.abs(strain).max():g}; the state of the units is unchanged"
            )
        fired = self.membranes.step(self.state, 1e3 * dt)
        if fired < 0:
            message = f"dt: expected steps with at most {ROOM} spikes of a unit, received {dt:g} s"
            raise InputError(message)
        return fired

    def fired(self) -> list[tuple[int, float]]:
        """List (index of the unit, time in s) of every spike of the last step."""
        state = self.state
        units = np.flatnonzero(state.counts).tolist()
        return [(i, 1e-3 * t) for i in units for t in state.spikes[i, : state.counts[i]].tolist()]


def _stepped(membrane: object, n: int, method: str, dt: float | None) -> Stepped:
    """Create the stepped form of a membrane for n units."""
    if isinstance(membrane, IntegrateAndFire):
        return _Leaky(membrane, n)
    if isinstance(membrane, HodgkinHuxley):
        return _Axons(membrane, n, method, dt)
    raise InputError(
        "membrane: expected IntegrateAndFire or HodgkinHuxley for stepped units, received "
        f"{type(membrane).__name__}; use neural.units on the whole strain"
    )


def unfit_strain(strain: object, shape: tuple[int, int]) -> str:
    """Error message for a strain that is not an array of this shape."""
    return (
        f"strain: expected an array {shape} of xx yy zz xy yz xz for {shape[0]} units, received "
        f"{getattr(strain, 'shape', type(strain).__name__)}; give one row per unit, as the steps "
        "of a finger with these sites do"
    )


def _length(kind: str, lengths: Mapping[str, float]) -> float:
    """Length in mm of a type, checked."""
    if kind not in lengths:
        message = f"lengths: expected a length in mm for every type of the units, {kind} is missing"
        raise InputError(message)
    return number(f"lengths.{kind}", lengths[kind], above=0.0, unit="mm")


def _whole(substeps: int) -> int:
    """Check the number of substeps."""
    if isinstance(substeps, bool) or not isinstance(substeps, int) or substeps < 1:
        raise InputError(f"substeps: expected a whole number of 1 or more, received {substeps!r}")
    return substeps


def _code(kind: str, drive: str) -> int:
    """Index of a drive in STREAMED; InputError for one without a compiled form."""
    if drive not in STREAMED:
        raise InputError(
            f"drives.{kind}: expected one of {', '.join(STREAMED)} for stepped units, "
            f"received {drive!r}; use neural.units on the whole strain"
        )
    return STREAMED.index(drive)
