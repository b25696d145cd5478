"""Afferents that fire as recorded units do: the family `recorded`.

The drive of a unit (`neural/drives.py`) passes a linear filter, a saturating rectifier that takes
both signs of the filter's output with unequal weights, and a leaky integrate-and-fire membrane with
adaptation, a refractory time and noise. Currents are over the threshold current of the membrane.
The parameters are fitted to responses of single units through the mechanics of this package
(`validation/afferents/`); `recorded.json` holds them with their uncertainties.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cache, cached_property, partial
from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.neural.checked_signals import UnitInput, coarse_remarks
from fefinger.neural.endorgans import PoleZero
from fefinger.neural.membranes import IntegrateAndFire
from fefinger.neural.trains import SpikeTrains
from fefinger.neural.variation import Variation
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice, number, reject_unknown, set_number
from fefinger.support.vocabulary import DRIVES, RECORDED_RULES, TYPES


if TYPE_CHECKING:
    from fefinger.neural.recorded_compiled import Units


FILE = "recorded.json"
"""File of the fitted parameters, beside this module."""


LATENCY = 3.5
"""Mean time from threshold to impulse over its standard deviation: no draw deviates by more
(`recorded_compiled.normal`), so that no impulse comes before what causes it."""


THRESHOLD = IntegrateAndFire().threshold
"""Current in µA/cm² that the threshold of every unit counts as: a nominal one, since only the
ratio of a current to the threshold matters."""

LONGEST = {"SAI": 2e-4, "SAII": 2e-4, "FAI": 2e-4, "FAII": 1e-4}
"""Longest integration step in s of the units of a type."""


@dataclass(frozen=True)
class Bounds:
    """Range of a parameter, its unit, and what it is."""

    low: float
    high: float
    unit: str
    meaning: str


def _in(low: float, high: float, unit: str, meaning: str) -> Any:
    """Return the field of a parameter with these bounds, which has no default."""
    return field(metadata={"bounds": Bounds(low, high, unit, meaning)})


@dataclass(frozen=True, kw_only=True)
class Recorded:
    """Parameters of the units of one type, each with its range, unit and meaning in BOUNDS.

    Filter: a lead of the given order, [(static p + s) / (p + s)]^order with p = 2 pi corner, and a
    lag q / (q + s) with q = 2 pi upper.
    Generator: I = u / (1 + u / largest) with u = gain |y|, times `negative` where y < 0: it still
    follows a vibration that saturates both signs.
    Adaptation: adaptation dw/dt = I - w takes adapting w off the current.
    Membrane: membrane dv/dt = I - adapting w - a + noise - v, spike at 1, then 0 for `refractory`;
    every spike adds recovery to a, which fades within recovering. The noise is linear between
    independent normal values 1 ms apart, and fades with I below threshold: the channels of a
    generator at rest are closed, so that noise alone never makes an impulse. An impulse is recorded
    `latency` after threshold, and a normal time of mean 0 and standard deviation `jitter` that is
    never beyond the latency: never before threshold, nor within `refractory` of the last.

    Raises InputError for an unknown drive or a parameter out of its bounds.
    """

    drive: str
    length: float = _in(0.1, 100.0, "mm", "displacement of a 1 mm pin per unit of the drive")
    gain: float = _in(1e-2, 1e6, "1/mm", "current over threshold per mm at the filter's output")
    static: float = _in(0.0, 1.0, "", "gain of the filter at rest over that at high frequency")
    corner: float = _in(1e-2, 2000.0, "Hz", "corner frequency of the filter")
    order: float = _in(1.0, 2.0, "", "order of the filter; 2: the corner twice")
    upper: float = _in(50.0, 1e5, "Hz", "corner frequency above which the filter falls again")
    negative: float = _in(0.0, 1.0, "", "current of a negative output over that of a positive one")
    largest: float = _in(1.01, 1e4, "", "current of the saturated generator over threshold")
    adapting: float = _in(0.0, 1.0, "", "part of a constant current that adaptation takes away")
    adaptation: float = _in(1e-4, 1e3, "s", "time constant of adaptation")
    recovery: float = _in(0.0, 100.0, "", "current over threshold that a spike takes away")
    recovering: float = _in(1e-4, 10.0, "s", "time constant with which it returns")
    membrane: float = _in(1e-4, 1.0, "s", "time constant of the membrane")
    refractory: float = _in(5e-4, 0.1, "s", "absolute refractory time")
    noise: float = _in(0.0, 10.0, "", "standard deviation of the noise current from threshold on")
    jitter: float = _in(0.0, 2e-3, "s", "standard deviation of the time from threshold to impulse")
    spread: float = _in(0.0, 3.0, "", "standard deviation of the logarithm of the gains of units")

    def __post_init__(self) -> None:
        choice("drive", self.drive, DRIVES)
        for name, bounds in BOUNDS.items():
            set_number(self, name, at_least=bounds.low, at_most=bounds.high, unit=bounds.unit)
        if self.order not in (1.0, 2.0):
            raise InputError(f"order: expected 1 or 2, received {self.order:g}")
        # Least ratio of the two corners of a filter, so that its partial fractions do not cancel.
        apart = 1.1
        if self.upper < apart * self.corner:
            raise InputError(
                f"upper: expected {apart:g} times the corner of {self.corner:g} Hz or more, "
                f"received {self.upper:g} Hz"
            )

    @property
    def latency(self) -> float:
        """Mean time in s from threshold to impulse, transduction: LATENCY times the jitter."""
        return LATENCY * self.jitter

    @cached_property
    def modes(self) -> tuple[float, Array, Array]:
        """At rest, weights (3,) and poles (3,) in rad/s of the filter, as of `modes_of`.

        Two poles of the lead are a thousandth apart where its order is 2: so near, the partial
        fractions are still exact. The lag turns c s / (s + p) into q c / (q - p) times
        s / (s + p) - s / (s + q), and leaves nothing of a jump.
        """
        count = int(self.order)
        poles = (self.corner, 1.001 * self.corner)[:count]
        lead = PoleZero(zeros=(self.static * self.corner,) * count, poles=poles)
        at_rest, c, p = lead.partial_fractions()
        q = 2.0 * np.pi * self.upper
        share, pole = np.zeros(3), np.full(3, q)
        share[:count], pole[:count] = c * q / (q - p), p
        share[2] = -at_rest - share.sum()
        return at_rest, share, pole

    def frequency_response(self, frequency: Array) -> NDArray[np.complex128]:
        """Output over input of the filter at frequencies in Hz."""
        s = 1j * np.asarray(frequency, float)
        lead = ((s + self.static * self.corner) / (s + self.corner)) ** self.order
        return np.asarray(lead * self.upper / (s + self.upper))


BOUNDS: dict[str, Bounds] = {
    each.name: each.metadata["bounds"] for each in fields(Recorded) if each.metadata
}
"""Range, unit and meaning of each parameter."""


@cache
def record() -> dict[str, Any]:
    """Contents of FILE: values, uncertainties and provenance."""
    text = resources.files("fefinger.neural").joinpath(FILE).read_text(encoding="utf-8")
    return dict(json.loads(text))


@cache
def fitted() -> dict[str, Recorded]:
    """Fitted parameters by type."""
    tables = {kind: record()["types"][kind].items() for kind in TYPES}
    return {
        kind: Recorded(**{name: x["value"] if isinstance(x, dict) else x for name, x in table})
        for kind, table in tables.items()
    }


def parameters_of(
    types: Sequence[str], parameters: Mapping[str, Recorded] | None
) -> list[Recorded]:
    """Parameters of the units of these types: as given by type, else the fitted ones.

    InputError for an unknown type, or a value that is no Recorded.
    """
    given = parameters or {}
    reject_unknown("parameters", given, TYPES)
    for kind, unit in given.items():
        if not isinstance(unit, Recorded):
            raise InputError(f"parameters.{kind}: expected a Recorded, received {unit!r}")
    by_type = {**fitted(), **given}
    return [by_type[kind] for kind in types]


def units_of(
    parameters: Sequence[Recorded],
    *,
    factors: Array | None = None,
    noise: float | None = None,
    seed: int = 0,
    numbers: ArrayLike | None = None,
    trial: int = 0,
) -> "Units":
    """Arrays of the parameters of n units, for the compiled steps.

    factors (n,): on the gains. noise: for all units, by default the fitted noise of their types; 0
    leaves out the jitter too, but not the latency. seed, numbers (n,) and trial select the random
    stream of each unit.
    """
    from fefinger.neural.recorded_compiled import Units, mixed

    n = len(parameters)
    column = {
        each.name: np.array([getattr(unit, each.name) for unit in parameters])
        for each in fields(Recorded)
    }
    at_rest, share, pole = map(np.array, zip(*(unit.modes for unit in parameters), strict=True))
    (base,) = np.random.SeedSequence([seed, 2, 1, *([trial] if trial else [])]).generate_state(
        1, np.uint64
    )
    streams = np.asarray(np.arange(n) if numbers is None else numbers).astype(np.uint64)
    column |= {
        "gain": column["gain"] * (1.0 if factors is None else factors),
        "at_rest": at_rest,
        "share": share,
        "pole": pole,
        "noise": column["noise"] if noise is None else np.full(n, float(noise)),
        "jitter": np.zeros(n) if noise == 0.0 else column["jitter"],
        "latency": LATENCY * column["jitter"],
        # Splitmix64 of a counter: a bijection, so that no two units share a start.
        "stream": np.asarray(mixed(base + streams * np.uint64(0x9E3779B97F4A7C15))),
    }
    return Units(**{name: column[name] for name in Units._fields})


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
    """Simulate the spikes of units of the family `recorded`.

    Impulses are recorded a latency after threshold (`Recorded`), so none comes before its cause; an
    impulse whose latency leads beyond the end of the series is left out. A series that is shifted
    in time fires the same spikes, shifted, with the same noise.

    Parameters
    ----------
    time, drive, types, unit, delays, names, positions, depths
        As in `afferent_units.simulate_units`; by default each unit has one end organ.
    lengths
        (n_organs,) or one number: mm of x_in per unit of drive. x_in is the displacement of a round
        pin 1 mm wide that strains the end organ below it as much.
    rule
        Input of a unit with several end organs: "max", their largest at every time, or "mean".
    variation
        Unequal gains, and noise in µA/cm² for a threshold of THRESHOLD; None: equal gains, and the
        fitted noise.
    parameters
        Parameters by type; default the fitted ones.
    step
        Longest integration step in s; default LONGEST.
    check, exact, since
        As in `afferent_units.simulate_units`.

    Raises
    ------
    InputError
        As in `afferent_units.simulate_units`.
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
    n = len(given.types)
    x_in = combined(given.organs, given.columns, rule)
    variation = (variation or Variation(seed=0, noise=None)).for_units(given.types)
    chosen, noise = parameters_of(given.types, parameters), variation.noise
    units = units_of(
        chosen,
        factors=np.array([variation.gain(i, each.spread) for i, each in enumerate(chosen)]),
        noise=None if noise is None else noise / THRESHOLD,
        seed=variation.seed,
        numbers=variation.numbers,
        trial=variation.trial,
    )
    steps = np.array([LONGEST[kind] for kind in given.types])
    if step is not None:
        steps = np.full(n, number("step", step, above=0.0, at_most=1e-3, unit="s"))
    times, peaks, current = _fire(units, given.time, x_in, steps)
    notes = () if exact else tuple(coarse_remarks(given, x_in))
    reruns = []
    if check:
        change = "the step of the membrane is halved"
        other = partial(_fire, units, given.time, x_in, steps / 2)
        said, rerun = given.changes(times, lambda: other()[0], change)
        notes, reruns = notes + said, [rerun]
        for change, varied in _varied(units, given.types, parameters is None):
            found = _fire(varied, given.time, x_in, steps)[0]
            reruns.append(given.rerun(found, change))
    if check and not exact:
        change = "only every second sample is used"
        other = partial(_fire, units, *given.thinned(x_in), steps)
        said, rerun = given.changes(times, lambda: other()[0], change)
        notes, reruns = notes + said, [*reruns, rerun]
    spike_mv = 40.0  # potential in mV that the threshold counts as, as in `IntegrateAndFire`
    return given.trains(
        times,
        x_in=x_in,
        notes=notes,
        reruns=reruns,
        family="recorded",
        current=THRESHOLD * current,
        peak_mV=spike_mv * peaks,
        seed=variation.seed,
        trial=variation.trial,
    )


