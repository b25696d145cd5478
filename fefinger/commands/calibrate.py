"""`fefinger calibrate` and `fefinger fit`: a tissue or a lumped model from records of presses."""

from functools import partial
from typing import Any

import click

from fefinger.commands import console
from fefinger.commands.console import json_option, output_option


NO_TISSUE = "no tissue.toml is written: t(u) scales the force, not a tissue; use --mechanics solid"


@click.command()
@click.argument("data", metavar="[DATA.csv]", required=False)
@click.option(
    "--subject",
    "subjects",
    multiple=True,
    metavar="NAME",
    help="Subject of Pawluk (1997) to fit (repeatable), or whose finger size applies to DATA.csv.",
)
@click.option("--width", type=float, help="Width of the fingertip in DATA.csv in mm.")
@click.option("--thickness", type=float, help="Thickness of that fingertip in mm.")
@click.option("--pad-radius", type=float, help="Effective pad radius of that fingertip in mm.")
@click.option("--frames", metavar="FILE", help="CSV of a slow press: time, position, p1 to p64.")
@click.option("--check", metavar="FILE", help="CSV of a motion to predict, not to fit.")
@click.option(
    "--mechanics",
    default="solid",
    help="solid, or condensed (small strain, times the stiffening t(u) of the thesis).",
)
@click.option(
    "--resolution", default="standard", help="Mesh of the last step: coarse, standard, fine."
)
@click.option(
    "--workers", default=1, type=click.IntRange(1), help="Subjects fitted at the same time."
)
@output_option("calibration.json and, by solid, tissue.toml")
@json_option
def calibrate(
    data: str | None,
    subjects: tuple[str, ...],
    width: float | None,
    thickness: float | None,
    pad_radius: float | None,
    frames: str | None,
    check: str | None,
    mechanics: str,
    resolution: str,
    workers: int,
    output: str | None,
    as_json: bool,
) -> None:
    """Fit the tissue of a finger to a ramp and hold.

    DATA.csv is your own record of a plate at 30 degrees to the bone, with the columns time (s),
    position (mm) and force (N). Without it the records of the subjects of Pawluk (1997) are fitted.
    Solved presses are cached: an interrupted calibration continues where it stopped. On a coarse
    mesh solid takes some 1.5 minutes of CPU and condensed 15 s; on the standard mesh solid takes
    longer, by one to six presses.
    """
    from fefinger.calibration import jobs
    from fefinger.results.candidate import MECHANICS

    given = {"width": width, "thickness": thickness, "pad_radius": pad_radius}
    size: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    how = {"mechanics": mechanics, "resolution": resolution, "frames": frames, "check": check}
    todo = jobs.jobs(data, subjects, size, how)
    with jobs.folders(todo, output) as folders:
        with console.progress() as report:
            calibrations = jobs.run(todo, workers, report)

        def text(record: console.Record) -> str:
            told = console.with_files("\n\n".join(map(repr, calibrations)), record)
            finite = all(MECHANICS[each.mechanics].finite for each in calibrations)
            return told if finite else f"{told}\n{NO_TISSUE}"

        console.save_and_print(
            lambda: jobs.save(calibrations, folders),
            lambda files: {"calibrations": [c.record() for c in calibrations], "files": files},
            text,
            as_json=as_json,
        )


@click.command()
@click.argument("data", metavar="DATA.csv")
@click.option(
    "--terms",
    default=3,
    type=click.IntRange(1, 5),
    help="Number of exponentials of the relaxation function.",
)
@output_option("fit.json and fit.csv")
@json_option
def fit(data: str, terms: int, output: str | None, as_json: bool) -> None:
    """Identify the lumped model of a finger from a ramp and hold.

    DATA.csv has the columns time (s), position (mm) and force (N).
    """
    from fefinger.calibration import lumped_fit
    from fefinger.support import outputs

    with outputs.output(output) as folder:
        if folder is not None:
            lumped_fit.keep_others(folder)
        identified = lumped_fit.fit(data, terms=terms)
        console.save_and_print(
            lambda: [] if folder is None else lumped_fit.save(identified, folder),
            lambda files: lumped_fit.record(identified) | {"files": files},
            partial(console.with_files, lumped_fit.summary(identified)),
            as_json=as_json,
        )
