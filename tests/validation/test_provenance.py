"""Reports of measurements: what is written is read again, and nothing that is no number."""

import json

import pytest
from fefinger.validation import provenance


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
