"""`fefinger fit`: from a CSV file to both identifications, and the sentences for unusable files."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.oracles import synthetic

from fefinger.__main__ import main
from fefinger.calibration import lumped_fit
from fefinger.scene import library
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.theory.lumped import identify
from fefinger.theory.lumped.spring import Spring


ROW = library.lumped()["a.h."]
HEAD = "time,position,force"


@pytest.fixture(scope="module")
def samples():
    """Return (n_t, 3): a trial of subject a.h. with the noise of the thesis, touched at 0.5 mm."""
    made = synthetic.ramp_and_hold(Spring(ROW.b, ROW.m, 0.5), ROW.prony, seed=0, hold=5)
    return np.column_stack([made.time, made.position, made.force])


@pytest.fixture(scope="module")
def file(samples, tmp_path_factory):
    return write(tmp_path_factory.mktemp("data") / "trial.csv", samples)


@pytest.fixture(scope="module")
def brief(samples):
    """Return all of the ramp, which takes 500 rows, and every tenth row of the hold."""
    return np.concatenate([samples[:1000], samples[1000::10]])


def write(path, table, head=HEAD):
    np.savetxt(path, table, "%.7g", ",", header=head, comments="")
    return path


def test_fit_finds_the_subject_and_shows_the_bias_of_the_thesis(file, capsys):
    assert main(["fit", str(file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert list(found) == ["samples", "thesis", "joint", "files"]
    b, c0 = (found["joint"]["parameters"][name] for name in ("b", "c0"))
    assert b["unit"] == "N/mm"
    assert abs(b["value"] - 0.18) < 4 * b["uncertainty"] < 0.02
    assert abs(c0["value"] - 0.25) < 4 * c0["uncertainty"] < 0.02
    assert found["thesis"]["parameters"]["b"]["value"] < 0.7 * 0.18
    assert found["thesis"]["parameters"]["c0"]["value"] > 1.3 * 0.25
    assert found["joint"]["mse_percent"] < found["thesis"]["mse_percent"] < 5
    assert found["thesis"]["vaf_stiffness"] > 0.95
    assert found["joint"]["vaf_stiffness"] is None
    assert found["joint"]["warnings"] == []


def test_fit_prints_both_ways_and_writes_the_record_with_both_models(file, capsys, tmp_path):
    assert main(["fit", str(file), "-o", str(tmp_path / "out")]) == 0
    out, err = capsys.readouterr()
    for words in ("ramp and hold together", "procedure of the thesis", "+-", "N/mm", "mse"):
        assert words in out
    assert err == ""
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["fit.csv", "fit.json"]
    with open(tmp_path / "out" / "fit.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    measured, joint = (
        np.array([float(row[name]) for row in rows]) for name in ("force_N", "joint_N")
    )
    assert np.sqrt(np.mean((measured - joint) ** 2)) < 9e-3  # 3 mN, and 8 N/mm times 1 um
    saved = json.loads((tmp_path / "out" / "fit.json").read_text())
    assert saved["joint"]["parameters"]["m"]["value"] == pytest.approx(2.1, rel=0.01)


def test_what_is_not_identified_is_null_in_the_file_too(samples, tmp_path):
    """It was Infinity, which JSON does not have."""

    def refused(name):
        raise AssertionError(name)

    found = lumped_fit.fit(write(tmp_path / "trial.csv", samples))
    unknown = replace(found.joint, uncertainty=found.joint.uncertainty | {"v3": np.inf})
    lumped_fit.save(replace(found, joint=unknown), tmp_path)
    saved = json.loads((tmp_path / "fit.json").read_text(), parse_constant=refused)
    assert saved["joint"]["parameters"]["v3"]["uncertainty"] is None


def test_columns_may_stand_in_any_order_with_units_and_others_between(samples, tmp_path, file):
    swapped = np.column_stack([samples[:, 2], np.ones(len(samples)), samples[:, [1, 0]]])
    path = write(tmp_path / "a.csv", swapped, "Force (N),angle,position_mm,time [s]")
    for got, expected in zip(lumped_fit.read(path), lumped_fit.read(file), strict=True):
        np.testing.assert_array_equal(got, expected)


def test_two_terms_are_two(file):
    assert len(lumped_fit.fit(file, terms=2).joint.prony.v) == 2


def changed(samples, column, change):
    table = samples.copy()
    table[:, column] = change(table[:, column])
    return table


def swap(samples):
    table = samples.copy()
    table[[100, 200]] = table[[200, 100]]
    return table


def repeat(samples):
    return np.insert(samples, 100, samples[99], axis=0)


TABLES = {
    "position in m": (lambda s: changed(s, 1, lambda x: x / 1e3), r"position: expected mm.* in m;"),
    "position in um": (lambda s: changed(s, 1, lambda x: x * 1e3), r"position: .* in um;"),
    "force in g": (lambda s: changed(s, 2, lambda f: f * 102), r"in mN or grams of force;"),
    "force in mN": (lambda s: changed(s, 2, lambda f: f * 1e3), r"force: .*in mN;"),
    "time in ms": (lambda s: changed(s, 0, lambda t: t * 1e3), r"time: .*in ms;"),
    "the ramp alone": (lambda s: s[:200], r"time: .*, or ended before a hold;"),
    "pulling": (lambda s: changed(s, 2, lambda f: -f), "expected pressing to be positive"),
    "outward": (lambda s: changed(s, 1, lambda x: -x), "change their sign"),
    "unsorted": (swap, r"line 103: expected a time above .* received an earlier time"),
    "repeated": (repeat, r"line 102: expected a time above .* received a repeated time"),
    "few": (lambda s: s[:30], "at least 40 rows of a ramp and hold, received 30"),
    "coarse": (lambda s: s[::50], "ramp in contact: expected at least 20 samples"),
    "no hold": (lambda s: np.column_stack([s[:400, 0] * 5, s[:400, 1:]])[:330], "hold: expected"),
    "still": (lambda s: changed(s, 1, lambda x: x * 0), "position: expected numbers that change"),
    "no force": (lambda s: changed(s, 2, lambda f: f * 0), "force: expected numbers that change"),
}


@pytest.mark.parametrize(("spoil", "message"), TABLES.values(), ids=TABLES)
def test_a_table_that_cannot_be_used_is_refused_with_what_is_wrong(brief, tmp_path, spoil, message):
    with pytest.raises(InputError, match=message):
        lumped_fit.fit(write(tmp_path / "bad.csv", spoil(brief)))


def test_a_short_ramp_before_a_long_hold_is_not_taken_for_one_that_goes_outward(samples, tmp_path):
    """The ramp is under a hundredth of the rows, and noise decides the deepest of the hold."""
    samples = samples[::2]
    top = int(samples[:, 2].argmax())
    hold = np.repeat(samples[top + 1 : top + 2], 100 * top, axis=0)
    hold[:, 0] = samples[-1, 0] + 1e-3 * np.arange(1, len(hold) + 1)
    record = np.vstack([samples, hold])
    record[top, 1] = record[top + 1 :, 1].min() - 1e-4
    assert lumped_fit.fit(write(tmp_path / "long.csv", record), terms=1) is not None


def test_of_two_presses_one_is_fitted(samples, tmp_path):
    """The force peaks before the corner of the second ramp, above which most positions lie."""
    moved = [samples[-1, 0] + 1e-3, 0.0, 0.0]
    twice = np.vstack([samples, samples * [1, 1, 1.1] + moved])
    twice[twice[:, 2].argmax(), 1] -= 0.1
    assert lumped_fit.fit(write(tmp_path / "twice.csv", twice), terms=2) is not None


TEXTS = {
    "no force": (
        "time,position\n0,1\n1,2\n",
        r"one column 'force' \(N\), received none of the columns 'time,position'",
    ),
    "two forces": (
        "time,position,force 1,force 2\n0,1,2,3\n",
        "received 2, force 1, force 2, of",
    ),
    "one row": (f"{HEAD}\n0,1,2\n", "expected at least 40 rows of a ramp and hold, received 1"),
    "no header": ("0,1,2\n1,2,3\n", "one column 'time'"),
    "other unit": ("time_years,position,force\n0,1,2\n", "column 'time_years': expected time in s"),
}


@pytest.mark.parametrize(("text", "message"), TEXTS.values(), ids=TEXTS)
def test_a_file_that_is_no_record_is_refused_on_the_command_line(capsys, tmp_path, text, message):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        lumped_fit.read(path)
    assert main(["fit", str(path), "--json"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"error: {path}: ")


def test_other_units_of_the_header_are_converted(brief, file, tmp_path):
    path = tmp_path / "other.csv"
    np.savetxt(
        path, brief * [1e3, 1e3, 1e3], "%.9g", ",", header="Time (ms),Position (um),force_mN"
    )
    path.write_text(path.read_text().removeprefix("# "))
    reference = write(tmp_path / "usual.csv", brief)
    for actual, expected in zip(lumped_fit.read(path), lumped_fit.read(reference), strict=True):
        np.testing.assert_allclose(actual, expected, rtol=1e-6, atol=1e-9)


def test_a_file_that_is_not_there_is_refused(capsys, tmp_path):
    assert main(["fit", str(tmp_path / "none.csv")]) == 2
    assert "a record, such as CSV, received" in capsys.readouterr().err


def test_a_fit_that_does_not_converge_says_so(file, monkeypatch):
    def fail(*record, **options):
        msg = "joint: the fit did not converge"
        raise RuntimeError(msg)

    monkeypatch.setattr(identify, "joint", fail)
    with pytest.raises(ConvergenceError, match="did not converge"):
        lumped_fit.fit(file)


def test_a_record_of_the_name_of_the_output_is_not_overwritten(file, capsys, tmp_path):
    record = tmp_path / "fit.csv"
    record.write_bytes(file.read_bytes())
    assert main(["fit", str(record), "-o", str(tmp_path)]) == 2
    assert "'fit.csv' in" in capsys.readouterr().err
    assert record.read_bytes() == file.read_bytes()
