"""The cases of every suite, before any of them is measured, and what makes their verdicts."""

import json
import re
import sys
from importlib.metadata import EntryPoint

import pytest
from fefinger.validation import suites
from fefinger.validation.afferents.suite import MISSES as OF_AFFERENTS
from fefinger.validation.case import Case, Expected, Outcome
from fefinger.validation.human.suite import MISSES as OF_HUMANS

from fefinger.__main__ import main
from fefinger.support.checks import InputError


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


OWN = '''"""Our numbers against ours."""

from fefinger.validation.case import Expected, Row, tabled


def cases(quick):
    rows = {"right": Row(lambda: 2.0, Expected(2.1, 0.2, "N"), "our record")}
    if not quick:
        rows["wrong"] = Row(lambda: 2.0, Expected(3.0, 0.2, "N"), "our record")
    return tabled(rows)
'''


@pytest.fixture
def beside(tmp_path, monkeypatch):
    """Work in a folder for modules of a user's own, which are forgotten afterwards."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        if name.startswith("suite_of_"):
            del sys.modules[name]


def test_a_module_beside_is_a_suite(beside, capsys):
    (beside / "suite_of_ours.py").write_text(OWN)
    assert main(["validate", "suite_of_ours", "--quick", "-o", "out"]) == 0
    page = (beside / "out" / "validation.html").read_text()
    assert "Our numbers against ours." in page
    assert "our record" in page
    capsys.readouterr()
    assert main(["validate", "suite_of_ours", "--json"]) == 1
    (suite,) = json.loads(capsys.readouterr().out)["suites"]
    verdicts = {case["name"]: case["verdict"] for case in suite["cases"]}
    assert (suite["suite"], verdicts) == ("suite_of_ours", {"right": "pass", "wrong": "fail"})


def test_an_entry_point_is_a_suite(beside, monkeypatch):
    (beside / "suite_of_entry.py").write_text(OWN)
    monkeypatch.syspath_prepend(str(beside))
    point = EntryPoint("ours", "suite_of_entry", suites.GROUP)
    monkeypatch.setattr(suites, "entry_points", lambda group: [point])
    (outcome,) = suites.run(["ours"], quick=True)["ours"]
    assert outcome.verdict == "pass"


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("suite_of_none", None, "expected one of fem, .* or a module of your own"),
        ("femm", None, "Did you mean 'fem'"),
        ("suite_of_nothing", "x = 1", r"expected a module with a function cases\(quick\)"),
        ("suite_of_errors", "1 / 0", "ZeroDivisionError"),
    ],
)
def test_what_is_no_suite_is_refused_before_any_is_measured(beside, name, text, sentence):
    if text is not None:
        (beside / f"{name}.py").write_text(text)
    with pytest.raises(InputError, match=sentence):
        suites.run(["thesis", name])
