"""Error of neglecting inertia, and error of `modal`.

Measured in `reports/modal.json` on the fingers of four subjects under a plate and a ball: the
change of the dynamic stiffness by inertia over frequency x thickness / wave speed, with the modulus
at that frequency; the change of the force of ramps over speed / wave speed, with the relaxed
modulus; what the modes leave out, of a vibration and of a sudden press, and what the mesh changes;
and, in tissue that stiffens, what the linear finger that stands for it is off. Of all fingers,
objects and preloads the largest is taken, of those whose relaxation damps as much: near resonances
that hardly damp nothing is certain. Tissue that stiffens has the least factor on its moduli of the
measured fingers. Errors of a vibration are over its own force without inertia; that force is
SHARE x amplitude / depth of the peak.
"""

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from fefinger.mechanics.evidence.presses import read
from fefinger.mechanics.press.notes import stiffens
from fefinger.mechanics.press.operator_cache import MESH_OF_INERTIA
from fefinger.mechanics.press.time_steps import MODAL_STEP, RESOLVED
from fefinger.mechanics.situation import Situation
from fefinger.scene import library
from fefinger.scene.cautions import modulus, wave_speed
from fefinger.scene.finger import Finger
from fefinger.scene.motion import Motion
from fefinger.support.arrays import Array
from fefinger.support.text import percent
from fefinger.theory.contact.elastic import amplification


REPORT = "modal.json"

BEYOND = 0.7
"""Frequency over that of the last mode beyond which the answer through time is not trusted."""

SHARE = 5.0
"""Force of a vibration over the peak, by amplitude over depth: at most 4.6 of the measured ones."""

NOISY = 10.0
"""Second difference of samples over their noise, which noise reaches at one in 20 000."""

NEGLIGIBLE = 0.02
"""Change by inertia that is not worth a sentence."""

EXTRAPOLATED = {"coarse": 4 / 3, "standard": 1 / 3, "fine": 1 / 12}
"""Error of a mesh over the difference of the standard from the coarse one, of order 2."""


def statics_error(case: Situation) -> tuple[float, str]:
    """Return the error of neglecting inertia in a vibration, a ramp or a slide, and the reason.

    Errors of vibrations and ramps were measured, the error of a slide is a closed form.
    """
    frequency, speed = case.motion.highest_frequency or 0.0, _speed(case)
    wave = wave_speed(case.finger)
    reduced, of_vibration = reduced_frequency(case), of_oscillation(case, frequency)
    speeds, errors = _envelope("ramp")
    beyond = max(1.0, speed / wave / float(speeds[-1]))  # rises by the square, as inertia does
    of_ramp = float(np.interp(speed / wave, speeds, errors)) * beyond**2
    slide = _slide_speed(case)
    if (of_slide := amplification(slide / wave)) > max(of_vibration, of_ramp):
        return of_slide, (
            f"speed along the skin / wave speed = {1e-3 * slide:.3g} / {1e-3 * wave:.3g} m/s = "
            f"{slide / wave:.2g}, as under a load that moves over a half-space"
        )
    if of_vibration >= of_ramp:
        faster = frequency * case.finger.pulp / reduced if reduced else wave
        reason = (
            f"frequency x thickness / wave speed = {frequency:.4g} Hz x {case.finger.pulp:.3g} mm "
            f"/ {1e-3 * faster:.3g} m/s = {reduced:.2g}"
        )
        return of_vibration, reason
    return of_ramp, (
        f"speed / wave speed = {1e-3 * speed:.3g} / {1e-3 * wave:.3g} m/s = {speed / wave:.2g}"
    )


def of_oscillation(case: Situation, frequency: float) -> float:
    """Return the change of an oscillating force by inertia, over that force without inertia.

    frequency: in Hz. Beyond what was measured it is the last change.
    """
    reduced = frequency * case.finger.pulp / _faster(case, frequency)
    return float(np.interp(reduced, *_envelope("vibration", _damping(case, frequency))))


def left_out(case: Situation) -> tuple[float, str]:
    """Return the error of leaving inertia out over the peak of the force, and its source.

    None below NEGLIGIBLE.
    """
    error, reason = statics_error(case)
    of_noise, source = noise_error(case), ""
    least_noise = 1e-3  # part of the peak that noise adds below which it is not worth a clause
    if of_noise >= least_noise:
        motion = case.motion
        source = (
            f"; noise of {motion.noise:.2g} {motion.unit} in the samples adds "
            f"{percent(of_noise)} of the peak, which inertia changes by about as much"
        )
    if error < NEGLIGIBLE:
        return of_noise, source
    vibrates = case.motion.highest_frequency is not None
    what = "the oscillation of the force" if vibrates else "the force"
    over_peak = error * (_share(case) if vibrates else 1.0)
    return math.hypot(over_peak, of_noise), (
        f"; reports/{REPORT}: inertia, left out, changes {what} by up to {percent(error)}: "
        f"{reason}{source}"
    )


