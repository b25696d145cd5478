"""What inertia changes of a force, and what `modal` errs by and costs.

Measured in `reports/modal.json` on the fingers of four subjects under a plate and a ball: the
change of the dynamic stiffness by inertia over frequency x thickness / wave speed, with the modulus
at that frequency; the change of the force of ramps over speed / wave speed, with the relaxed
modulus; and what the modes leave out. Of all fingers, objects and preloads the largest is taken.
Tissue that stiffens with strain is taken as before it does: it is faster, and inertia changes less.
"""

from collections.abc import Sequence
from functools import cache

import numpy as np

from fefinger.mechanics.evidence.machine import slowness
from fefinger.mechanics.evidence.table import read
from fefinger.mechanics.press.mode_cache import at_hand
from fefinger.mechanics.press.operator_cache import parities
from fefinger.mechanics.refusals import Doubt
from fefinger.mechanics.situation import Situation
from fefinger.scene.inertia import wave_speed
from fefinger.support.arrays import Array
from fefinger.support.text import percent


REPORT = "modal.json"

STEPS = 0.003
"""Error of 60 steps per cycle, by the order of the steps (`mechanics/press/modal_steps.py`)."""

FINE = 2.5
"""Cost on the fine mesh over that on the standard one, as their unknowns; not measured."""

SAMPLED = 10.0
"""Samples per cycle below which straight lines between them change the force by more than 2 %."""

BEYOND = 0.3
"""Frequency over that of the last mode beyond which the answer through time is not trusted."""


def statics_error(case: Situation) -> tuple[float, str]:
    """Return the measured error of leaving inertia out, of what vibrates or of a ramp, and why."""
    frequency, speed = case.motion.highest_frequency or 0.0, _speed(case)
    wave = wave_speed(case.finger)
    faster = wave * _stiffer(case, frequency)
    reduced = frequency * case.finger.pulp / faster
    of_vibration = float(np.interp(reduced, *_envelope("vibration")))
    of_ramp = float(np.interp(speed / wave, *_envelope("ramp")))
    if of_vibration >= of_ramp:
        reason = (
            f"frequency x thickness / wave speed = {frequency:g} Hz x {case.finger.pulp:.3g} mm / "
            f"{1e-3 * faster:.3g} m/s = {reduced:.2g}"
        )
        return of_vibration, reason
    return of_ramp, (
        f"speed / wave speed = {1e-3 * speed:.3g} / {1e-3 * wave:.3g} m/s = {speed / wave:.2g}"
    )


def modal_error(case: Situation) -> float:
    """Return the error of the force by the modes that are left out, and by the steps."""
    frequency = case.motion.highest_frequency
    if frequency is None:
        return STEPS
    left = float(np.interp(_ratio(case, frequency), *_envelope("truncation")))
    return STEPS + left


def sentence(left: float) -> str:
    """Return the source of an error of modes and steps."""
    return f"reports/{REPORT}: {percent(left)} of modes and steps"


def doubts(case: Situation) -> list[Doubt]:
    """Return the doubt that a motion has frequencies which the modes do not reach."""
    frequency, rate = case.motion.highest_frequency, case.motion.sample_rate
    if frequency is None:
        return []
    if rate is not None and rate < SAMPLED * frequency:
        reason = (
            f"samples per s / highest frequency = {rate:.4g} / {frequency:.3g} Hz = "
            f"{rate / frequency:.2g} < {SAMPLED:g}: straight lines between the samples distort it; "
            "sample the motion more finely"
        )
        return [Doubt("motion.time", reason)]
    if _ratio(case, frequency) <= BEYOND:
        return []
    reason = (
        f"frequency / frequency of the last mode = {_ratio(case, frequency):.2g} > {BEYOND:g}: "
        "the modes that are computed do not reach it"
    )
    return [Doubt("motion.frequency", reason)]


def seconds(case: Situation) -> float:
    """Return the expected time in s of modes and steps, besides that without inertia."""
    record = read(REPORT)
    mesh = "standard" if case.mesh == "fine" else case.mesh
    larger = FINE if case.mesh == "fine" else 1.0
    costs = record["seconds"][mesh]
    bodies = len(parities(half=case.half))
    steps = 2 * len(case.times)
    spent = larger * (bodies * costs["setup"] + steps * costs["step"])
    return spent * slowness(record) + once(case)


def once(case: Situation) -> float:
    """Return the time in s of computing the modes, which are kept; 0 where at hand."""
    if at_hand(case.finger, half=case.half):
        return 0.0
    record = read(REPORT)
    mesh = "standard" if case.mesh == "fine" else case.mesh
    larger = FINE if case.mesh == "fine" else 1.0
    build = len(parities(half=case.half)) * larger * record["seconds"][mesh]["build"]
    return float(build * slowness(record))


def _speed(case: Situation) -> float:
    """Largest speed in mm/s of a motion that prescribes the depth, without its vibration."""
    if case.motion.control == "force" or case.motion.highest_frequency is not None:
        return 0.0
    return float(np.abs(case.motion.rate(case.meshes[0].times)).max())


def _stiffer(case: Situation, frequency: float) -> float:
    """Wave speed at a frequency over that in relaxed tissue."""
    prony = case.finger.prony
    omega = 2j * np.pi * frequency
    rates = np.array(prony.v)
    weights = np.array(prony.weights[1:]) / prony.weights[0]
    return float(np.sqrt(abs(1.0 + (weights * omega / (omega + rates)).sum())))


def _ratio(case: Situation, frequency: float) -> float:
    """Frequency over that of the last mode, with the modulus at that frequency.

    The frequency of the last mode follows from wave speed and thickness.
    """
    last = min(read(REPORT)["last_mode"]) * wave_speed(case.finger) / case.finger.thickness
    return frequency / (last * _stiffer(case, frequency))


@cache
def _envelope(name: str) -> tuple[Array, Array]:
    """Largest measured errors over the reduced frequency or speed, rising, from 0 at 0."""
    rows = read(REPORT)[name]
    if name == "vibration":
        points = [pair for row in rows for pair in zip(row["reduced"], row["error"], strict=True)]
    else:
        key = {"ramp": "speed_over_wave", "truncation": "ratio"}[name]
        points = [(row[key], row["error"]) for row in rows]
    return _rising(points)


def _rising(points: Sequence[tuple[float, float]]) -> tuple[Array, Array]:
    places = np.unique([place for place, _ in points])
    largest = [max(error for at, error in points if at == place) for place in places]
    return np.append(0.0, places), np.append(0.0, np.maximum.accumulate(largest))
