"""`fefinger view` and `fefinger live`: pictures of saved results, and a finger in the browser."""

from typing import Any

import click

from fefinger.support.checks import InputError


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

    from fefinger.live.setup import Setup
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