def noise_error(case: Situation) -> float:
    """Estimate the force that noise in the samples of a motion adds, over the peak force.

    It is the amplitude of a sine of as much power. Above the resonances the skin hardly follows a
    force, so inertia takes from the answer about what noise adds; of a depth the root mean square
    of the change is about that (`tests/scene/test_oscillation.py`).
    """
    return _share(case, math.sqrt(2) * case.motion.noise)


def modal_error(case: Situation) -> float:
    """Return the error of the force by modes, mesh and steps, over its peak."""
    # Error of 60 steps per cycle, by the order of the steps (`mechanics/press/modal_press.py`).
    steps = 0.003
    return steps + float(np.hypot(_share(case) * vibration_error(case), press_error(case)))


def press_error(case: Situation) -> float:
    """Return the error of the force in a press by leaving modes out, over its peak."""
    return left_out_by_modes(suddenness(case.motion, 1 / last_mode(case)))


def left_out_by_modes(sudden: float) -> float:
    """Return the error of the force by leaving modes out, over its peak, for a `suddenness`."""
    return float(np.interp(sudden, *_envelope("press")))


def suddenness(motion: Motion, cycle: float) -> float:
    """Dimensionless measure of how suddenly a press changes its speed.

    The largest change of the mean speed from one eighth of a cycle to the next, over peak / cycle,
    with the cycle in s of the last mode. Vibration of the motion and noise of its samples do not
    count. Over eighths, sharp and rounded presses of the same suddenness have the same error.
    """
    part = cycle / 8

    def slow(t: Array) -> Array:
        at = np.clip(t, 0.0, motion.duration)
        # A vibration that has a part at t = 0 has had it before, which is no start of a press.
        return np.where(t < 0, 0.0, motion.value(at)) - motion.vibration(at)

    ends = np.array(motion.breakpoints)
    middles = (ends[1:] + ends[:-1]) / 2
    t = np.concatenate([ends, ends - part, ends + part, middles])
    t = np.minimum(t, motion.duration - part)  # what would come after the end is not known
    change = np.abs(slow(t + part) - 2 * slow(t) + slow(t - part)).max()
    of_noise = NOISY * motion.noise * min(1.0, part * (motion.sample_rate or 0.0))
    return float(max(change - of_noise, 0.0) / motion.peak * cycle / part)


def vibration_error(case: Situation) -> float:
    """Return the error of the oscillation of the force, over that without inertia.

    It is the whole oscillation where it is too fast for the modes, or for what was measured.
    """
    frequency = case.motion.highest_frequency
    if frequency is None:
        return 0.0
    kind, reduced, over_last = _damping(case, frequency), reduced_frequency(case), ratio(case)
    if reduced > highest() * (1 + 1e-9) or over_last > BEYOND:
        return 1.0
    modes = float(np.interp(over_last, *_envelope("truncation", kind)))
    mesh = EXTRAPOLATED[of_inertia(case).mesh]
    meshes = mesh * float(np.interp(reduced, *_envelope("mesh_of_inertia", kind)))
    stiff = stiffens(case.finger)
    strain = float(np.interp(reduced, *_envelope("preload", kind))) if stiff else 0.0
    return float(np.sqrt(modes**2 + meshes**2 + strain**2))


def geometric_share(part: float) -> float:
    """Material over total stiffness, less 1, of a finger preloaded by `part` of its thickness.

    The mean of the measured fingers: the stress of the preload lowers the stiffness and, other than
    the material, does not relax.
    """
    return float(np.interp(part, *_by_part("share", np.mean, 0.0)))


def sentence(case: Situation) -> str:
    """Return the source of the error of modes, mesh and steps."""
    left, frequency = modal_error(case), case.motion.highest_frequency
    if frequency is None or press_error(case) > _share(case) * vibration_error(case):
        return f"reports/{REPORT}: {percent(left)} of modes and steps"
    text = (
        f"reports/{REPORT}: {percent(left)} of modes, mesh and steps, as the oscillation of the "
        f"force is {percent(vibration_error(case))} off at {frequency:.4g} Hz"
    )
    if _resonates(case):
        text += f", where resonances of this tissue hardly damp{damped_set(case.finger)}"
    return text


def _resonates(case: Situation) -> bool:
    """Whether a vibration meets resonances of tissue that hardly damps them."""
    frequency = case.motion.highest_frequency
    undamped = frequency is not None and _damping(case, frequency) == "published"
    resonant = 0.2  # frequency x thickness / wave speed from which fingers resonate under a plate
    return undamped and reduced_frequency(case) > resonant


def damped_set(finger: Finger) -> str:
    """Name the viscous variant of a finger's tissue, if there is one."""
    name = f"{finger.tissue}{library.VISCOUS}"
    if name not in library.TISSUE_SETS:
        return ""
    return f"; a set that damps them, of low confidence, is finger.tissue = {name!r}"


def advice(case: Situation) -> str:
    """Suggest the viscous variant of a tissue whose resonances are hardly damped."""
    name = damped_set(case.finger) if _resonates(case) else ""
    return f"Resonances of this tissue hardly damp{name}. " if name else ""


