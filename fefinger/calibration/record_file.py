"""Reading and checking of records: a ramp and hold to fit, and a motion to predict."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np

from fefinger.calibration import lumped_fit
from fefinger.calibration.noise import Noise, estimated, of_hold
from fefinger.calibration.record_target import MESH, ONE_G, RecordTarget, peak_after_corner
from fefinger.calibration.rig import NOISE, UNITS, Rig
from fefinger.calibration.slow_press import PLATE
from fefinger.calibration.trace import trace
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.theory.lumped.identify import TERMS, Identification, joint
from fefinger.theory.lumped.ramp_hold import SMOOTHING, RampHold, free_samples, split, still_samples


STIFFNESS = (0.02, 100.0)
"""Range in N/mm of a fingertip's stiffness at half of its largest force, with a wide margin."""

FREE = 5
"""Fewest samples before contact by which the offset of the force is known."""


def record(
    file: str | Path,
    mesh: str,
    columns: Mapping[str, str] | None = None,
    rig: Rig | None = None,
    press: str = "",
    indenter: Indenter = PLATE,
) -> RecordTarget:
    """Read and check the target in a file of time, position and force.

    `mesh` is the resolution of the model to be fitted; `columns` as of `lumped_fit.read`; press and
    indenter: as of RecordTarget.

    Raises InputError if the file has no usable ramp and hold, other units, or a response unlike a
    finger's.
    """
    table = lumped_fit.read(file, columns=columns)
    return made(str(file), *table, mesh, rig or Rig(), press, indenter)


def made(
    name: str,
    time: Array,
    position: Array,
    force: Array,
    mesh: str,
    rig: Rig | None = None,
    press: str = "",
    indenter: Indenter = PLATE,
) -> RecordTarget:
    """Make the target of a record (n_t,) s, mm, N, called `name` in messages."""
    rig = rig or Rig()
    free = _free(position, force)
    tare = float(force[:free].mean()) if free >= FREE else 0.0
    try:
        parts = split(time, position, force - tare)
        _check_rig(parts, tare, rig)
        _check_noise(parts, rig)
        late = peak_after_corner(parts) if rig.is_loose("delay") else 1e-3 * rig.delay[0]
        lumped = _lumped(time, np.interp(time - late, time, position), force - tare)
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None
    except RuntimeError:
        raise InputError(
            f"{name}: expected a force that rises on the ramp and falls in the hold, received one "
            "for which the fit of the lumped law of the thesis does not converge; check that this "
            f"is a finger, and that its hold of {parts.hold_seconds:.3g} s is long enough to relax"
        ) from None
    _check_finger(name, parts, lumped)
    jitter = parts.position_noise if rig.position_noise is None else rig.position_noise
    reduced = trace(parts, parts.force + tare, jitter)
    noise = _noise_of(parts, free, rig)
    spread = noise.covariance(reduced.size)
    # The first fit takes the model for less sure than the noise, which may be nothing.
    rough = (5e-3 * reduced.force) ** 2
    rough += np.maximum((1e-3 * np.ptp(reduced.force)) ** 2 - noise.sd**2, 0) / reduced.size
    return RecordTarget(
        *(name, parts, lumped, reduced, tare, noise, jitter, rig, mesh, press, indenter),
        (MESH[mesh], ONE_G),
        np.asarray(np.linalg.cholesky(spread + np.diag(rough))),
    )


def _free(position: Array, force: Array) -> int:
    """Return a number of samples before contact; of a force that wanders, before any motion."""
    free = free_samples(force)
    # A rest of few samples may be where colored noise first strays; `_noise_of` uses none shorter.
    return free if free >= 4 * SMOOTHING else max(free, still_samples(position))


def _noise_of(record: RampHold, free: int, rig: Rig) -> Noise:
    """Return the noise of the force: given, or of the hold and the rest before touch."""
    sd = record.force_noise
    if free >= 4 * SMOOTHING:
        time = record.time[:free]
        line = np.polynomial.polynomial.polyfit(time, record.force[:free], 1)
        rest = record.force[:free] - np.polynomial.polynomial.polyval(time, line)
        sd = max(sd, float(np.std(rest)))
    sd = max(sd, 1e-6 * float(np.ptp(record.force)))
    found = estimated([record.force[:free], of_hold(record)], len(record.force), sd)
    return found if rig.force_noise is None else found.scaled(1e-3 * rig.force_noise)


