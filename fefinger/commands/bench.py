"""`fefinger bench`: measure speed and accuracy against a baseline."""

import click

from fefinger.commands import console
from fefinger.commands.options import json_option, output_option, silent


@click.command()
@click.argument("suites", nargs=-1)
@output_option("bench-SUITE.json")
@json_option
def bench(suites: tuple[str, ...], output: str | None, as_json: bool) -> None:
    """Measure speed and accuracy.

    Runs all suites, or the SUITES named, each against a baseline in the same run.
    """
    from fefinger.validation.bench import suites as benchmarks

    from fefinger.support.outputs import output_folder

    folder = None if output is None else output_folder(output)
    with console.progress() as report:
        measured = benchmarks.run(suites, progress=report or silent)
    if folder is not None:
        for suite, figures in measured.items():
            benchmarks.write(suite, figures, folder)
    record = benchmarks.as_json(figure for figures in measured.values() for figure in figures)
    console.print_answer(record, console.bench_summary(record), as_json=as_json)
