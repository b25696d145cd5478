"""CSV files of users: what is read, and the messages on what cannot be."""

import numpy as np
import pytest
from refusals import refused

from fefinger.support.checks import InputError
from fefinger.support.csv_columns import CsvTable, read_columns, read_matrix, read_table


TEXTS = {
    "empty": ("", "header and rows of numbers below it, received an empty file"),
    "no rows": ("time,depth\n", "received the header 'time,depth' alone"),
    "semicolons": ("time;depth\n0,0;0,0\n", "expected commas .*, received semicolons in the first"),
    "tabs": ("time\tdepth\n0\t0\n", "received tabs in the first line"),
    "spaces": ("time depth\n0 0\n", "received spaces in the first line"),
    "too few": ("time,depth\n0,0\n\n1\n", "line 4: expected 2 values, received 1"),
    "too many": ("time,depth\n0,0,0,0\n", "line 2: expected 2 values, .* write 0.5 for 0,5"),
    "comma": ('time,depth\n0,0\n1,"0,1"\n', "line 3, column depth: .* '0,1'; write 0.5 for 0,5"),
    "missing": ("time,depth\n0,0\n1,\n", "column depth: expected a finite number, received ''"),
    "text": ("time,depth\n0,x\n", "line 2, column depth: expected a finite number, received 'x'"),
    "nan": ("time,depth\n0,nan\n", "line 2, column depth: .* received 'nan'"),
    "no header": ("0,0\n1,1\n", "the first line to be 'time,depth', .* received '0,0'"),
    "other name": ("time,force\n0,0\n", "the first line to be 'time,depth', .*, received 'time,f"),
}


@pytest.mark.parametrize(("text", "message"), TEXTS.values(), ids=TEXTS)
def test_a_file_that_cannot_be_used_is_refused_with_its_place(tmp_path, text, message):
    file = tmp_path / "bad.csv"
    file.write_text(text)
    with pytest.raises(InputError, match=message) as refused:
        read_columns("motion.file", file, ("time", "depth"))
    assert str(refused.value).startswith(f"motion.file: {str(file)!r}: ")


def test_times_in_milliseconds_are_told_unless_the_header_has_a_unit(tmp_path):
    file = tmp_path / "ms.csv"
    for head, unit in (("time", None), ("time_s", 1.0), ("Time (ms)", 1e-3)):
        rows = "".join(f"{k},0\n" for k in range(100))
        file.write_text(f"{head},depth\n{rows}")
        if unit is None:
            with pytest.raises(
                InputError, match=r"100 samples 1 apart, as if they were in ms; name"
            ):
                read_columns("file", file, ("time", "depth"))
        else:
            assert read_columns("file", file, ("time", "depth"))[0][-1] == pytest.approx(99 * unit)


def test_files_that_are_no_text_are_refused(tmp_path):
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x01")
    for name, message in (("binary.csv", "no UTF-8 text; save"), ("missing.csv", "does not exist")):
        with pytest.raises(InputError, match=message):
            read_table("file", tmp_path / name)


def test_blank_lines_spaces_and_a_byte_order_mark_are_ignored(tmp_path):
    file = tmp_path / "good.csv"
    file.write_text("\ufefftime, depth (mm)\n\n0, 0\n1, 0.5\n\n", encoding="utf-8")
    assert read_columns("file", file, ("time", "depth")) == ((0.0, 1.0), (0.0, 0.5))
    table = read_table("file", file)
    assert [table.line(row) for row in (0, 1)] == [3, 4]
    np.testing.assert_array_equal(table.numbers([1]), [[0], [0.5]])


ROWS = "0,0\n1e-3,0.5\n 0.002 ,+7.25e-1\n\n0.003,123456789.123456789\n"
"""Rows that are read quickly."""


def test_plain_numbers_are_read_quickly_and_the_same(tmp_path, monkeypatch):
    file = tmp_path / "good.csv"
    file.write_text(f"time,depth\n{ROWS}")
    quick = read_columns("file", file, ("time", "depth"))
    with monkeypatch.context() as patched:
        patched.setattr(CsvTable, "_row", None)  # a million rows must not be read cell by cell
        # exact: both ways round the same text
        assert read_columns("file", file, ("time", "depth")) == quick
    monkeypatch.setattr(CsvTable, "_quickly", lambda table, most: None)
    # exact: both ways round the same text
    assert read_columns("file", file, ("time", "depth")) == quick


def test_what_is_not_read_quickly_is_read_too(tmp_path):
    file = tmp_path / "odd.csv"
    file.write_text('time,depth\n"0",1_0\n,\n1,"2"\n')
    assert read_columns("file", file, ("time", "depth")) == ((0.0, 1.0), (10.0, 2.0))


@pytest.mark.parametrize("rows", ["0,0\n1,1\n2,2\n3,3\n", '"0",0\n1,1\n2,2\n3,3\n'])
def test_a_table_that_is_too_long_is_refused(tmp_path, monkeypatch, rows):
    file = tmp_path / "long.csv"
    file.write_text(f"a,b\n{rows}")
    assert len(read_table("file", file).numbers([0, 1], most=4)) == 4
    with pytest.raises(InputError, match="at most 3 rows of 2 numbers, received more"):
        read_table("file", file).numbers([0, 1], most=3)
    file.write_text(rows)
    assert read_matrix("file", file, most=8).shape == (4, 2)
    with refused("file"):
        read_matrix("file", file, most=7)
