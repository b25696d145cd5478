"""Membranes and end organs at extreme currents, rates and steps."""

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
from fefinger.validation.extremes.invariants import not_finite, off
from fefinger.validation.extremes.trial import ANSWERED, REFUSED, Findings, Row, Trial, grouped
from fefinger.validation.neural.connor_stevens import ConnorStevens

from fefinger.neural.afferent_units import simulate_units
from fefinger.neural.endorgans import END_ORGANS, PoleZero
from fefinger.neural.membranes import HodgkinHuxley, IntegrateAndFire, Membrane
from fefinger.support.arrays import Array


GROUP = "nerve"

MEMBRANES: dict[str, Membrane] = {
    "squid, slowed": HodgkinHuxley(),
    "squid": HodgkinHuxley(1.0),
    "squid, 40 C": HodgkinHuxley(1.0, 40.0),
    "squid, slowed by 100 at 0 C": HodgkinHuxley(100.0, 0.0),
    "Connor-Stevens": ConnorStevens(),
    "integrate and fire": IntegrateAndFire(),
}


@cache
def trials() -> tuple[Trial, ...]:
    """Return the trials of membranes and end organs."""
    return grouped(GROUP, _currents, _paces, _organs, _afferents)


def _currents() -> Iterator[Row]:
    """Constant currents from none to 1e4 uA/cm² of both signs, and beyond."""
    for name, membrane in MEMBRANES.items():
        for current in (0.0, 1e-300, 1e-9, 6.2, 111.0, 1e4, -1e4):
            ask = partial(_constant, membrane, current)
            wants = ANSWERED if abs(current) < 1e4 else None
            yield "current", f"{name}, {current:g} uA/cm²", ask, wants
        for current in (1.001e4, np.inf, np.nan):
            ask = partial(_constant, membrane, current)
            yield "current", f"{name}, {current:g} uA/cm²", ask, REFUSED


def _checked(membrane: Membrane, time: Array, current: Array) -> Findings:
    """Return that spikes are in order, in the run, no faster than a membrane, and repeatable."""
    firing = membrane.fire(time, current, dt=None, stimulus_driven=True)
    (times,) = firing.times
    again = membrane.fire(time, current, dt=None, stimulus_driven=False)
    seconds = float(time[-1] - time[0])
    outside = float(np.sum((times < time[0]) | (times > time[-1]))) if len(times) else 0.0
    return {
        "finite": not_finite(times, firing.peak_mV, firing.block_seconds, firing.final),
        "in order": (float(np.sum(np.diff(times) <= 0)), 0.0),
        "in the run": (outside, 0.0),
        "at most 2 per ms at any temperature": (len(times), 2e3 * 45 * seconds + 1),
        "repeatable": (float(len(times) != len(again.times[0])), 0.0),
        "block within the run": (float(firing.block_seconds[0]), seconds + 1e-12),
        "no spike at rest": (0.0 if np.abs(current).max() >= 1.0 else float(len(times)), 0.0),
    }


def _constant(membrane: Membrane, current: float) -> Findings:
    return _checked(membrane, np.array([0.0, 0.05]), np.array([current, current]))


def _paces() -> Iterator[Row]:
    """Yield samples from 1e-9 to 5 s apart, jumps, noise, and time that stands still."""
    rng = np.random.default_rng(8)
    signals = {
        "samples 1e-9 s apart": (1e-9 * np.arange(50), np.full(50, 50.0)),
        "two samples, 5 s apart": (np.array([0.0, 5.0]), np.array([0.0, 80.0])),
        "jumps of 2e4 uA/cm²": (np.repeat(1e-3 * np.arange(20), 2), np.tile([1e4, -1e4], 20)),
        "noise of 1e3 uA/cm²": (1e-4 * np.arange(500), 1e3 * rng.normal(size=500)),
        "5e3 Hz": (2.5e-5 * np.arange(4000), 100 * np.sin(np.pi * np.arange(4000) / 4)),
        "time that stands still": (np.zeros(10), np.full(10, 50.0)),
        "far from zero": (1e6 + 1e-3 * np.arange(50), np.full(50, 50.0)),
    }
    for name, membrane in MEMBRANES.items():
        for pace, (time, current) in signals.items():
            wants = ANSWERED if np.abs(current).max() < 500 else None
            yield "pace", f"{name}, {pace}", partial(_checked, membrane, time, current), wants
    yield "pace", "slowed by 9 at 16.3 C is slowed by 3 at 6.3 C", _warmed, ANSWERED


