"""`fefinger view`: pictures of saved results."""

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
