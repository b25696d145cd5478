"""`fefinger study`: answer a grid of scenes side by side."""

import click

from fefinger import console
from fefinger.commands.options import DONE, FAILED, changes_option, json_option, output_option


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
    help="Tell of this force or depth on loading too, by default 1N and 1mm (repeatable).",
)
@changes_option
@click.option("--mechanics", metavar="NAME", help="Use this mechanics, not the cheapest.")
@click.option("--workers", type=int, metavar="N", help="Processes, by default one per core.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler to use instead.")
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
    output: str | None,
    as_json: bool,
) -> int:
    """Answer a grid of scenes side by side.

    SCENE is answered for every combination of the values of --over. With -o, scenes that are
    finished are kept: the same command goes on where it was stopped.
    """
    from fefinger.scenes import settings
    from fefinger.study import AT
    from fefinger.study import study as answer
    from fefinger.study_grid import parse_over

    over, changed = parse_over(grid), settings(changes)
    try:
        with console.progress() as report:
            found = answer(
                scene,
                over,
                changes=changed,
                at=at or AT,
                mechanics=mechanics,
                folder=output,
                workers=workers,
                scheduler=scheduler,
                progress=report,
            )
    except KeyboardInterrupt:
        if output is not None:
            click.echo("the same command goes on from the scenes that are finished", err=True)
        raise
    files = [] if output is None else found.save(output)
    record = console.study_record(found, files)
    if as_json:
        console.print_json(record)
    else:
        click.echo(console.study_summary(record))
    return FAILED if found.failures else DONE
