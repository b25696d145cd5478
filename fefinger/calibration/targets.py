"""What a calibrated finger has to show: a subject's curves, or the record of a user."""

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from fefinger.calibration import lumped_fit
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.support.checks import InputError, choice
from fefinger.theory.array.sensor import ArraySensor
from fefinger.theory.lumped.identify import Identification, joint
from fefinger.theory.lumped.ramp_hold import RampHold, averages, deviation_of, split
from fefinger.theory.lumped.spring import Spring, constant_velocity, force
from fefinger.theory.relaxation import Prony


Array = NDArray[np.float64]

SPEED = 60.0
"""mm/s of the ramps of the thesis."""

PEAK = 2.5
"""N at the end of these ramps (2 to 3 N, section 2.2.2)."""

FORCES = 40
"""Forces at which the stiffness of a subject is compared: a ramp of 30 ms, sampled at 13 kHz and
averaged over 9 samples, has about as many independent stiffnesses."""

HOLD = 6.0
"""Length of the holds of the thesis in s (5 to 7 s)."""

LIVELY = 1e-3
"""Part of the peak force by which a force has to fall in a hold to count as relaxing."""

STIFFNESS = (0.02, 100.0)
"""N/mm that a finger can have at half of its largest force, with a wide margin."""

RETURN = 0.1
"""Part of the way in that an indenter has to come back for a record to count as unloading."""

FEWEST = 4
"""Frames that a press needs for three numbers to be fitted."""

PRESSURE = (1.0, 500.0)
"""kPa that the largest reading of an array on a finger can be."""


@dataclass(frozen=True)
class Bulk:
    """A subject of Table 2.1: elastic stiffness against force, and relaxation.

    force (n,) N of the instantaneous response; stiffness (n,) N/mm and stiffness_sd N/mm, the
    scatter that VAF_k leaves; time (k,) s after a step, relaxation (k,) and relaxation_sd likewise.
    """

    name: str
    spring: Spring
    prony: Prony
    force: Array
    stiffness: Array
    stiffness_sd: float
    time: Array
    relaxation: Array
    relaxation_sd: float


@dataclass(frozen=True)
class Record:
    """A ramp and hold of a user, averaged: time s, position mm, force N and its sd N, (n,) each.

    The standard deviation is that of the noise; mesh is the resolution of what is fitted to it.
    """

    name: str
    record: RampHold
    lumped: Identification
    time: Array
    position: Array
    force: Array
    force_sd: Array
    mesh: str

    def missed(self, force: Array) -> Array:
        """Return by how much a model's force (n,) N misses, in standard deviations (n,).

        Of what noise and the mesh may be off by, taken apart into independent errors.
        """
        return np.asarray(solve_triangular(self._scatter, force - self.force, lower=True))

    @cached_property
    def _scatter(self) -> Array:
        """The Cholesky factor (n, n) N of the covariance of noise and of the mesh's error."""
        between = np.abs(np.subtract.outer(self.position, self.position))
        smooth = self._lumped_force()  # with the noise of the measured one the fit would be biased
        alike = np.exp(-between / LENGTH) * np.multiply.outer(smooth, smooth)
        covariance = np.diag(self.force_sd**2) + MESH[self.mesh] ** 2 * alike
        return np.asarray(np.linalg.cholesky(covariance))

    @property
    def lumped_misfit(self) -> float:
        """What the lumped model misses over what the data allow, as of a `Stage`."""
        missed = (self._lumped_force() - self.force) / self.force_sd
        # The weights of G sum to 1, so one of the parameters is not free.
        return float(missed @ missed) / max(1, len(missed) - len(self.lumped.parameters) + 1)

    def _lumped_force(self) -> Array:
        return force(self.lumped.spring, self.lumped.prony, self.time, self.position)


@dataclass(frozen=True)
class Frames:
    """What an array read in a slow press.

    depth (n_t, n) mm, pressure (n_t, n) kPa of elements at distance (n,) mm from the center of
    contact.
    """

    depth: Array
    pressure: Array
    distance: Array


