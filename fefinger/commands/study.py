"""`fefinger study`: answer a grid of scenes in parallel."""

import shlex
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fefinger.commands import console
from fefinger.commands.options import DONE, FAILED, changes_option, json_option, output_option
from fefinger.support.interrupt import advice


if TYPE_CHECKING:
    from fefinger.studies.study import Study

GOES_ON = "the same command continues from the finished scenes"


@click.command()
@click.argument("scene")
@click.option(
    "--over",
    "grid",
    multiple=True,
    required=True,
    metavar="FIELD=START:STOP:COUNT",
    help="Values of a field, or FIELD=A,B,C (repeatable: every combination).",
)
@click.option(
    "--at",
    multiple=True,
    metavar="FORCE|DEPTH",
    help="Also report at this force or depth on loading, by default 1N and 1mm where they are "
    "reached (repeatable).",
)
@changes_option
@click.option(
    "--mechanics",
    metavar="NAME|each",
    help="Use this mechanics on one mesh, not the cheapest one that answers all scenes; each: the "
    "cheapest for each scene.",
)
@click.option("--workers", type=int, metavar="N", help="Processes, by default one per core.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler to use instead.")
@click.option(
    "--table",
    "tables",
    multiple=True,
    metavar="FILE",
    help="Also write the table to this .csv, .parquet or .nc file (repeatable).",
)
@output_option("the table, its report and the finished scenes")
@json_option
def study(
    scene: str,
    grid: tuple[str, ...],
    at: tuple[str, ...],
    changes: tuple[str, ...],
    mechanics: str | None,
    workers: int | None,
    scheduler: str | None,
    tables: tuple[str, ...],
    output: str | None,
    as_json: bool,
) -> int:
    """Answer a grid of scenes in parallel.

    Answers SCENE for every combination of the values of --over. With -o, finished scenes are
    saved, and the same command continues where it was stopped.
    """
    from fefinger.scene.builtin import settings
    from fefinger.studies.grid import parse_over
    from fefinger.studies.study import study as answer
    from fefinger.studies.tables import check, write

    over, changed = parse_over(grid), settings(changes)
    for file in tables:
        check(file, "--table")
    message = advice(GOES_ON) if output is not None else nullcontext()
    with message, console.progress() as report:
        answered = answer(
            scene,
            over,
            changes=changed,
            at=at,
            mechanics=mechanics,
            folder=output,
            workers=workers,
            scheduler=scheduler,
            progress=report,
        )
    options = {"--over": grid, "--at": at, "--set": changes}
    command = _command(scene, options, mechanics)
    answered = replace(answered, about={"command": command, **answered.about})
    files: list[str] = []
    try:
        files += [] if output is None else _saved(answered, output)
        files += [write(answered, file, "--table") for file in tables]
    finally:  # print the answers also where saving them fails
        record = console.study_record(answered, files)
        console.print_answer(record, console.study_summary(record), as_json=as_json)
    return FAILED if answered.failures else DONE


def _command(scene: str, options: dict[str, tuple[str, ...]], mechanics: str | None) -> str:
    """Command line that repeats the study, without output folder and number of processes."""
    words = [word for option, texts in options.items() for text in texts for word in (option, text)]
    words += ["--mechanics", mechanics] if mechanics else []
    return shlex.join(["fefinger", "study", scene, *words])


def _saved(study: "Study", output: str) -> list[str]:
    """Save a study; print where the table of an earlier study in the folder was moved to."""
    from fefinger.studies.tables import NAMES

    files = study.save(output)
    for folder in dict.fromkeys(str(Path(file).parent) for file in files[len(NAMES) :]):
        click.echo(f"moved: the files of these names that were there are now in {folder}", err=True)
    return files
