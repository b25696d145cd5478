"""One mechanics and one mesh for all scenes of a study, so that nothing else differs."""

import hashlib
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from fefinger.mechanics import names
from fefinger.plan import choose
from fefinger.results.result_record import Plan
from fefinger.scene.finger import AUTO, RESOLUTIONS
from fefinger.scene.scene import Scene
from fefinger.studies import stored
from fefinger.studies.grid import EACH
from fefinger.studies.tasks import Task, key
from fefinger.support.checks import InputError


MOST = 400
"""Largest number of scenes that are planned to choose a mechanics; larger grids are sampled."""

TURNING = "indenter.angle", "indenter.tilt", "indenter.at"
"""Fields that change the place of contact on the pad."""

ROUND = "hertz", "layered"
"""Mechanics of an axisymmetric pad, whose response does not depend on the place of contact."""


ALL, SOME = "All scenes are", "The scenes that can be answered are"


class Choice(NamedTuple):
    """Common mechanics and mesh of all scenes, None where each has its own, with a sentence."""

    mechanics: str | None
    mesh: str | None
    sentence: str


def agreed(
    tasks: Mapping[int, Task], over: Collection[str] = (), folder: Path | None = None
) -> tuple[dict[int, Task], str]:
    """Assign one mechanics and mesh to all tasks; also return a sentence on the choice.

    The mechanics is the one named in the tasks or in all scenes (`ask.mechanics`), or the cheapest
    that refuses none of the scenes; scenes that name different ones keep them. The mesh is the
    finest that one of them needs, for those that do not state theirs. Where no mechanics can answer
    all, the tasks are unchanged. The choice is stored in a `folder`, because the cheapest depends
    on the caches of this machine, and a continued study must not change it. `over` are the fields
    of the grid.
    """
    keys = "".join(sorted(map(key, tasks.values()))).encode()
    place = folder / f"choice-{hashlib.sha256(keys).hexdigest()[:16]}.json" if folder else None
    choice = _stored(place)
    if choice is None:
        named = next(iter(tasks.values()))["mechanics"]
        choice = _choice(tasks, over)
        if place is not None and (named is None or choice.mesh is not None):
            stored.write(place, choice._asdict())
    if choice.mechanics is None:
        return dict(tasks), choice.sentence
    planned = {"mechanics": choice.mechanics}
    with_choice = {i: task | planned | _meshed(task, choice.mesh) for i, task in tasks.items()}
    return with_choice, choice.sentence


def _stored(place: Path | None) -> Choice | None:
    """Read the choice from a file; None if it is missing or damaged."""
    record = None if place is None else stored.read(place)
    return None if record is None else Choice(**record)


def _choice(tasks: Mapping[int, Task], over: Collection[str]) -> Choice:
    sample = list(tasks.values())[:: -(-len(tasks) // MOST)]
    scenes = [Scene.from_dict(task["scene"]) for task in sample]
    named = sample[0]["mechanics"]
    if named is None:
        stated = {task["scene"]["ask"].get("mechanics") for task in tasks.values()}
        if len(stated) > 1:
            return Choice(None, None, "")
        (named,) = stated
    planned = [(scene, plan) for scene in scenes if (plan := _plan(scene, named)) is not None]
    chosen = (_named(plan.mechanics, _mesh(scene, plan)) for scene, plan in planned)
    used = list(dict.fromkeys(chosen))
    if named is not None:
        mesh = _finest(planned)
        taken = _named(named, mesh)
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
            return Choice(name, mesh, _sentence(_named(name, mesh), used, which))
    return Choice(None, None, "")


def _sentence(taken: str, used: Sequence[str], which: str) -> str:
    if used == [taken]:
        return ""
    cheapest = f"would be {', '.join(used)}, scene by scene (--mechanics {EACH})"
    if len(used) == 1:
        cheapest = f"would be {used[0]}, which does not depend on the place of contact"
    return f"{which} answered by {taken}; the cheapest accurate enough {cheapest}."


def _plan(scene: Scene, mechanics: str | None = None) -> Plan | None:
    """Plan a scene; None where it has no plan: its error is reported when it is answered."""
    try:
        return choose(scene, mechanics)
    except InputError:
        return None


def _mesh(scene: Scene, plan: Plan) -> str | None:
    """Mesh chosen by a plan; None without a mesh or where the scene states its mesh."""
    stated = scene.finger.resolution != AUTO
    return None if stated or plan.settings is None else plan.settings.resolution


def _named(mechanics: str, mesh: str | None) -> str:
    return f"{mechanics} on the {mesh} mesh" if mesh else mechanics


def _finest(planned: Sequence[tuple[Scene, Plan]]) -> str | None:
    meshes = {_mesh(scene, plan) for scene, plan in planned}
    return max((mesh for mesh in meshes if mesh), key=RESOLUTIONS.index, default=None)


def _meshed(task: Task, mesh: str | None) -> Task:
    """Set the mesh of a task's scene, unless the scene states one."""
    finger = task["scene"]["finger"]
    if mesh is None or finger["resolution"] != AUTO:
        return {}
    return {"scene": {**task["scene"], "finger": {**finger, "resolution": mesh}}}