def _varied(
    units: "Units", types: Sequence[str], fitted_gains: bool
) -> "Iterator[tuple[str, Units]]":
    """Yield units in other trials and, where they are the fitted ones, with gains at their limits.

    A gain is fitted to within its stated error; one that is set by hand to within the spread of
    units.
    """
    if units.noise.any():
        # Other trials that bound a spike count: with the first the least and largest of five,
        # between which the next one lies in two of three cases.
        trials = 4
        for trial in range(1, trials + 1):
            # Its noise is independent: the counter is mixed before it is used.
            yield f"other trial {trial}", units._replace(stream=units.stream + np.uint64(trial))
    if not fitted_gains:
        return
    rows = {kind: record()["types"][kind] for kind in dict.fromkeys(types)}
    parts = {
        kind: row["gain"]["error"] / row["gain"]["value"]
        if row["gain"]["error"] is not None
        else row["spread"]["value"]
        for kind, row in rows.items()
    }
    off = np.exp([parts[kind] for kind in types])
    yield "gains lower by their error", units._replace(gain=units.gain / off)
    yield "gains higher by their error", units._replace(gain=units.gain * off)


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

    The steps count time from the first sample, as real-time units do, so that the noise does not
    depend on the origin of time.
    """
    from fefinger.neural.recorded_compiled import PEAK, fire, rested

    states = rested(units, x_in[0])
    times, current = fire(units, states, time - time[0], x_in, steps)
    return [time[0] + each for each in times], states[:, PEAK], current
