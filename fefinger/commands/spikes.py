"""`fefinger spikes`: fire afferent units from a series of one's own."""

import click

from fefinger.commands import console
from fefinger.commands.options import json_option, output_option


@click.command()
@click.option("--from", "source", required=True, metavar="SIGNALS.csv", help="Series to read.")
@click.option("--type", "types", multiple=True, metavar="TYPE", help="SAI, SAII, FAI or FAII.")
@click.option("--length", type=float, metavar="MM", help="Displacement that a strain of 1 means.")
@click.option("--corners", is_flag=True, help="Lines between coarse samples are meant as they are.")
@click.option("--tolerance", type=float, metavar="MS", help="Error of spike times in ms.")
@output_option("spikes.csv and spikes.npz")
@json_option
def spikes(
    source: str,
    types: tuple[str, ...],
    length: float | None,
    corners: bool,
    tolerance: float | None,
    output: str | None,
    as_json: bool,
) -> None:
    """Fire afferent units from a series of one's own.

    SIGNALS.csv has a column time (s) and others whose names end with displacement_mm,
    displacement_um or strain, as in left_displacement_mm. Each drives a unit of every TYPE
    (repeatable, by default all four); one named FAI_displacement_mm drives a unit of FAI alone.
    Displacement is positive into the skin, strain where it excites: compression for SAI and FAII,
    stretch of the skin for SAII and FAI.
    """
    from fefinger.neural import series
    from fefinger.support import outputs

    signals = series.read(source)
    with outputs.output(output) as folder:
        trains = series.fire(signals, types, length=length, corners=corners, tolerance=tolerance)
        files: list[str] = []
        try:
            files = [] if folder is None else series.save(trains, folder)
        finally:  # the answer is told, also where it cannot be saved
            record = console.spikes_record(trains, files)
            if as_json:
                console.print_json(record)
            else:
                click.echo(console.spikes_summary(record))
