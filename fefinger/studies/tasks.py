"""Scenes of a study as tasks of plain values, their stored answers, and processes for them.

An answer has "rows", or "error", a sentence. It is stored by a hash of all inputs of its task.
"""

import hashlib
import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fefinger.scene.builtin import given
from fefinger.scene.scene import Scene
from fefinger.studies.grid import EACH, MISSED, Row, parse_at, product
from fefinger.support import VERSION, atomic_write, processes
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.inputs import read_json
from fefinger.support.machine import software


FORMAT = 4
"""Version of the measures, in the hash; a higher one makes all scenes be computed again."""

AT = "1N", "1mm"
"""Force and depth of rows by default, besides the peak and the end."""

LEAN = {"ask.fields": False}
"""Changes to every scene, as a study uses no fields on the mesh."""

CHECKSUM = "sha256"
"""Key of the checksum of a stored record."""

Task = dict[str, Any]
Answer = dict[str, Any]


@dataclass(frozen=True)
class StudyRequest:
    """Inputs of a study: a scene, values of fields, and what holds for all scenes."""

    scene: Scene | str | Path
    over: Mapping[str, Sequence[object]]
    changes: Mapping[str, object]
    mechanics: str | None
    at: Sequence[str]

    @property
    def points(self) -> list[dict[str, object]]:
        """The combinations of the values, the last field changing fastest."""
        return product(self.over)

    def check(self, unusable: Mapping[int, str]) -> None:
        """Raise InputError for a value with which every scene is `unusable`, given their errors."""
        points = self.points
        for field, values in self.over.items():
            for value in values:
                errors = [unusable.get(i) for i, at in enumerate(points) if at[field] == value]
                if all(errors):
                    count = f"none of the {len(points)} scenes was run"
                    raise InputError(f"{errors[0]} (--over {field} = {value}; {count})")

    def wanted(self, row: Row) -> bool:
        """Return whether a row belongs into the table: at levels of AT only if they are reached."""
        return bool(self.at) or not row["status"].startswith(MISSED)

    def tasks(self) -> tuple[dict[int, Task], dict[int, str]]:
        """Make the tasks, and the errors of unusable scenes, by their number in the grid."""
        forces, depths = parse_at(self.at or AT)
        named = None if self.mechanics == EACH else self.mechanics
        shared = {"mechanics": named, "forces": list(forces), "depths": list(depths)}
        tasks: dict[int, Task] = {}
        unusable: dict[int, str] = {}
        for i, values in enumerate(self.points):
            try:
                scene = given(self.scene, {**LEAN, **self.changes, **values})
            except InputError as error:
                unusable[i] = str(error)
            else:
                tasks[i] = {"scene": scene.to_dict(), **shared}
        return tasks, unusable

    def record(self) -> dict[str, object]:
        """Return the inputs of the study as plain values."""
        return {
            "grid": {field: list(values) for field, values in self.over.items()},
            "changes": dict(self.changes),
            "mechanics": self.mechanics or "the cheapest that refuses no scene",
            "at": list(self.at or AT),
        }


def key(task: Task) -> str:
    """Return the hash of all inputs of a task, with surface files, plugins and versions."""
    parts = {**task, "fefinger": VERSION, "format": FORMAT}
    for name in ("surface", "bone_surface"):
        file = task["scene"]["finger"].get(name)
        if file is not None:
            parts[name] = hashlib.sha256(Path(file).read_bytes()).hexdigest()
    for name in task["scene"].get("plugins", ()):
        file = getattr(sys.modules.get(name), "__file__", None)
        if file is not None:
            parts[name] = hashlib.sha256(Path(file).read_bytes()).hexdigest()
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def write_record(path: Path, record: Mapping[str, object]) -> None:
    """Write plain values with a checksum into a folder that exists, or raise InputError."""
    text = json.dumps({**record, CHECKSUM: _checksum(record)}, allow_nan=False)
    with atomic_write.in_place(path) as new:
        new.write_text(text, encoding="utf-8")


