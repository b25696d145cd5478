"""Several calibrations: from what the command line was given to texts and files."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fefinger.calibration.calibrate import calibrate
from fefinger.calibration.record import Calibration
from fefinger.scene.finger import Finger
from fefinger.support import processes
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.progress import Progress


@dataclass(frozen=True)
class Job:
    """One calibration: its source, and the keywords of `calibrate`."""

    source: str
    options: dict[str, Any]


def jobs(
    data: str | None, subjects: Sequence[str], size: dict[str, Any], options: dict[str, Any]
) -> tuple[Job, ...]:
    """Return what is to be done for a file or for subjects.

    Raises
    ------
    InputError
        Neither, or what does not belong together.
    """
    if data is None:
        if not subjects:
            msg = 'calibrate: expected DATA.csv or --subject, as --subject "a.h.", received neither'
            raise InputError(msg)
        chosen = {name: Finger.subject(name, **size) for name in subjects}
        return tuple(Job(name, options | {"finger": finger}) for name, finger in chosen.items())
    if len(subjects) > 1:
        msg = f"--subject: expected one beside DATA.csv, for its size, received {len(subjects)}"
        raise InputError(msg)
    if subjects:
        return (Job(data, options | {"finger": Finger.subject(subjects[0], **size)}),)
    missing = [name for name in ("width", "thickness") if name not in size]
    if missing:
        msg = (
            f"--{missing[0]}: expected the size of the finger in {data} in mm, received none; give "
            "--width and --thickness, or --subject"
        )
        raise InputError(msg)
    return (Job(data, options | {"finger": Finger(**size)}),)


def run(todo: Sequence[Job], workers: int = 1, report: Progress | None = None) -> list[Calibration]:
    """Return the calibrations, `workers` of them at a time in processes of their own.

    The processes end with what waits for them, however that ends.
    """
    if workers == 1 or len(todo) == 1:
        return [calibrate(job.source, progress=report, **job.options) for job in todo]
    found: dict[int, Calibration] = {}
    for number, each in processes.each(_one, todo, workers):
        if isinstance(each, processes.Died):
            msg = f"{todo[number].source}: {each}"
            raise ConvergenceError(msg)
        found[number] = each
        if report is not None:
            report("subjects", len(found) / len(todo))
    return [found[number] for number in range(len(todo))]


def _one(job: Job) -> Calibration:
    return calibrate(job.source, **job.options)


@contextmanager
def folders(todo: Sequence[Job], output: str | None) -> Iterator[list[Path]]:
    """Give the folder of every job below `output`, made for the work inside; none without one.

    An error leaves no empty one.
    """
    from fefinger.support import outputs

    with ExitStack() as opened:
        whole = opened.enter_context(outputs.output(output))
        if whole is None or len(todo) == 1:
            yield [] if whole is None else [whole]
            return
        names = [job.source.strip(".").replace(".", "") for job in todo]
        for name in names:
            opened.enter_context(outputs.output(whole / name))
        yield [whole / name for name in names]


def save(found: Sequence[Calibration], places: Sequence[Path]) -> list[str]:
    """Write the calibrations into their folders and return the files."""
    if not places:
        return []
    return [
        file for each, place in zip(found, places, strict=True) for file in each.save(str(place))
    ]


def summary(found: Calibration) -> str:
    """Return a calibration as text: parameters, misfits, what was not found, stages."""
    from fefinger.support.text import table

    rows = [
        [
            each.name,
            f"{each.value:.4g} +- {each.sd:.2g}",
            each.unit,
            "-" if each.prior is None else f"{each.prior[0]:.4g}",
            each.how,
        ]
        for each in found.parameters
    ]
    stages = [
        [
            each.name,
            f"{each.cpu:.1f}",
            f"{each.presses} of {each.presses_cpu:.1f}" if each.presses else "-",
            "-" if each.misfit is None else f"{each.misfit:.3g}",
        ]
        for each in found.stages
    ]
    misfits = [[name, f"{value:.4g}"] for name, value in found.residuals.items()]
    misfits += [
        [
            name if "not fitted" in name else f"{name}, not fitted",
            f"mse {100 * errors['mse']:.2g} %, peaks {100 * errors['peak']:.2g} %",
        ]
        for name, errors in found.checks.items()
    ]
    parts = [
        found.status,
        table(rows, ("", "value +- one sd", "unit", "prior", "")),
        table(misfits, ("", "")),
        table(stages, ("stage", "CPU s", "presses, CPU s", "misfit")),
    ]
    return "\n".join([*parts, *(f"not identified: {said}" for said in found.unidentified)])