MESH = {"coarse": 4.3e-3, "standard": 3e-3, "fine": 3e-3}
"""Standard deviation of a force that the model's mesh makes, over it, by resolution.

Of coarse meshes that of `reports/mesh-curves.json`, from presses on meshes that were drawn anew; on
standard ones it is 1e-3 there, but new presses of calibrated fingers by `solid` are 0.5e-3 to
3.5e-3 off the curves that were fitted (suite `calibration`). Draws of another day gave 4.5e-3 and
1.3e-3, and 0.3 and 0.44 mm for LENGTH. Two of 31 draws of the coarse mesh before were 2 % stiffer,
which is not explained.
"""

LENGTH = 0.3
"""Depth in mm over which that error goes by: it is correlated as exp(-distance / LENGTH).

0.36 mm on coarse meshes, 0.22 mm on standard ones, in that report. As one error for all samples of
a hold it leaves the relaxation alone.
"""


def subject(name: str) -> Bulk:
    """Return the target of a subject of Table 2.1, by the lumped model.

    Raises
    ------
    InputError
        For a name that Table 2.1 does not have.
    """
    rows = library.pawluk_bulk()
    choice("subject", name, [each for each in rows if each != "means"])
    row, (stiffness_vaf, hold_vaf) = rows[name], library.pawluk_accounted()[name]
    spring = Spring(row.b, row.m)
    deepest = float(spring.position(PEAK / row.prony.long_time))
    depth = np.linspace(0.0, deepest, 2000)
    ramp = constant_velocity(spring, row.prony, depth, SPEED)
    top = float(spring.force(np.interp(PEAK, ramp, depth)))
    force = np.linspace(0.0, top, FORCES + 1)[1:]
    time = np.geomspace(1e-3, HOLD, 100)
    even = row.prony.relaxation(np.linspace(1e-3, HOLD, 10000))
    stiffness = spring.stiffness(force)
    return Bulk(
        name=name,
        spring=spring,
        prony=row.prony,
        force=force,
        stiffness=stiffness,
        stiffness_sd=math.sqrt(1 / stiffness_vaf - 1) * float(np.std(stiffness)),
        time=time,
        relaxation=row.prony.relaxation(time),
        relaxation_sd=math.sqrt(1 / hold_vaf - 1) * float(np.std(even)),
    )


def record(file: str | Path, mesh: str) -> Record:
    """Return the target in a CSV file of time (s), position (mm) and force (N), once checked.

    `mesh` is the resolution of what will be fitted to it.

    Raises
    ------
    InputError
        A file without a usable ramp and hold, in other units, or of nothing that a finger does.
    """
    return made(str(file), *lumped_fit.read(file), mesh)


def made(name: str, time: Array, position: Array, force: Array, mesh: str) -> Record:
    """Return the target of a record (n_t,) s, mm, N that is called `name` in messages."""
    try:
        parts = split(time, position, force)
        found = joint(time, position, force)
    except ValueError as error:
        msg = f"{name}: {error}"
        raise InputError(msg) from None
    except RuntimeError:
        msg = (
            f"{name}: expected a force that rises on the ramp and falls in the hold, as the lumped "
            "law of the thesis, but its fit does not converge; is this a finger, and is its hold "
            f"of {parts.hold_seconds:.3g} s long enough to see it relax?"
        )
        raise InputError(msg) from None
    _check_finger(name, parts, found)
    t, x, f, _ = averages(parts)
    sd = deviation_of(parts, found.spring, found.prony)
    return Record(name, parts, found, t, x, f, sd, mesh)


def check_depth(wanted: Record, finger: Finger) -> None:
    """Refuse a record that presses a finger as deep as its soft tissue, or deeper."""
    deep = float(wanted.position.max()) - wanted.lumped.spring.x0
    if deep >= finger.pulp:
        msg = (
            f"{wanted.name}: position: expected a press of less than {finger.pulp:.3g} mm, the "
            f"tissue under the pad (half of the thickness, {finger.thickness:g} mm), received one "
            f"that goes {deep:.3g} mm beyond touch; check the size of the finger and the unit"
        )
        raise InputError(msg)


