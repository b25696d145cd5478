"""`fefinger explain`: show which mechanics would answer a scene, with its error and cost."""

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
    """Show which mechanics would answer SCENE.

    Prints the expected error and time of every mechanics and mesh, and why the others are refused.
    """
    from dataclasses import asdict

    from fefinger import plan
    from fefinger.results.candidate import MECHANICS
    from fefinger.scene import builtin
    from fefinger.scene.finger import origin_notes
    from fefinger.scene.inertia import noise, warnings

    loaded = builtin.load(scene, builtin.settings(changes))
    motion = loaded.motion
    notes = [*origin_notes(loaded.finger), *warnings(motion), *noise(motion)]
    try:
        chosen = plan.explain(loaded)
        console.print_answer(asdict(chosen), f"{chosen!r}\n\n{chosen.machine}", as_json=as_json)
        if not MECHANICS[chosen.mechanics].inertia:
            notes += _too_fast(loaded)
    finally:  # a refusal has its notes before it
        for sentence in notes:
            click.echo(sentence, err=True)


def _too_fast(scene: "Scene") -> tuple[str, ...]:
    """Warnings on speed, for motions that prescribe the depth."""
    from fefinger.mechanics.press.time_steps import time_grid
    from fefinger.scene.inertia import quasistatic

    motion = scene.motion
    if motion.control != "depth":
        return ()
    time = time_grid(motion, fast=True, most=sys.maxsize)
    return quasistatic(scene, time, motion.value(time))
