"""`fefinger run`: answer a scene with force, pressure, strain and spikes."""

import time

import click

from fefinger.commands import console
from fefinger.commands.options import changes_option, json_option, output_option
from fefinger.support.checks import InputError, Stopped


@click.command()
@click.argument("scene")
@output_option("the result, its pictures and its report")
@click.option(
    "--mechanics",
    metavar="NAME",
    help="Use this mechanics instead of the cheapest one that is accurate enough.",
)
@changes_option
@click.option("-v", "--verbose", is_flag=True, help="Print notes, stages and the choice too.")
@json_option
def run(
    scene: str,
    output: str | None,
    mechanics: str | None,
    changes: tuple[str, ...],
    verbose: bool,
    as_json: bool,
) -> None:
    """Answer SCENE with force, pressure, strain and spikes.

    Ends with the numbers that matter and their expected errors; how they were reached and what was
    left out is in the report, or printed by -v.
    """
    from fefinger.pipeline import run as answer
    from fefinger.result import earlier
    from fefinger.scene import builtin
    from fefinger.support import outputs

    loaded = builtin.load(scene, builtin.settings(changes))
    with outputs.output(output):
        replaced = bool(earlier(output)) if output is not None else False
        with console.progress() as report:
            try:
                result = answer(loaded, mechanics=mechanics, progress=report)
            except Stopped as stop:
                if output is not None:
                    _save_partial(stop, output, replaced=replaced)
                raise
        seconds, written = dict(result.seconds), list[str]()
        try:
            if output is not None:
                started = time.perf_counter()
                written = result.save(output)
                seconds["save"] = time.perf_counter() - started
                _tell(output, replaced=replaced)
        finally:  # print the answer also where saving it fails
            for warning in result.warnings:
                click.echo(warning, err=True)
            record = console.run_record(result, seconds, written)
            text = console.run_summary(result, seconds, written, verbose=verbose)
            console.print_answer(record, text, as_json=as_json)


def _tell(output: str, *, replaced: bool) -> None:
    if replaced:
        click.echo(f"replaced an earlier result in {output}", err=True)


def _save_partial(stop: Stopped, output: str, *, replaced: bool) -> None:
    """Save the partial result of a run that stopped early, and print where or why not."""
    try:
        click.echo(f"saved up to there: {', '.join(stop.reached.save(output))}", err=True)
        _tell(output, replaced=replaced)
    except InputError as error:  # the caller still raises the reason of the stop
        click.echo(f"not saved: {error}", err=True)