def unloading(file: str | Path) -> tuple[Array, Array, Array]:
    """Return time s, position mm and force N of a record that a fit is to predict.

    Raises
    ------
    InputError
        As `fitting.read`, or where the indenter never comes back.
    """
    time, position, force = lumped_fit.read(file, fewest=FEWEST, of="a motion to predict")
    top = int(np.argmax(position))
    way = float(position[top] - position[0])
    back = float(position[top] - position[top:].min())
    if back < RETURN * way:
        msg = (
            f"{file}: expected a record that also unloads, as a sinusoid or a ramp out, because "
            f"loading is what was fitted; the indenter comes back {back:.3g} of {way:.3g} mm"
        )
        raise InputError(msg)
    return time, position, force


def frames(file: str | Path) -> Frames:
    """Return the frames of the array in a CSV file: time, position (mm from touch), p1 ... p64.

    One frame per row, in kPa, read element by element in the row order of the array, so that the
    depth is that at the time of every element. The array is aligned by the frame with the largest
    sum, as in section 3.2.1 of the thesis.

    Raises
    ------
    InputError
        Missing columns, times that do not rise, another unit, or no contact.
    """
    sensor = ArraySensor()
    count = len(sensor.positions)
    units = {"time": "s", "position": "mm"} | {f"p{i}": "kPa" for i in range(1, count + 1)}
    table = lumped_fit.columns(file, units)
    time, depth, pressure = table[:, 0], table[:, 1], table[:, 2:]
    if len(table) < FEWEST:
        msg = f"{file}: expected {FEWEST} frames or more of a slow press, received {len(table)}"
        raise InputError(msg)
    _check_pressure(str(file), float(pressure.max()))
    reached = np.interp(time[:, None] + sensor.delays, time, depth)
    return aligned(reached, pressure, sensor)


def aligned(depth: Array, pressure: Array, sensor: ArraySensor) -> Frames:
    """Return frames (n_t, n) mm and kPa about the center of pressure of the heaviest one."""
    heaviest = np.maximum(pressure[int(np.argmax(pressure.sum(axis=1)))], 0.0)
    center = heaviest @ sensor.positions / heaviest.sum()
    distance = np.hypot(*(sensor.positions - center).T)
    return Frames(depth, pressure, distance)


def _check_pressure(file: str, largest: float) -> None:
    low, high = PRESSURE
    if low <= largest <= high:
        return
    likely = "MPa" if largest < low else "Pa"
    if largest <= 0:
        msg = f"{file}: p1 ... : expected pressures above 0 in contact, received none"
    else:
        msg = (
            f"{file}: p1 ... : expected kPa, with a largest pressure of {low:g} to {high:g}, "
            f"received {largest:.3g}, as if it were in {likely}; convert the columns"
        )
    raise InputError(msg)


def _check_finger(name: str, parts: RampHold, found: Identification) -> None:
    """Refuse what no finger does: no relaxation, a force that rises in the hold, other stiffness.

    The ramp and its hold are those of a finger only if the stiffness is, in N/mm.
    """
    hold = parts.force[parts.hold :]
    early, late = (
        float(hold[: max(5, len(hold) // 50)].mean()),
        float(hold[-len(hold) // 5 :].mean()),
    )
    if late > (1 - LIVELY) * early:
        msg = (
            f"{name}: expected a force that falls in the hold, because a finger relaxes, received "
            f"{early:.4g} N at its start and {late:.4g} N at its end; is this a finger, and is the "
            "force the right column?"
        )
        raise InputError(msg)
    half = float(found.spring.stiffness(0.5 * parts.force.max()))
    low, high = STIFFNESS
    if not low <= half <= high:
        msg = (
            f"{name}: expected a stiffness of {low:g} to {high:g} N/mm at half of the largest "
            f"force, received {half:.3g} N/mm, which no fingertip has; check what was pressed, and "
            "the units"
        )
        raise InputError(msg)
