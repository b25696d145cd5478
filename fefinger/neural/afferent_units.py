"""Simulation of afferent units: end organs, branching, conduction delay, noise, variation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.neural.checked_signals import UnitInput, coarse_remarks, dense_times, remarks
from fefinger.neural.endorgans import (
    END_ORGANS,
    GAINS,
    LARGEST_CURRENT,
    Organ,
    PoleZero,
    chord_steps,
    transduce,
)
from fefinger.neural.membranes import LARGEST_STEP, Firing, HodgkinHuxley, Membrane
from fefinger.neural.membranes.firing import largest_step, trimmed
from fefinger.neural.trains import SpikeTrains
from fefinger.neural.variation import Variation
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice, reject_unknown
from fefinger.support.vocabulary import GENERATORS, RULES, TYPES


CHORD_ERROR, LONGEST = 1e-5, 2e-3
"""Largest deviation in µA/cm² of currents from straight lines between their samples, and largest
distance of the samples in s."""

LINES = 1e-5
"""Bound in s of the error of spike times by straight lines between samples LARGEST_STEP apart."""

_DENSE = 500_000
"""Number of current values held at a time: 4 MB, and several times that during computation."""


@dataclass(frozen=True, kw_only=True)
class _Setup:
    """A simulation from inputs of end organs to spikes.

    x_in (n_t, n_organs) mm of the end organs at time (n_t,) s; dt: longest step in s.
    """

    units: UnitInput
    time: Array
    x_in: Array
    dt: float
    rule: str
    generator: str
    organs: Mapping[str, Organ]
    membrane: Membrane
    variation: Variation | None
    method: str | None
    tolerance: float | None

    def __post_init__(self) -> None:
        choice("generator", self.generator, GENERATORS)
        choice("rule", self.rule, RULES)
        reject_unknown("organs", self.organs, TYPES)
        for kind, organ in self.organs.items():
            if not hasattr(organ, "respond"):
                msg = f"organs.{kind}: expected a filter such as PoleZero, received {organ!r}"
                raise InputError(msg)

    @cached_property
    def gains(self) -> Array:
        """Gains (n_units,) in µA/cm² per mm, with their random variation."""
        vary = self.variation
        factors = [1.0 if vary is None else vary.gain(i) for i in range(len(self.units.types))]
        return np.array([GAINS[kind] for kind in self.units.types]) * factors

    def sampled(self, units: Sequence[int]) -> Array:
        """Choose the times at which the currents of units of one type are sampled.

        The error of straight lines in between is at most CHORD_ERROR dt / LARGEST_STEP, where steps
        longer than dt suffice for that; a filter without real modes is sampled every dt. A
        tolerance below LINES lowers both limits.
        """
        wanted = 1.0 if self.tolerance is None else min(1.0, self.tolerance / LINES)
        straight = CHORD_ERROR * min(wanted, self.dt / LARGEST_STEP)
        dt = min(self.dt, LARGEST_STEP * wanted**0.5)
        kind = self.units.types[units[0]]
        organ = self.organs.get(kind, END_ORGANS[kind])
        steps: Array | float = dt
        if isinstance(organ, PoleZero):
            gain = float(np.max(self.gains[units]))
            bend = gain / LARGEST_CURRENT if self.generator == "saturating" else 0.0
            columns = np.concatenate([self.units.columns[i] for i in units])
            x_in = self.x_in[:, columns]
            steps = chord_steps(organ, self.time, x_in, straight / gain, bend=bend)
            steps = np.clip(steps, dt, LONGEST)
        at = dense_times(self.time, steps)
        if self.variation is None or not self.variation.noise:
            return at
        knots = self.variation.knots(float(self.time[0]), float(self.time[-1]))
        return np.unique(np.concatenate([at, knots[knots < self.time[-1]]]))

    def run(self, at: Array, currents: Array, *, driven: bool) -> Firing:
        """Integrate the membranes under currents (n_at, n_units) in µA/cm²."""
        method = {} if self.method is None else {"method": self.method}
        return self.membrane.fire(at, currents, dt=self.dt, stimulus_driven=driven, **method)

    def branches(self, units: Sequence[int], at: Array | None = None) -> list[Array]:
        """Compute generator currents (n_at, n_branches) in µA/cm² of units of one type."""
        kind, columns = self.units.types[units[0]], [self.units.columns[i] for i in units]
        organs = [len(c) for c in columns]
        currents = transduce(
            kind,
            self.time,
            self.x_in[:, np.concatenate(columns)],
            gain=np.repeat(self.gains[units], organs),
            generator=self.generator,
            at=at,
            organ=self.organs.get(kind),
        )
        return np.split(currents, np.cumsum(organs)[:-1], axis=1)

    def combined(self, units: Sequence[int], at: Array | None = None) -> Array:
        """Combine the currents of the branches of each unit by the rule: (n_at, n_units) in µA/cm².

        As many end organs of a type are filtered at once as `_DENSE` allows.
        """
        out = np.empty((len(self.time if at is None else at), len(units)))
        groups: list[list[int]] = []
        types, room = self.units.types, 0
        for k, i in enumerate(units):
            room -= len(self.units.columns[i])
            if room < 0 or types[i] != types[units[k - 1]]:
                groups.append([])
                room = _DENSE // len(out) - len(self.units.columns[i])
            groups[-1].append(k)
        for group in groups:
            currents = self.branches([units[k] for k in group], at)
            for k, branches in zip(group, currents, strict=True):
                mean = self.rule == "mean"
                out[:, k] = branches.mean(axis=1) if mean else branches.max(axis=1)
        return out

    def noise(self, unit: int, at: Array, membranes: int) -> Array | float:
        """Noise current (n_at, membranes) in µA/cm² of the membranes of a unit, or 0."""
        if self.variation is None or not self.variation.noise:
            return 0.0
        return self.variation.current(unit, at, float(at[0]), float(at[-1]), membranes)


def simulate_units(
    time: ArrayLike,
    drive: ArrayLike,
    *,
    types: Sequence[str],
    unit: ArrayLike | None = None,
    lengths: ArrayLike = 1.0,
    rule: str = "mean",
    delays: ArrayLike = 0.0,
    variation: Variation | None = None,
    generator: str = "saturating",
    organs: Mapping[str, Organ] | None = None,
    membrane: Membrane | None = None,
    names: Sequence[str] | None = None,
    positions: ArrayLike | None = None,
    depths: ArrayLike | None = None,
    dt: float = LARGEST_STEP,
    tolerance: float | None = None,
    check: bool = True,
    exact: bool = False,
    since: float = -np.inf,
) -> SpikeTrains:
    """Simulate the spikes of afferent units, each with one or more end organs.

    The chain: x_in = length * drive, end-organ filter, half-wave rectification, generator,
    membrane. The drive is linear between its samples and the filter exact for that, so the sampling
    may be uneven. Every end organ has its filter, rectification and generator; `rule` combines
    their currents.
    `x_in` of the result is the mean of a unit's end organs, `current` their mean, or with the rules
    "max" and "first" their largest, at the given times; neither includes noise.

    Parameters
    ----------
    time
        (n_t,) s, not decreasing; a repeated time is a jump. The drive is zero before `time[0]`.
    drive
        (n_t, n_organs), dimensionless; or mm of skin displacement with the default length 1.
    lengths
        (n_organs,) or one number: mm of skin displacement per unit of drive.
    types
        (n_units,) afferent type of each unit.
    unit
        (n_organs,) index of the unit of each end organ; every unit has one or more. Default one.
    rule
        One of RULES.
    delays
        (n_units,) or one number: s from a spike at the end organ to where it is recorded.
    variation
        Membrane noise and unequal gains; None: neither.
    organs
        Filters by type; default END_ORGANS.
    names, positions, depths
        Of the units: names (default: types, numbered where they repeat), (n_units, 3) mm and
        (n_units,) mm.
    generator
        "saturating" or "linear".
    membrane
        Default HodgkinHuxley() with rates / 6.
    dt, tolerance
        Longest integration step in s; or allowed error of spike times in s, from which integrator
        and step (`HodgkinHuxley.integrator`) and the sampling of the current are chosen.
    check
        Repeat with half the step and with half of the samples; differences of counts become notes.
    exact
        The straight lines between the samples are the signal, corners included: the sampling is
        neither checked nor remarked on, since fewer samples would be another signal.
    since
        Time in s, at the recording, before which spikes are left out.

    Raises
    ------
    InputError
        Arrays that do not fit, unknown names, values that are not finite, times that decrease, a
        unit without an end organ, or a rule that the membrane does not support.
    """
    given = UnitInput.of(
        time,
        drive,
        lengths,
        types,
        unit=unit,
        names=names,
        delays=delays,
        positions=positions,
        depths=depths,
        since=since,
    )
    membrane = membrane or HodgkinHuxley()
    seconds = float(given.time[-1] - given.time[0])
    method, dt = _integrator(membrane, rule, tolerance, seconds, dt)
    setup = _Setup(
        units=given,
        time=given.time,
        x_in=given.organs,
        dt=dt,
        rule=rule,
        generator=generator,
        organs=organs or {},
        membrane=membrane,
        variation=None if variation is None else variation.for_units(given.types),
        method=method,
        tolerance=tolerance,
    )
    firing = _fire(setup, driven=True)
    mean_in = np.column_stack([given.organs[:, c].mean(axis=1) for c in given.columns])
    notes = remarks(given.names, firing)
    if not exact:
        notes += tuple(coarse_remarks(given, mean_in))
    reruns = []
    if check:
        half = replace(setup, dt=dt / 2)
        change = "the step of the membrane is halved"
        said, rerun = given.changes(firing.times, lambda: _fire(half, driven=False).times, change)
        notes, reruns = notes + said, [rerun]
    if check and not exact:
        time, x_in = given.thinned(given.organs)
        fewer = replace(setup, time=time, x_in=x_in)
        change = "only every second sample is used"
        said, rerun = given.changes(firing.times, lambda: _fire(fewer, driven=False).times, change)
        notes, reruns = notes + said, [*reruns, rerun]
    by_type = sorted(range(len(given.types)), key=given.types.__getitem__)
    current = np.empty((len(given.time), len(given.types)))
    current[:, by_type] = setup.combined(by_type)
    return given.trains(
        firing.times,
        x_in=mean_in,
        notes=notes,
        reruns=reruns,
        current=current,
        peak_mV=firing.peak_mV,
        block_seconds=firing.block_seconds,
        stimulus_driven=firing.stimulus_driven,
        seed=None if variation is None else variation.seed,
        trial=0 if variation is None else variation.trial,
    )


def _integrator(
    membrane: Membrane, rule: str, tolerance: float | None, seconds: float, dt: float
) -> tuple[str | None, float]:
    """Choose method and step in s for a tolerance; without one, None and dt."""
    if rule == "first":
        _squid(membrane, "rule: expected for 'first'")
    dt = largest_step(dt)
    if tolerance is None:
        return None, dt
    return _squid(membrane, "tolerance: expected").integrator(tolerance, seconds)


def _squid(membrane: object, what: str) -> HodgkinHuxley:
    """Check that a membrane is a HodgkinHuxley."""
    if not isinstance(membrane, HodgkinHuxley):
        raise InputError(f"{what} a HodgkinHuxley membrane, received {type(membrane).__name__}")
    return membrane


def _fire(setup: _Setup, *, driven: bool) -> Firing:
    """Simulate all units, by type and in groups whose currents fit in `_DENSE` values."""
    if setup.rule == "first":
        races = [_race(setup, i, driven=driven) for i in range(len(setup.units.types))]
        return _joined(races, np.arange(len(races)))
    runs, order = [], []
    types = setup.units.types
    # Number of units that one thread integrates at once; groups of this size keep all lanes filled.
    lanes = 16
    for kind in dict.fromkeys(types):
        units = [i for i, other in enumerate(types) if other == kind]
        at = setup.sampled(units)
        step = lanes * max(1, _DENSE // (lanes * len(at)))
        for start in range(0, len(units), step):
            some = units[start : start + step]
            currents = setup.combined(some, at)
            for k, i in enumerate(some):
                currents[:, k : k + 1] += setup.noise(i, at, 1)
            runs.append(setup.run(at, currents, driven=driven))
            order += some
    return _joined(runs, np.argsort(order))


def _race(setup: _Setup, unit: int, *, driven: bool) -> Firing:
    """Simulate one membrane per branch of a unit; the first to fire resets the others."""
    from fefinger.neural.membranes.equations import race

    at = setup.sampled([unit])
    (currents,) = setup.branches([unit], at)
    currents = np.ascontiguousarray(currents + setup.noise(unit, at, currents.shape[1]))
    membrane = _squid(setup.membrane, "rule: expected for 'first'")
    crossings = membrane.fire(at, currents, dt=setup.dt).stimulus_driven.max() if driven else 0
    spikes = np.empty((1, int(2e3 * max(1.0, membrane.speed) * (at[-1] - at[0])) + 16))
    constants = membrane.step_ms(setup.dt), membrane.speed, membrane.rest(), membrane.block
    count, peak, blocked, final = race(1e3 * at, currents, *constants, spikes[0])
    return Firing(
        times=(1e-3 * trimmed(spikes, np.array([count]))[0],),
        peak_mV=np.array([peak]),
        block_seconds=np.array([1e-3 * blocked]),
        stimulus_driven=np.array([crossings], np.int64),
        final=final[:1],
    )


def _joined(runs: Sequence[Firing], order: NDArray[np.intp]) -> Firing:
    """Concatenate the firing of groups of units and reorder it."""
    times = [times for run in runs for times in run.times]
    arrays = ("peak_mV", "block_seconds", "stimulus_driven", "final")
    return Firing(
        times=tuple(times[i] for i in order),
        **{name: np.concatenate([getattr(run, name) for run in runs])[order] for name in arrays},
    )
