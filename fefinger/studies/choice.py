"""One mechanics and one mesh for all scenes of a study, so that nothing else differs."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from fefinger.checks import InputError
from fefinger.finger import AUTO, RESOLUTIONS
from fefinger.mechanics import names
from fefinger.plan import choose
from fefinger.studies.grid import EACH


if TYPE_CHECKING:
    from fefinger.records import Plan
    from fefinger.scene import Scene
    from fefinger.studies.tasks import Task

MOST = 400
"""Scenes that are asked which mechanics they take; of larger grids a part, evenly."""


def agreed(tasks: "Mapping[int, Task]") -> "tuple[dict[int, Task], str]":
    """Return the tasks with one mechanics and mesh for all, and a sentence on it.

    It is the first on the ladder that refuses none of the scenes, and the finest mesh that one of
    them takes of it. Tasks and an empty sentence are returned as they came where all agree, or
    where no mechanics answers all.
    """
    from fefinger.scene import Scene

    sample = list(tasks.values())[:: -(-len(tasks) // MOST)]
    scenes = [Scene.from_dict(task["scene"]) for task in sample]
    found = [plan for scene in scenes if (plan := _plan(scene)) is not None]
    used = list(dict.fromkeys(_label(plan) for plan in found))
    if len(used) < 2:
        return dict(tasks), ""
    first = max(names().index(plan.mechanics) for plan in found)
    for name in names()[first:]:
        own = [_plan(scene, name) for scene in scenes if _plan(scene) is not None]
        plans = [plan for plan in own if plan is not None and not plan.overridden]
        if len(plans) == len(own):
            return _with(tasks, name, _finest(plans)), (
                f"All scenes are answered by {_named(name, _finest(plans))}; the cheapest that is "
                f"good enough would be {', '.join(used)}, scene by scene (--mechanics {EACH})."
            )
    return dict(tasks), ""


def _plan(scene: "Scene", mechanics: str | None = None) -> "Plan | None":
    """Return the plan for a scene, None where it has none, which is told when it is answered."""
    try:
        return choose(scene, mechanics)
    except InputError:
        return None


def _label(plan: "Plan") -> str:
    return _named(plan.mechanics, plan.settings.resolution if plan.settings else None)


def _named(mechanics: str, mesh: str | None) -> str:
    return f"{mechanics} on the {mesh} mesh" if mesh else mechanics


def _finest(plans: "Sequence[Plan]") -> str | None:
    meshes = {plan.settings.resolution for plan in plans if plan.settings}
    return max((mesh for mesh in meshes if mesh), key=RESOLUTIONS.index, default=None)


def _with(tasks: "Mapping[int, Task]", mechanics: str, mesh: str | None) -> "dict[int, Task]":
    return {i: {**task, "mechanics": mechanics, **_meshed(task, mesh)} for i, task in tasks.items()}


def _meshed(task: "Task", mesh: str | None) -> "Task":
    """Return the scene of a task on a mesh, if it leaves that open."""
    from fefinger.scene import Scene

    scene = Scene.from_dict(task["scene"])
    if mesh is None or scene.finger.resolution != AUTO:
        return {}
    return {"scene": replace(scene, finger=replace(scene.finger, resolution=mesh)).to_dict()}
