"""`fefinger live`: show a finger that is pressed and rolled, while it is computed."""

from pathlib import Path

import click


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
