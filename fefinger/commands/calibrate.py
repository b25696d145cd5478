"""`fefinger calibrate` and `fefinger fit`: a tissue or a lumped model from records of presses."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fefinger.commands import console
from fefinger.commands.console import json_option, output_option


if TYPE_CHECKING:
    from fefinger.calibration.rig import Rig
    from fefinger.scene.finger import Finger
    from fefinger.scene.indenter import Indenter

NO_TISSUE = "no tissue.toml is written: t(u) scales the force, not a tissue; use --mechanics solid"


def column_option(command: console.Command) -> console.Command:
    """Add `--column QUANTITY=HEADER`, a column that cannot be told by its name."""
    return click.option(
        "--column",
        "columns",
        multiple=True,
        metavar="QUANTITY=HEADER",
        callback=_named,
        help="Header or number of a column, such as 'force=channel 2 in mN' (repeatable).",
    )(command)


def _named(context: object, option: object, given: tuple[str, ...]) -> dict[str, str]:
    from fefinger.support.checks import InputError

    pairs = [each.partition("=") for each in given]
    for quantity, sign, header in pairs:
        if not (quantity and sign and header):
            raise InputError(
                "--column: expected QUANTITY=HEADER, such as 'force=channel 2 in mN', received "
                f"{quantity + sign + header!r}"
            )
    return {quantity.strip(): header.strip() for quantity, _, header in pairs}


@click.command()
@click.argument("data", metavar="DATA.csv...", nargs=-1)
@click.option("--subject", metavar="NAME", help="Subject of Pawluk (1997) whose finger size it is.")
@click.option("--width", type=float, help="Width of the fingertip in DATA.csv in mm.")
@click.option("--thickness", type=float, help="Thickness of that fingertip in mm.")
@click.option("--pad-radius", type=float, help="Effective pad radius of that fingertip in mm.")
@click.option("--frames", metavar="FILE", help="CSV of a slow press: time, position, p1 to p64.")
@click.option("--check", metavar="FILE", help="Record of a press or motion to predict, not to fit.")
@column_option
@click.option("--rig", metavar="FILE", help="TOML file of what the rig does, such as its delay.")
@click.option(
    "--indenter",
    "objects",
    multiple=True,
    metavar="TABLE",
    help="What pressed, as 'kind=\"sphere\", radius=5' or 'angle=0'; once, or for each DATA and "
    "then --check; by default the plate at 30 degrees.",
)
@click.option("--delay", type=float, help="Time in ms by which the force is late; else fitted.")
@click.option("--design", is_flag=True, help="Say what presses would tell, before the experiment.")
@click.option(
    "--mechanics",
    default="solid",
    help="solid, or condensed (small strain, times the stiffening t(u) of the thesis).",
)
@click.option(
    "--resolution", default="standard", help="Mesh of the last step: coarse, standard, fine."
)
@output_option("calibration.json, its page and, by solid, tissue.toml")
@json_option
def calibrate(
    data: tuple[str, ...],
    subject: str | None,
    width: float | None,
    thickness: float | None,
    pad_radius: float | None,
    frames: str | None,
    check: str | None,
    columns: dict[str, str],
    rig: str | None,
    objects: tuple[str, ...],
    delay: float | None,
    design: bool,
    mechanics: str,
    resolution: str,
    output: str | None,
    as_json: bool,
) -> None:
    """Fit the tissue of a finger to a ramp and hold.

    DATA.csv is your own record of a plate at 30 degrees to the bone, or of --indenter, with the
    columns time, position and force, in any order and unit: text, .lvm, .mat or HDF5. Several
    presses of one finger, at other speeds or depths or by other objects, are fitted together.
    Solved presses are cached: an interrupted calibration continues where it stopped. On a coarse
    mesh solid takes some 1.5 minutes of CPU for each object and condensed 15 s; on the standard
    mesh solid takes longer, by one to six presses.
    """
    from fefinger.calibration import calibrate as calibration
    from fefinger.calibration.record import PAGE_FILE, keep_others
    from fefinger.calibration.rig import Rig
    from fefinger.calibration.slow_press import PLATE
    from fefinger.calibration.targets import finger_of
    from fefinger.pages import calibration_page
    from fefinger.results.candidate import MECHANICS
    from fefinger.support import atomic_write
    from fefinger.support.checks import InputError

    if not data and not design:
        raise click.MissingParameter(param_type="argument", param_hint="'DATA.csv...'")
    given = {"width": width, "thickness": thickness, "pad_radius": pad_radius}
    size: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    missing = [name for name in ("width", "thickness") if name not in size]
    if subject is None and missing:
        of_data = f" in {data[0]}" if data else ""
        raise InputError(
            f"--{missing[0]}: expected the size of the finger{of_data} in mm, received none; "
            "give --width and --thickness, or --subject"
        )
    finger = finger_of(subject, **size)
    of_rig = Rig() if rig is None else Rig.from_toml(rig)
    if delay is not None:
        of_rig = replace(of_rig, delay=(delay, 0.0))
    if design:
        _design(finger, of_rig, as_json=as_json)
        return
    how: dict[str, Any] = {
        "rig": of_rig,
        "indenter": [_object(each) for each in objects] or PLATE,
        "mechanics": mechanics,
        "resolution": resolution,
        "columns": columns,
    }
    with atomic_write.output(output) as folder:
        if folder is not None:
            keep_others(folder)
        with console.progress() as report:
            found = calibration.calibrate(
                data, finger=finger, frames=frames, check=check, progress=report, **how
            )

        def text(record: console.Record) -> str:
            told = console.with_files(repr(found), record)
            return told if MECHANICS[found.mechanics].finite else f"{told}\n{NO_TISSUE}"

        def save() -> list[str]:
            if folder is None:
                return []
            files = [*found.save(folder), str(folder / PAGE_FILE)]
            calibration_page.write(found, files[-1])
            return files

        console.save_and_print(
            save,
            lambda files: {"calibrations": [found.record()], "files": files},
            text,
            as_json=as_json,
        )


def _object(text: str) -> "Indenter":
    """Return the object of a TOML table without its braces."""
    from fefinger.scene.toml import indenter_of
    from fefinger.support.checks import InputError
    from fefinger.support.inputs import NoSingleValueError, parse_value

    try:
        read = parse_value("--indenter", f"{{{text}}}")
    except NoSingleValueError as error:
        raise InputError(
            f'--indenter: expected keys of an object, such as kind="sphere", radius=5, received '
            f"{text!r}: {error}"
        ) from None
    return indenter_of(read, Path())


def _design(finger: "Finger", rig: "Rig", *, as_json: bool) -> None:
    """Print what presses of a finger by a rig would tell."""
    from dataclasses import asdict

    from fefinger.calibration import design

    with console.progress() as report:
        planned = design.design(finger, rig, progress=report)
    record = {"presses": [asdict(each) for each in planned]}
    console.print_answer(record, design.told(planned), as_json=as_json)


@click.command()
@click.argument("data", metavar="DATA.csv")
@click.option(
    "--terms",
    default=3,
    type=click.IntRange(1, 5),
    help="Number of exponentials of the relaxation function.",
)
@column_option
@output_option("fit.json and fit.csv")
@json_option
def fit(data: str, terms: int, columns: dict[str, str], output: str | None, as_json: bool) -> None:
    """Identify the lumped model of a finger from a ramp and hold.

    DATA.csv has the columns time, position and force, in any order and unit: text, .lvm, .mat or
    HDF5.
    """
    from fefinger.calibration import lumped_fit
    from fefinger.support import atomic_write

    with atomic_write.output(output) as folder:
        if folder is not None:
            lumped_fit.keep_others(folder)
        identified = lumped_fit.fit(data, terms=terms, columns=columns)
        console.save_and_print(
            lambda: [] if folder is None else lumped_fit.save(identified, folder),
            lambda files: lumped_fit.record(identified) | {"files": files},
            partial(console.with_files, lumped_fit.summary(identified)),
            as_json=as_json,
        )
