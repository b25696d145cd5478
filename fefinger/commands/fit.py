"""`fefinger fit`: identify the lumped model of a finger from a measured ramp and hold."""

import click

from fefinger.commands import console
from fefinger.commands.options import json_option, output_option


@click.command()
@click.argument("data", metavar="DATA.csv")
@click.option(
    "--terms",
    default=3,
    type=click.IntRange(1, 5),
    help="Number of exponentials of the relaxation function.",
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
        if folder is not None:
            lumped_fit.keep_others(folder)
        identified = lumped_fit.fit(data, terms=terms)
        files: list[str] = []
        try:
            files = [] if folder is None else lumped_fit.save(identified, folder)
        finally:  # print the answer also where saving it fails
            record = lumped_fit.record(identified) | {"files": files}
            lines = [lumped_fit.summary(identified), *(f"file  {file}" for file in files)]
            console.print_answer(record, "\n".join(lines), as_json=as_json)
