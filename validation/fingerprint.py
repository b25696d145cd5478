"""Record the answers of fefinger, and compare them with those after a change of its code.

    python -m fefinger.validation.fingerprint record FILE [--quick]
    python -m fefinger.validation.fingerprint compare FILE [--quick]

A fingerprint holds every built-in scene answered by every mechanics, the planner's choice for it,
the values of the quick validation suites, and the messages that bad input gets. Of the package it
uses the way of a scene and the command line, so that other modules can be moved under it. Numbers
are compared to `RELATIVE` of the largest absolute value of their array, spike times to
`SPIKE_SECONDS`, texts exactly; each difference is printed in one line, and the exit status is then
1.

Each record works in an empty cache of its own: the planner looks at what is kept there, and an
operator kept by older code would hide a change. Meshes are those that are shipped: another draw of
the mesher would be another mesh. `--quick` leaves out `pressed`, `solid` and the suites.

Compiled code rounds differently in the process that compiles it than when numba reads it from its
cache, and what is iterated to a tolerance then ends within that tolerance, not at the same bits. So
record and compare when everything is compiled: after a change run the command twice.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import chdir, contextmanager
from dataclasses import asdict, dataclass, field
from itertools import takewhile
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from fefinger.validation.empty_cache import empty_cache
from fefinger.validation.unusable import BAD_COMMANDS, BAD_TABLES, FILES
from threadpoolctl import threadpool_limits

from fefinger.pipeline import run
from fefinger.plan import choose, explain
from fefinger.results.result_record import Plan
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError, InputError


Kind = TypeVar("Kind")
Tables = dict[str, Any]

RELATIVE = 1e-12
"""Part of the largest absolute value of an array that is no difference."""

SPIKE_SECONDS = 1e-9

SUMMARY = "Record what fefinger answers, or tell what of it has changed."

SEPARATOR, SPIKES, SUITES = " | ", "spikes of ", "suites"
"""Between the parts of a label, and two of the parts."""

QUANTITIES = ("time", "depth", "force", "contact_area", "centroid")
AT_PLACES = ("pressure", "strain")
"""What is recorded of a Result: the first at all times, the others at about `TIMES` of them."""

TIMES = 100

FAST, SLOW = ("lumped", "hertz", "layered", "condensed", "linear"), ("pressed", "solid")

FORCE = {"ask.fields": False, "ask.pressure": False, "ask.strain": False, "ask.spikes": []}
NO_FIELDS = {"ask.fields": False, "ask.pressure": True, "ask.strain": True}
COARSE = {"finger.resolution": "coarse", **NO_FIELDS}
ASKED: Mapping[str, Mapping[str, Any]] = {
    "lumped": FORCE,
    "hertz": NO_FIELDS,
    "layered": NO_FIELDS,
    "condensed": COARSE,
    "linear": COARSE,
    "pressed": COARSE,
    "solid": COARSE,
}
"""Changes that let a mechanics answer: it is asked for all that it has but the fields."""

CHANGED: Mapping[str, Mapping[str, Any]] = {
    "edge-press": {"motion.hold": 0.5},
    "flat-press": {"motion.hold": 0.5},
    "flat-sinusoid": {"motion.cycles": 1},
    "grating-press": {"motion.hold": 0.5},
    "p11-constant-current": {"motion.hold": 0.5},
    "p2-ramp-and-hold": {"motion.hold": 0.5},
    "p3-ramp-and-sinusoid": {"motion.cycles": 1},
    "p4-repetitive-task": {"motion.cycles": 2},
    "p5-quasi-static-array": {"motion.speed": 4.0},
    "p6-sinusoid-array": {"motion.cycles": 1},
    "p7-curvature": {"motion.hold": 0.5, "indenter.radius": 5.81},
    "p8-sinusoid": {"motion.cycles": 2},
    "p9-ramp-hold-retract": {"motion.hold": 0.2},
    "press-to-1N": {"motion.hold": 0.5},
    "sphere-press": {"motion.hold": 0.5},
    "vibration-200Hz": {"motion.cycles": 4, "motion.settle": 0.05},
}
"""Changes to a scene when it is answered; it is planned as it is.

