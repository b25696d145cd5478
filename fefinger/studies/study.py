"""Many scenes at once: a grid over fields of a scene, answered side by side, as one tidy table.

    study = ff.study("flat-press", {"indenter.angle": range(0, 61, 5)}, folder="out")
    study.table()                    # pandas, one row per scene and time

Scenes that are finished stay in the folder, under the hash of all that decides them, and are not
answered again; a scene that fails costs itself alone. `studies/grid.py` reads the grid,
`tasks.py` beside it makes the scenes, `workers.py` answers them, `measures.py` says what is told of
each, `tables.py` and `report.py` write the table and the page.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fefinger.studies.rows import StudyRows


if TYPE_CHECKING:
    import xarray as xr

    from fefinger.scene.scene import Scene
    from fefinger.studies.tasks import Answer, Asked, Task
    from fefinger.support.progress import Progress

AT = ("1N", "1mm")
"""Force and depth that are told of by default, besides the peak and the end."""


@dataclass(frozen=True)
class Study(StudyRows):
    """The rows of a study, and the files that they are written to."""

    def to_xarray(self) -> "xr.Dataset":
        """Return the table as arrays over the fields of the grid and over `at`."""
        from fefinger.studies.tables import dataset

        return dataset(self)

    def write(self, path: str | Path) -> str:
        """Write the table to a .csv, .parquet or .nc file and return its path.

        InputError for another ending, or where the extra `parquet` is needed and not installed.
        """
        from fefinger.studies.tables import write

        return write(self, path)

    def save(self, folder: str | Path) -> list[str]:
        """Write table.csv, study.json and report.html into a folder, and return their paths.

        The table of other scenes that is there already, with its page, is moved into a folder
        beside it, whose files are returned too. InputError where there is no room for the files,
        none of which is then left.
        """
        import json

        from fefinger.studies import tables
        from fefinger.studies.page import html
        from fefinger.support import atomic_write
        from fefinger.support.outputs import output_folder

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
    scene: "Scene | str | Path",
    over: Mapping[str, Sequence[Any]],
    *,
    changes: Mapping[str, Any] | None = None,
    at: Sequence[str] = AT,
    mechanics: str | None = None,
    folder: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: "Progress | None" = None,
) -> Study:
    """Answer a grid of scenes side by side.

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
        Forces and depths at which rows are told, as "1N" and "0.5mm", on the loading branch.
    mechanics
        Name of the mechanics; by default one for all scenes, the cheapest that refuses none of
        them. Either is on one mesh, the finest that one of the scenes needs, unless they state
        `finger.resolution`; "each" takes the cheapest for every scene, and its mesh.
    folder
        Where finished scenes are kept and looked for; None keeps none.
    workers
        Processes on this machine; by default one per core.
    scheduler
        Address of a Dask scheduler to use instead.
    progress
        Called with "scenes" and the fraction that is done.

    Raises
    ------
    InputError
        A grid or scenes that cannot be used at all; a single one that cannot is listed.
    """
    from fefinger.mechanics import names
    from fefinger.studies.grid import EACH, checked
    from fefinger.studies.tasks import Asked
    from fefinger.support.checks import InputError, choice, number
    from fefinger.support.outputs import output

    if mechanics is not None:
        choice("mechanics", mechanics, (*names(), EACH))
    count = None if workers is None else int(number("workers", workers, at_least=1))
    asked = Asked(scene, checked(over), changes or {}, mechanics, at)
    tasks, failed = asked.tasks()
    if not tasks:
        raise InputError(next(iter(failed.values())))
    with ExitStack() as opened:
        place = None
        if folder is not None:
            opened.enter_context(output(folder))
            place = opened.enter_context(output(Path(folder, "scenes")))
        return _answers(asked, tasks, failed, place, progress, count, scheduler)


def _answers(
    asked: "Asked",
    tasks: "Mapping[int, Task]",
    failed: Mapping[int, str],
    place: Path | None,
    progress: "Progress | None",
    workers: int | None,
    scheduler: str | None,
) -> Study:
    """Answer what is not kept in `place` already, and keep it there."""
    from fefinger.studies.grid import EACH
    from fefinger.studies.one_mechanics import agreed
    from fefinger.studies.tasks import keep, kept, made
    from fefinger.support.checks import InputError
    from fefinger.support.text import finite

    answers: dict[int, Answer] = {}
    chosen = ""
    if asked.mechanics != EACH:
        tasks, chosen = agreed(tasks, asked.over, place)
    if place is not None:
        found = ((i, kept(place, task)) for i, task in tasks.items())
        answers = {i: answer for i, answer in found if answer is not None}
    reused = len(answers)
    for i, answer in _answered(tasks, answers.keys() ^ tasks.keys(), workers, scheduler):
        answers[i] = {**finite(answer), **made()}
        if place is not None and "rows" in answer:
            with suppress(InputError):  # a disk that is full: the answer goes into the table still
                keep(place, tasks[i], answers[i])
        if progress is not None:
            progress("scenes", (len(answers) + len(failed)) / len(asked.points))
    done = _collected(asked, tasks, failed, answers, reused)
    return replace(done, about={**done.about, "chosen": chosen}) if chosen else done


def _answered(
    tasks: "Mapping[int, Task]", left: set[int], workers: int | None, scheduler: str | None
) -> "Iterator[tuple[int, Answer]]":
    """Give the answers to those tasks that are left, as they come."""
    from fefinger.studies.workers import cluster, local

    places = sorted(left)
    asked = [tasks[i] for i in places]
    if scheduler is None:
        answers = local(asked, workers)
    else:
        answers = cluster(asked, scheduler)
    for i, found in answers:
        yield places[i], found


def _collected(
    asked: "Asked",
    tasks: "Mapping[int, Task]",
    unusable: Mapping[int, str],
    answers: "Mapping[int, Answer]",
    reused: int,
) -> Study:
    """Return the rows in the order of the grid, with what each scene is."""
    from fefinger.studies.tasks import key, provenance

    one, points = next(iter(tasks.values()))["scene"], asked.points
    columns = asked.columns(one["motion"]["kind"])
    lost = {i: answer["error"] for i, answer in answers.items() if "error" in answer}
    failed = {**unusable, **lost}
    rows: list[dict[str, Any]] = []
    for i, values in enumerate(points):
        own = {columns[field]: _entry(value) for field, value in values.items()}
        none = [{"at": "", "status": f"failed: {failed.get(i)}"}]
        told = none if i in failed else answers[i]["rows"]
        last = {"scene": key(tasks[i])} if i in tasks else {}
        rows += [{**own, **row, **last} for row in told]
    return Study(
        name=one["name"],
        over=tuple(columns.values()),
        rows=tuple(rows),
        failures=tuple((points[i], failed[i]) for i in sorted(failed)),
        scenes=len(points),
        reused=reused,
        about={**asked.told(), **provenance(list(answers.values()), reused)},
    )


def _entry(value: Any) -> Any:
    """Return a value of a field as an entry of a table: a list as text."""
    return str(value) if isinstance(value, list | tuple | dict) else value
