"""One mechanics and one mesh for all scenes of a study, so that nothing else differs."""

import hashlib
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from fefinger.mechanics import names
from fefinger.plan import choose
from fefinger.results.candidate import Candidate
from fefinger.results.result_record import Plan
from fefinger.scene.finger import AUTO, RESOLUTIONS
from fefinger.scene.scene import Scene
from fefinger.studies.grid import EACH
from fefinger.studies.tasks import Task, key, read_record, write_record
from fefinger.support.checks import InputError


MOST = 400
"""Largest number of scenes that are planned to choose a mechanics; of more, a sample is planned."""

TURNING = "indenter.angle", "indenter.tilt", "indenter.at"
"""Fields that change the place of contact on the pad."""

ROUND = "hertz", "layered"
"""Mechanics of an axisymmetric pad, whose response does not depend on the place of contact."""

ALL, SOME = "All scenes are", "The scenes that can be answered are"


class Choice(NamedTuple):
    """Mechanics and mesh of all scenes, None where each has its own, and a sentence about them."""

    mechanics: str | None
    mesh: str | None
    sentence: str


def agreed(
    tasks: Mapping[int, Task], over: Collection[str] = (), folder: Path | None = None
) -> tuple[dict[int, Task], str]:
    """Assign one mechanics and mesh to all tasks; also return a sentence on the choice.

    The mechanics is the one named in the tasks or in all scenes (`ask.mechanics`), or else the
    cheapest that refuses no scene; scenes that name different ones keep them. The mesh is the
    finest that a scene needs, for scenes that state none. Where no mechanics answers all, tasks
    stay as they are. The choice is stored in a `folder`: the cheapest depends on the caches of this
    machine, and a continued study must not change it. `over`: the fields of the grid.
    """
    keys = "".join(sorted(map(key, tasks.values()))).encode()
    place = folder / f"choice-{hashlib.sha256(keys).hexdigest()[:16]}.json" if folder else None
    record = None if place is None else read_record(place)
    if record is not None:
        choice = Choice(**record)
    else:
        named = next(iter(tasks.values()))["mechanics"]
        choice = _choice(tasks, over)
        if place is not None and (named is None or choice.mesh is not None):
            write_record(place, choice._asdict())
    if choice.mechanics is None:
        return dict(tasks), choice.sentence
    planned = {"mechanics": choice.mechanics}
    with_choice = {i: task | planned | _meshed(task, choice.mesh) for i, task in tasks.items()}
    return with_choice, choice.sentence


def _choice(tasks: Mapping[int, Task], over: Collection[str]) -> Choice:
    """Choose the mechanics and mesh of tasks over a grid of fields, see `agreed`."""
    sample = list(tasks.values())[:: -(-len(tasks) // MOST)]
    scenes = [Scene.from_dict(task["scene"]) for task in sample]
    named = sample[0]["mechanics"]
    if named is None:
        stated = {task["scene"]["ask"].get("mechanics") for task in tasks.values()}
        if len(stated) > 1:
            return Choice(None, None, "")
        (named,) = stated
    planned = [(scene, plan) for scene in scenes if (plan := _plan(scene, named)) is not None]
    chosen = (_on(plan.mechanics, _mesh(scene, plan)) for scene, plan in planned)
    used = list(dict.fromkeys(chosen))
    if named is not None:
        mesh = _finest(planned)
        taken = _on(named, mesh)
        others = ", ".join(each for each in used if each != taken)
        sentence = (
            f"{ALL} answered by {taken}, the finest that one of them needs; for others {others} "
            "would suffice (--set finger.resolution=NAME takes another mesh)."
        )
        return Choice(named, mesh, sentence if mesh and others else "")
    first = max((names().index(plan.mechanics) for _, plan in planned), default=len(names()))
    barred = ROUND if set(over) & set(TURNING) else ()
    for name in names()[first:]:
        if name in barred:
            continue
        candidates = [(scene, _plan(scene, name)) for scene, _ in planned]
        able = [(s, plan) for s, plan in candidates if plan is not None and not plan.overridden]
        if candidates and len(able) == len(candidates):
            mesh = _finest(able)
            which = ALL if len(planned) == len(sample) else SOME
            return Choice(name, mesh, _sentence(_on(name, mesh), used, which))
    return Choice(None, None, "")


def _sentence(taken: str, used: Sequence[str], which: str) -> str:
    if used == [taken]:
        return ""
    cheapest = f"would be {', '.join(used)}, scene by scene (--mechanics {EACH})"
    if len(used) == 1:
        cheapest = f"would be {used[0]}, which does not depend on the place of contact"
    return f"{which} answered by {taken}; the cheapest accurate enough {cheapest}."


def _plan(scene: Scene, mechanics: str | None = None) -> Plan | None:
    """Plan a scene; None where that fails: the error is reported when the scene is answered."""
    try:
        return choose(scene, mechanics)
    except InputError:
        return None


def _mesh(scene: Scene, plan: Plan) -> str | None:
    """Return the mesh that a plan has chosen; None without one, or if the scene states it."""
    stated = scene.finger.resolution != AUTO
    return None if stated or plan.settings is None else plan.settings.resolution


def _on(mechanics: str, mesh: str | None) -> str:
    return Candidate(mechanics, mesh).on


def _finest(planned: Sequence[tuple[Scene, Plan]]) -> str | None:
    meshes = {_mesh(scene, plan) for scene, plan in planned}
    return max((mesh for mesh in meshes if mesh), key=RESOLUTIONS.index, default=None)


def _meshed(task: Task, mesh: str | None) -> Task:
    """Set the mesh of a task's scene, unless the scene states one."""
    finger = task["scene"]["finger"]
    if mesh is None or finger["resolution"] != AUTO:
        return {}
    return {"scene": {**task["scene"], "finger": {**finger, "resolution": mesh}}}
