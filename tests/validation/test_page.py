"""The page of validations says what every case found, and needs no other file."""

import json
import math
import re
from typing import Any

import pytest
from fefinger.validation import page, suites
from fefinger.validation.case import Case, Expected

from fefinger.commands import validate
from fefinger.support.checks import InputError
from fefinger.view import figures


def case(name: str, verdict: str, **changes: Any) -> dict[str, Any]:
    numbers = {"value": 1.234567, "expected": 1.2, "tolerance": 0.05, "printed": None}
    words = {
        "unit": "N",
        "source": "Eq. 2.1",
        "erratum": "",
        "shortfall": "",
        "reason": "",
        "failure": "",
    }
    return {"name": name, "verdict": verdict} | numbers | words | changes


RECORD = {
    "suites": [
        {
            "suite": "one",
            "cases": [
                case("first <a>", "pass"),
                case("second", "documented", printed=1.5, erratum="The print is wrong."),
                case("third", "documented", printed=1.6, erratum="The print is wrong."),
            ],
        },
        {
            "suite": "two",
            "cases": [
                case("fourth", "fail", value=9.0, reason="Two digits."),
                case("fifth", "short", wanted=2.0, shortfall="Nobody reaches it."),
            ],
        },
    ]
}
MADE = {"command": "fefinger validate", "versions": {"fefinger": "1.2"}}


def cells(html: str) -> list[list[str]]:
    rows = re.findall(r"<tr[^>]*>(.*?)(?=<tr|</tr|</table)", html, flags=re.DOTALL)
    return [re.findall(r"<td[^>]*>(.*?)(?=</?t|$)", row, flags=re.DOTALL) for row in rows]


def test_counts_stand_per_suite_and_in_all():
    html = page.html(RECORD, {}, {})
    counts = [row[1:] for row in cells(html)[1:4]]
    assert counts == [
        ["1", "2", "0", "0", "3"],
        ["0", "0", "1", "1", "2"],
        ["1", "2", "1", "1", "5"],
    ]
    assert "Of 5 comparisons, 1 pass." in html
    assert "1 misses its target." in html
    assert "In 2 more, fefinger is within the tolerance" in html
    assert "1 failed." in html


def test_every_case_has_its_row_with_the_digits_of_its_tolerance():
    found = cells(page.html(RECORD, {}, {}))
    rows = [row for row in found if len(row) == 7]
    assert rows[0] == ["pass", "first &lt;a&gt;", "1.235", "1.200 ± 0.05", "", "N", "Eq. 2.1"]
    assert [row[4] for row in rows] == ["", "1.5", "1.6", "", "2"]
    assert [row[0] for row in rows] == ["pass", "documented", "documented", "fail", "short"]
    html = page.html(RECORD, {}, {})
    one, two = html.split("<h3>Comparisons")[1:]
    assert "<th>printed</th>" in one
    assert "<th>target</th>" not in one
    assert "<th>target</th>" in two
    assert "<th>printed</th>" not in two


def test_a_shared_erratum_is_given_once_up_front_and_after_the_last_it_holds_for():
    html = page.html(RECORD, {}, {})
    assert html.count("The print is wrong.") == 2
    front, back = html.index("The print is wrong."), html.rindex("The print is wrong.")
    assert front < html.index("<h3>Comparisons") < html.index('<td class="case">first &lt;a&gt;')
    assert html.rindex("third") < back < html.index("fourth")
    assert "(second, and 1 more)" in html
    assert "Tolerance: Two digits." in html


@pytest.mark.parametrize(
    ("value", "tolerance", "text"),
    [
        (12.3456, 0.05, "12.346"),
        (12.3456, 30, "12.3"),
        (0.123456789, 1e-9, "0.123457"),
        (3.21e-11, 1e-9, "3.2e-11"),
        (0.0123456, 1.0, "0.0123"),
        (0.0, 1.0, "0"),
        (1 / 3, 0, "0.333333"),
        (float("nan"), 0.1, "nan"),
    ],
)
def test_values_show_what_the_tolerance_can_tell_apart(value, tolerance, text):
    record = {"suites": [{"suite": "s", "cases": [case("c", "pass", value=value)]}]}
    record["suites"][0]["cases"][0]["tolerance"] = tolerance
    (row,) = [row for row in cells(page.html(record, {}, {})) if len(row) == 6]
    assert row[2] == text


def test_a_missed_target_is_explained_up_front_and_below_its_case():
    html = page.html(RECORD, {}, {})
    title, front = html.index("Missed targets"), html.index("Nobody reaches it.")
    assert html.index('id="two"') < title < front < html.index('<td class="case">fifth')
    assert html.count("Nobody reaches it.") == 2
    assert html.rindex("Differing published values") < html.index('id="two"')


