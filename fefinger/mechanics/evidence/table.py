"""Every measured error and cost of the mechanics, from all reports, as one table of one shape.

An entry says what was measured (`quantity`), of which candidate, in which press, under which
conditions, and in which report it stands. The rules of refusal, error and cost read entries; no
other module knows how a report is laid out.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Any

import numpy as np

from fefinger.results.candidate import Candidate
from fefinger.support.arrays import Array
from fefinger.support.inputs import read_report


SMALL_STRAIN_COST = "small-strain-cost.json"
SOLID_COST = "solid-cost.json"
LUMPED = "lumped-force.json"
TIME_STEPS = "time-steps.json"
TABULATION = "pressed-error.json"
PRESS_MESH = "press-mesh.json"

MAIN = "a.h."
"""Subject whose finger was pressed by every object."""

TABULATION_SETS = ("rules", "held-out", "deep", "standard", "built-in", "light")
"""Sets of scenes in which `pressed` was compared with `solid`: four draws, built-in ones, and light
touches that retreat."""

AS_ONE = "force relaxed as one"
"""Force of a table that relaxes as that of small strain does: with its whole stress."""

SECONDS = ("build", "setup", "fields", "step", "area", "reference")
"""Stages whose CPU seconds are measured, as quantities "setup seconds" and so on."""


@dataclass(frozen=True, eq=False)
class Measured:
    """One quantity of one candidate in one press.

    values (n,): over the `depth` (n,) in mm, one where it is no curve, nan where the mesh is too
    coarse for it. `conditions` hold sizes and tissue of what was pressed, and the object.
    """

    report: str
    candidate: Candidate
    quantity: str
    press: str
    values: Array
    depth: Array | None = None
    conditions: Mapping[str, Any] = field(default_factory=dict)

    @property
    def finger(self) -> str:
        """Subject whose finger was pressed, or the name of published tissue."""
        return self.press.partition("/")[0]

    @property
    def object(self) -> str:
        """Name of the object that pressed it."""
        return self.press.partition("/")[2]

    @property
    def value(self) -> float:
        """The value where it is no curve, else that at the largest depth."""
        return float(self.values[-1])

    @cached_property
    def part(self) -> Array:
        """Depth (n,) over the thickness of the finger."""
        assert self.depth is not None
        return np.asarray(self.depth / self.conditions["thickness_mm"])


class Table:
    """Entries by report, quantity, candidate and press."""

    def __init__(self, entries: Iterator[Measured]) -> None:
        """Index the entries; of equal keys all are kept."""
        self.entries = tuple(entries)
        self._groups: dict[tuple[str, str, Candidate], list[Measured]] = {}
        for each in self.entries:
            key = each.report, each.quantity, each.candidate
            self._groups.setdefault(key, []).append(each)

    def all(self, report: str, quantity: str, candidate: Candidate) -> list[Measured]:
        """Return all entries of a quantity of a candidate."""
        return self._groups.get((report, quantity, candidate), [])

    def presses(self, report: str, quantity: str, candidate: Candidate) -> dict[str, Measured]:
        """Return the entries of a quantity of a candidate by press."""
        return {each.press: each for each in self.all(report, quantity, candidate)}

    def value(self, report: str, quantity: str, candidate: Candidate) -> float:
        """Return the value of a quantity that is of no press."""
        return self.presses(report, quantity, candidate)[""].value


@cache
def read(name: str) -> dict[str, Any]:
    """Return a report as it is written."""
    measured: dict[str, Any] = json.loads(read_report(name))
    return measured


@cache
def table() -> Table:
    """Return the table of all reports."""
    return Table(each for name, entries in READERS.items() for each in entries(name))


def _entry(
    report: str,
    candidate: Candidate,
    quantity: str,
    press: str,
    values: Any,
    depth: Any = None,
    conditions: Mapping[str, Any] | None = None,
) -> Measured:
    """Return an entry; None among its values becomes nan."""
    array = np.atleast_1d(np.array(values, dtype=float))
    depths = None if depth is None else np.array(depth, dtype=float)
    return Measured(report, candidate, quantity, press, array, depths, conditions or {})


def _costs(
    name: str,
    candidate: Candidate,
    row: Mapping[str, Any],
    conditions: Mapping[str, Any] | None = None,
) -> Iterator[Measured]:
    for stage in SECONDS:
        if f"{stage}_seconds" in row:
            seconds = row[f"{stage}_seconds"]
            yield _entry(name, candidate, f"{stage} seconds", "", seconds, None, conditions)


def _small_strain_cost(name: str) -> Iterator[Measured]:
    for label, row in read(name)["rows"].items():
        candidate = Candidate.of(label)
        yield from _costs(name, candidate, row)
        if "unknowns" in row:
            yield _entry(name, candidate, "unknowns", "", row["unknowns"])


def _solid_cost(name: str) -> Iterator[Measured]:
    for row in read(name)["rows"]:
        yield from _costs(name, Candidate("solid", row["mesh"]), row, row)


def _lumped(name: str) -> Iterator[Measured]:
    candidate = Candidate("lumped")
    for row in read(name)["rows"]:
        yield _entry(name, candidate, "law", row["source"], (row["b"], row["m"]), None, row)


def _time_steps(name: str) -> Iterator[Measured]:
    for mechanics, row in read(name)["rows"].items():
        for quantity, error in row.items():
            yield _entry(name, Candidate(mechanics), f"error of {quantity}", "", error)


def _tabulation(name: str) -> Iterator[Measured]:
    candidate = Candidate("pressed")
    for row in (row for draw in TABULATION_SETS for row in read(name)[draw].values()):
        if "refused" in row:
            continue
        errors = dict(row["peak"])
        if "force" in row["loading"]:  # else the force is prescribed
            errors["force"] = row["loading"]["force"]
        for quantity in ("force", "strain", "area"):
            if quantity in row["retreat"]:
                errors[f"{quantity} on retreat"] = row["retreat"][quantity]
        for phase, error in row.get("relaxed as one", {}).items():
            errors[AS_ONE if phase == "loading" else f"{AS_ONE} on retreat"] = error
        conditions, scene = {"part": row["part"]}, row["scene"]["name"]
        for quantity, error in errors.items():
            what = f"error of {quantity}"
            yield _entry(name, candidate, what, scene, error, None, conditions)
    for mesh, row in read(name)["costs"].items():
        yield from _costs(name, Candidate("pressed", mesh), row)


def _press_mesh(name: str) -> Iterator[Measured]:
    for press, row in read(name)["rows"].items():
        if "refused" in row:
            continue
        conditions = {key: row[key] for key in ("thickness_mm", "subcutaneous_kPa")}
        depth, candidate = row["depth_mm"], Candidate("solid")
        yield _entry(name, candidate, "force", press, row["force_N"], depth, conditions)
        for label, errors in row["errors"].items():
            for quantity, values in errors.items():
                what, of = f"error of {quantity}", Candidate.of(label)
                yield _entry(name, of, what, press, values, depth, conditions)


READERS = {
    SMALL_STRAIN_COST: _small_strain_cost,
    SOLID_COST: _solid_cost,
    LUMPED: _lumped,
    TIME_STEPS: _time_steps,
    TABULATION: _tabulation,
    PRESS_MESH: _press_mesh,
}
"""How each report is laid out."""
