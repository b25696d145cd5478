"""`fefinger cache`: see and prune what is kept to be used again."""

from typing import Any

import click

from fefinger.commands import console
from fefinger.commands.options import json_option


@click.command()
@click.option("--prune", "days", type=float, metavar="DAYS", help="Remove what was unused so long.")
@json_option
def cache(days: float | None, as_json: bool) -> None:
    """See and prune what is kept to be used again.

    Meshes that were built, operators of condensed fingers (a few hundred MB each), patches, one
    for every indenter and set of end organs, and presses of a calibration (small). Beyond 10 GB
    of operators and 2 GB of patches the least recently used go by themselves. All is made anew
    when it is needed; `--prune 0` removes everything.
    """
    from fefinger.support import cache as kept
    from fefinger.support.checks import number

    removed: tuple[kept.Entry, ...] = ()
    if days is not None:
        removed = kept.remove(kept.unused(number("--prune", days, at_least=0, unit="days")))
    record: dict[str, Any] = {
        "folder": str(kept.root()),
        "entries": [console.cache_record(entry) for entry in kept.entries()],
        "removed": [console.cache_record(entry) for entry in removed],
    }
    if as_json:
        console.print_json(record)
    else:
        click.echo(console.cache_summary(record))
