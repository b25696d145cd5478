"""`fefinger live`: a finger that is pressed in a page of the browser."""

import click

from fefinger.support.checks import InputError


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
    from fefinger.support.outputs import output_folder

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
