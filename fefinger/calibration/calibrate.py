"""Fit a finger to records in stages, each of which starts from the one before: `calibrate`."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from fefinger.calibration import array_sensor, record_file
from fefinger.calibration.held_out import Held, checked
from fefinger.calibration.outcome import refuse_gross
from fefinger.calibration.press_store import Work
from fefinger.calibration.record import Calibration
from fefinger.calibration.records_target import together
from fefinger.calibration.rig import Rig
from fefinger.calibration.search import Search
from fefinger.calibration.slow_press import PLATE
from fefinger.mesh.store import mesh_problem
from fefinger.scene.finger import RESOLUTIONS, Finger
from fefinger.scene.indenter import Indenter
from fefinger.support.checks import InputError, choice
from fefinger.support.progress import Progress
from fefinger.support.threads import one_thread


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
        What the rig does to the record, by default that of usual rigs: a force late by 0 +- 2 ms,
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
