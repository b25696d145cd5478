"""The table of a study as files, what is kept of an earlier one, and how it was made."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from refusals import refused

import fefinger as ff
from fefinger.__main__ import main
from fefinger.studies import tables, tasks
from fefinger.studies.grid import parse_at
from fefinger.studies.study import Study
from fefinger.support import machine
from fefinger.support.checks import InputError


LEAN = {
    "ask.spikes": [],
    "ask.pressure": False,
    "ask.strain": False,
    "motion.speed": 10,
    "motion.hold": 0.05,
}
"""A force alone, which `lumped` answers at once."""


COMMAND = ["study", "flat-press", "--over", "motion.depth=0.4,0.3", "--mechanics", "lumped"]
for field, value in LEAN.items():
    COMMAND += ["--set", f"{field}={json.dumps(value)}"]


def asked(over, **options):
    return ff.study("flat-press", over, changes=LEAN, mechanics="lumped", workers=1, **options)


@pytest.fixture(scope="module")
def grid():
    """Return a study over depths and thicknesses; one scene, deeper than half of it, fails."""
    return asked({"motion.depth": (0.4, 6, 0.2), "finger.thickness": (10, 20)}, at=("0.1mm",))


def test_a_netcdf_has_the_grid_as_axes_with_units_and_what_made_it(grid, tmp_path):
    file = tmp_path / "study.nc"
    assert grid.write(file) == str(file)
    with xr.open_dataset(file) as data:
        assert data["force_N"].dims == ("motion.depth_mm", "finger.thickness_mm", "at")
        assert data["at"].values.tolist() == ["peak", "end", "0.1 mm"]
        assert data["force_N"].attrs == {"long_name": "force", "units": "N"}
        assert data["motion.depth_mm"].attrs["units"] == "mm"
        for row in grid.rows:
            if row["at"]:
                place = {"motion.depth_mm": row["motion.depth_mm"]}
                place |= {"finger.thickness_mm": row["finger.thickness_mm"], "at": row["at"]}
                # exact: a file keeps every bit
                assert data["force_N"].sel(place).item() == row["force_N"]
        failed = data.sel({"motion.depth_mm": 6, "finger.thickness_mm": 10})
        assert np.isnan(failed["force_N"]).all()
        assert (failed["status"] == "failed").all()
        assert data.attrs["fefinger"] == ff.__version__
        assert data.attrs["grid.motion.depth"] == "[0.4, 6, 0.2]"


def test_an_array_says_what_was_not_reached_and_what_every_column_holds():
    high = {"x_mm": 1.0, "at": "1 N", "status": "done", "force_rel_error": 0.1, "spikes_SAI": 3}
    low = {"x_mm": 2.0, "at": "end", "status": "done"}
    lost = {"x_mm": 3.0, "at": "", "status": "failed: no mesh"}
    data = tables.dataset(_study([high, low, lost]))
    told = data["status"].sel(at="1 N").values.tolist()
    assert told == ["done", "not reached", "failed"]
    assert (
        data["force_rel_error"].attrs["long_name"] == "expected error of the force over its value"
    )
    assert data["spikes_SAI"].attrs["long_name"].startswith("spikes of the units of SAI")


def _study(rows):
    return Study("made-up", ("x_mm",), tuple(rows), (), len(rows), 0, {"grid": {"x": [1, 2]}})


@pytest.mark.parametrize(("ending", "read"), [("csv", pd.read_csv), ("parquet", pd.read_parquet)])
def test_a_table_comes_back_as_it_was(grid, tmp_path, ending, read):
    if ending == "parquet":
        pytest.importorskip("pyarrow", reason="needs the extra 'parquet'")
    again = read(grid.write(tmp_path / f"study.{ending}"))
    wanted = grid.table()
    assert again.columns.tolist() == wanted.columns.tolist()
    assert again["force_N"].to_numpy() == pytest.approx(wanted["force_N"].to_numpy(), nan_ok=True)
    assert again["at"].fillna("").tolist() == wanted["at"].tolist()
    if ending == "parquet":
        assert again.attrs == wanted.attrs
        assert again.attrs["mechanics"] == "lumped"


def test_values_that_are_lists_or_of_several_kinds_are_columns_too(tmp_path):
    pytest.importorskip("pyarrow", reason="needs the extra 'parquet'")
    mixed = _study([{"x_mm": 1.0, "at": "end", "status": "done"}])
    mixed = replace(mixed, rows=(*mixed.rows, {"x_mm": "wide", "at": "end", "status": "done"}))
    assert pd.read_parquet(mixed.write(tmp_path / "m.parquet"))["x_mm"].tolist() == ["1.0", "wide"]
    over = {"indenter.at": ([0.0, 0.0], [1.0, 0.0])}
    found = ff.study("sphere-press", over, changes={"ask.spikes": []}, mechanics="lumped")
    assert found.table()["indenter.at_mm"].unique().tolist() == ["[0.0, 0.0]", "[1.0, 0.0]"]


def test_other_endings_and_folders_and_parquet_without_its_extra_are_refused_before_any_work(
    grid, tmp_path, tmp_path_factory, capsys, monkeypatch
):
    dossier = tmp_path_factory.mktemp("dossier") / "a.nc"
    dossier.mkdir()
    with refused("table"):
        grid.write(tmp_path / "a.xlsx")
    with pytest.raises(InputError, match="a file in a folder that exists"):
        grid.write(tmp_path / "none" / "a.csv")
    with refused("--table"):
        tables.check(dossier, "--table")
    with pytest.raises(InputError, match=r"cannot write '/proc/a\.nc'"):
        grid.write("/proc/a.nc")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    command = ["study", "flat-press", "--over", "indenter.angle=20,30", "--table"]
    assert main([*command, str(tmp_path / "a.parquet")]) == 2
    assert "pip install 'fefinger[parquet]'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("words_alone")
def test_the_table_of_other_scenes_is_kept_and_told(tmp_path, capsys):
    large = asked({"motion.depth": (0.4, 0.3, 0.2)}, folder=tmp_path)
    assert len(large.save(tmp_path)) == 3
    before = (tmp_path / "table.csv").read_text()
    again = asked({"motion.depth": (0.4, 0.3, 0.2)}, folder=tmp_path)
    assert again.reused == 3
    again.save(tmp_path)
    assert not (tmp_path / "earlier-1").exists()
    assert main([*COMMAND, "-o", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert "2 of 2 scenes" in out
    assert ", 2 of them reused" in out
    assert f"moved: the files of these names that were there are now in {tmp_path}/earlier-1" in err
    assert (tmp_path / "earlier-1" / "table.csv").read_text() == before  # exact: the file was moved
    assert (tmp_path / "earlier-1" / "report.html").exists()
    asked({"motion.depth": (0.4, 0.3, 0.1)}, folder=tmp_path).save(tmp_path)
    assert not (tmp_path / "earlier-2").exists()


def test_files_that_no_study_wrote_are_moved_and_not_overwritten(tmp_path):
    (tmp_path / "table.csv").write_text("mine")
    asked({"motion.depth": (0.4, 0.3)}, folder=tmp_path).save(tmp_path)
    assert (tmp_path / "earlier-1" / "table.csv").read_text() == "mine"
    assert (tmp_path / "table.csv").read_text() != "mine"


@pytest.mark.usefixtures("words_alone")
def test_the_page_and_the_table_say_how_they_were_made(tmp_path, capsys, monkeypatch):
    # What is installed has no repository, and an empty commit is left out of the page.
    monkeypatch.setattr(machine, "commit", lambda: "abc1234")
    assert main([*COMMAND, "--at", "0.2mm", "-o", str(tmp_path)]) == 0
    capsys.readouterr()
    record = json.loads((tmp_path / "study.json").read_text())
    assert record["command"].startswith(
        "fefinger study flat-press --over motion.depth=0.4,0.3 --at 0.2mm --set"
    )
    assert record["answers"]["finished_before"] == "0 of 2"
    assert record["answers"]["seeds"] == "none: nothing is drawn at random"
    page = (tmp_path / "report.html").read_text()
    for text in ("fefinger study flat-press --over", record["date"], ff.__version__):
        assert text in page
    for name in ("commit", "packages.numpy", "answers.seeds", "date"):
        assert f"<th>{name}</th>" in page


def test_seeds_are_told_where_something_is_drawn():
    made = {"date": "2026-01-01T00:00:00+00:00", "commit": "abc"}
    rows = [{"seed": 7}, {"seed": 7}]
    later = {**made, "date": "2026-02-01T00:00:00+00:00", "commit": "abd"}
    told = tasks.provenance([{"rows": rows, **made}, {"error": "x", **later}], 1)["answers"]
    assert told["seeds"] == "7"
    assert told["finished_before"] == "1 of 2"
    assert told["dates"] == f"{made['date']} to {later['date']}"
    assert told["commits"] == "abc, abd"


@pytest.mark.parametrize(
    ("texts", "words"),
    [
        (["1N", "1.0 N"], "received 1 N again"),
        ("1N", "a list of forces and depths, received '1N' alone"),
        ([1.0], "'1.0': expected a force or a depth"),
    ],
)
def test_levels_that_cannot_be_read_are_refused(texts, words):
    with pytest.raises(InputError, match=words):
        parse_at(texts)


def test_a_grid_without_fields_is_refused():
    with refused("--over"):
        asked({})


def test_the_commit_is_that_of_the_programs_own_tree(tmp_path, monkeypatch):
    subprocess.run(["git", "init", "-q", tmp_path], check=True)
    place = tmp_path / "installed" / "fefinger" / "support" / "p.py"
    monkeypatch.setattr(machine, "__file__", str(place))
    (tmp_path / "installed").mkdir()
    assert machine.commit.__wrapped__() == ""
    monkeypatch.setenv("PATH", "")
    assert machine.commit.__wrapped__() == ""