def read_record(path: Path) -> dict[str, Any] | None:
    """Read what `write_record` has written; None if it is missing, damaged or edited."""
    try:
        record = read_json(path)
    except InputError:
        return None
    if not isinstance(record, dict) or record.pop(CHECKSUM, None) != _checksum(record):
        return None
    return record


def _checksum(record: Mapping[str, object]) -> str:
    return hashlib.sha256(json.dumps(record, sort_keys=True).encode()).hexdigest()


def place(folder: Path, task: Task) -> Path:
    """Return where the answer of a task is stored in a folder."""
    return folder / f"{key(task)}.json"


def provenance(answers: Sequence[Answer], reused: int) -> dict[str, object]:
    """Return software, dates, commits and seeds of a study's answers."""
    record: dict[str, object] = software()
    dates = sorted(answer["date"] for answer in answers)
    commits = sorted({answer["commit"] for answer in answers})
    rows = (row for answer in answers for row in answer.get("rows", ()))
    seeds = sorted({row["seed"] for row in rows if row.get("seed") is not None})
    record["answers"] = {
        "finished_before": f"{reused} of {len(answers)}",
        "dates": " to ".join(dict.fromkeys(dates[:1] + dates[-1:])),
        "commits": ", ".join(filter(None, commits)),
        "seeds": ", ".join(map(str, seeds)) or "none: nothing is drawn at random",
    }
    return record


def answer(task: Task) -> Answer:
    """Run the scene of a task with one BLAS thread; return its rows, or its error."""
    try:
        from fefinger.pipeline import run
        from fefinger.studies.measures import rows
        from fefinger.support.processes import one_blas_thread

        with one_blas_thread():
            result = run(Scene.from_dict(task["scene"]), mechanics=task["mechanics"])
            return {"rows": rows(result, forces=task["forces"], depths=task["depths"])}
    except (InputError, ConvergenceError) as error:
        return {"error": str(error)}
    except Exception as error:  # an error of one scene must not stop the others
        return {"error": f"unexpected {type(error).__name__}: {error}"}


def local(tasks: Sequence[Task], workers: int | None = None) -> Iterator[tuple[int, Answer]]:
    """Run tasks in local processes, by default one per core; yield (number, answer) as they finish.

    A process that dies loses only its current scene.
    """
    for number, outcome in processes.each(answer, tasks, workers or processes.cores()):
        if isinstance(outcome, processes.WorkerExit):
            outcome = {"error": str(outcome)}
        yield number, outcome


def cluster(tasks: Sequence[Task], address: str) -> Iterator[tuple[int, Answer]]:
    """Run tasks on the Dask cluster at `address`; yield as `local`.

    Raises InputError without the extra `distributed`, or without a scheduler at that address.
    """
    try:
        from dask.distributed import Client
        from dask.distributed import as_completed as completed
    except ImportError as error:
        raise InputError(
            "--scheduler: expected the extra 'distributed' to be installed, "
            f"received {error}; pip install 'fefinger[distributed]'"
        ) from None

    class Connected(Client):
        """A client that ends where it cannot connect: it would try to for 60 s when Python ends."""

        def __init__(self) -> None:
            try:
                # No default: it would stay the scheduler of every other library here.
                super().__init__(address, set_as_default=False)
            except Exception:  # of any class, as below; it is raised again after closing
                with suppress(Exception):  # closing what never opened may fail as well
                    self.close()
                raise

    try:
        client = Connected()
    except Exception as error:  # of any class: a TypeError where tls:// has no certificates
        raise InputError(
            "--scheduler: expected the address of a Dask scheduler, such as tcp://host:8786, "
            f"received {address!r} ({error})"
        ) from None
    with client, client.as_current():
        futures = {client.submit(answer, task, pure=False): i for i, task in enumerate(tasks)}
        for done in completed(futures):
            failure = done.exception()
            lost = {"error": f"the cluster lost this scene: {failure}"}
            yield futures[done], lost if failure else done.result()
