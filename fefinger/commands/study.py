"""`fefinger study`: answer a grid of scenes side by side."""

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

GOES_ON = "the same command goes on from the scenes that are finished"


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
    help="Tell of this force or depth on loading too, by default 1N and 1mm (repeatable).",
)
@changes_option
@click.option(
    "--mechanics",
    metavar="NAME|each",
    help="Use this one, not the cheapest that answers all, on one mesh too; each: the cheapest, "
    "scene by scene.",
)
@click.option("--workers", type=int, metavar="N", help="Processes, by default one per core.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler to use instead.")
@click.option(
    "--table",
    "tables",
    multiple=True,
    metavar="FILE",
    help="Write the table to this .csv, .parquet or .nc file too (repeatable).",
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
    """Answer a grid of scenes side by side.

    SCENE is answered for every combination of the values of --over. With -o, scenes that are
    finished are kept: the same command goes on where it was stopped.
    """
    from fefinger.scene.builtin import settings
    from fefinger.studies.grid import parse_over
    from fefinger.studies.study import AT
    from fefinger.studies.study import study as answer
    from fefinger.studies.tables import check, write

    over, changed = parse_over(grid), settings(changes)
    for file in tables:
        check(file, "--table")
    kept = advice(GOES_ON) if output is not None else nullcontext()
    with kept, console.progress() as report:
        found = answer(
            scene,
            over,
            changes=changed,
            at=at or AT,
            mechanics=mechanics,
            folder=output,
            workers=workers,
            scheduler=scheduler,
            progress=report,
        )
    asked = {"--over": grid, "--at": at, "--set": changes}
    command = _command(scene, asked, mechanics)
    found = replace(found, about={"command": command, **found.about})
    files: list[str] = []
    try:
        files += [] if output is None else _saved(found, output)
        files += [write(found, file, "--table") for file in tables]
    finally:  # the answers are told, also where they cannot be saved
        record = console.study_record(found, files)
        if as_json:
            console.print_json(record)
        else:
            click.echo(console.study_summary(record))
    return FAILED if found.failures else DONE


def _command(scene: str, asked: dict[str, tuple[str, ...]], mechanics: str | None) -> str:
    """Return the command that asks the same again, wherever and with however many processes."""
    words = [word for option, texts in asked.items() for text in texts for word in (option, text)]
    words += ["--mechanics", mechanics] if mechanics else []
    return shlex.join(["fefinger", "study", scene, *words])


def _saved(found: "Study", output: str) -> list[str]:
    """Save a study, and tell where the table of other scenes is that was there."""
    from fefinger.studies.tables import NAMES

    files = found.save(output)
    for folder in dict.fromkeys(str(Path(file).parent) for file in files[len(NAMES) :]):
        click.echo(f"kept: the table of other scenes that was there is now in {folder}", err=True)
    return files
