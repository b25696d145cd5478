"""Cautions on a scene: speed against shear waves in the tissue, and unusual numbers.

Only `modal` has inertia. For the others this is a warning after the answer, when the depth is known
also under force control; beforehand the planner compares the measured error of statics
(`mechanics/evidence/vibration.py`) with `ask.rel_error`. The relative error is
1 / cos(2 pi f h / c) - 1 for a layer of thickness h whose surface moves at the frequency f, with c
the speed of shear waves at this frequency, and about (v / c)² for a body moved at the speed v, with
c of relaxed tissue. The limits here keep both below 5 %.

Numbers a thousand times too small or too large for a finger may be meant, and are answered; all of
one kind together are likely in another unit.
"""

import math
from collections.abc import Iterator
from typing import Protocol

import numpy as np

from fefinger.scene.finger import Finger
from fefinger.scene.motion import Motion
from fefinger.scene.oscillation import SAMPLED
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.text import percent
from fefinger.support.units import LOADED, MODULUS, PRESS, SLOW, SLOWEST


DENSITY = 1e-6
"""Density of soft tissue in kg/mm³, that of water."""


def wave_speed(finger: Finger, frequency: float = 0.0) -> float:
    """Return the speed in mm/s of shear waves of a frequency in Hz in subcutaneous tissue.

    The slowest layer: sqrt(G / density) with G = E / (2 (1 + nu)), 3.39 m/s for relaxed tissue of
    E = 34 kPa and nu = 0.48. The kPa are 1e3 kg / (m s²), or kg / (mm s²).
    """
    tissue = finger.subcutaneous
    shear = tissue.modulus * abs(modulus(finger, frequency)) / (2 * (1 + tissue.poisson))
    return math.sqrt(shear / DENSITY)


def modulus(finger: Finger, frequency: float) -> complex:
    """Return the complex modulus at a frequency in Hz, over the relaxed modulus."""
    relaxed, *decaying = finger.prony.weights
    omega = 2j * math.pi * frequency
    terms = zip(decaying, finger.prony.v, strict=True)
    return 1.0 + sum(weight / relaxed * omega / (omega + rate) for weight, rate in terms)


def warnings(motion: Motion) -> tuple[str, ...]:
    """Warnings of a motion that jumps into the finger, or of its samples."""
    return jump(motion) + coarse_samples(motion)


def jump(motion: Motion) -> tuple[str, ...]:
    """Warning if a motion starts with a jump into the finger."""
    start = float(motion.value(np.zeros(1))[0])
    # A motion from less starts from 0, but for noise of a record.
    if start <= 1e-3 * motion.peak:
        return ()
    return (
        f"Warning: the motion starts at {start:.3g} {motion.unit}, which the indenter reaches in a "
        "jump; start the motion from 0.",
    )


def coarse_samples(motion: Motion) -> tuple[str, ...]:
    """Warning of a vibration with few samples per cycle or with gaps, which lines distort."""
    frequency, rate = motion.highest_frequency, motion.sample_rate
    if frequency is None or rate is None:
        return ()
    warning: tuple[str, ...] = ()
    if rate < SAMPLED * frequency:
        warning = (
            f"Warning: the motion has {rate / frequency:.2g} samples per cycle of "
            f"{frequency:.3g} Hz, joined by straight lines; take {SAMPLED:g} or more, or filter "
            "its noise.",
        )
    if motion.gaps:
        (start, stop), *more = motion.gaps
        others = f", and in {len(more)} more places" if more else ""
        warning += (
            f"Warning: the motion vibrates at up to {frequency:.3g} Hz and has no samples from "
            f"{start:.4g} to {stop:.4g} s{others}; a straight line joins them.",
        )
    return warning


def unmodeled(scene: Scene) -> tuple[str, ...]:
    """Types of units that statics does not give the cause to fire, among those asked for.

    FAII answer waves that reach them through the skin. In a vibration the object itself moves as
    they do; of a ramp statics leaves them its corners, of slip and of distance nothing. Under
    ridges of the skin, textures are such a cause.
    """
    vibrates, ridges = scene.motion.highest_frequency is not None, scene.finger.raised_ridges
    return () if vibrates or ridges or "FAII" not in scene.ask.spikes else ("FAII",)


def noise(motion: Motion) -> tuple[str, ...]:
    """Note on what is taken for noise of a record and not for a vibration."""
    if not motion.noise:
        return ()
    return (
        f"The samples of the motion scatter by {motion.noise:.2g} {motion.unit} (root mean square) "
        f"from one to the next, with fewer than {SAMPLED:g} per cycle: this is taken for noise of "
        "the record, whose inertia is left out. Filter it where spikes of FAII are asked for.",
    )


def missing(motion: Motion) -> tuple[str, ...]:
    """Note on gaps in the samples of a motion that no warning of a vibration is about."""
    if motion.gaps or not motion.missing:
        return ()
    (start, stop), *more = motion.missing
    others = f", and in {len(more)} more places" if more else ""
    return (
        f"The motion has no samples from {start:.4g} to {stop:.4g} s{others}; a straight line "
        "joins them.",
    )


