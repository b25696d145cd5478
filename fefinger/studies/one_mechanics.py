"""One mechanics and one mesh for all scenes of a study, so that nothing else differs."""

import hashlib
import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from fefinger.mechanics import names
from fefinger.plan import choose
from fefinger.scene.finger import AUTO, RESOLUTIONS
from fefinger.studies.grid import EACH
from fefinger.studies.tasks import key, write
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from pathlib import Path

    from fefinger.results.records import Plan
    from fefinger.scene.scene import Scene
    from fefinger.studies.tasks import Task

MOST = 400
"""Scenes that are asked which mechanics they take; of larger grids a part, evenly."""

TURNING = "indenter.angle", "indenter.tilt", "indenter.at"
"""Fields of where the pad is touched."""

ROUND = "hertz", "layered"
"""Mechanics to which the pad is alike wherever it is touched: no answer to how that changes."""


ALL, SOME = "All scenes are", "The scenes that can be answered are"


class Choice(NamedTuple):
    """One mechanics and mesh for all scenes, None where each has its own, and what to say."""

    mechanics: str | None
    mesh: str | None
    said: str


def agreed(
    tasks: "Mapping[int, Task]", over: Collection[str] = (), folder: "Path | None" = None
) -> "tuple[dict[int, Task], str]":
    """Return the tasks with one mechanics and mesh for all, and a sentence on it.

    It is the one that the tasks name, or the first on the ladder that refuses none of the scenes;
    and the finest mesh that one of them takes of it, for those that do not state theirs. Where no
    mechanics answers all, tasks are returned as they came. The choice is kept in a `folder`: what
    is cheapest depends on what else is kept on this machine, and a study that goes on must not
    start again for that. `over` are the fields of the grid.
    """
    place = folder / f"choice-{_digest(tasks)}.json" if folder else None
    found = _kept(place)
    if found is None:
        named = next(iter(tasks.values()))["mechanics"]
        found = _choice(tasks, over)
        if place is not None and (named is None or found.mesh is not None):
            write(place, json.dumps(found))
    if found.mechanics is None:
        return dict(tasks), found.said
    return _with(tasks, found.mechanics, found.mesh), found.said


def _digest(tasks: "Mapping[int, Task]") -> str:
    return hashlib.sha256("".join(sorted(map(key, tasks.values()))).encode()).hexdigest()[:16]


def _kept(place: "Path | None") -> Choice | None:
    """Return the choice in a file, None without one; a damaged one counts as none."""
    try:
        return None if place is None else Choice(*json.loads(place.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def _choice(tasks: "Mapping[int, Task]", over: Collection[str]) -> Choice:
    """Choose for all scenes."""
    from fefinger.scene.scene import Scene

    sample = list(tasks.values())[:: -(-len(tasks) // MOST)]
    scenes = [Scene.from_dict(task["scene"]) for task in sample]
    named = sample[0]["mechanics"]
    asked = [(scene, plan) for scene in scenes if (plan := _plan(scene, named)) is not None]
    used = list(dict.fromkeys(_label(scene, plan) for scene, plan in asked))
    if named is not None:
        mesh = _finest(asked)
        return Choice(named, mesh, _said_of_named(_named(named, mesh), used) if mesh else "")
    first = max((names().index(plan.mechanics) for _, plan in asked), default=len(names()))
    barred = ROUND if set(over) & set(TURNING) else ()
    for name in names()[first:]:
        own = [(scene, _plan(scene, name)) for scene, _ in asked] if name not in barred else []
        able = [(scene, plan) for scene, plan in own if plan is not None and not plan.overridden]
        if own and len(able) == len(own):
            mesh = _finest(able)
            scenes_ = ALL if len(asked) == len(sample) else SOME
            return Choice(name, mesh, _said(_named(name, mesh), used, scenes_))
    return Choice(None, None, "")


def _said(taken: str, used: Sequence[str], which: str) -> str:
    if used == [taken]:
        return ""
    cheapest = f"would be {', '.join(used)}, scene by scene (--mechanics {EACH})"
    if len(used) == 1:
        cheapest = f"would be {used[0]}, which does not tell where the pad is touched"
    return f"{which} answered by {taken}; the cheapest that is good enough {cheapest}."


def _said_of_named(taken: str, used: Sequence[str]) -> str:
    others = [each for each in used if each != taken]
    if not others:
        return ""
    return (
        f"{ALL} answered by {taken}, the finest that one of them needs; for others "
        f"{', '.join(others)} would do (--set finger.resolution=NAME takes another mesh)."
    )


def _plan(scene: "Scene", mechanics: str | None = None) -> "Plan | None":
    """Return the plan for a scene, None where it has none, which is told when it is answered."""
    try:
        return choose(scene, mechanics)
    except InputError:
        return None


def _label(scene: "Scene", plan: "Plan") -> str:
    return _named(plan.mechanics, _mesh(scene, plan))


def _mesh(scene: "Scene", plan: "Plan") -> str | None:
    """Return the mesh that a plan has chosen; None where there is none, or the scene states it."""
    stated = scene.finger.resolution != AUTO
    return None if stated or plan.settings is None else plan.settings.resolution


def _named(mechanics: str, mesh: str | None) -> str:
    return f"{mechanics} on the {mesh} mesh" if mesh else mechanics


def _finest(planned: "Sequence[tuple[Scene, Plan]]") -> str | None:
    meshes = {_mesh(scene, plan) for scene, plan in planned}
    return max((mesh for mesh in meshes if mesh), key=RESOLUTIONS.index, default=None)


def _with(tasks: "Mapping[int, Task]", mechanics: str, mesh: str | None) -> "dict[int, Task]":
    return {i: {**task, "mechanics": mechanics, **_meshed(task, mesh)} for i, task in tasks.items()}


def _meshed(task: "Task", mesh: str | None) -> "Task":
    """Return the scene of a task on a mesh, if it leaves that open."""
    from fefinger.scene.scene import Scene

    scene = Scene.from_dict(task["scene"])
    if mesh is None or scene.finger.resolution != AUTO:
        return {}
    return {"scene": replace(scene, finger=replace(scene.finger, resolution=mesh)).to_dict()}
