"""`fefinger view` and `fefinger live`: pictures of saved results, and of a finger as it moves."""

from pathlib import Path
from typing import Any

import click


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
    from fefinger.support.outputs import check_ending, output_file
    from fefinger.view import film, frames, quantities

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
        film.check(movie, "--movie")
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


@click.command()
@click.option("-o", "output", metavar="FILE", help="Record to a .gif or .mp4 file instead.")
@click.option("--subject", default="a.h.", metavar="NAME", help="Subject of Pawluk (1997).")
@click.option("--resolution", default="standard", metavar="MESH", help="Mesh: coarse or standard.")
def live(output: str | None, subject: str, resolution: str) -> None:
    """Watch a finger being pressed and rolled.

    Shows pressure, strain in the medial section and spikes as they are computed. Strain is small,
    so that the tissue is one that does not stiffen, of Maeno et al. (1998). The first run
    builds the operator of the finger, which takes about a minute.
    """
    from fefinger.scene.finger import Finger
    from fefinger.scene.library import PUBLISHED
    from fefinger.support.outputs import output_file
    from fefinger.view import film
    from fefinger.view import live as shows

    finger = Finger.subject(subject, resolution=resolution, tissue=PUBLISHED)
    if output is None:
        last = shows.watch(finger)
    else:
        film.check(output, "-o")
        output_file(output, "-o")
        last = shows.record(finger, Path(output))
    click.echo(
        f"{last.steps} steps of {1e3 * shows.DT:g} ms at {last.rate:.0f} steps/s, "
        f"{len(last.spikes)} spikes" + (f": {output}" if output else "")
    )
