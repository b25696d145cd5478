"""`fefinger explain`: say which mechanics would answer SCENE."""

import sys
from typing import TYPE_CHECKING

import click

from fefinger.commands import console
from fefinger.commands.options import changes_option, json_option


if TYPE_CHECKING:
    from fefinger.scene.scene import Scene


@click.command()
@click.argument("scene")
@changes_option
@json_option
def explain(scene: str, changes: tuple[str, ...], as_json: bool) -> None:
    """Say which mechanics would answer SCENE.

    With how well and how fast it would, and why the others would not.
    """
    from fefinger import plan
    from fefinger.scene import builtin
    from fefinger.scene.finger import own

    asked = builtin.load(scene, builtin.settings(changes))
    for sentence in (*own(asked.finger), *_too_fast(asked)):
        click.echo(sentence, err=True)
    found = plan.explain(asked)
    if as_json:
        console.print_json(console.plan_record(found))
    else:
        click.echo(console.plan_summary(found))


def _too_fast(scene: "Scene") -> tuple[str, ...]:
    """Return the warnings of an answer to a motion, as far as it prescribes the depth."""
    from fefinger.mechanics.press.time_steps import time_grid
    from fefinger.scene.inertia import jump, quasistatic

    motion = scene.motion
    if motion.control != "depth":
        return jump(motion)
    time = time_grid(motion, fast=True, most=sys.maxsize)
    return jump(motion) + quasistatic(scene, time, motion.value(time))
