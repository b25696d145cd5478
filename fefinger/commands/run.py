"""`fefinger run`, `explain`, `view` and `live`: a scene answered, planned, drawn or pressed."""

import math
import sys
import time
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from fefinger.commands import console
from fefinger.commands.console import Record, changes_option, json_option, output_option
from fefinger.support.checks import InputError, Stopped
from fefinger.support.text import table


if TYPE_CHECKING:
    from fefinger.neural.trains import SpikeTrains
    from fefinger.result import Result
    from fefinger.results.records import Lateral


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
    from fefinger.support import atomic_write

    loaded = builtin.load(scene, builtin.settings(changes))
    with atomic_write.output(output):
        replaced = bool(earlier(output)) if output is not None else False
        with console.progress() as report:
            try:
                result = answer(loaded, mechanics=mechanics, progress=report)
            except Stopped as stop:
                if output is not None:
                    _save_partial(stop, output, replaced=replaced)
                raise
        seconds = dict(result.seconds)

        def save() -> list[str]:
            if output is None:
                return []
            started = time.perf_counter()
            written = result.save(output)
            seconds["save"] = time.perf_counter() - started
            _tell(output, replaced=replaced)
            return written

        def text(record: Record) -> str:
            for warning in result.warnings:
                click.echo(warning, err=True)
            return run_summary(result, seconds, record["files"], verbose=verbose)

        console.save_and_print(save, partial(run_record, result, seconds), text, as_json=as_json)


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


def run_record(result: "Result", seconds: dict[str, float], files: list[str]) -> Record:
    """Return the record of `fefinger run`; area and centroid are at the peak."""
    force, area, centroid = result.force, result.contact_area, result.centroid
    peak = result.peak
    return {
        "status": result.status,
        "mechanics": result.plan.mechanics,
        "peak_force_N": None if force is None else float(force.max()),
        "final_force_N": None if force is None else float(force[-1]),
        "contact_area_mm2": None if area is None else float(area[peak]),
        "centroid_mm": None if centroid is None else [float(x) for x in centroid[peak]],
        **({} if result.lateral is None else slid_record(result.lateral)),
        **({} if result.spikes is None else fired_record(result.spikes, result.unmodeled)),
        "seconds": seconds,
        "files": files,
    }


def slid_record(lateral: "Lateral") -> Record:
    """Return the largest lateral force, and the outcome of friction in words."""
    peak = max(math.hypot(*force) for force in lateral.force.tolist())
    return {"peak_lateral_force_N": peak, "friction": lateral.outcome or None}


def fired_record(trains: "SpikeTrains", unmodeled: tuple[str, ...] = ()) -> Record:
    """Return the family of the afferents, spikes of each type, and the mean rates of its units.

    Rates in Hz are over the time in which spikes count; within: the least and the largest in other
    runs (`SpikeTrains.bounds`); unmodeled: types not to be counted on.
    """
    totals, span = trains.totals(), trains.t_stop - trains.t_start
    rates = {
        kind: [each / span / trains.types.count(kind) for each in counted]
        for kind, counted in totals.items()
    }
    return {
        "afferents": trains.family,
        "spikes": {kind: count for kind, (count, *_) in totals.items()},
        "spikes_within": {kind: ends for kind, (_, *ends) in totals.items()},
        "rates_Hz": {kind: rate for kind, (rate, *_) in rates.items()},
        "rates_within_Hz": {kind: ends for kind, (_, *ends) in rates.items()},
        "unmodeled": list(unmodeled),
    }


def run_summary(
    result: "Result", seconds: dict[str, float], files: list[str], *, verbose: bool = False
) -> str:
    """Return a dozen lines on a result; if `verbose`, also how it was computed, and all notes."""
    from fefinger.results import key_numbers

    rows = key_numbers.rows(result)
    saving = f" (saved in {seconds['save']:.1f} s)" if "save" in seconds else ""
    spent = f"{sum(result.seconds.values()):.1f} s{saving}"
    rows.append(("computed", f"by {result.plan.on}, in {spent}"))
    if result.plan.overridden:
        reasons = "; ".join(dict.fromkeys(refusal.reason for refusal in result.plan.overridden))
        rows.append(("WARNING", f"chosen by name despite: {reasons}"))
    if verbose:
        return "\n".join([table(rows), "", table(_details(result, seconds, files))])
    report = [file for file in files if file.endswith(".html")]
    notes = f"{len(result.notes)} notes"
    where = f"{report[0]} ({notes})" if report else f"-o DIR writes it, -v prints its {notes}"
    rows.append(("report", where))
    return f"{result.scene.name}\n{table(rows)}"


def _details(
    result: "Result", seconds: dict[str, float], files: list[str]
) -> list[tuple[str, str]]:
    """Return rows on the computation of a result: choice, expected errors, stages, notes, files."""
    rows = [("status", result.status), ("mechanics", result.plan.sentence)]
    if result.centroid is not None:
        x, y = result.centroid[result.peak]
        rows.append(("centroid", f"x {x:.3f} mm, y {round(y, 3) + 0.0:.3f} mm at the peak"))
    if result.plan.trust:
        rows.append(("trust", f"{result.plan.trust} Source: {result.plan.chosen.evidence}."))
    stages = ", ".join(f"{stage} {value:.1f}" for stage, value in seconds.items())
    rows.append(("seconds", stages))
    return [*rows, *(("note", note) for note in result.notes), *(("file", file) for file in files)]


