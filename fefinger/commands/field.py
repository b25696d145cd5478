"""`fefinger field`: the receptive field of afferent units."""

from typing import TYPE_CHECKING

import click

from fefinger.commands import console
from fefinger.commands.options import changes_option, json_option, output_option, types_option


if TYPE_CHECKING:
    from fefinger.studies.receptive_field import ReceptiveField


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
    from fefinger.support import outputs

    loaded = builtin.load(scene, builtin.settings(changes))
    with outputs.output(output) as folder:
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
        files: list[str] = []
        try:
            files = [] if output is None else answer.save(output)
        finally:  # print the answer also where saving it fails
            record = answer.record() | {"files": files}
            console.print_answer(record, _summary(answer, files), as_json=as_json)


def _summary(answer: "ReceptiveField", files: list[str]) -> str:
    lines = [f"{answer.scene} by {answer.mechanics}, {len(answer.places)} places"]
    lines += [
        f"{kind}: at most {answer.of(kind).max()} impulses, half of them or more within "
        f"{answer.area(kind):.3g} mm²"
        for kind in answer.kinds
    ]
    if answer.left_out:
        count, reason = len(answer.left_out), answer.left_out[0][1]
        lines.append(f"left out: {count} of the places of the square, as {reason}")
    return "\n".join([*lines, *(f"wrote {file}" for file in files)])
