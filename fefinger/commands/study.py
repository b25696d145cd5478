"""`fefinger study`: answer a grid of scenes in parallel."""

import shlex
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fefinger.commands import console
from fefinger.commands.console import (
    DONE,
    FAILED,
    Record,
    changes_option,
    json_option,
    output_option,
    short,
)
from fefinger.support.interrupt import advice
from fefinger.support.text import brief, percent, table


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

    def save() -> Iterator[str]:
        if output is not None:
            yield from _saved(answered, output)
        for file in tables:
            yield write(answered, file, "--table")

    console.save_and_print(save, partial(study_record, answered), study_summary, as_json=as_json)
    return FAILED if answered.failures else DONE


def _command(scene: str, options: dict[str, tuple[str, ...]], mechanics: str | None) -> str:
    """Return the command line of the study, without output folder and number of processes."""
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


def study_record(study: "Study", files: list[str]) -> Record:
    """Return the record of `fefinger study`."""
    return {
        "scenes": study.scenes,
        "reused": study.reused,
        "failed": [{"scene": values, "error": error} for values, error in study.failures],
        "over": list(study.over),
        "chosen": study.about.get("chosen", ""),
        "rows": list(study.rows),
        "files": files,
    }


STUDY = {
    **{"at": "at", "force_N": "force/N", "force_rel_error": "error", "depth_mm": "depth/mm"},
    **{"contact_area_mm2": "area/mm²", "highest_pressure_1mm2_kPa": "kPa", "spikes": "spikes"},
    **{"shift_distal_mm": "shift/mm", "asymmetry": "asym.", "ellipticity": "ellip."},
    "stiffness_N_per_mm": "N/mm",
}
"""Columns of a study that a terminal shows, with short headings."""


def study_summary(record: Record) -> str:
    """Return a table of the main columns in a record, failed scenes, notes and files."""
    from fefinger.studies.grid import remarks

    available = {name for row in record["rows"] for name in row}
    shown = [*record["over"], *(name for name in STUDY if name in available)]
    finished = [row for row in record["rows"] if row["status"] == "done"]

    def cell(name: str, value: Any) -> str:
        if value is None:
            return ""
        return percent(value) if name == "force_rel_error" else short(value)

    rows = [[cell(name, row.get(name)) for name in shown] for row in finished]
    notes = [record["chosen"], *remarks(record["rows"], record["over"])]
    below = []
    for each in record["failed"]:
        values = ", ".join(f"{field} = {value}" for field, value in each["scene"].items())
        below.append(("failed", f"{values}: {brief(each['error'])}"))
    below += [
        *(("note", note) for note in notes if note),
        *(("file", file) for file in record["files"]),
    ]
    done = record["scenes"] - len(record["failed"])
    used = dict.fromkeys(f"{row['mechanics']} {row.get('mesh') or ''}".strip() for row in finished)
    by = f" by {', '.join(used)}" if used else ""
    total = f"{done} of {record['scenes']} scenes{by}, {record['reused']} of them reused"
    headings = [STUDY.get(name) or _heading(name, record["over"]) for name in shown]
    return "\n".join([table(rows, headings), total, *([table(below)] if below else [])])


def _heading(name: str, names: list[str]) -> str:
    """Return a short heading of a column, without the name of its table if others differ."""
    from fefinger.scene.schema import split

    last, unit = split(name.rpartition(".")[2])
    alone = sum(other.rpartition(".")[2] == name.rpartition(".")[2] for other in names) == 1
    if not alone:
        last, unit = split(name)
    return f"{last}/{unit}" if unit else last