They shorten its motion; and p7 takes its next larger ball, as 2.94 mm is beyond the coarse mesh.
"""

UNSHIPPED = ("curved-hold", "p10-ball-on-array", "pin-hold", "probe-vibration")
"""Scenes whose finger has no shipped coarse mesh: they are answered without one only."""

MESHED = ("condensed", "linear", *SLOW)

DRAWN = ("twin: ",)
"""Beginnings of the names of validation cases on a mesh that is drawn anew, and so left out."""


@dataclass(frozen=True)
class Fingerprint:
    """Arrays, single numbers and texts by their label "scene | mechanics | quantity"."""

    quick: bool
    arrays: dict[str, Array] = field(default_factory=dict)
    values: dict[str, float] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)

    @property
    def labels(self) -> list[str]:
        """Labels of everything that was recorded, in order."""
        return [*self.arrays, *self.values, *self.texts]

    def save(self, path: Path) -> None:
        """Write one .npz file: the arrays, and the rest as JSON."""
        rest = {"quick": self.quick, "values": self.values, "texts": self.texts}
        named: dict[str, Any] = {
            f"array {number}": array for number, array in enumerate(self.arrays.values())
        }
        header = json.dumps({"arrays": list(self.arrays), **rest})
        with path.open("wb") as file:
            np.savez_compressed(file, header=np.array(header), **named)

    @classmethod
    def load(cls, path: Path) -> "Fingerprint":
        """Read what `save` wrote."""
        with np.load(path) as file:
            rest = json.loads(str(file["header"]))
            arrays = {label: file[f"array {number}"] for number, label in enumerate(rest["arrays"])}
        return cls(rest["quick"], arrays, rest["values"], rest["texts"])

    def without_slow(self) -> "Fingerprint":
        """Return the part that a quick record has."""
        return Fingerprint(True, _fast(self.arrays), _fast(self.values), _fast(self.texts))


def _fast(part: dict[str, Kind]) -> dict[str, Kind]:
    return {label: each for label, each in part.items() if not _slow(label)}


def _slow(label: str) -> bool:
    subject, part, *_ = label.split(SEPARATOR)
    return subject == SUITES or part in SLOW


def differences(base: Fingerprint, new: Fingerprint) -> Iterator[str]:
    """Give one line for each difference between two fingerprints."""
    base_labels, new_labels = set(base.labels), set(new.labels)
    yield from (f"{label}: missing" for label in base.labels if label not in new_labels)
    yield from (f"{label}: not in the base" for label in new.labels if label not in base_labels)
    for label, array in base.arrays.items():
        if label in new.arrays:
            yield from _of_arrays(label, array, new.arrays[label])
    for label, value in base.values.items():
        if label in new.values:
            yield from _of_arrays(label, np.array(value), np.array(new.values[label]))
    for label, text in base.texts.items():
        if label in new.texts:
            yield from _of_texts(label, text, new.texts[label])


def _of_arrays(label: str, base: Array, new: Array) -> Iterator[str]:
    if base.shape != new.shape:
        yield f"{label}: shape {new.shape}, was {base.shape}"
        return
    same = (base == new) | (np.isnan(base) & np.isnan(new))
    with np.errstate(invalid="ignore"):
        apart = np.nan_to_num(np.where(same, 0.0, np.abs(new - base)), nan=np.inf)
    scale = float(np.max(np.abs(base), initial=0.0, where=np.isfinite(base)))
    spikes = label.split(SEPARATOR)[-1].startswith(SPIKES)
    limit = SPIKE_SECONDS if spikes else RELATIVE * scale
    worst = float(np.max(apart, initial=0.0))
    if worst > limit:
        at = np.unravel_index(int(np.argmax(apart)), apart.shape)
        where = f" at {tuple(int(i) for i in at)}" if at else ""
        size = f", {worst / scale:.2g} of the largest value" if scale > 0 else ""
        yield f"{label}: {float(new[at])!r}, was {float(base[at])!r}{where}{size}"


def _of_texts(label: str, base: str, new: str) -> Iterator[str]:
    if base != new:
        same = takewhile(lambda pair: pair[0] == pair[1], zip(base, new, strict=False))
        first = len(tuple(same))
        excerpt = slice(max(first - 20, 0), first + 60)
        start = excerpt.start
        yield f"{label}: text {new[excerpt]!r}, was {base[excerpt]!r} (from character {start})"


def record(*, quick: bool) -> Fingerprint:
    """Answer everything and return what came out; progress goes to standard error.

    Raises RuntimeError if a mesh had to be drawn, which would be another one the next time.
    """
    made = Fingerprint(quick)
    with _alone() as folder, threadpool_limits(1, user_api="blas"):
        tables = {name: _table(name) for name in _scenes()}
        for name, table in tables.items():
            with _reported(f"{name}: plan"):
                _plan(made, name, Scene.from_dict(table))
        for name, table in tables.items():  # measures the machine, on which a plan may depend
            with _reported(f"{name}: ladder"):
                _ladder(made, name, Scene.from_dict(table))
        for name, table in tables.items():
            for mechanics in FAST if quick else (*FAST, *SLOW):
                with _reported(f"{name}: {mechanics}"):
                    _answer(made, name, table, mechanics)
        with _reported("messages"):
            _messages(made, tables["flat-press"], folder)
        drawn = [entry for entry in _json("cache")["entries"] if entry["kind"] == "meshes"]
        if drawn:
            message = f"fingerprint: expected shipped meshes alone, but these were drawn: {drawn}"
            raise RuntimeError(message)
        if not quick:
            with _reported("suites"):
                _suites(made)
    return made


@contextmanager
def _alone() -> Iterator[Path]:
    """Work in an empty folder, with an empty cache."""
    with tempfile.TemporaryDirectory() as folder, empty_cache(), chdir(folder):
        yield Path(folder)


@contextmanager
def _reported(what: str) -> Iterator[None]:
    """Say on standard error how much CPU time the work inside took."""
    before = sum(os.times()[:4])
    yield
    print(f"{what}: {sum(os.times()[:4]) - before:.1f} s of CPU", file=sys.stderr, flush=True)


def _command(*words: str) -> "subprocess.CompletedProcess[str]":
    """Run the command line, with BLAS on one thread as in this process."""
    return subprocess.run(
        [sys.executable, "-m", "fefinger", *words],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
    )


def _json(*words: str) -> Any:
    return json.loads(_command(*words, "--json").stdout)


def _scenes() -> list[str]:
    return [scene["name"] for scene in _json("scenes")["scenes"]]


def _table(name: str) -> Tables:
    return dict(_json("scenes", name))


def _label(*parts: str) -> str:
    return SEPARATOR.join(parts)


def _plan(made: Fingerprint, name: str, scene: Scene) -> None:
    """Record what the planner chooses, with the times of the machine of the reports."""
    try:
        plan = choose(scene)
    except InputError as error:
        made.texts[_label(name, "plan", "refused")] = _timeless(str(error))
        return
    made.texts[_label(name, "plan", "mechanics")] = plan.mechanics
    made.texts[_label(name, "plan", "settings")] = _settings(plan)
    made.texts[_label(name, "plan", "trust")] = plan.trust


def _settings(plan: Plan) -> str:
    return json.dumps(None if plan.settings is None else asdict(plan.settings))


def _ladder(made: Fingerprint, name: str, scene: Scene) -> None:
    """Record the expected errors and the refusals of every mechanics on every mesh."""
    try:
        plan = explain(scene)
    except InputError as error:
        made.texts[_label(name, "ladder", "refused")] = _timeless(str(error))
        return
    for rung in plan.rungs:
        candidate = f"{rung.mechanics} {rung.resolution or ''}".strip()
        made.texts[_label(name, "ladder", f"{candidate} evidence")] = rung.evidence
        refusals = "\n".join(f"{each.about}: {each.reason}" for each in rung.refusals)
        made.texts[_label(name, "ladder", f"{candidate} refusals")] = refusals
        for quantity, size in {"force": rung.error, **rung.errors}.items():
            made.values[_label(name, "ladder", f"{candidate} error of {quantity}")] = float(size)


def _answer(made: Fingerprint, name: str, table: Tables, mechanics: str) -> None:
    """Record the answer of one mechanics to a scene, or why there is none."""
    if name in UNSHIPPED and mechanics in MESHED:
        return
    changes = {**CHANGED.get(name, {}), **ASKED[mechanics]}
    try:
        result = run(Scene.from_dict(_changed(table, changes)), mechanics=mechanics)
    except (InputError, ConvergenceError) as error:
        text = f"{type(error).__name__}: {error}"
        made.texts[_label(name, mechanics, "refused")] = _timeless(text)
        return
    made.texts[_label(name, mechanics, "notes")] = "\n".join(result.notes)
    every = max(len(result.time) // TIMES, 1)
    for quantity in (*QUANTITIES, *AT_PLACES):
        values = getattr(result, quantity)
        if values is not None:
            sampled = values[::every] if quantity in AT_PLACES else values
            made.arrays[_label(name, mechanics, quantity)] = np.asarray(sampled, float)
    if result.spikes is not None:
        for unit, times in zip(result.spikes.names, result.spikes.times, strict=True):
            made.arrays[_label(name, mechanics, f"{SPIKES}{unit}")] = np.asarray(times, float)


def _messages(made: Fingerprint, table: Tables, folder: Path) -> None:
    """Record the messages for unusable scenes and command lines."""
    for changes in BAD_TABLES:
        label = _label("messages", "scene", json.dumps(changes))
        try:
            Scene.from_dict(_changed(table, changes))
            made.texts[label] = "accepted"
        except InputError as error:
            made.texts[label] = str(error)
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    for line in BAD_COMMANDS:
        done = _command(*line.split())
        output = f"exit status {done.returncode}\n{done.stderr}".replace(str(folder), "FOLDER")
        made.texts[_label("messages", "command", line)] = _timeless(output)


def _suites(made: Fingerprint) -> None:
    """Record value and verdict of every case of the quick suites."""
    for suite in _json("validate", "--quick")["suites"]:
        for case in suite["cases"]:
            if case["name"].startswith(DRAWN):
                continue
            value = np.nan if case["value"] is None else case["value"]
            made.values[_label(SUITES, suite["suite"], case["name"])] = float(value)
            verdict = f"{case['verdict']} {case['failure']}".strip()
            made.texts[_label(SUITES, suite["suite"], case["name"], "verdict")] = verdict


def _changed(table: Tables, changes: Mapping[str, Any]) -> Tables:
    """Return a copy of the tables of a scene with values set by their dotted path."""
    result: Tables = json.loads(json.dumps(table))
    for path, value in changes.items():
        *parents, key = path.split(".")
        place = result
        for parent in parents:
            place = place.setdefault(parent, {})
        place[key] = value
    return result


def _timeless(text: str) -> str:
    """Return a message without expected times, which depend on the machine, and their padding."""
    return re.sub(r" +", " ", re.sub(r"\b[\d.]+ (ms|s|min|h)\b", "TIME", text))


def main(arguments: list[str]) -> int:
    """Record a fingerprint, or compare the present code with one; exit status 1: it differs."""
    parser = argparse.ArgumentParser(prog="fingerprint", description=SUMMARY)
    parser.add_argument("action", choices=("record", "compare"))
    parser.add_argument("file", type=Path, metavar="FILE", help="fingerprint, an .npz file")
    parser.add_argument("--quick", action="store_true", help="without `pressed`, `solid`, suites")
    options = parser.parse_args(arguments)
    if options.action == "record":
        record(quick=options.quick).save(options.file)
        return 0
    base = Fingerprint.load(options.file)
    if base.quick and not options.quick:
        parser.error(f"{options.file} is quick: record a whole one, or compare with --quick")
    lines = list(
        differences(base.without_slow() if options.quick else base, record(quick=options.quick))
    )
    print("\n".join(lines) if lines else "no difference")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
