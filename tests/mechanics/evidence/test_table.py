"""The table of evidence against the reports that it is read from."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fefinger.mechanics.evidence import table
from fefinger.mechanics.evidence.table import Measured, read
from fefinger.results.candidate import Candidate


def curve(report: str, quantity: str, label: str, press: str) -> Measured:
    return table.table().presses(report, quantity, Candidate.of(label))[press]


def test_every_report_is_in_the_table_and_every_entry_has_numbers() -> None:
    assert {each.report for each in table.table().entries} == set(table.READERS)
    for each in table.table().entries:
        assert each.values.dtype == float
        assert each.depth is None or each.depth.shape == each.values.shape
        keyed = table.table().all(each.report, each.quantity, each.candidate)
        assert any(each is other for other in keyed)


ENTRIES = [
    (
        *(table.SMALL_STRAIN_COST, "setup seconds", "linear coarse", ""),
        "rows > linear coarse > setup_seconds",
    ),
    (table.PRESS_MESH, "force", "solid", "a.h./flat-30", "rows > a.h./flat-30 > force_N"),
    (table.SMALL_STRAIN_COST, "step seconds", "layered", "", "rows > layered > step_seconds"),
    (
        *(table.TIME_STEPS, "error of strain", "linear", ""),
        "rows > linear > strain",
    ),
]
"""Report, quantity, candidate and press of entries, and where the report has their numbers."""


@pytest.mark.parametrize(("report", "quantity", "label", "press", "place"), ENTRIES)
def test_an_entry_holds_the_numbers_of_its_report(
    report: str, quantity: str, label: str, press: str, place: str
) -> None:
    written: Any = read(report)
    for key in place.split(" > "):
        written = written[key]
    found = curve(report, quantity, label, press)
    assert found.values.tolist() == np.atleast_1d(written).tolist()


def test_seconds_of_solid_are_one_entry_per_press_in_their_order() -> None:
    every = [each for each in table.table().entries if each.report == table.SOLID_COST]
    steps = [each.value for each in every if each.quantity == "step seconds"]
    assert steps == [row["step_seconds"] for row in read(table.SOLID_COST)["rows"]]


def test_no_other_module_of_the_mechanics_opens_a_report() -> None:
    room = Path(table.__file__).parents[1]
    readers = [path for path in room.rglob("*.py") if "read_report" in path.read_text("utf-8")]
    assert readers == [Path(table.__file__)]
