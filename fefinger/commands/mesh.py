"""`fefinger mesh`: build, check and draw a finger mesh."""

import click

from fefinger.commands import console
from fefinger.commands.options import changes_option, json_option


@click.command()
@click.argument("scene", default="flat-press")
@click.option("--whole", is_flag=True, help="Mesh the whole finger, not its symmetric half.")
@click.option("-o", "--output", metavar="FILE.vtu", help="File to write the mesh to.")
@click.option("--picture", metavar="PNG", help="Draw the mesh.")
@changes_option
@json_option
def mesh(
    scene: str,
    whole: bool,
    output: str | None,
    picture: str | None,
    changes: tuple[str, ...],
    as_json: bool,
) -> None:
    """Build, check and draw a finger mesh.

    Uses the shipped or cached mesh of the finger of SCENE if there is one.
    """
    from fefinger.mesh import quality, vtu
    from fefinger.mesh.store import load_or_build
    from fefinger.scene import builtin
    from fefinger.support.outputs import output_file

    finger = builtin.load(scene, builtin.settings(changes)).finger
    if output is not None:
        output_file(output, "-o", ".vtu")
    if picture is not None:
        output_file(picture, "--picture", ".png")
    built = load_or_build(finger, half=not whole, progress=console.remark)
    quality.gate(built.quality)
    if output is not None:
        vtu.write(built, output)
    if picture is not None:
        from fefinger import view

        view.draw_mesh(built, picture)
    for file in filter(None, (output, picture)):
        console.remark(f"wrote {file}")
    console.print_answer(console.mesh_record(built), console.mesh_summary(built), as_json=as_json)
