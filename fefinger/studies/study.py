"""Many scenes at once: a grid over fields of a scene, answered side by side, as one tidy table.

    study = ff.study("flat-press", {"indenter.angle": range(0, 61, 5)}, folder="out")
    study.table()                    # pandas, one row per scene and time

Finished scenes are stored in the folder, by a hash of all their inputs, and not computed again; a
scene that fails does not stop the others. `grid.py` reads the grid, `tasks.py` makes and runs the
scenes, `measures.py` makes their rows, `tables.py` and `study_page.py` write table and page.
"""

import hashlib
import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from fefinger.mechanics import names
from fefinger.plan import choose
from fefinger.results.candidate import Candidate
from fefinger.results.result_record import Plan
from fefinger.scene.finger import AUTO, RESOLUTIONS
from fefinger.scene.scene import Scene
from fefinger.scene.schema import column
from fefinger.studies import tables
from fefinger.studies.grid import EACH, checked
from fefinger.studies.tables import StudyRows
from fefinger.studies.tasks import (
    Answer,
    StudyRequest,
    Task,
    cluster,
    key,
    local,
    place,
    provenance,
    read_record,
    write_record,
)
from fefinger.support import atomic_write
from fefinger.support.atomic_write import output, output_folder
from fefinger.support.checks import InputError, choice, number
from fefinger.support.machine import software
from fefinger.support.progress import Progress
from fefinger.support.text import finite


if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, repr=False)
class Study(StudyRows):
    """Rows of a study, with conversion to arrays and writing to files."""

    def to_xarray(self) -> "xr.Dataset":
        """Convert the table to arrays over the fields of the grid and over `at`."""
        return tables.dataset(self)

    def write(self, path: str | Path) -> str:
        """Write the table to a .csv, .parquet or .nc file and return its path.

        Raises InputError for another ending, or a missing extra `parquet`.
        """
        return tables.write(self, path)

    def save(self, folder: str | Path) -> list[str]:
        """Write table.csv, study.json and report.html into a folder, and return their paths.

        Files of an earlier study of other scenes are moved into a subfolder; their new paths are
        returned too. Raises InputError where the files cannot be written, and leaves none.
        """
        from fefinger.studies.study_page import html

        place, page = output_folder(folder), html(self)
        record = {"name": self.name, "over": self.over, **self.about, "rows": self.rows}
        texts = {
            "study.json": json.dumps(record, indent=1, allow_nan=False) + "\n",
            "report.html": page,
        }
        with atomic_write.together(place, texts):
            aside = tables.set_aside(self, place)
            tables.write(self, place / "table.csv")
        return [*(str(place / name) for name in tables.NAMES), *aside]


def study(
    scene: Scene | str | Path,
    over: Mapping[str, Sequence[object]],
    *,
    changes: Mapping[str, object] | None = None,
    at: Sequence[str] = (),
    mechanics: str | None = None,
    folder: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Study:
    """Run a grid of scenes in parallel.

    Parameters
    ----------
    scene
        Name of a built-in scene, a TOML file, or a Scene.
    over
        Values of fields by their path, as {"indenter.angle": (0, 30, 60)}; every combination is
        answered, the last field changing fastest.
    changes
        Values that all scenes have instead of their own; "ask.fields" is False by default.
    at
        Forces and depths of the rows, as "1N" and "0.5mm", on the loading branch; by default those
        of 1 N and 1 mm that are reached.
    mechanics
        Name of the mechanics; by default those that the scenes name (`ask.mechanics`), or one for
        all scenes, the cheapest that refuses none of them. One for all is on one mesh, the finest
        that one of the scenes needs, unless they state `finger.resolution`; "each" takes the
        cheapest for every scene, and its mesh.
    folder
        Where finished scenes are stored and looked up; None stores none.
    workers
        Processes on this machine; by default one per core.
    scheduler
        Address of a Dask scheduler to use instead.
    progress
        Called with "scenes" and the fraction that is done.

    Raises
    ------
    InputError
        If the grid is unusable, or a value of it in every scene that has it: then nothing is run.
        Other unusable scenes are listed in `failures`.
    """
    if mechanics is not None:
        choice("mechanics", mechanics, (*names(), EACH))
    count = None if workers is None else int(number("workers", workers, at_least=1))
    if not over:
        raise InputError("--over: expected one field or more with its values, received none")
    for field in over.keys() & (changes or {}).keys():
        msg = f"{field}: expected in --over or in --set, received in both; leave one out"
        raise InputError(msg)
    request = StudyRequest(scene, checked(over), changes or {}, mechanics, at)
    tasks, unusable = request.tasks()
    request.check(unusable)
    points = request.points

    def run(left: Sequence[Task]) -> Iterator[tuple[int, Answer]]:
        return local(left, count) if scheduler is None else cluster(left, scheduler)

    def report(answered: int) -> None:
        if progress is not None:
            progress("scenes", (answered + len(unusable)) / len(points))

    with ExitStack() as opened:
        scenes, chosen = None, ""
        if folder is not None:
            opened.enter_context(output(folder))
            scenes = opened.enter_context(output(Path(folder, "scenes")))
        if mechanics != EACH:
            tasks, chosen = agreed(tasks, request.over, scenes)
        answers, reused = _answers(tasks, scenes, run, report)
    about = {**request.record(), **provenance(list(answers.values()), reused)}
    about |= {"chosen": chosen} if chosen else {}
    one = next(iter(tasks.values()))["scene"]
    columns = {field: column(field, one["motion"]["kind"]) for field in request.over}
    failed = {**unusable, **{i: each["error"] for i, each in answers.items() if "error" in each}}

    def rows(i: int) -> Iterator[dict[str, object]]:
        values = {
            columns[field]: str(value) if isinstance(value, list | tuple | dict) else value
            for field, value in points[i].items()
        }
        scene = {"scene": key(tasks[i])} if i in tasks else {}
        if i in failed:
            yield {**values, "at": "", "status": f"failed: {failed[i]}", **scene}
        else:
            for row in filter(request.wanted, answers[i]["rows"]):
                yield {**values, **row, **scene}

    return Study(
        name=one["name"],
        over=tuple(columns.values()),
        rows=tuple(row for i in range(len(points)) for row in rows(i)),
        failures=tuple((points[i], failed[i]) for i in sorted(failed)),
        scenes=len(points),
        reused=reused,
        about=about,
    )


def _answers(
    tasks: Mapping[int, Task],
    folder: Path | None,
    run: Callable[[Sequence[Task]], Iterator[tuple[int, Answer]]],
    report: Callable[[int], None],
) -> tuple[dict[int, Answer], int]:
    """Return the answers of tasks, and how many of them were stored in the folder before.

    The other tasks are `run`, and their answers stored. `report` is called with their number.
    """
    answers: dict[int, Answer] = {}
    if folder is not None:
        stored = ((i, read_record(place(folder, task))) for i, task in tasks.items())
        answers = {i: answer for i, answer in stored if answer is not None}
    reused = len(answers)
    left = sorted(tasks.keys() - answers.keys())
    for nth, answer in run([tasks[i] for i in left]):
        i, now = left[nth], software()
        answers[i] = {**finite(answer), "date": now["date"], "commit": now["commit"]}
        if folder is not None and "rows" in answer:
            with suppress(InputError):  # on a full disk the answer still goes into the table
                write_record(place(folder, tasks[i]), answers[i])
        report(len(answers))
    return answers, reused


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
    # Largest number of scenes that are planned to choose a mechanics; of more, a sample is planned.
    most = 400
    sample = list(tasks.values())[:: -(-len(tasks) // most)]
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
