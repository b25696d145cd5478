"""Scenes of a study as tasks of plain values, stored under a hash of all their inputs.

A task is the input of a worker process; its answer has "rows", or "error", a sentence.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fefinger.scene.builtin import given
from fefinger.scene.scene import Scene
from fefinger.studies.columns import MISSED
from fefinger.studies.grid import EACH, parse_at, product
from fefinger.support import atomic_write
from fefinger.support.checks import InputError
from fefinger.support.provenance import software
from fefinger.support.version import VERSION


FORMAT = 3
"""Version of the measures in the hash; increased when they change, to compute scenes again."""

AT = "1N", "1mm"
"""Default force and depth of the rows, besides the peak and the end."""

LEAN = {"ask.fields": False}
"""Changes to every scene: a study does not use fields on the mesh."""

Task = dict[str, Any]
Answer = dict[str, Any]


@dataclass(frozen=True)
class StudyRequest:
    """Inputs of a study: a scene, the grid of field values, and the settings of all scenes."""

    scene: Scene | str | Path
    over: Mapping[str, Sequence[Any]]
    changes: Mapping[str, Any]
    mechanics: str | None
    at: Sequence[str]

    @property
    def points(self) -> list[dict[str, Any]]:
        """The combinations of the values, in order."""
        return product(self.over)

    def check(self, unusable: Mapping[int, str]) -> None:
        """Raise InputError for a value of the grid that makes every scene with it unusable."""
        points = self.points
        for field, values in self.over.items():
            for value in values:
                errors = [unusable.get(i) for i, at in enumerate(points) if at[field] == value]
                if all(errors):
                    count = f"none of the {len(points)} scenes was run"
                    raise InputError(f"{errors[0]} (--over {field} = {value}; {count})")

    def wanted(self, row: Mapping[str, Any]) -> bool:
        """Whether a row belongs into the table: at levels of AT only those that are reached."""
        return bool(self.at) or not row["status"].startswith(MISSED)

    def tasks(self) -> tuple[dict[int, Task], dict[int, str]]:
        """Make the tasks by their number in the grid; also the errors of unusable scenes."""
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

    def record(self) -> dict[str, Any]:
        """Record the inputs of the study as plain values."""
        return {
            "grid": {field: list(values) for field, values in self.over.items()},
            "changes": dict(self.changes),
            "mechanics": self.mechanics or "the cheapest that refuses no scene",
            "at": list(self.at or AT),
        }


def key(task: Task) -> str:
    """Hash of all inputs of a task, surface files and versions included."""
    parts = {**task, "fefinger": VERSION, "format": FORMAT}
    for name in ("surface", "bone_surface"):
        file = task["scene"]["finger"].get(name)
        if file is not None:
            parts[name] = hashlib.sha256(Path(file).read_bytes()).hexdigest()
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def store(folder: Path, task: Task, answer: Answer) -> None:
    """Write the answer of a task into a folder."""
    atomic_write.write(folder, {f"{key(task)}.json": json.dumps(answer, allow_nan=False)})


def load(folder: Path, task: Task) -> Answer | None:
    """Read the answer of a task from a folder; None if it is missing or damaged."""
    try:
        answer = json.loads((folder / f"{key(task)}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    complete = isinstance(answer, dict) and {"rows", "date", "commit"} <= answer.keys()
    return answer if complete else None


def made() -> dict[str, str]:
    """Date and commit of new answers, which are stored with them."""
    now = software()
    return {"date": now["date"], "commit": now["commit"]}


def provenance(answers: Sequence[Answer], reused: int) -> dict[str, Any]:
    """Provenance of a study's answers: software, dates, commits and seeds."""
    record: dict[str, Any] = software()
    dates = sorted(answer["date"] for answer in answers)
    commits = sorted({answer["commit"] for answer in answers})
    seeds = sorted(
        {
            row["seed"]
            for answer in answers
            for row in answer.get("rows", ())
            if row.get("seed") is not None
        }
    )
    record["answers"] = {
        "finished_before": f"{reused} of {len(answers)}",
        "dates": " to ".join(dict.fromkeys(dates[:1] + dates[-1:])),
        "commits": ", ".join(filter(None, commits)),
        "seeds": ", ".join(map(str, seeds)) or "none: nothing is drawn at random",
    }
    return record
