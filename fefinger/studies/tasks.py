"""The scenes of a study as tasks of plain values, under the hash of all that decides their answer.

A task is what a process of this machine or of a cluster is given; its answer has "rows", or
"error", a sentence.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fefinger.studies.columns import column
from fefinger.studies.grid import EACH, parse_at, product
from fefinger.support.atomic_write import in_place
from fefinger.support.checks import InputError
from fefinger.support.version import VERSION


if TYPE_CHECKING:
    from fefinger.scene.scene import Scene

FORMAT = 3
"""Raised when the measures change, so that scenes are answered again."""

LEAN = {"ask.fields": False}
"""A study has no use for fields on the mesh."""

WHOLE = ("finger.subject", "finger.surface", "finger.tissue")
"""Fields that decide others, which a Scene has already written out."""

Task = dict[str, Any]
Answer = dict[str, Any]


@dataclass(frozen=True)
class Asked:
    """What a study is of: a scene, the values of its fields, and what all its scenes share."""

    scene: "Scene | str | Path"
    over: Mapping[str, Sequence[Any]]
    changes: Mapping[str, Any]
    mechanics: str | None
    at: Sequence[str]

    @property
    def points(self) -> list[dict[str, Any]]:
        """The combinations of the values, in order."""
        return product(self.over)

    def tasks(self) -> tuple[dict[int, Task], dict[int, str]]:
        """Return the tasks by their place in the grid, and why the others are none."""
        forces, depths = parse_at(self.at)
        named = None if self.mechanics == EACH else self.mechanics
        shared = {"mechanics": named, "forces": list(forces), "depths": list(depths)}
        tasks: dict[int, Task] = {}
        unusable: dict[int, str] = {}
        for i, values in enumerate(self.points):
            try:
                scene = changed(self.scene, {**LEAN, **self.changes, **values})
            except InputError as error:
                unusable[i] = str(error)
            else:
                tasks[i] = {"scene": scene.to_dict(), **shared}
        return tasks, unusable

    def columns(self, kind: str) -> dict[str, str]:
        """Return the columns of the fields, for a kind of motion."""
        return {field: column(field, kind) for field in self.over}

    def told(self) -> dict[str, Any]:
        """Return what it takes to ask the same again."""
        grid = {field: list(values) for field, values in self.over.items()}
        return {
            "grid": grid,
            "changes": dict(self.changes),
            "mechanics": self.mechanics or "the cheapest that refuses no scene",
            "at": list(self.at),
        }


def changed(scene: "Scene | str | Path", overrides: Mapping[str, Any]) -> "Scene":
    """Return a scene, by its name, file or itself, with changes.

    Raises
    ------
    InputError
        No such scene, a change that cannot be used, or one that a Scene has already followed.
    """
    from fefinger.scene import builtin
    from fefinger.scene.scene import Scene

    if not isinstance(scene, Scene):
        return builtin.load(scene, overrides)
    for field in WHOLE:
        if field in overrides:
            msg = (
                f"{field}: expected the name or the file of a scene to change it in, received a "
                "Scene, which has all that follows from it written out"
            )
            raise InputError(msg)
    return Scene.from_dict(builtin.changed(scene.to_dict(), overrides))


def key(task: Task) -> str:
    """Return the hash of all that decides the answer to a task: files and versions included."""
    parts = {**task, "fefinger": VERSION, "format": FORMAT}
    for name in ("surface", "bone_surface"):
        file = task["scene"]["finger"].get(name)
        if file is not None:
            parts[name] = hashlib.sha256(Path(file).read_bytes()).hexdigest()
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def keep(folder: Path, task: Task, answer: Answer) -> None:
    """Write the answer to a task into a folder."""
    write(folder / f"{key(task)}.json", json.dumps(answer, allow_nan=False))


def kept(folder: Path, task: Task) -> Answer | None:
    """Return the answer to a task that a folder has; a damaged one counts as none."""
    try:
        found = json.loads((folder / f"{key(task)}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    whole = isinstance(found, dict) and {"rows", "date", "commit"} <= found.keys()
    return found if whole else None


def made() -> dict[str, str]:
    """Return when and by which commit answers are made, which is kept with them."""
    from fefinger.support.provenance import software

    now = software()
    return {"date": now["date"], "commit": now["commit"]}


def provenance(answers: Sequence[Answer], reused: int) -> dict[str, Any]:
    """Return what made the answers of a study, the last of them now: program, dates and seeds."""
    from fefinger.support.provenance import software

    told: dict[str, Any] = software()
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
    told["answers"] = {
        "finished_before": f"{reused} of {len(answers)}",
        "dates": " to ".join(dict.fromkeys(dates[:1] + dates[-1:])),
        "commits": ", ".join(filter(None, commits)),
        "seeds": ", ".join(map(str, seeds)) or "none: nothing is drawn at random",
    }
    return told


def write(path: Path, text: str) -> None:
    """Write a file, which appears complete or not at all."""
    with in_place(path) as new:
        new.write_text(text, encoding="utf-8")
