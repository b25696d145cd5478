"""`fefinger spikes`: spikes of afferent units driven by a displacement or strain series."""

import click

from fefinger.commands import console
from fefinger.commands.options import json_option, output_option, types_option
from fefinger.support.checks import InputError


OPTIONS = {
    "types": "--type",
    "length": "--length",
    "tolerance": "--tolerance",
    "family": "--afferents",
    "trial": "--trial",
}
"""Options by the argument of `neural.series.fire`, at which its messages begin."""


@click.command()
@click.option("--from", "source", required=True, metavar="SIGNALS.csv", help="Series to read.")
@types_option("repeatable, by default all that the sampling rate allows")
@click.option(
    "--length",
    type=float,
    metavar="MM",
    help="Displacement in mm per unit strain; default for the family recorded: the fitted value.",
)
@click.option("--corners", is_flag=True, help="Take straight lines between samples as exact.")
@click.option(
    "--tolerance",
    type=float,
    metavar="MS",
    help="Allowed error of spike times in ms (family thesis only).",
)
@click.option(
    "--afferents",
    metavar="FAMILY",
    help="recorded (the default), fitted to recorded units, thesis, or a family of your own.",
)
@click.option(
    "--trial", type=int, default=0, metavar="N", help="Another trial is other noise of the units."
)
@output_option("spikes.csv, units.csv and spikes.npz")
@json_option
def spikes(
    source: str,
    types: tuple[str, ...],
    length: float | None,
    corners: bool,
    tolerance: float | None,
    afferents: str | None,
    trial: int,
    output: str | None,
    as_json: bool,
) -> None:
    """Compute spikes of afferent units driven by your own series.

    SIGNALS.csv has a column time (s) and columns whose names end with displacement_mm,
    displacement_um or strain, such as left_displacement_mm. Each drives a unit of every TYPE
    (repeatable, by default all that the sampling rate allows, from 1600 Hz on all four); one named
    FAI_displacement_mm drives a unit of FAI alone. Displacement is positive into the skin. Strain
    is positive where it excites: compression for SAI and FAII, stretch of the skin for SAII and
    FAI. For the afferents recorded a pin 1 mm wide causes it.
    """
    from fefinger.neural import series
    from fefinger.neural.signals import read
    from fefinger.support import outputs
    from fefinger.support.vocabulary import FAMILIES

    signals = read(source)
    with outputs.output(output) as folder:
        if folder is not None:
            series.keep_others(folder)
        try:
            trains = series.fire(
                signals,
                types,
                length=length,
                corners=corners,
                tolerance=tolerance,
                family=FAMILIES[0] if afferents is None else afferents,
                trial=trial,
            )
        except InputError as error:
            name, colon, rest = str(error).partition(":")
            raise InputError(f"{OPTIONS.get(name, name)}{colon}{rest}") from error
        files: list[str] = []
        try:
            files = [] if folder is None else series.save(trains, folder)
        finally:  # print the answer also where saving it fails
            record = console.spikes_record(trains, files)
            console.print_answer(record, console.spikes_summary(record), as_json=as_json)
