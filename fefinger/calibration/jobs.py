"""Several calibrations at once: from command-line options to summaries and files."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from fefinger.calibration.calibrate import calibrate
from fefinger.calibration.record import Calibration, keep_others
from fefinger.calibration.targets import finger_of
from fefinger.support import outputs, processes
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.progress import Progress


Job = dict[str, Any]
"""Arguments of `calibrate`, but for the progress."""


def jobs(
    data: str | None, subjects: Sequence[str], size: dict[str, Any], options: dict[str, Any]
) -> tuple[Job, ...]:
    """Make the jobs for a data file or for subjects.

    Raises
    ------
    InputError
        If there is neither, or an invalid combination.
    """
    if data is None:
        if not subjects:
            msg = 'calibrate: expected DATA.csv or --subject, as --subject "a.h.", received neither'
            raise InputError(msg)
        chosen = {name: finger_of(name, **size) for name in subjects}
        return tuple(options | {"source": name, "finger": chosen[name]} for name in chosen)
    if len(subjects) > 1:
        msg = f"--subject: expected one with DATA.csv, for its size, received {len(subjects)}"
        raise InputError(msg)
    if subjects:
        return (options | {"source": data, "finger": finger_of(subjects[0], **size)},)
    missing = [name for name in ("width", "thickness") if name not in size]
    if missing:
        raise InputError(
            f"--{missing[0]}: expected the size of the finger in {data} in mm, received none; give "
            "--width and --thickness, or --subject"
        )
    return (options | {"source": data, "finger": finger_of(None, **size)},)


def run(todo: Sequence[Job], workers: int = 1, report: Progress | None = None) -> list[Calibration]:
    """Run the calibrations, `workers` of them at a time in separate processes.

    The processes are ended when this function ends, also by an error.
    """
    if workers == 1 or len(todo) == 1:
        return [calibrate(progress=report, **job) for job in todo]
    calibrations: dict[int, Calibration] = {}
    for number, each in processes.each(_one, todo, workers):
        if isinstance(each, processes.WorkerExit):
            raise ConvergenceError(f"{todo[number]['source']}: {each}")
        calibrations[number] = each
        if report is not None:
            report("subjects", len(calibrations) / len(todo))
    return [calibrations[number] for number in range(len(todo))]


def _one(job: Job) -> Calibration:
    return calibrate(**job)


@contextmanager
def folders(todo: Sequence[Job], output: str | None) -> Iterator[list[Path]]:
    """Create the folder of every job below `output`, as a context; [] without an output.

    Empty folders are removed after an error. InputError where a folder holds files of a
    calibration's names that no calibration wrote.
    """
    with ExitStack() as opened:
        whole = opened.enter_context(outputs.output(output))
        places = [] if whole is None else [whole]
        if whole is not None and len(todo) > 1:
            places = [whole / job["source"].strip(".").replace(".", "") for job in todo]
            for place in places:
                opened.enter_context(outputs.output(place))
        for place in places:
            keep_others(place)
        yield places


def save(calibrations: Sequence[Calibration], places: Sequence[Path]) -> list[str]:
    """Write the calibrations into their folders and return the files."""
    pairs = zip(calibrations, places, strict=bool(places))
    return [file for each, place in pairs for file in each.save(place)]