def _lumped(time: Array, position: Array, force: Array) -> Identification:
    """Fit the lumped law to a record, with fewer terms where a slow ramp does not show them all."""
    for terms in range(TERMS, 1, -1):
        with suppress(RuntimeError):
            return joint(time, position, force, terms=terms)
    return joint(time, position, force, terms=1)


def _check_rig(parts: RampHold, tare: float, rig: Rig) -> None:
    """Raise ValueError for a rig that does, or may do, as much to a record as the finger.

    What is usual may, of a slow or light press. An offset is compared with the reading before
    touch.
    """
    seconds, travel = float(np.ptp(parts.time)), float(np.ptp(parts.position))
    newtons = float(np.ptp(parts.force))
    off = (1e3 * tare - rig.offset[0], rig.offset[1])
    whole = {
        "delay": (rig.delay, 1e3 * seconds, f"{seconds:.3g} s of record"),
        "lag": (rig.lag, 1e3 * seconds, f"{seconds:.3g} s of record"),
        "compliance": (rig.compliance, travel / newtons, f"{travel:.3g} mm of travel"),
        "offset": (off, 1e3 * newtons, f"{newtons:.3g} N of force"),
        "drift": (rig.drift, 1e3 * newtons / seconds, f"{newtons:.3g} N of force"),
    }
    for name, ((mean, sd), most, what) in whole.items():
        given = getattr(rig, name)
        if given != getattr(Rig, name) and max(abs(mean), sd) >= most:
            raise ValueError(
                f"rig.{name}: expected a rig that does less than the {what}, as {most:.3g} "
                f"{UNITS[name]} do, received {given[0]:g} +- {given[1]:g} {UNITS[name]}; check its "
                "unit"
            )


def _check_noise(parts: RampHold, rig: Rig) -> None:
    """Raise ValueError for a given noise as large as the record, which then says nothing."""
    force, position = 1e3 * float(np.ptp(parts.force)), float(np.ptp(parts.position))
    for name, most in (("force_noise", force), ("position_noise", position)):
        noise = getattr(rig, name)
        if noise is not None and noise >= most:
            unit = NOISE[name][0]
            raise ValueError(
                f"rig.{name}: expected less than the {most:.3g} {unit} that the record has in all, "
                f"received {noise:g} {unit}; check its unit"
            )


def check_depth(wanted: RecordTarget, finger: Finger) -> None:
    """Raise InputError for a record that is deeper than the soft tissue of the finger."""
    deep = float(wanted.position.max()) - wanted.lumped.spring.x0
    if deep >= finger.pulp:
        raise InputError(
            f"{wanted.name}: position: expected a press of less than {finger.pulp:.3g} mm, the "
            f"tissue under the pad (half of the thickness, {finger.thickness:g} mm), received one "
            f"that goes {deep:.3g} mm beyond touch; check the size of the finger and the unit"
        )


def motion(
    file: str | Path, columns: Mapping[str, str] | None = None
) -> tuple[Array, Array, Array]:
    """Read time s, position mm and force N, each (n,), of a press or motion for prediction.

    The force is tared by the rest before contact, if there is one. Raises InputError as
    `lumped_fit.read`.
    """
    fewest = 4  # fewest samples of a motion to predict
    time, position, force = lumped_fit.read(
        file, fewest=fewest, of="a motion to predict", columns=columns
    )
    free = _free(position, force)
    tare = float(force[:free].mean()) if FREE <= free < len(force) else 0.0
    return time, position, force - tare


def _check_finger(name: str, parts: RampHold, lumped: Identification) -> None:
    """Raise InputError for a response unlike a finger's: no relaxation, or another stiffness.

    The stiffness comes from the fit `lumped`.
    """
    hold = parts.force[parts.hold :]
    early = float(hold[: max(5, len(hold) // 50)].mean())
    late = float(hold[-len(hold) // 5 :].mean())
    lively = 1e-3  # smallest relative fall of the force in a hold that counts as relaxation
    if late > (1 - lively) * early:
        raise InputError(
            f"{name}: expected a force that falls in the hold, because a finger relaxes, received "
            f"{early:.4g} N at its start and {late:.4g} N at its end; check that this is a finger "
            "and that the force is the right column"
        )
    half = float(lumped.spring.stiffness(0.5 * parts.force.max()))
    low, high = STIFFNESS
    if not low <= half <= high:
        raise InputError(
            f"{name}: expected a stiffness of {low:g} to {high:g} N/mm at half of the largest "
            f"force, received {half:.3g} N/mm, which no fingertip has; check what was pressed, and "
            "the units"
        )