@click.command()
@click.argument("scene")
@changes_option
@json_option
def explain(scene: str, changes: tuple[str, ...], as_json: bool) -> None:
    """Show which mechanics would answer SCENE.

    Prints the expected error of the force and the time of every mechanics and mesh, and why the
    others are refused. Times are of computing, without compiling and saving.
    """
    from dataclasses import asdict

    from fefinger import plan
    from fefinger.mechanics.press.time_steps import time_grid
    from fefinger.results.candidate import MECHANICS
    from fefinger.scene import builtin
    from fefinger.scene.cautions import quasistatic, samples, warnings
    from fefinger.scene.finger import origin_notes, other_size

    loaded = builtin.load(scene, builtin.settings(changes))
    motion = loaded.motion
    notes = [*origin_notes(loaded.finger), *other_size(loaded.finger)]
    notes += [*warnings(motion), *samples(motion)]
    try:
        chosen = plan.explain(loaded)
        console.print_answer(asdict(chosen), f"{chosen!r}\n\n{chosen.machine}", as_json=as_json)
        if not motion.by_force and not MECHANICS[chosen.mechanics].inertia:
            time = time_grid(motion, fast=True, most=sys.maxsize)
            notes += quasistatic(loaded, time, motion.value(time))
    finally:  # a refusal has its notes before it
        for sentence in notes:
            click.echo(sentence, err=True)


@click.command()
@click.argument("folders", metavar="DIR...", nargs=-1, required=True)
@click.option("--field", metavar="NAME", help="Quantity to color the finger by; `list` lists them.")
@click.option(
    "--time", "at", type=float, metavar="T", help="Time in s, by default that of the peak."
)
@click.option(
    "--limits",
    metavar="LOW:HIGH",
    help="Ends of the color bar, by default from 0, or the negative of its upper end, to a round "
    "number; the highest half percent of the values may lie beyond.",
)
@click.option("--screenshot", metavar="PNG", help="Draw to this file instead of a window.")
@click.option("--movie", metavar="FILE", help="Draw all times to a .gif or .mp4 file.")
@click.option("--html", metavar="FILE", help="Write an interactive page for any browser.")
def view(
    folders: tuple[str, ...],
    field: str | None,
    at: float | None,
    limits: str | None,
    screenshot: str | None,
    movie: str | None,
    html: str | None,
) -> None:
    """Show the strain or the pressure in DIR.

    DIR is a folder that `fefinger run -o` wrote; several are shown side by side on one color scale.
    Without --screenshot, --movie or --html a window opens.
    """
    from fefinger import view as pictures
    from fefinger.pages import viewer
    from fefinger.result import load
    from fefinger.support.atomic_write import check_ending, output_file
    from fefinger.view import frames, quantities
    from fefinger.view.pictures import check_film

    if field == "list":
        click.echo("\n".join(f"{name}: {quantities.ABOUT[name]}" for name in quantities.FIELDS))
        return
    shown = quantities.named("--field", quantities.DEFAULT if field is None else field)
    wanted = {"--screenshot": screenshot, "--movie": movie, "--html": html}
    files = {option: path for option, path in wanted.items() if path is not None}
    for option, ending in (("--screenshot", ".png"), ("--html", ".html")):
        if option in files:
            check_ending(files[option], option, ending)
    if movie is not None:
        check_film(movie, "--movie")
    span = None if limits is None else quantities.limits(limits)
    results = [load(folder) for folder in folders]
    for folder, result in zip(folders, results, strict=True):
        if result.fields is None:
            click.echo(f"{folder} holds no fields to view:", err=True)
        quantities.fields_of(result)
    frames.check("--time", results, at)
    for sentence in [] if at is None else frames.deviations(results, folders, at):
        click.echo(sentence, err=True)
    for option, path in files.items():
        output_file(path, option)
    how: dict[str, Any] = {"field": shown, "limits": span, "folders": folders}
    if screenshot is not None:
        pictures.screenshot(results, screenshot, time=at, **how)
    if movie is not None:
        pictures.movie(results, movie, **how)
    if html is not None:
        viewer.write(results, html, time=at, **how)
    for path in files.values():
        click.echo(path)
    if not files:
        pictures.show(results, time=at, **how)


LACKING = (
    "live: expected the packages of the extra `live`, found none of aiohttp; install them by "
    "`pip install 'fefinger[live]'`"
)


@click.command()
@click.option("-o", "output", metavar="DIR", help="Folder for the touches that the page saves.")
@click.option("--subject", default="a.h.", metavar="NAME", help="Subject of Pawluk (1997).")
@click.option("--resolution", default="standard", metavar="MESH", help="Mesh: coarse or standard.")
@click.option("--port", default=0, metavar="N", help="Port; 0 takes a free one.")
@click.option("--browser/--no-browser", default=True, help="Open the page in the browser.")
def live(output: str | None, subject: str, resolution: str, port: int, browser: bool) -> None:
    """Press a finger with the mouse, in a page of the browser.

    Shows pressure, strain and spikes as they are computed, at 1 kHz of the model. Prints the
    address of the page, which serves this machine alone, and ends with Ctrl-C. What is played can
    be saved as a scene and its result, under -o.
    """
    import asyncio

    from fefinger.live.player import Setup
    from fefinger.support.atomic_write import output_folder

    try:
        from fefinger.live.server import Server
    except ModuleNotFoundError as error:
        if error.name != "aiohttp":
            raise
        raise InputError(LACKING) from None
    setup = Setup(subject=subject)
    setup.finger(resolution)  # checks the resolution
    if not 0 <= port < 65536:
        raise InputError(f"--port: expected a number from 0 to 65535, received {port}")
    folder = None if output is None else output_folder(output)
    server = Server(resolution=resolution, output=folder, setup=setup, port=port)
    click.echo(server.address)
    asyncio.run(server.serve(browser=browser))
