"""`fefinger view`: look at the strain or the pressure in DIR."""

from pathlib import Path

import click


@click.command()
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
