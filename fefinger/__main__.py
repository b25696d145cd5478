"""The command line: `fefinger ...` and `python -m fefinger ...`.

Exit status: 0 done, 1 the answer failed its check, 2 unusable input, 130 interrupted. Standard
output has the answer alone; progress, warnings and errors go to standard error.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from fefinger import console
from fefinger.checks import ConvergenceError, InputError, Stopped
from fefinger.interrupt import INTERRUPTED, MESSAGE, interruptible
from fefinger.version import VERSION


DONE, FAILED, UNUSABLE = 0, 1, 2

Command = Callable[..., Any]


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status; without arguments, for the process."""
    if arguments is None:
        return interruptible(lambda: main(sys.argv[1:]))
    try:
        status = cli.main(args=arguments, prog_name="fefinger", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except InputError as error:
        click.echo(f"error: {error}", err=True)
        return UNUSABLE
    except ConvergenceError as error:
        click.echo(f"failed: {error}", err=True)
        return FAILED
    except (KeyboardInterrupt, click.Abort):
        click.echo(MESSAGE, err=True)
        return INTERRUPTED
    return int(status or DONE)


def _changes(command: Command) -> Command:
    return click.option(
        "--set",
        "changes",
        multiple=True,
        metavar="FIELD=VALUE",
        help="Change a value of the scene, as in --set motion.depth=2 (repeatable).",
    )(command)


def _json(command: Command) -> Command:
    return click.option("--json", "as_json", is_flag=True, help="Print JSON.")(command)


def _output(what: str) -> Callable[[Command], Command]:
    return click.option("-o", "--output", metavar="DIR", help=f"Folder to write {what} to.")


def _silent(stage: str, fraction: float) -> None:
    """Report nothing."""


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(VERSION)
def cli() -> None:
    """Touch with a finite-element fingertip, and read the spikes of its nerve fibers.

    SCENE is the name of a built-in scene (`fefinger scenes` lists them) or a TOML file.
    """


@cli.command()
@click.argument("scene")
@_output("the result, its pictures and its report")
@click.option("--mechanics", metavar="NAME", help="Use this mechanics, not the cheapest.")
@_changes
@_json
def run(
    scene: str, output: str | None, mechanics: str | None, changes: tuple[str, ...], as_json: bool
) -> None:
    """Answer SCENE: force, pressure, strain and spikes."""
    from fefinger import scenes
    from fefinger.run import run as answer

    asked = scenes.load(scene, scenes.settings(changes))
    if output is not None:
        from fefinger.files import output_folder

        output_folder(output)
    with console.progress() as report:
        try:
            result = answer(asked, mechanics=mechanics, progress=report)
        except Stopped as stop:
            if output is not None:
                click.echo(f"kept: {', '.join(stop.reached.save(output))}", err=True)
            raise
        seconds, files = dict(result.seconds), []
        if output is not None:
            started = time.perf_counter()
            files = result.save(output)
            seconds["save"] = time.perf_counter() - started
    if as_json:
        console.print_json(console.run_record(result, seconds, files))
    else:
        click.echo(console.run_summary(result, seconds, files))


@cli.command()
@click.argument("scene")
@_changes
@_json
def explain(scene: str, changes: tuple[str, ...], as_json: bool) -> None:
    """Say which mechanics would answer SCENE.

    With how well and how fast it would, and why the others would not.
    """
    from fefinger import plan, scenes

    found = plan.explain(scenes.load(scene, scenes.settings(changes)))
    if as_json:
        console.print_json(console.plan_record(found))
    else:
        click.echo(console.plan_summary(found))


@cli.command()
@click.argument("name", required=False)
@_json
def scenes(name: str | None, as_json: bool) -> None:
    """List the built-in scenes, or print one.

    The scene called NAME is printed as TOML to start from.
    """
    from fefinger import scenes as library

    if name is not None:
        text = library.text(name)
        if as_json:
            console.print_json(library.load(name).to_dict())
        else:
            click.echo(text, nl=False)
        return
    rows = [(known, library.summary(known)) for known in library.names()]
    if as_json:
        console.print_json({"scenes": [{"name": n, "summary": summary} for n, summary in rows]})
    else:
        click.echo(console.table(rows))


@cli.command()
@click.argument("scene", default="flat-press")
@click.option("--whole", is_flag=True, help="The whole finger, not the half that is enough.")
@click.option("-o", "--output", metavar="FILE.vtu", help="File to write the mesh to.")
@click.option("--picture", metavar="PNG", help="Draw the mesh.")
@_changes
@_json
def mesh(
    scene: str,
    whole: bool,
    output: str | None,
    picture: str | None,
    changes: tuple[str, ...],
    as_json: bool,
) -> None:
    """Build, check and draw a finger mesh.

    Takes the ready mesh of the finger of SCENE if there is one.
    """
    from fefinger import scenes
    from fefinger.files import output_folder
    from fefinger.mesh import files, quality
    from fefinger.mesh.ready import ready

    finger = scenes.load(scene, scenes.settings(changes)).finger
    for path in (output, picture):
        if path is not None:
            output_folder(Path(path).parent)
    built = ready(finger, half=not whole, progress=lambda line: click.echo(line, err=True))
    quality.gate(built.quality)
    if output is not None:
        files.write(built, output)
    if picture is not None:
        from fefinger import view

        view.draw_mesh(built, picture)
    if as_json:
        console.print_json(console.mesh_record(built))
    else:
        click.echo(console.mesh_summary(built))


@cli.command()
@click.option("--from", "source", required=True, metavar="SIGNALS.csv", help="Series to read.")
@click.option("--type", "types", multiple=True, metavar="TYPE", help="SAI, SAII, FAI or FAII.")
@click.option("--length", type=float, metavar="MM", help="Displacement that a strain of 1 means.")
@click.option("--corners", is_flag=True, help="Lines between coarse samples are meant as they are.")
@click.option("--tolerance", type=float, metavar="MS", help="Error of spike times in ms.")
@_output("spikes.csv and spikes.npz")
@_json
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
    from fefinger import spikes as series
    from fefinger.files import output_folder

    signals = series.read(source)
    folder = None if output is None else output_folder(output)
    trains = series.fire(signals, types, length=length, corners=corners, tolerance=tolerance)
    files = [] if folder is None else series.save(trains, folder)
    record = console.spikes_record(trains, files)
    if as_json:
        console.print_json(record)
    else:
        click.echo(console.spikes_summary(record))


@cli.command()
@click.argument("folder", metavar="DIR")
@click.option("--field", metavar="NAME", help="What to color the finger by.")
@click.option("--time", "at", type=float, metavar="T", help="Time in s, else the largest force.")
@click.option("--screenshot", metavar="PNG", help="Draw to this file instead of a window.")
def view(folder: str, field: str | None, at: float | None, screenshot: str | None) -> None:
    """Look at the strain or the pressure in DIR.

    DIR is a folder that `fefinger run -o` wrote.
    """
    from fefinger import view as pictures
    from fefinger.checks import number
    from fefinger.files import load, output_folder

    result = load(folder)
    shown = pictures.DEFAULT if field is None else field
    if at is not None:
        number("--time", at, at_least=0, at_most=float(result.time[-1]), unit="s")
    if screenshot is None:
        pictures.show(result, field=shown)
        return
    output_folder(Path(screenshot).parent)
    pictures.screenshot(result, screenshot, field=shown, time=at)
    click.echo(screenshot)


@cli.command()
@click.option("-o", "output", metavar="FILE", help="Record a .gif or .mp4 instead of a window.")
@click.option("--subject", default="a.h.", metavar="NAME", help="Whose finger, a.h. by default.")
@click.option("--resolution", default="standard", metavar="MESH", help="coarse or standard.")
def live(output: str | None, subject: str, resolution: str) -> None:
    """Watch a finger being pressed and rolled.

    Pressure, strain in the medial section and spikes as they are computed. The first time, the
    finger is condensed, which takes about a minute.
    """
    from fefinger import live as shows
    from fefinger.files import output_folder
    from fefinger.finger import Finger

    finger = Finger.subject(subject, resolution=resolution)
    if output is None:
        last = shows.watch(finger)
    else:
        output_folder(Path(output).parent)
        last = shows.record(finger, Path(output))
    click.echo(
        f"{last.steps} steps of {1e3 * shows.DT:g} ms at {last.rate:.0f} steps/s, "
        f"{len(last.spikes)} spikes" + (f": {output}" if output else "")
    )


@cli.command()
@click.argument("data", metavar="DATA.csv")
@click.option("--terms", default=3, type=click.IntRange(1, 5), help="Exponentials in G, 3.")
@_output("fit.json and fit.csv")
@_json
def fit(data: str, terms: int, output: str | None, as_json: bool) -> None:
    """Identify the lumped finger from a ramp and hold.

    DATA.csv has the columns time (s), position (mm) and force (N).
    """
    from fefinger import fitting
    from fefinger.files import output_folder

    folder = None if output is None else output_folder(output)
    found = fitting.fit(data, terms=terms)
    files = [] if folder is None else fitting.save(found, folder)
    if as_json:
        console.print_json(fitting.record(found) | {"files": files})
    else:
        click.echo("\n".join([fitting.summary(found), *(f"file  {file}" for file in files)]))


@cli.command()
@click.argument("suites", nargs=-1)
@click.option("--quick", is_flag=True, help="Leave out what takes longer than seconds.")
@_output("validation.json and validation.html")
@_json
def validate(suites: tuple[str, ...], quick: bool, output: str | None, as_json: bool) -> int:
    """Compare with theory and published numbers.

    Runs all suites, or the SUITES named.
    """
    from fefinger.files import output_folder
    from fefinger.validation import suites as every

    folder = None if output is None else output_folder(output)
    with console.progress() as report:
        record = every.as_json(every.run(suites, quick=quick, progress=report or _silent))
    if folder is not None:
        from fefinger import validation_report
        from fefinger.validation.provenance import provenance

        pictures = every.figures([suite["suite"] for suite in record["suites"]])
        words = ["fefinger validate", *suites, *(["--quick"] if quick else [])]
        validation_report.save(record, folder, pictures, provenance(" ".join(words)))
    if as_json:
        console.print_json(record)
    else:
        click.echo(console.validation_summary(record))
    verdicts = {case["verdict"] for suite in record["suites"] for case in suite["cases"]}
    return FAILED if "fail" in verdicts else DONE


@cli.command()
@click.argument("suites", nargs=-1)
@_output("bench-SUITE.json")
@_json
def bench(suites: tuple[str, ...], output: str | None, as_json: bool) -> None:
    """Measure speed and accuracy.

    Runs all suites, or the SUITES named, each against a baseline in the same run.
    """
    from fefinger import bench as benchmarks
    from fefinger.files import output_folder

    folder = None if output is None else output_folder(output)
    with console.progress() as report:
        measured = benchmarks.run(suites, progress=report or _silent)
    if folder is not None:
        for suite, figures in measured.items():
            benchmarks.write(suite, figures, folder)
    record = benchmarks.as_json(figure for figures in measured.values() for figure in figures)
    if as_json:
        console.print_json(record)
    else:
        click.echo(console.bench_summary(record))


if __name__ == "__main__":
    sys.exit(main())
