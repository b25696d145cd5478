"""`fefinger spikes` and `fefinger field`: spikes of a series of your own, receptive fields."""

from functools import partial
from typing import TYPE_CHECKING

import click

from fefinger.commands import console
from fefinger.commands.console import (
    Record,
    changes_option,
    json_option,
    output_option,
    short,
    types_option,
)
from fefinger.support.checks import InputError
from fefinger.support.text import table


if TYPE_CHECKING:
    from fefinger.neural.trains import SpikeTrains
    from fefinger.studies.receptive_field import ReceptiveField

OPTIONS = {
    "types": "--type",
    "length": "--length",
    "tolerance": "--tolerance",
    "family": "--afferents",
    "trial": "--trial",
}
"""Options by the argument of `neural.series.fire` that its messages name."""


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
    (repeatable, by default all that the sampling rate allows, from 1200 Hz on all four); one named
    FAI_displacement_mm drives a unit of FAI alone. Displacement is positive into the skin. Strain
    is positive where it excites: compression for SAI and FAII, stretch of the skin for SAII and
    FAI. For the afferents recorded a pin 1 mm wide causes it.
    """
    from fefinger.neural import series
    from fefinger.neural.signals import read
    from fefinger.support import atomic_write
    from fefinger.support.vocabulary import FAMILIES

    signals = read(source)
    with atomic_write.output(output) as folder:
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
        console.save_and_print(
            lambda: [] if folder is None else series.save(trains, folder),
            partial(spikes_record, trains),
            spikes_summary,
            as_json=as_json,
        )


def spikes_record(trains: "SpikeTrains", files: list[str]) -> Record:
    """Return the record of `fefinger spikes`, with None where a unit has too few spikes."""
    span = trains.t_stop - trains.t_start
    units = [
        {
            "name": trains.names[i],
            "type": trains.types[i],
            "spikes": len(times),
            "mean_rate_Hz": len(times) / span,
            "peak_rate_Hz": float(1.0 / (times[1:] - times[:-1]).min()) if len(times) > 1 else None,
            "first_spike_s": float(times[0]) if len(times) else None,
            "block_s": float(trains.block_seconds[i]),
        }
        for i, times in enumerate(trains.times)
    ]
    return {"units": units, "notes": list(trains.notes), "files": files}


def spikes_summary(record: Record) -> str:
    """Return a table of the units in a record, then notes and files."""
    keys = ("spikes", "mean_rate_Hz", "peak_rate_Hz", "first_spike_s")
    rows = [
        (unit["name"], unit["type"], *("" if unit[k] is None else short(unit[k]) for k in keys))
        for unit in record["units"]
    ]
    below = [(kind, each) for kind in ("note", "file") for each in record[f"{kind}s"]]
    text = table(rows, ("unit", "type", "spikes", "mean Hz", "peak Hz", "first s"))
    return f"{text}\n{table(below)}" if below else text


@click.command()
@click.argument("scene", default="pin-hold")
@types_option("repeatable, by default SAI and FAI")
@click.option(
    "--reach",
    type=float,
    default=3.0,
    metavar="MM",
    help="Half the side length of the square grid.",
)
@click.option(
    "--spacing", type=float, default=1.0, metavar="MM", help="Spacing of the grid positions."
)
@click.option(
    "--seed", type=int, default=0, metavar="N", help="Seed of the random places of the end organs."
)
@click.option("--mechanics", metavar="NAME", help="Use this mechanics.")
@output_option("field.csv and field.svg")
@changes_option
@json_option
def field(
    scene: str,
    types: tuple[str, ...],
    reach: float,
    spacing: float,
    seed: int,
    mechanics: str | None,
    output: str | None,
    changes: tuple[str, ...],
    as_json: bool,
) -> None:
    """Compute receptive fields of units.

    Presses the object of SCENE at places around one unit of each TYPE. SCENE has an object with a
    place, as a pin or a sphere (default: pin-hold).
    """
    from fefinger.scene import builtin
    from fefinger.studies.receptive_field import keep_others, receptive_field
    from fefinger.support import atomic_write

    loaded = builtin.load(scene, builtin.settings(changes))
    with atomic_write.output(output) as folder:
        if folder is not None:
            keep_others(folder)
        with console.progress() as report:
            answer = receptive_field(
                loaded,
                types or ("SAI", "FAI"),
                reach=reach,
                spacing=spacing,
                seed=seed,
                mechanics=mechanics,
                progress=report,
            )
        console.save_and_print(
            lambda: [] if output is None else answer.save(output),
            lambda files: answer.record() | {"files": files},
            partial(field_summary, answer),
            as_json=as_json,
        )


def field_summary(answer: "ReceptiveField", record: Record) -> str:
    """Describe a receptive field, with the files in its record."""
    lines = [f"{answer.scene} by {answer.mechanics}, {len(answer.places)} places"]
    lines += [
        f"{kind}: at most {answer.of(kind).max()} impulses, half of them or more within "
        f"{answer.area(kind):.3g} mm², one or more within {answer.area(kind, 0.0):.3g} mm²"
        for kind in answer.kinds
    ]
    if answer.left_out:
        count, reason = len(answer.left_out), answer.left_out[0][1]
        lines.append(f"left out: {count} of the places of the square, as {reason}")
    return "\n".join([*lines, *(f"wrote {file}" for file in record["files"])])
