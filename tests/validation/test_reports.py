"""Reports: their provenance and numbers, the index, and the table of the contact angle."""

import json
import re
from pathlib import Path

import pandas as pd
import pytest
from fefinger.validation import contact_angle, index, provenance

from fefinger.__main__ import main
from fefinger.studies.tasks import StudyRequest, answer


def test_a_report_is_saved_behind_its_provenance_and_read_again(tmp_path):
    path = tmp_path / "a.json"
    assert provenance.saved(path) == {}
    provenance.save(path, {"rows": [1.5, None]})
    record = provenance.saved(path)
    assert record["rows"] == [1.5, None]
    assert record["command"].startswith("python -m ")
    assert record["command"].endswith(" reports")
    assert list(record)[-1] == "rows"
    assert path.read_text(encoding="utf-8") == json.dumps(record, separators=(",", ":")) + "\n"


def test_a_report_that_is_no_json_leaves_the_one_before(tmp_path):
    path = tmp_path / "a.json"
    provenance.save(path, {"rows": [1.0]})
    with pytest.raises(ValueError, match="not JSON compliant"):
        provenance.save(path, {"rows": [float("nan")]})
    assert provenance.saved(path)["rows"] == [1.0]


def test_numbers_are_rounded_to_digits():
    assert provenance.short([1.23456, 123456.0]) == [1.235, 123500.0]
    assert provenance.short([1.23456], 2) == [1.2]


CASE = {
    "name": "a",
    "value": 1.0,
    "expected": 1.0,
    "tolerance": 0.1,
    "unit": "N",
    "source": "x",
    "failure": "",
    "verdict": "pass",
}
REPORTS = Path(__file__).resolve().parents[2] / "reports"
# Bytes; a clone holds all of them. The last 0.5 MB are 28 held-out scenes, ridges, soft objects.
PAGE_LIMIT, FOLDER_LIMIT = 500_000, 6_000_000


def test_the_committed_index_is_fresh():
    written = (REPORTS / "index.html").read_text(encoding="utf-8")
    assert written == index.html(REPORTS), "run `python -m fefinger.validation.index reports`"


def test_no_committed_comparison_fails():
    failed = [
        f"{path.stem}: {case['name']}"
        for path in REPORTS.glob("*.json")
        for suite in json.loads(path.read_text(encoding="utf-8")).get("suites", ())
        for case in suite["cases"]
        if case["verdict"] == "fail"
    ]
    assert not failed


def test_every_file_is_linked_and_every_link_is_there():
    html = index.html(REPORTS)
    links = set(re.findall(r'href="([^"]*)"', html))
    assert links >= {path.name for kind in ("json", "csv") for path in REPORTS.glob(f"*.{kind}")}
    assert links >= {path.name for path in REPORTS.glob("*.html")} - {"index.html"}
    for link in links:
        assert (REPORTS / link).is_file(), link


def test_pages_and_the_folder_of_reports_are_small():
    sizes = {path.name: path.stat().st_size for path in REPORTS.iterdir() if path.is_file()}
    large = {name: size for name, size in sizes.items() if name.endswith(".html")
             and size > PAGE_LIMIT}  # fmt: skip
    assert not large
    assert sum(sizes.values()) <= FOLDER_LIMIT


@pytest.mark.parametrize("page", sorted(REPORTS.glob("*.html")), ids=lambda path: path.stem)
def test_the_raw_data_that_a_page_names_is_beside_it(page):
    html = page.read_text(encoding="utf-8")
    found = re.search(r'Raw data beside this page: <a href="([^"]*)"', html)
    if page.stem == "index":
        assert found is None
    elif found is not None:
        assert (page.parent / found[1]).is_file()
        assert Path(found[1]).stem == page.stem


@pytest.fixture
def folder(tmp_path):
    """Return a folder with a suite, a benchmark and evidence."""
    case = {"verdict": "pass"}
    made = {"command": "c", "commit": "abc123", "date": "2026-01-02T03:04:05"}
    suite = {"suites": [{"suite": "fem", "cases": [case, case, {"verdict": "documented"}]}]}
    (tmp_path / "fem.json").write_text(json.dumps(suite | {"provenance": made}))
    (tmp_path / "fem.html").write_text("")
    (tmp_path / "bench-x.json").write_text(json.dumps(made | {"figures": []}))
    (tmp_path / "new.json").write_text(json.dumps(made | {"about": "Something <new>."}))
    (tmp_path / "sweep.csv").write_text("a,b\n")
    (tmp_path / "sweep.json").write_text(json.dumps({"data": "sweep.csv", "provenance": made}))
    (tmp_path / "sweep.html").write_text("")
    return tmp_path


