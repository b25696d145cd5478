"""`fefinger explain`: show which mechanics would answer a scene, with its error and cost."""

import sys

import click

from fefinger.commands import console
from fefinger.commands.options import changes_option, json_option


@click.command()
@click.argument("scene")
@changes_option
@json_option
def explain(scene: str, changes: tuple[str, ...], as_json: bool) -> None:
    """Show which mechanics would answer SCENE.

    Prints the expected error of the force and the time of every mechanics and mesh, and why the
    others are refused. Times are those of computing, without compiling and saving.
    """
    from dataclasses import asdict

    from fefinger import plan
    from fefinger.mechanics.press.time_steps import time_grid
    from fefinger.results.candidate import MECHANICS
    from fefinger.scene import builtin
    from fefinger.scene.finger import origin_notes, other_size
    from fefinger.scene.inertia import quasistatic, samples, warnings

    loaded = builtin.load(scene, builtin.settings(changes))
    motion = loaded.motion
    notes = [*origin_notes(loaded.finger), *other_size(loaded.finger)]
    notes += [*warnings(motion), *samples(motion)]
    try:
        chosen = plan.explain(loaded)
        console.print_answer(asdict(chosen), f"{chosen!r}\n\n{chosen.machine}", as_json=as_json)
        if not motion.by_force and not MECHANICS[chosen.mechanics].inertia:
            time = time_grid(motion, fast=True, most=sys.maxsize)
            notes += quasistatic(loaded, time, motion.value(time))
    finally:  # a refusal has its notes before it
        for sentence in notes:
            click.echo(sentence, err=True)
