"""`fefinger scenes`: list the built-in scenes, or print one."""

import click

from fefinger.commands import console
from fefinger.commands.options import json_option
from fefinger.support.text import table


@click.command()
@click.argument("name", required=False)
@json_option
def scenes(name: str | None, as_json: bool) -> None:
    """List the built-in scenes, or print one.

    Prints the scene called NAME as TOML, to start a scene of your own from.
    """
    from fefinger.scene import builtin as library

    if name is not None:
        text = library.text(name)
        if as_json:
            console.print_json(library.load(name).to_dict())
        else:
            click.echo(text, nl=False)
        return
    rows = [(each, library.summary(each)) for each in library.names()]
    if as_json:
        console.print_json({"scenes": [{"name": n, "summary": summary} for n, summary in rows]})
    else:
        click.echo(table(rows))
