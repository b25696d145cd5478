"""Fit a finger to records in stages, each of which starts from the one before: `calibrate`.

A press or motion that was not fitted is predicted, with the error of the prediction.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fefinger.calibration import array_sensor, record_file
from fefinger.calibration.curve import ForceLaw, curve
from fefinger.calibration.outcome import refuse_gross
from fefinger.calibration.press_store import Work
from fefinger.calibration.record import Calibration, PressFit, plain
from fefinger.calibration.record_target import RecordTarget
from fefinger.calibration.records_target import RecordsTarget, indenters, presses, together
from fefinger.calibration.rig import Rig, lagged
from fefinger.calibration.search import Search
from fefinger.calibration.slow_press import PLATE, press
from fefinger.calibration.targets import TOUCH, errors
from fefinger.mesh.store import mesh_problem
from fefinger.scene.finger import RESOLUTIONS, Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.tissue import Tissue
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice
from fefinger.support.processes import one_thread
from fefinger.support.progress import Progress
from fefinger.theory.lumped.ramp_hold import smooth


SHOWS = 0.01
"""Part of the largest force from which it shows that an object touches."""


@dataclass(frozen=True)
class Held:
    """A record that is predicted: time s, position mm, force N (n_t,), and what presses."""

    name: str
    time: Array
    position: Array
    force: Array
    indenter: Indenter

    @property
    def shows(self) -> float:
        """Position in mm at which the force first shows."""
        touched = smooth(self.force) > SHOWS * float(self.force.max())
        return float(self.position[int(np.argmax(touched))])


def checked(
    done: Calibration, work: Work, held: Held, fitted: RecordTarget | RecordsTarget
) -> Calibration:
    """Add the prediction of a record that was not fitted, and its errors.

    What the rig does is taken from the first record that was fitted, and so is touch. Under an
    object that no record has, the fitted finger is pressed anew on the final mesh, and touch is
    where the prediction is best.
    """
    law, x0 = done.law, done[TOUCH].value
    if held.indenter != indenters(fitted)[0]:
        law = _law(done, work, held)
        x0 = _touch(done, law, held, fitted)
    model = _seen(done, law, held, fitted, x0)
    check = {"record that was not fitted": errors(held.force, model)}
    # As many averages where it moves as in time.
    gone = np.append(0.0, np.cumsum(np.abs(np.diff(smooth(held.position)))))
    part = gone / gone[-1] + np.linspace(0, 1, len(gone))
    averages = 400  # largest number of averages that are kept for a page
    starts = np.unique((part * averages / 2).astype(int), return_index=True)[1]
    size = np.diff([*starts.tolist(), len(gone)])
    rows = [
        plain(np.add.reduceat(each, starts) / size)
        for each in (held.time, held.position - x0, held.force, model)
    ]
    shown = PressFit(held.name, rows[0], rows[1], rows[2], rows[3], held_out=True)
    return replace(
        done,
        checks=done.checks | check,
        presses=(*done.presses, shown),
        stages=tuple(work.stages),
    )


def _seen(
    done: Calibration, law: ForceLaw, held: Held, fitted: RecordTarget | RecordsTarget, x0: float
) -> Array:
    """Return the force (n_t,) N that the rig would record."""
    rig = presses(fitted)[0].rig.at({each.name: each.value for each in done.parameters})
    depth = held.position - x0 - rig["compliance"] * held.force
    model = lagged(held.time, law.predicted(held.time, depth), 1e-3 * rig["lag"])
    return np.interp(held.time - 1e-3 * rig["delay"], held.time, model)


def _law(done: Calibration, work: Work, held: Held) -> ForceLaw:
    """Return the force law of the fitted finger under another object, by a press on its mesh."""
    finger = fitted_finger(done, work.finger)
    # Depth of the press by another object over the largest depth of its record, from where the
    # force first shows: touch is a little before.
    deeper = 1.1
    deep = deeper * (float(held.position.max()) - held.shows)
    with work.stage("press of the record that was not fitted"):
        pressed = press(finger, done.mechanics, deep / finger.thickness, indenter=held.indenter)
    return ForceLaw(curve(pressed)[0], done.prony)


def fitted_finger(done: Calibration, finger: Finger) -> Finger:
    """Return the finger with the size and the tissue of a calibration."""
    skin, pulp = Tissue(**done.skin), Tissue(**done.subcutaneous)
    radius = done.finger["pad_radius"]
    return replace(finger, pad_radius=radius, skin=skin, subcutaneous=pulp)


def _touch(
    done: Calibration, law: ForceLaw, held: Held, fitted: RecordTarget | RecordsTarget
) -> float:
    """Return the position in mm of first touch with which a record is predicted best."""
    from scipy.optimize import minimize_scalar

    def off(x0: float) -> float:
        return float(np.sum((_seen(done, law, held, fitted, x0) - held.force) ** 2))

    earlier = 0.5  # travel in mm before the force shows, within which touch is sought
    bounds = (held.shows - earlier, held.shows)
    return float(minimize_scalar(off, bounds=bounds, method="bounded").x)


MECHANICS = ("condensed", "solid")


@one_thread
def calibrate(
    source: str | Path | Sequence[str | Path],
    *,
    finger: Finger | None = None,
    mechanics: str = "solid",
    resolution: str = "standard",
    frames: str | Path | None = None,
    check: str | Path | None = None,
    columns: Mapping[str, str] | None = None,
    rig: Rig | None = None,
    indenter: Indenter | Sequence[Indenter] = PLATE,
    progress: Progress | None = None,
) -> Calibration:
    """Fit a finger to the record of a user, or to several presses of one finger by one rig.

    Parameters
    ----------
    source
        A file of time, position and force (text, `.lvm`, `.mat` or HDF5) with a fast ramp and a
        hold of a plate at 30 degrees to the bone, or of `indenter`; or several, at other speeds or
        depths or by other objects, which share tissue, delay, lag and compliance.
    finger
        Size and tissues, whose moduli are the prior of the fit.
    mechanics
        "condensed" (small strain, times the t(u) of Pawluk 1997) or "solid" (finite strain,
        stiffening tissue).
    resolution
        Final mesh of `solid`: "coarse", "standard" or "fine".
    frames
        CSV file of a slow press: time, position (mm from touch), p1 ... p64 (kPa).
    check
        File of another press or motion, which is predicted and not fitted.
    columns
        Header of time, position or force, where a file does not tell it, such as {"force":
        "channel 2 in mN"}.
    rig
        What the rig does to the record, by default what usual rigs do: a force late by 0 +- 2 ms,
        with an offset of 0 +- 50 mN and a drift of 0 +- 5 mN/s, which are fitted.
    indenter
        The object of all records, such as `ff.Flat(0)` or `ff.Sphere(5)`, or one for each, and then
        for `check`.
    progress
        Called with the name of a stage and the fraction of it that is done.

    Raises
    ------
    InputError
        If a source cannot be used.
    ConvergenceError
        If a fit or a press fails, or the best finger does not reproduce the record.
    """
    choice("mechanics", mechanics, MECHANICS)
    choice("resolution", resolution, RESOLUTIONS)
    if finger is None:
        raise InputError(
            f"{source}: expected the size of the finger with a record, received none; give width "
            "and thickness in mm, or the subject whose size it has"
        )
    work = Work(replace(finger, resolution=resolution), progress)
    problem = mesh_problem(work.finger)
    if problem:
        raise InputError(problem)
    # All files are read before the first fit, which takes seconds.
    measured = None if frames is None else array_sensor.frames(frames)
    predicted = None if check is None else record_file.motion(check, columns)
    files = [source] if isinstance(source, str | Path) else list(source)
    if not files:
        raise InputError("source: expected the file of a record or more, received none")
    rig, objects = rig or Rig(), _objects(indenter, len(files), check is not None, mechanics)
    if measured is not None and objects[0] != PLATE:
        raise InputError(
            f"{frames}: expected a first record of the plate at 30 degrees with frames of the "
            f"array, which lies on it, received one of {objects[0].describe()}"
        )
    with work.stage("lumped") as misfit:
        records = []
        for count, file in enumerate(files, start=1):
            press = f" {count}" if count > 1 else ""
            under = objects[count - 1]
            records.append(record_file.record(file, resolution, columns, rig, press, under))
            record_file.check_depth(records[-1], finger)
        misfit(max(each.lumped_misfit for each in records))
    calibration = Search(work, together(records), measured).calibration(mechanics)
    for each in records:
        refuse_gross(calibration, each)
    if predicted is None:
        return calibration
    held = Held(str(check), *predicted, objects[-1])
    return checked(calibration, work, held, together(records))


def _objects(
    given: Indenter | Sequence[Indenter], files: int, has_check: bool, mechanics: str
) -> tuple[Indenter, ...]:
    """Return the objects of the records, and of the one to predict."""
    objects = list(given) if isinstance(given, Sequence) else [given]
    count = files + has_check
    if len(objects) not in (1, count):
        of_check = " and one for the record to predict, the last" if has_check else ""
        raise InputError(
            f"indenter: expected one object, or one for each of {files} records{of_check}, "
            f"received {len(objects)}"
        )
    objects = objects * (count if len(objects) == 1 else 1)
    if mechanics == "condensed" and len(set(objects)) > 1:
        raise InputError(
            "indenter: expected one object by condensed, whose t(u) is of one, received "
            f"{len(set(objects))}; use solid"
        )
    return tuple(objects)
