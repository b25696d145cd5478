"""What the commands share: options, exit statuses, progress, and the printing of answers."""

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from fefinger.support.checks import choice
from fefinger.support.text import strict_json


if TYPE_CHECKING:
    from fefinger.support.progress import Progress

DONE, FAILED, UNUSABLE = 0, 1, 2
"""Exit statuses: done, the answer failed its check, invalid input."""

Command = Callable[..., Any]
Record = Mapping[str, Any]
"""An answer as it is printed by --json."""


def changes_option(command: Command) -> Command:
    """Add `--set FIELD=VALUE`, changes to the scene."""
    return click.option(
        "--set",
        "changes",
        multiple=True,
        metavar="FIELD=VALUE",
        help="Change a value of the scene, such as motion.depth=2 (repeatable).",
    )(command)


def types_option(about: str) -> Callable[[Command], Command]:
    """Add `--type TYPE`, types of afferents; `about` is added to the help."""

    def checked(context: object, option: object, types: tuple[str, ...]) -> tuple[str, ...]:
        from fefinger.support.vocabulary import TYPE_SYNONYMS, TYPES

        return tuple(choice("--type", kind, TYPES, TYPE_SYNONYMS) for kind in types)

    text = f"SAI, SAII, FAI or FAII ({about})."
    return click.option(
        "--type", "types", multiple=True, metavar="TYPE", help=text, callback=checked
    )


def json_option(command: Command) -> Command:
    """Add `--json`, the answer as JSON on standard output."""
    return click.option("--json", "as_json", is_flag=True, help="Print JSON.")(command)


def output_option(what: str) -> Callable[[Command], Command]:
    """Add `-o DIR`, the output folder; `what` is named in the help."""
    return click.option("-o", "--output", metavar="DIR", help=f"Folder to write {what} to.")


def silent(stage: str, fraction: float) -> None:
    """Ignore progress."""


@contextmanager
def progress() -> "Iterator[Progress | None]":
    """Yield a progress callback that draws bars on standard error; None outside a terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress as Bars
    from rich.progress import TaskID

    with Bars(console=Console(stderr=True), transient=True) as bars:
        tasks: dict[str, TaskID] = {}

        def report(stage: str, fraction: float) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=1.0)
            bars.update(tasks[stage], completed=fraction)

        yield report


def remark(line: str) -> None:
    """Print a line on standard error if that is a terminal."""
    if sys.stderr.isatty():
        click.echo(line, err=True)


def print_answer(record: object, text: str, *, as_json: bool) -> None:
    """Print the answer of a command: its record as JSON, null where not finite, or else a text."""
    click.echo(strict_json(record) if as_json else text)


def save_and_print(
    save: Callable[[], Iterable[str]],
    record: Callable[[list[str]], Record],
    text: Callable[[Record], str],
    *,
    as_json: bool,
) -> None:
    """Save an answer and print it, also where saving it fails.

    `save` gives the paths of the files, which `record` takes; `text` is made of the record.
    """
    files: list[str] = []
    try:
        files.extend(save())
    finally:
        saved = record(files)
        print_answer(saved, text(saved), as_json=as_json)


def with_files(text: str, record: Record) -> str:
    """Return a text with a line for each of the files in a record."""
    return "\n".join([text, *(f"file  {file}" for file in record["files"])])


def short(value: object) -> str:
    """Format a value with at most four digits."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)
