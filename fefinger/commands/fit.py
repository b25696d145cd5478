"""`fefinger fit`: identify the lumped model of a finger from a measured ramp and hold."""

import click

from fefinger.commands import console
from fefinger.commands.options import json_option, output_option


@click.command()
@click.argument("data", metavar="DATA.csv")
@click.option(
    "--terms", default=3, type=click.IntRange(1, 5), help="Exponentials in G, by default 3."
)
@output_option("fit.json and fit.csv")
@json_option
def fit(data: str, terms: int, output: str | None, as_json: bool) -> None:
    """Identify the lumped model of a finger from a ramp and hold.

    DATA.csv has the columns time (s), position (mm) and force (N).
    """
    from fefinger.calibration import lumped_fit
    from fefinger.support import outputs

    with outputs.output(output) as folder:
        identified = lumped_fit.fit(data, terms=terms)
        files: list[str] = []
        try:
            files = [] if folder is None else lumped_fit.save(identified, folder)
        finally:  # print the answer also where saving it fails
            if as_json:
                console.print_json(lumped_fit.record(identified) | {"files": files})
            else:
                lines = [lumped_fit.summary(identified), *(f"file  {file}" for file in files)]
                click.echo("\n".join(lines))