def samples(motion: Motion) -> tuple[str, ...]:
    """Return the notes on samples: their first time, noise, gaps, and forces below 0."""
    return begins(motion) + noise(motion) + missing(motion) + pulling(motion)


def begins(motion: Motion) -> tuple[str, ...]:
    """Note on a record whose first time is not 0."""
    if not motion.begins:
        return ()
    return (f"The samples of the motion begin at {motion.begins:.7g} s, which counts as 0 s.",)


def pulling(motion: Motion) -> tuple[str, ...]:
    """Note on readings before contact that are subtracted, and on forces below 0, which count as 0.

    Before contact they are noise of the sensor, after it the probe swings, or the sensor lags.
    """
    notes: tuple[str, ...] = ()
    if motion.tare:
        notes += (
            f"Before contact the force reads {motion.tare:.2g} N in the mean, which is subtracted.",
        )
    if motion.pulling:
        notes += (
            f"The samples of the force go down to {-motion.pulling:.2g} N, "
            f"{percent(motion.pulling / motion.peak)} of the peak below 0: as a contact cannot "
            "pull, values below 0 count as 0.",
        )
    return notes


def quasistatic(scene: Scene, time: Array, depth: Array) -> tuple[str, ...]:
    """Warning if an indenter at depth (n_t,) mm at times (n_t,) s moves too fast for statics.

    The depth is the answer's, so that force control is checked too. A jump has no speed.
    """
    step = np.diff(time)
    along = np.linalg.norm(np.diff(scene.motion.shift(time), axis=0), axis=1)
    speeds = np.hypot(np.diff(depth), along) / np.where(step > 0, step, np.inf)
    speed, wave = float(speeds.max(initial=0.0)), wave_speed(scene.finger)
    motion, indenter = scene.motion, scene.indenter
    # A smooth plate without friction does not move the skin along its path.
    smooth = indenter.flat is not None and indenter.friction == 0 and not motion.turns_plate
    across = None if smooth else motion.path_frequency
    frequency = max(motion.highest_frequency or 0.0, across or 0.0)
    exceeded = []
    fast = 0.22  # limit of indenter speed over shear wave speed: 0.22² is an error of 5 %
    if speed > fast * wave:
        exceeded.append(
            f"speed / wave speed = {1e-3 * speed:.3g} / {1e-3 * wave:.3g} m/s = "
            f"{speed / wave:.2g} > {fast:g}"
        )
    thick, stiffer = frequency * scene.finger.pulp, wave_speed(scene.finger, frequency)
    quick = 0.05  # limit of frequency x thickness / shear wave speed: 1 / cos(2 pi 0.05) - 1 is 5 %
    if thick > quick * stiffer:
        exceeded.append(
            f"frequency x thickness / wave speed = {frequency:.4g} Hz x {scene.finger.pulp:.3g} mm "
            f"/ {1e-3 * stiffer:.3g} m/s = {thick / stiffer:.2g} > {quick:g}"
        )
    if not exceeded:
        return ()
    return (
        f"Warning: not quasi-static, {' and '.join(exceeded)}; inertia and waves are neglected.",
    )


class Touch(Protocol):
    """Anything with a finger and a motion, as a scene."""

    @property
    def finger(self) -> Finger:
        """The finger."""

    @property
    def motion(self) -> Motion:
        """The motion."""


def unusual(scene: Touch) -> list[str]:
    """Return sentences on moduli, depth, force and times that are likely in another unit."""
    return [*_moduli(scene), *_size(scene.motion), *_slow(scene.motion)]


def _moduli(scene: Touch) -> Iterator[str]:
    """Yield a sentence if every modulus of soft tissue suggests the same other unit."""
    layers = scene.finger.skin.modulus, scene.finger.subcutaneous.modulus
    hints = {MODULUS.hint(each) for each in layers}
    if len(hints) == 1 and (hint := hints.pop()):
        yield (
            f"the moduli of skin and subcutaneous tissue, {layers[0]:.3g} and {layers[1]:.3g} kPa, "
            f"are none of a finger{hint}; moduli are in kPa"
        )


def _size(motion: Motion) -> Iterator[str]:
    for likely, most in ((PRESS, motion.deepest), (LOADED, motion.hardest)):
        if most is not None and (hint := likely.hint(most)):
            yield (
                f"the largest {likely.what} is {most:.3g} {likely.unit}{hint}; it is in "
                f"{likely.unit}"
            )


def _slow(motion: Motion) -> Iterator[str]:
    """Yield a sentence on samples far apart of a slow press, which may have their times in ms."""
    if motion.sample_rate is None or motion.sample_rate * SLOW > 1:
        return
    time = np.array(motion.breakpoints)
    fastest = float(np.abs(np.diff(motion.value(time)) / np.diff(time)).max())
    if fastest < SLOWEST:
        yield (
            f"the samples of the motion are {1 / motion.sample_rate:.3g} s apart and it moves with "
            f"at most {fastest:.2g} {motion.unit}/s, as if its times were in ms; they are in s"
        )
