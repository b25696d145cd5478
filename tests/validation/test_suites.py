"""The cases of every suite, before any of them is measured, and what makes their verdicts."""

import re

import pytest
from fefinger.validation import suites
from fefinger.validation.afferents.suite import MISSES as OF_AFFERENTS
from fefinger.validation.case import Case, Expected, Outcome
from fefinger.validation.human.misses import MISSES as OF_HUMANS


DRAWN = (
    *("2-2", "2-3", "2-4", "2-5", "2-6", "2-8", "2-10", "3-2", "3-3", "3-4", "3-5", "3-6"),
    *("3-8", "3-10", "5-1", "A-4", "A-5"),
)
"""Figures of the thesis."""


@pytest.mark.parametrize("quick", [False, True], ids=["whole", "quick"])
@pytest.mark.parametrize("suite", suites.SUITES)
def test_every_case_has_a_name_a_source_a_tolerance_and_says_why_it_differs(suite, quick):
    cases = suites.cases(suite, quick=quick)
    assert len({case.name for case in cases}) == len(cases) > 0
    for case in cases:
        expected = case.expected
        assert case.source, case.name
        assert case.reason or suite not in ("fem", "neural", "thesis"), case.name
        if expected.tolerance == 0:  # only counts: no verdict may hang on a rounding
            assert expected.value == round(expected.value), case.name
        assert Outcome(case, expected.value + 1.01 * expected.tolerance + 1e-9).verdict == "fail"
        for other, why in ((case.printed, case.erratum), (case.wanted, case.shortfall)):
            if other is not None and abs(other - expected.value) > expected.tolerance:
                assert why, case.name


def test_tolerances_of_the_thesis_are_small():
    for case in suites.cases("thesis", quick=True):
        limit = 0.06 * abs(case.expected.value) or 3.0
        assert case.expected.tolerance <= limit, case.name


def test_the_quick_cases_of_neural_are_part_of_the_whole():
    quick, whole = ({case.name for case in suites.cases("neural", quick=q)} for q in (True, False))
    assert quick < whole


@pytest.mark.parametrize(("suite", "misses"), [("afferents", OF_AFFERENTS), ("human", OF_HUMANS)])
def test_every_miss_is_the_name_of_a_case(suite, misses):
    assert set(misses) <= {case.name for case in suites.cases(suite, quick=False)}


@pytest.mark.parametrize(
    ("value", "printed", "wanted", "verdict"),
    [
        (1.05, None, None, "pass"),
        (1.05, 1.08, None, "pass"),
        (1.05, 1.2, None, "documented"),
        (1.15, 1.2, None, "fail"),
        (float("nan"), None, None, "fail"),
        (0.95, None, 1.15, "short"),
        (1.06, None, 1.15, "pass"),
        (0.85, None, 0.85, "fail"),
    ],
)
def test_a_verdict_is_about_ours_first(value, printed, wanted, verdict):
    case = Case("n", lambda: value, Expected(1.0, 0.1, "N"), "", printed, wanted=wanted)
    assert Outcome(case, value).verdict == verdict


def test_the_figures_of_the_thesis_are_drawn():
    found = suites.figures({"suites": [{"suite": "thesis", "cases": []}]})
    captions = [caption for caption, _ in found["thesis"]]
    numbers = [n for text in captions for n in re.findall(r"\d-\d+|A-\d", text.split(".")[0])]
    assert set(DRAWN) <= set(numbers)
    for _, drawn in found["thesis"]:
        for axis in drawn.axes:
            assert axis.get_xlabel() or axis.get_ylabel()
            assert axis.lines or axis.collections
