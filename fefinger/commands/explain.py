"""`fefinger explain`: say which mechanics would answer SCENE."""

import click

from fefinger import console
from fefinger.commands.options import changes_option, json_option


@click.command()
@click.argument("scene")
@changes_option
@json_option
def explain(scene: str, changes: tuple[str, ...], as_json: bool) -> None:
    """Say which mechanics would answer SCENE.

    With how well and how fast it would, and why the others would not.
    """
    from fefinger import plan, scenes
    from fefinger.finger import own

    asked = scenes.load(scene, scenes.settings(changes))
    for sentence in own(asked.finger):
        click.echo(sentence, err=True)
    found = plan.explain(asked)
    if as_json:
        console.print_json(console.plan_record(found))
    else:
        click.echo(console.plan_summary(found))
