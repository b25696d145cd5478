"""`fefinger scenes`: list the built-in scenes, print one, or print the schema of scene files."""

import click

from fefinger.commands import console
from fefinger.commands.options import json_option
from fefinger.support.text import table


@click.command()
@click.argument("name", required=False)
@click.option("--schema", is_flag=True, help="Print the JSON Schema of scene files, for editors.")
@json_option
def scenes(name: str | None, schema: bool, as_json: bool) -> None:
    """List the built-in scenes, or print one.

    Prints the scene called NAME as TOML, to start a scene of your own from. With --schema it prints
    the JSON Schema by which an editor completes and checks scene files; with NAME, a scene or its
    file, the schema has the objects of its plugins too.
    """
    from fefinger.scene import builtin as library

    if schema:
        from fefinger.scene.schema import schema as scene_schema

        if name is not None:
            library.load(name)
        console.print_answer(scene_schema(), "", as_json=True)
        return
    if name is not None:
        text = library.text(name).removesuffix("\n")
        record = library.load(name).to_dict() if as_json else {}  # a text needs no library
        console.print_answer(record, text, as_json=as_json)
        return
    rows = [(each, library.summary(each)) for each in library.names()]
    listed = {"scenes": [{"name": n, "summary": summary} for n, summary in rows]}
    console.print_answer(listed, table(rows), as_json=as_json)
