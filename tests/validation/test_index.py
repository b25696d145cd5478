"""The page that gathers the reports: complete, and as fresh as the files that it is made from."""

import json
import re
from pathlib import Path

import pytest
from fefinger.validation import index

from fefinger.__main__ import main


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
PAGE_LIMIT, FOLDER_LIMIT = 500_000, 5_000_000  # bytes


def test_the_committed_index_is_fresh() -> None:
    written = (REPORTS / "index.html").read_text(encoding="utf-8")
    assert written == index.html(REPORTS), "run `python -m fefinger.validation.index reports`"


def test_no_committed_comparison_fails() -> None:
    failed = [
        f"{path.stem}: {case['name']}"
        for path in REPORTS.glob("*.json")
        for suite in json.loads(path.read_text(encoding="utf-8")).get("suites", ())
        for case in suite["cases"]
        if case["verdict"] == "fail"
    ]
    assert not failed


def test_every_file_is_linked_and_every_link_is_there() -> None:
    html = index.html(REPORTS)
    links = set(re.findall(r'href="([^"]*)"', html))
    assert links >= {path.name for kind in ("json", "csv") for path in REPORTS.glob(f"*.{kind}")}
    assert links >= {path.name for path in REPORTS.glob("*.html")} - {"index.html"}
    for link in links:
        assert (REPORTS / link).is_file(), link


def test_pages_and_the_folder_of_reports_are_small() -> None:
    sizes = {path.name: path.stat().st_size for path in REPORTS.iterdir() if path.is_file()}
    large = {name: size for name, size in sizes.items() if name.endswith(".html")
             and size > PAGE_LIMIT}  # fmt: skip
    assert not large
    assert sum(sizes.values()) <= FOLDER_LIMIT


@pytest.mark.parametrize("page", sorted(REPORTS.glob("*.html")), ids=lambda path: path.stem)
def test_the_raw_data_that_a_page_names_is_beside_it(page: Path) -> None:
    html = page.read_text(encoding="utf-8")
    found = re.search(r'Raw data beside this page: <a href="([^"]*)"', html)
    if page.stem == "index":
        assert found is None
    elif found is not None:
        assert (page.parent / found[1]).is_file()
        assert Path(found[1]).stem == page.stem


@pytest.fixture
def folder(tmp_path: Path) -> Path:
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


def test_a_table_takes_its_provenance_from_the_record_beside_it(folder: Path) -> None:
    html = index.html(folder)
    (row,) = re.findall(r'<tr><td><a href="sweep.csv">.*?</tr>', html)
    assert re.findall(r'<a href="([^"]*)">', row) == ["sweep.csv", "sweep.json", "sweep.html"]
    assert "2026-01-02" in row
    assert "abc123" in row
    assert html.index('id="studies"') < html.index("sweep.csv") < html.index('id="benchmarks"')


def test_suites_have_date_commit_and_verdicts(folder: Path) -> None:
    html = index.write(folder).read_text(encoding="utf-8")
    assert "3 comparisons in 1 suite:" in html
    (row,) = re.findall(r"<tr><td><a href=\"fem.html\">fem</a>.*?</tr>", html)
    cells = re.findall(r"<td[^>]*>(.*?)</td>", row)[2:]
    assert cells[:7] == ["2", "1", "0", "0", "3", "2026-01-02", "abc123"]
    assert html.index('id="benchmarks"') < html.index("bench-x.json") < html.index('id="evidence"')
    assert "Something &lt;new&gt;." in html


def test_the_module_writes_it_or_says_what_it_needs(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert index.main([str(folder)]) == 0
    assert capsys.readouterr().out.strip() == str(folder / "index.html")
    assert index.main([]) == 2
    assert "expected one folder of reports" in capsys.readouterr().err


def test_validate_names_its_files_and_freshens_the_index(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
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


def test_pages_are_written_anew_from_their_data(folder: Path) -> None:
    record = {"suites": [{"suite": "old", "cases": [CASE]}], "provenance": {"commit": "abc"}}
    (folder / "fem.json").write_text(json.dumps(record))
    assert list(index.rewrite_pages(folder)) == [folder / "fem.html"]
    assert json.loads((folder / "fem.json").read_text()) == record
    assert ">abc<" in (folder / "fem.html").read_text(encoding="utf-8")
