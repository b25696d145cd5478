"""Options that several commands share, and the exit statuses."""

from collections.abc import Callable
from typing import Any

import click

from fefinger.support.checks import choice


DONE, FAILED, UNUSABLE = 0, 1, 2

Command = Callable[..., Any]


def changes_option(command: Command) -> Command:
    """Add `--set FIELD=VALUE`, the changes to a scene."""
    return click.option(
        "--set",
        "changes",
        multiple=True,
        metavar="FIELD=VALUE",
        help="Change a value of the scene, such as motion.depth=2 (repeatable).",
    )(command)


def types_option(about: str) -> Callable[[Command], Command]:
    """Add `--type TYPE`, checked types of afferents; `about` is added to the help."""

    def checked(context: Any, option: Any, types: tuple[str, ...]) -> tuple[str, ...]:
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