def test_a_finding_stands_before_the_comparisons():
    table = {"caption": "Forces.", "heading": ["", "a.h."], "rows": [["ball"], ["bone", "1.50"]]}
    found = {"texts": ["Hertz is too soft."], "tables": [table]}
    html = page.html(RECORD, {}, {}, findings={"two": found})
    place = html.index("Hertz is too soft.")
    assert html.index('id="two"') < place < html.index("Forces.") < html.index("fourth")
    assert ["bone", "1.50"] in cells(html)
    assert (
        html.index("Forces.")
        < html.rindex("<h3>Comparisons")
        < html.index('<td class="case">fourth')
    )


def test_the_cases_closest_to_their_tolerance_are_named_and_a_failed_one_is_not():
    near = case("near", "pass", value=1.24)
    record = {"suites": [{"suite": "s", "cases": [*RECORD["suites"][1]["cases"][:1], near]}]}
    html = page.html(record, {}, {}, findings={"s": {"about": "What it is about."}})
    assert "near: 80 %." in html
    assert "fourth: " not in html
    assert "<h1>Validation: s</h1>" in html
    assert "<h2>What it is about.</h2>" in html
    assert 'id="summary"' not in html


def test_in_a_range_from_0_on_a_small_value_is_far_from_the_limit():
    cases = [
        case("small", "pass", value=1e-9, expected=0.5, tolerance=0.5),
        case("large", "pass", value=0.9, expected=0.5, tolerance=0.5),
        case("exact", "pass", value=-0.2, expected=0.0, tolerance=0.5),
    ]
    html = page.html({"suites": [{"suite": "s", "cases": cases}]}, {}, {})
    assert "large: 90 %; exact: 40 %; small: 0 %." in html
    rows = [row for row in cells(html) if len(row) == 6]
    assert [row[3] for row in rows] == ["0 to 1", "0 to 1", "0 ± 0.5"]


def test_both_files_are_written_and_the_page_stands_alone(tmp_path):
    with figures.style():
        drawn = figures.figure(3, 2)
        drawn.subplots().plot([0, 1], [0, 1])
    page.save(RECORD, tmp_path, {"two": [("A line.", drawn)]}, MADE)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "validation.html",
        "validation.json",
    ]
    written = json.loads((tmp_path / "validation.json").read_text())
    assert written == RECORD | {"provenance": MADE}
    html = (tmp_path / "validation.html").read_text(encoding="utf-8")
    assert ["1.2"] in cells(html)
    assert html.index('id="two"') < html.index("<figcaption>A line.")
    links = re.findall(r'(?:src|href)="([^"]*)"', html)
    assert links[:3] == ["validation.json", "#one", "#two"]
    assert [link.partition(",")[0] for link in links[3:]] == ["data:image/svg+xml"]


def test_wide_figures_get_the_page_and_a_unit_of_1_is_not_written():
    drawn = [("wide", figures.figure(9.2, 7.6)), ("narrow", figures.figure(6.2, 2.8))]
    for _, each in drawn:
        each.subplots()
    html = page.html(RECORD, {"one": drawn}, {})
    assert re.findall(r'<figure( class="wide")?><img [^>]*alt="(\w+)"', html) == [
        (' class="wide"', "wide"),
        ("", "narrow"),
    ]
    cases = [case("bare", "pass", unit="1"), case("slope", "pass", unit="1/mm")]
    text = validate.validation_summary({"suites": [{"suite": "one", "cases": cases}]})
    ends = [line.partition("+- ")[2].split() for line in text.splitlines()[1:3]]
    assert [len(end) for end in ends] == [2, 3]
    assert ends[1][1] == "1/mm"


def test_a_case_that_breaks_fails_alone_with_its_error(monkeypatch):
    def breaks() -> float:
        msg = "depth: expected less than the tissue"
        raise InputError(msg)

    def made(name, measure):
        return Case(name, measure, Expected(1.0, 0.1, "N"), "Eq. 2.1")

    todo = (made("broken", breaks), made("good", lambda: 1.05), made("lost", lambda: math.nan))
    monkeypatch.setattr(suites, "cases", lambda suite, *, quick: todo)
    record = suites.as_json(suites.run(["thesis"]))
    found = record["suites"][0]["cases"]
    assert [case["verdict"] for case in found] == ["fail", "pass", "fail"]
    assert [case["value"] for case in found] == [None, 1.05, None]
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    assert "fail InputError: depth: expected less" in validate.validation_summary(record)
    assert validate.validation_summary(record).splitlines()[-1] == "1 pass, 2 FAIL"
    assert "Not measured: InputError: depth" in page.html(record, {}, {})