def notes(case: Situation) -> tuple[str, ...]:
    """Return the note on the error of the oscillation itself, if there is one."""
    frequency = case.motion.highest_frequency
    if frequency is None:
        return ()
    return (
        f"The oscillation of the force is within {percent(vibration_error(case))} of its own up to "
        f"{frequency:.4g} Hz (reports/{REPORT}).",
    )


def of_inertia(case: Situation) -> Situation:
    """Return the situation on the mesh on which inertia is computed."""
    return case.on(MESH_OF_INERTIA[case.mesh]) if stiffens(case.finger) else case


def _slide_speed(case: Situation) -> float:
    """Largest speed in mm/s along the skin of an object that is no smooth plate."""
    if not case.motion.slides or not (case.indenter.flat is None or case.indenter.raised):
        return 0.0
    t = case.meshes[0].times
    along = np.linalg.norm(np.diff(case.motion.shift(t), axis=0), axis=1)
    return float((along / np.diff(t)).max())


def _speed(case: Situation) -> float:
    """Largest speed in mm/s of a motion that prescribes the depth, without its vibration."""
    if case.motion.by_force:
        return 0.0
    t = case.meshes[0].times
    slow = case.motion.value(t) - case.motion.vibration(t)
    return float(np.abs(np.diff(slow) / np.diff(t)).max())


def _damping(case: Situation, frequency: float) -> str:
    """Return the measured relaxation that damps at most as much: "published" or "viscous"."""
    if not frequency:
        return "published"
    viscous = Finger.subject("a.h.", tissue=f"{library.PUBLISHED}{library.VISCOUS}")
    losses = [
        each.imag / each.real
        for each in (modulus(finger, frequency) for finger in (case.finger, viscous))
    ]
    # Share of the loss factor of the viscous relaxation from which a finger counts as damped.
    damped = 0.8
    return "viscous" if losses[0] >= damped * losses[1] else "published"


def _faster(case: Situation, frequency: float) -> float:
    """Wave speed in mm/s at a frequency, under the preload."""
    factor = 1.0
    if stiffens(case.finger) and not case.motion.by_force:
        part = min(case.motion.steady_level, case.motion.peak) / case.finger.thickness
        factor = max(1.0, float(np.interp(part, *_by_part("factor", np.min, 1.0))))
    return float(wave_speed(case.finger, frequency) * np.sqrt(factor))


def reduced_frequency(case: Situation) -> float:
    """Return the highest frequency x thickness of the tissue / wave speed."""
    frequency = case.motion.highest_frequency or 0.0
    return frequency * case.finger.pulp / _faster(case, frequency)


def highest() -> float:
    """Return the reduced frequency up to which fingers were measured."""
    return float(_envelope("vibration", "published")[0][-1])


def _share(case: Situation, amplitude: float | None = None) -> float:
    """Force of an oscillation of an amplitude in mm or N over the peak, at most 1.

    By default the amplitude of the motion.
    """
    amplitude = case.motion.oscillation_amplitude if amplitude is None else amplitude
    factor = 1.0 if case.motion.by_force else SHARE
    return min(1.0, factor * amplitude / case.motion.peak)


def ratio(case: Situation) -> float:
    """Return the ratio of the highest frequency to the last mode, with the modulus at the former.

    The frequency of the last mode follows from wave speed and thickness.
    """
    frequency = case.motion.highest_frequency or 0.0
    last = min(read(REPORT)["last_mode"]) * _faster(case, frequency) / case.finger.thickness
    return frequency / last


def last_mode(case: Situation) -> float:
    """Return the frequency in Hz of the last mode that swings in a press, with relaxed tissue."""
    kept = min(read(REPORT)["last_mode"]) * _faster(case, 0.0) / case.finger.thickness
    sudden = RESOLVED / MODAL_STEP  # with the modulus of sudden strain
    return float(min(kept, sudden * np.sqrt(case.finger.prony.weights[0])))


@cache
def _by_part(name: str, of: Callable[[Array], float], at_rest: float) -> tuple[Array, Array]:
    """Values of the measured fingers over the preload in parts of the thickness."""
    rows = read(REPORT)["preload"]
    parts = np.unique([row["part"] for row in rows])
    values = [of(np.array([row[name] for row in rows if row["part"] == p])) for p in parts]
    return np.append(0.0, parts), np.append(at_rest, values)


@cache
def _envelope(name: str, kind: str = "") -> tuple[Array, Array]:
    """Largest measured errors over the reduced frequency or speed, rising, from 0 at 0.

    kind: relaxation of the measured fingers, where there are several.
    """
    report = read(REPORT)
    if name == "preload":  # of stiffening tissue
        rows = [row[kind] for row in report[name] if kind in row]
        at = [row["reduced"] for row in rows]
    else:
        rows = [row for row in report[name] if not kind or row["relaxation"] == kind]
        key = {"ramp": "speed_over_wave", "truncation": "ratio", "press": "suddenness"}.get(name)
        at = [row[key] if key else report["reduced"] for row in rows]
    places, errors = (np.hstack(each) for each in (at, [row["error"] for row in rows]))
    every = np.unique(places)
    largest = [errors[places == place].max() for place in every]
    return np.append(0.0, every), np.append(0.0, np.maximum.accumulate(largest))
