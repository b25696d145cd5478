"""`fefinger cache`: list and prune the cache of meshes, operators, patches and presses."""

from typing import Any

import click

from fefinger.commands import console
from fefinger.commands.options import json_option


@click.command()
@click.option(
    "--prune", "days", type=float, metavar="DAYS", help="Remove entries unused for this many days."
)
@json_option
def cache(days: float | None, as_json: bool) -> None:
    """List and prune the cache.

    The cache holds meshes, operators of condensed fingers (a few hundred MB each), their modes of
    vibration (50 MB), patches (their parts under one indenter with one set of end organs) and
    presses of a calibration (small). Beyond 10 GB of operators and 2 GB of modes or patches the
    least recently used are removed automatically. Entries are built again when they are needed;
    `--prune 0` removes everything.
    """
    from fefinger.support import cache as store
    from fefinger.support.checks import number

    removed: tuple[store.Entry, ...] = ()
    if days is not None:
        removed = store.remove(store.unused(number("--prune", days, at_least=0, unit="days")))
    record: dict[str, Any] = {
        "folder": str(store.root()),
        "entries": [console.cache_record(entry) for entry in store.entries()],
        "removed": [console.cache_record(entry) for entry in removed],
    }
    console.print_answer(record, console.cache_summary(record), as_json=as_json)