def test_a_table_takes_its_provenance_from_the_record_beside_it(folder):
    html = index.html(folder)
    (row,) = re.findall(r'<tr><td><a href="sweep.csv">.*?</tr>', html)
    assert re.findall(r'<a href="([^"]*)">', row) == ["sweep.csv", "sweep.json", "sweep.html"]
    assert "2026-01-02" in row
    assert "abc123" in row
    assert html.index('id="studies"') < html.index("sweep.csv") < html.index('id="benchmarks"')


def test_suites_have_date_commit_and_verdicts(folder):
    html = index.write(folder).read_text(encoding="utf-8")
    assert "3 comparisons in 1 suite:" in html
    (row,) = re.findall(r"<tr><td><a href=\"fem.html\">fem</a>.*?</tr>", html)
    cells = re.findall(r"<td[^>]*>(.*?)</td>", row)[2:]
    assert cells[:7] == ["2", "1", "0", "0", "3", "2026-01-02", "abc123"]
    assert html.index('id="benchmarks"') < html.index("bench-x.json") < html.index('id="evidence"')
    assert "Something &lt;new&gt;." in html


def test_the_module_writes_it_or_says_what_it_needs(folder, capsys):
    assert index.main([str(folder)]) == 0
    assert capsys.readouterr().out.strip() == str(folder / "index.html")
    assert index.main([]) == 2
    assert "expected one folder of reports" in capsys.readouterr().err


def test_validate_names_its_files_and_freshens_the_index(folder, monkeypatch, capsys):
    from fefinger.validation import suites

    record = {"suites": [{"suite": "s", "cases": [CASE]}]}
    monkeypatch.setattr(suites, "run", lambda *args, **kwargs: {})
    monkeypatch.setattr(suites, "as_json", lambda outcomes: record)
    monkeypatch.setattr(suites, "figures", lambda names: {})
    monkeypatch.setattr(suites, "findings", lambda names: {})
    index.write(folder)
    assert main(["validate", "--name", "fem", "-o", str(folder)]) == 0
    assert '<a href="fem.json">' in (folder / "fem.html").read_text(encoding="utf-8")
    html = (folder / "index.html").read_text(encoding="utf-8")
    assert html == index.html(folder)
    assert "1 comparison in 1 suite:" in html


def test_pages_are_written_anew_from_their_data(folder):
    record = {"suites": [{"suite": "old", "cases": [CASE]}], "provenance": {"commit": "abc"}}
    (folder / "fem.json").write_text(json.dumps(record))
    assert list(index.rewrite_pages(folder)) == [folder / "fem.html"]
    assert json.loads((folder / "fem.json").read_text()) == record
    assert ">abc<" in (folder / "fem.html").read_text(encoding="utf-8")


STUDIED = "a.h. to 1 mm"


@pytest.fixture(scope="module")
def table():
    """Return the table of the report."""
    return pd.read_csv(Path(__file__).parents[2] / "reports" / "contact-angle.csv")


def test_the_table_is_of_this_code(table):
    scene, changes, mechanics, _ = contact_angle.STUDIES[STUDIED]
    over = {"indenter.angle": (30.0,)}
    asked = StudyRequest(scene, over, changes, mechanics, contact_angle.AT)
    ((_, task),) = asked.tasks()[0].items()
    again = {row["at"]: row for row in answer(task)["rows"]}
    kept = table[(table["case"] == STUDIED) & (table["indenter.angle_deg"] == 30)]
    assert len(kept) == 2 + len(contact_angle.AT)
    for row in kept.to_dict("records"):
        for name in ("force_N", "depth_mm", "contact_area_mm2", "asymmetry", "ellipticity"):
            assert again[row["at"]][name] == pytest.approx(row[name], rel=1e-4), name


def test_every_scene_is_there_or_says_why_not(table):
    for case, (_, _, _, angles) in contact_angle.STUDIES.items():
        assert set(table[table["case"] == case]["indenter.angle_deg"]) == set(angles), case
    failed = table[table["status"].str.startswith("failed")]["status"]
    assert failed.str.contains("proximal cut").all()
