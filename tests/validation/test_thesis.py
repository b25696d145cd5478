"""The suite `thesis`: what it says about itself, its verdicts, and that its figures are drawn."""

import dataclasses
import re

import pytest


case_module = pytest.importorskip("fefinger.validation.case")
suites = pytest.importorskip("fefinger.validation.suites")

DRAWN = (
    *("2-2", "2-3", "2-4", "2-5", "2-6", "2-8", "2-10", "3-2", "3-3", "3-4", "3-5", "3-6"),
    *("3-8", "3-10", "5-1", "A-4", "A-5"),
)


def test_every_tolerance_has_its_reason_and_can_fail():
    for case in suites.cases("thesis", quick=True):
        assert case.reason, case.name
        expected = case.expected
        assert 0 < expected.tolerance <= (0.06 * abs(expected.value) or 3.0), case.name


@pytest.mark.parametrize(
    ("value", "printed", "verdict"),
    [
        (1.05, None, "pass"),
        (1.05, 1.08, "pass"),
        (1.05, 1.2, "documented"),
        (1.15, 1.2, "fail"),
        (float("nan"), None, "fail"),
    ],
)
def test_a_verdict_is_about_ours_first(value, printed, verdict):
    case = case_module.Case("n", lambda: value, case_module.Expected(1.0, 0.1, "N"), "", printed)
    assert case_module.Outcome(case, value).verdict == verdict
    moved = dataclasses.replace(case, expected=case_module.Expected(2.0, 0.1, "N"))
    assert case_module.Outcome(moved, value).verdict == "fail"


def test_the_figures_of_the_thesis_are_drawn():
    found = suites.figures({"suites": [{"suite": "thesis", "cases": []}]})
    captions = [caption for caption, _ in found["thesis"]]
    numbers = [n for text in captions for n in re.findall(r"\d-\d+|A-\d", text.split(".")[0])]
    assert set(DRAWN) <= set(numbers)
    for _, drawn in found["thesis"]:
        for axis in drawn.axes:
            assert axis.get_xlabel() or axis.get_ylabel()
            assert axis.lines or axis.collections
