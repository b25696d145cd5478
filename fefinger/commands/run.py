"""`fefinger run`: answer SCENE: force, pressure, strain and spikes."""

import time

import click

from fefinger import console
from fefinger.checks import Stopped
from fefinger.commands.options import changes_option, json_option, output_option


@click.command()
@click.argument("scene")
@output_option("the result, its pictures and its report")
@click.option("--mechanics", metavar="NAME", help="Use this mechanics, not the cheapest.")
@changes_option
@json_option
def run(
    scene: str, output: str | None, mechanics: str | None, changes: tuple[str, ...], as_json: bool
) -> None:
    """Answer SCENE: force, pressure, strain and spikes."""
    from fefinger import files, scenes
    from fefinger.run import run as answer
    from fefinger.waves import quasistatic

    asked = scenes.load(scene, scenes.settings(changes))
    with files.output(output), console.progress() as report:
        try:
            result = answer(asked, mechanics=mechanics, progress=report)
        except Stopped as stop:
            if output is not None:
                click.echo(f"kept: {', '.join(stop.reached.save(output))}", err=True)
            raise
        seconds, written = dict(result.seconds), list[str]()
        if output is not None:
            started = time.perf_counter()
            written = result.save(output)
            seconds["save"] = time.perf_counter() - started
    for warning in quasistatic(asked, result.time, result.depth):
        click.echo(warning, err=True)
    if as_json:
        console.print_json(console.run_record(result, seconds, written))
    else:
        click.echo(console.run_summary(result, seconds, written))