def _warmed() -> Findings:
    """Return that a membrane slowed and one warmed to the same rates fire alike."""
    time, current = np.array([0.0, 0.1, 0.4]), np.array([0.0, 40.0, 40.0])
    one = HodgkinHuxley(3.0).fire(time, current).times[0]
    two = HodgkinHuxley(9.0, 16.3).fire(time, current).times[0]
    return {"as many": (float(abs(len(one) - len(two))), 0.0), "as late": off(two, one, 1e-9)}


def _organs() -> Iterator[Row]:
    """Yield filters with corners from 1e-6 to 1e6 Hz, at steps from 1e-6 to 1e3 s."""
    organs = END_ORGANS | {
        "corners 1e-6 and 1e6 Hz": PoleZero((0.0, 0.0), (1e-6, 1e6)),
        "corners 1e-5 apart": PoleZero((0.0, 0.0), (10.0, 10.0 * (1 + 1e-5))),
        "no corners": PoleZero((), ()),
    }
    for name, organ in organs.items():
        for step in (1e-6, 1.0, 1e3):
            yield "end organ", f"{name}, steps of {step:g} s", partial(_ramped, organ, step), None
    yield "end organ", "two equal corners", partial(_two, 0.0), REFUSED
    yield "end organ", "corners 1e-9 apart", partial(_two, 1e-9), REFUSED


def _two(apart: float) -> Findings:
    return _ramped(PoleZero((0.0, 0.0), (10.0, 10.0 * (1 + apart))), 1.0)


def _ramped(organ: PoleZero, step: float) -> Findings:
    """Return that one step of a ramp is many short ones, and that a hold ends as at rest."""
    coarse, fine = step * np.arange(5.0), step * np.linspace(0, 4, 401)
    signal = np.minimum(coarse, 2 * step) / (2 * step)
    once = organ.respond(coarse, signal)
    often = organ.respond(fine, np.interp(fine, coarse, signal))[::100]
    ending = organ.respond([0.0, 1.0, 1e12], [0.0, 1.0, 1.0])[-1]
    at_rest = organ.partial_fractions()[0]
    return {
        "finite": not_finite(once, often),
        "steps do not matter": (float(np.abs(once - often).max()), 1e-7),
        "hold": (abs(ending - at_rest), 1e-9 + 1e-6 * abs(at_rest)),
    }


def _afferents() -> Iterator[Row]:
    """From skin displacement to spikes, 1e-12 to 1e6 mm, with both generators."""
    for generator in ("saturating", "linear"):
        for size in (1e-12, 1.0, 1e6):
            name = f"{generator}, {size:g} mm"
            wants = REFUSED if generator == "linear" and size > 1 else ANSWERED
            yield "displacement", name, partial(_driven, generator, size), wants


def _driven(generator: str, size: float) -> Findings:
    time = np.linspace(0, 0.2, 401)
    drive = size * np.minimum(time / 0.05, 1.0)[:, None] * np.ones(4)
    trains = simulate_units(time, drive, types=tuple(END_ORGANS), generator=generator, check=False)
    count = float(trains.count().sum())
    return {
        "finite": not_finite(trains.current, trains.peak_mV, trains.x_in),
        "no current below none": (max(0.0, -float(trains.current.min())), 0.0),
        "silent where nothing moves": (count if size < 1e-6 else 0.0, 0.0),
    }
