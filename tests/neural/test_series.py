"""A user's series to spikes: what is read, what fires, and a sentence for what cannot be used."""

import csv
import json
import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.__main__ import main
from fefinger.neural import series
from fefinger.neural.afferent_units import simulate_units
from fefinger.neural.recorded import fitted
from fefinger.neural.signals import read
from fefinger.neural.trains import SpikeTrains
from fefinger.scene.ask import Ask
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import FAMILIES, TYPES


fire = partial(series.fire, family="thesis")

TIME = np.append(np.linspace(0, 0.1, 501), np.linspace(0.1, 0.5, 9)[1:])
PRESS = np.where(TIME < 0.1, 0.5 * (1 - np.cos(np.pi * TIME / 0.1)), 1.0)


def write(path, header, *columns):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(zip(*(map(repr, map(float, c)) for c in columns), strict=True))
    return str(path)


@pytest.fixture
def press(tmp_path):
    return write(tmp_path / "press.csv", ("time", "displacement_mm"), TIME, PRESS)


def test_one_column_drives_a_unit_of_every_type(press):
    trains = fire(read(press))
    expected = simulate_units(TIME, np.tile(PRESS[:, None], 4), types=TYPES)
    assert trains.types == trains.names == TYPES
    assert expected.count().min() > 0
    for a, b in zip(trains.times, expected.times, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-9)
    assert trains.notes == expected.notes


@pytest.mark.parametrize(
    ("time", "name", "values", "length"),
    [
        ("time_ms", "displacement_um", 1e3 * PRESS, None),
        ("time_s", "left_displacement_m", 1e-3 * PRESS, None),
        ("time", "strain", PRESS / 2.5, 2.5),
    ],
)
def test_units_of_the_header_are_converted(time, name, values, length, press, tmp_path):
    scale = 1e3 if time == "time_ms" else 1.0
    path = write(tmp_path / "other.csv", (name, time), values, scale * TIME)
    other = fire(read(path), ("SAI", "FAI"), length=length)
    expected = fire(read(press), ("SAI", "FAI"))
    np.testing.assert_allclose(other.x_in, expected.x_in, rtol=1e-12)
    for a, b in zip(other.times, expected.times, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)


def test_units_may_stand_in_brackets(press, tmp_path):
    path = write(
        tmp_path / "b.csv", ("Time (ms)", "FAI displacement [um]"), 1e3 * TIME, 1e3 * PRESS
    )
    other = fire(read(path))
    assert other.types == ("FAI",)
    np.testing.assert_allclose(other.x_in[:, 0], PRESS, rtol=1e-12)


def test_wrong_units_are_told(tmp_path):
    ms = np.arange(100.0)
    path = write(tmp_path / "ms.csv", ("time", "displacement_mm"), ms, ms / 100)
    with pytest.raises(InputError, match="as if they were in ms; name the column time_ms"):
        read(path)
    path = write(tmp_path / "um.csv", ("time", "displacement_mm"), TIME, 1e3 * PRESS)
    with pytest.raises(InputError, match="mm, as if it were in um; check the unit"):
        read(path)
    path = write(tmp_path / "m.csv", ("time", "displacement_mm"), TIME, 1e-3 * PRESS)
    notes = fire(read(path), ("SAI",)).notes
    assert any("fires no unit; it reaches 0.001 mm, as if it were in m;" in note for note in notes)


def test_a_column_named_after_a_type_drives_that_type_alone(tmp_path):
    header = ("time", "FAI_displacement_mm", "tip_displacement_mm")
    path = write(tmp_path / "two.csv", header, TIME, PRESS, 0.5 * PRESS)
    trains = fire(read(path), ("SAI", "SAII"))
    assert trains.types == ("FAI", "SAI", "SAII")
    assert trains.names == (
        *("FAI_displacement_mm", "tip_displacement_mm:SAI", "tip_displacement_mm:SAII"),
    )
    np.testing.assert_allclose(trains.x_in, np.outer(PRESS, [1, 0.5, 0.5]))


def test_a_series_that_starts_pressed_is_noted(tmp_path):
    path = write(tmp_path / "late.csv", ("time", "displacement_mm"), [0, 0.5], [1, 1])
    trains = fire(read(path), ("SAI",))
    assert any("which is a jump from 0" in note for note in trains.notes)


@pytest.mark.parametrize(
    ("name", "values", "question"),
    [
        ("displacement_mm", -PRESS, "expected are positive values into the skin"),
        ("strain", -0.1 * PRESS, "expected are positive values where it excites the type"),
        ("displacement_mm", PRESS, None),
        ("displacement_mm", 0.3 * np.sin(1e3 * TIME) - 0.01, None),
        ("displacement_mm", np.zeros_like(TIME), None),
    ],
)
def test_a_column_of_the_wrong_sign_is_asked_about(name, values, question, tmp_path):
    path = write(tmp_path / "sign.csv", ("time", name), TIME, values)
    trains = fire(read(path), ("SAI",), length=2.0, corners=True)
    actual = [note for note in trains.notes if "expected are positive" in note]
    assert len(actual) == (question is not None)
    assert all(question in note for note in actual)


@pytest.mark.parametrize(("rate", "kind"), [(1000, "FAII"), (30, "FAI"), (5, "SAII")])
def test_samples_too_coarse_for_the_fastest_pole_are_refused_unless_meant(rate, kind, tmp_path):
    frequency = rate / 8
    time = np.arange(0, 6 / frequency, 1 / rate)
    wave = 0.5 * (1 - np.cos(2 * np.pi * frequency * time))
    signals = read(write(tmp_path / "wave.csv", ("time", "displacement_mm"), time, wave))
    with pytest.raises(InputError, match=f"too coarse for {kind}"):
        fire(signals, (kind,))
    assert len(fire(signals, (kind,), corners=True)) == 1


def test_types_for_which_samples_are_too_coarse_are_left_out_unless_named(tmp_path):
    time = np.arange(0, 0.5, 1e-3)
    path = write(tmp_path / "ramp.csv", ("time", "displacement_mm"), time, np.minimum(10 * time, 1))
    signals = read(path)
    trains = series.fire(signals)
    assert trains.types == ("SAI", "SAII", "FAI")
    wanted = "too coarse for FAII, which responds up to about 239 Hz: .*sample at 1200 Hz or more"
    assert re.search(f"{wanted}, or say .* exact .corners.* FAII was left out", trains.notes[0])
    with pytest.raises(InputError, match=f"{wanted}, leave FAII out of the types .*, or say"):
        series.fire(signals, ("SAI", "FAII"))
    finer = np.arange(0, 0.5, 1 / 1600)
    path = write(tmp_path / "f.csv", ("time", "displacement_mm"), finer, np.minimum(10 * finer, 1))
    assert series.fire(read(path)).types == TYPES
    seconds = np.arange(0, 10, 0.5)
    coarse = write(tmp_path / "c.csv", ("time", "displacement_mm"), seconds, 2 * seconds % 2)
    with pytest.raises(InputError, match="too coarse for SAI"):
        series.fire(read(coarse))


@pytest.mark.parametrize("kind", ["SAI", "SAII"])
def test_slow_units_take_slow_signals_from_few_samples(kind, tmp_path):
    time = np.arange(0, 35, 1.0)
    wave = 0.5 * (1 - np.cos(2 * np.pi * time / 30))
    path = write(tmp_path / "wave.csv", ("time", "displacement_mm"), time, wave)
    assert len(fire(read(path), (kind,)).times[0]) > 0


@pytest.mark.parametrize(
    ("kind", "amplitude", "frequency", "rate"), [("FAI", 0.015, 30, 100), ("SAI", 0.3, 4, 10)]
)
def test_counts_that_hang_on_lines_between_the_samples_are_noted(
    kind, amplitude, frequency, rate, tmp_path
):
    def noted(name, time, **options):
        wave = amplitude * (np.cos(0.3) - np.cos(2 * np.pi * frequency * time + 0.3))
        path = write(tmp_path / "wave.csv", ("time", name), time, wave)
        trains = fire(read(path), (kind,), **options)
        return trains.count()[0], any("a smooth curve joins" in note for note in trains.notes)

    count, message = noted("displacement_mm", np.arange(0, 1, 1 / rate))
    assert message
    assert noted("displacement_mm", np.arange(0, 1, 1 / rate), corners=True) == (count, False)
    fine, message = noted("displacement_mm", np.arange(0, 1, 1e-4))
    assert not message
    assert fine > count


@pytest.mark.parametrize("family", FAMILIES)
def test_exact_corners_are_not_taken_for_coarse_samples(family, tmp_path):
    """A trapezoid of its corners alone, whose every second sample is another signal."""
    time, x = [-0.1, 0.0, 0.05, 0.5, 0.55, 0.7], [0, 0, 1, 1, 0, 0]
    path = write(tmp_path / "corners.csv", ("time", "displacement_mm"), time, x)
    trains = series.fire(read(path), corners=True, family=family)
    assert trains.count().min() > 0
    assert not [note for note in trains.notes if "sample" in note]
    assert "unless it has these corners" in " ".join(
        simulate_units(time, np.array(x)[:, None], types=("FAII",)).notes
    )


def test_uneven_samples_and_jumps_are_welcome(tmp_path):
    time, x = [0, 0.1, 0.1, 0.4], [0, 0, 0.4, 0.4]
    path = write(tmp_path / "jump.csv", ("time", "displacement_mm"), time, x)
    trains = fire(read(path))
    assert trains.count().min() > 0
    assert np.all(np.concatenate(trains.times) > 0.1)


def unusable(text, tmp_path):
    path = tmp_path / "series.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time,displacement_mm\n0,0\n2,1\n1,1\n", "line 4: expected times that never decrease"),
        ("time,displacement_mm\n0,0\n1,500\n", "at most 10 mm, received 500 mm"),
        ("time,strain\n0,0\n1,20\n", "at most 1, received 20"),
        ("time\n0\n1\n", "a column of a signal beside the time"),
        ("displacement_mm\n0\n1\n", "expected one column named time, time_s, time_ms"),
        ("time,strain (%)\n0,0\n1,0.5\n", "'strain \\(%\\)': expected a name that ends with"),
        ("time,strain [µε]\n0,0\n1,0.5\n", "expected a name that ends with"),
        ("time,time_ms,strain\n0,0,0\n1,1,1\n", "expected one column named"),
        ("time,force_N\n0,0\n1,1\n", "column 'force_N': expected a name that ends with"),
        ("time,displacemnt_mm\n0,0\n1,1\n", "Did you mean 'displacement_mm'"),
        ("time,displacement\n0,0\n1,1\n", "Did you mean 'displacement_mm'"),
        ("time,displacement_mm\n0,0\n", "expected two rows of numbers or more"),
        ("time,displacement_mm\n1,0\n1,1\n", "span more than 0 s"),
        ("", "series.csv: .*received an empty file"),
        (
            "time,strain,strain\n0,0,0\n1,0,0.1\n",
            "different name for each column, received 'strain' more",
        ),
    ],
)
def test_series_that_cannot_be_used_are_refused(text, message, tmp_path):
    with pytest.raises(InputError, match=message):
        read(unusable(text, tmp_path))


def test_types_given_twice_and_strain_without_a_length_are_refused(press, tmp_path):
    with refused("types"):
        fire(read(press), ("SAI", "FAI", "SAI"))
    strain = read(write(tmp_path / "s.csv", ("time", "strain"), TIME, 0.1 * PRESS))
    with refused("length"):
        fire(strain)
    with refused("length"):
        fire(strain, length=-1.0)


def test_a_length_that_no_column_takes_is_checked_and_told(press):
    signals = read(press)
    assert "The length is not used" in " ".join(fire(signals, ("SAI",), length=2.0).notes)
    with refused("length"):
        fire(signals, ("SAI",), length=-1.0)


def test_other_types_change_nothing_of_a_unit(press):
    signals = read(press)
    (alone,) = series.fire(signals, ("SAI",)).times
    assert len(alone) > 5
    for types in (("FAII", "SAI"), ("SAI", "FAI"), TYPES):
        trains = series.fire(signals, types, corners=True)
        assert trains.times[trains.index("SAI")] == pytest.approx(alone, abs=1e-9)


def test_arrays_fire_as_the_file_that_holds_them(press, tmp_path):
    expected = series.fire(read(press), ("SAI", "FAI"))
    found = ff.spikes(TIME, PRESS, ("SAI", "FAI"))
    assert found.names == expected.names
    assert found.notes == expected.notes
    # exact: one call on the same signals
    assert all(map(np.array_equal, found.times, expected.times))
    header = ("time", "FAI_displacement_um", "tip_strain")
    path = write(tmp_path / "two.csv", header, TIME, 1e3 * PRESS, 0.1 * PRESS)
    named = {"FAI_displacement_um": (1e3 * PRESS).tolist(), "tip_strain": 0.1 * PRESS}
    expected = series.fire(read(path), ("SAI",), trial=2)
    found = ff.spikes(TIME, named, ("SAI",), trial=2)
    assert found.names == expected.names == ("FAI_displacement_um", "tip_strain:SAI")
    # exact: one call on the same signals
    assert all(map(np.array_equal, found.times, expected.times))
    assert found.count().min() > 0


@pytest.mark.parametrize(
    ("time", "displacement", "options", "message"),
    [
        (TIME, PRESS[:-1], {}, "displacement: expected 509 values as of time, received 508"),
        (TIME, np.tile(PRESS[:, None], 2), {}, "give several series as a dictionary by name"),
        (
            TIME,
            np.where(TIME == 0.1, np.nan, PRESS),
            {},
            r"displacement: expected finite .* nan at",
        ),
        (TIME, "press.csv", {}, "displacement: .*received"),
        (TIME, {}, {}, "displacement: expected one series or more"),
        (TIME, {"left": PRESS}, {}, "column 'left': expected a name that ends with one of"),
        (TIME, 1e3 * PRESS, {}, "at most 10 mm, received 1000 mm.*; check the unit"),
        (TIME[::-1], PRESS, {}, "sample 1: expected times that never decrease"),
        (TIME, PRESS, {"types": ("SA",)}, "types: expected one of"),
        (TIME, PRESS, {"family": "thesis", "trial": 1}, "trial: units of 'thesis' have no noise"),
        (TIME, PRESS, {"trial": -1}, "trial: expected a whole number"),
        (TIME[::100], PRESS[::100], {"types": ("FAII",)}, "too coarse for FAII"),
    ],
)
def test_arrays_that_cannot_be_used_are_refused(time, displacement, options, message):
    with pytest.raises(InputError, match=message):
        ff.spikes(time, displacement, **options)


def test_times_that_are_likely_in_milliseconds_are_refused_or_noted():
    time = np.arange(100.0)
    press = np.clip(time / 50, 0, 1)
    with refused("time"):
        ff.spikes(time, press)
    noted = ff.spikes(time, press, ("SAI",), corners=True).notes
    assert "as if they were in ms; divide them by 1000" in noted[0]
    assert not any("in ms" in note for note in ff.spikes(1e-3 * time, press).notes)


def test_trials_of_the_command_are_other_noise(press, tmp_path, capsys):
    for name, extra in (("first", []), ("again", ["--trial", "0"]), ("other", ["--trial", "1"])):
        command = ["spikes", "--from", press, "--type", "SAI", "-o", str(tmp_path / name), *extra]
        assert main(command) == 0
    first, again, other = (
        SpikeTrains.from_npz(tmp_path / name / "spikes.npz").times[0]
        for name in ("first", "again", "other")
    )
    np.testing.assert_array_equal(first, again)  # exact: one call, made twice
    assert not np.array_equal(first, other)
    capsys.readouterr()
    assert main(["spikes", "--from", press, "--afferents", "thesis", "--trial", "1"]) == 2
    assert "--trial: units of 'thesis' have no noise" in capsys.readouterr().err
    assert main(["spikes", "--from", press, "--afferents", "thesi"]) == 2
    assert "--afferents: expected one of" in capsys.readouterr().err


def test_the_command_prints_json_and_writes_its_files(press, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["spikes", "--from", press, "--type", "SAI", "--json", "-o", str(out)]) == 0
    record = json.loads(capsys.readouterr().out)
    assert list(record) == ["units", "notes", "files"]
    (unit,) = record["units"]
    trains = SpikeTrains.from_npz(out / "spikes.npz")
    assert unit["spikes"] == trains.count()[0] > 1
    assert unit["mean_rate_Hz"] == pytest.approx(unit["spikes"] / 0.5)
    assert unit["peak_rate_Hz"] == pytest.approx(1 / np.diff(trains.times[0]).min())
    assert unit["first_spike_s"] == trains.times[0][0]  # exact: handed on
    assert record["files"] == [str(out / name) for name in series.FILES]
    assert len((out / "spikes.csv").read_text().splitlines()) == 1 + unit["spikes"]


def test_the_command_prints_a_table_and_its_notes(tmp_path, capsys):
    path = write(tmp_path / "rest.csv", ("time", "displacement_mm"), [0, 0.2], [1e-4, 1e-4])
    assert main(["spikes", "--from", path, "--type", "SAII"]) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[0].split() == [
        "unit",
        "type",
        "spikes",
        "mean",
        "Hz",
        "peak",
        "Hz",
        "first",
        "s",
    ]
    assert "SAII  SAII  0" in out
    assert "jump from 0" in out
    assert err == ""


def test_the_command_exits_with_2_on_unusable_input(press, tmp_path, capsys):
    assert main(["spikes", "--from", press, "--type", "RA"]) == 2
    assert "error: --type: expected one of" in capsys.readouterr().err
    assert main(["spikes"]) == 2


def test_a_column_with_more_letters_than_any_type_drives_all(tmp_path):
    header = ("time", "FAIII_displacement_mm")
    path = write(tmp_path / "c.csv", header, [0, 0.1, 0.2], [0, 0.1, 0.1])
    assert fire(read(path), corners=True).types == TYPES


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        *(("SA1", "SAI"), ("SA2", "SAII")),
        *(("RA", "FAI"), ("RA1", "FAI"), ("FA1", "FAI"), ("fai", "FAI")),
        *(("PC", "FAII"), ("RA2", "FAII"), ("FA2", "FAII"), ("pc", "FAII")),
    ],
)
def test_other_names_of_types_get_the_name_that_is_meant(name, meant, press, tmp_path, capsys):
    path = write(tmp_path / "c.csv", ("time", f"{name}_displacement_mm"), TIME, PRESS)
    with pytest.raises(InputError, match=f"begins like .* Did you mean '{meant}'. Rename"):
        series.fire(read(path))
    with pytest.raises(InputError, match=f"types: expected one of .* Did you mean '{meant}'"):
        series.fire(read(press), (name,))
    assert main(["spikes", "--from", press, "--type", name]) == 2
    assert f"Did you mean '{meant}'" in capsys.readouterr().err
    with pytest.raises(InputError, match=rf"ask.spikes\[0\]: .* Did you mean '{meant}'"):
        Ask(spikes=(name,))


def test_a_series_of_days_is_refused_and_a_tolerance_taken(tmp_path):
    head = ("time", "displacement_mm")
    path = write(tmp_path / "long.csv", head, [0, 1e5, 2e5], [0, 1, 1])
    with refused("time"):
        fire(read(path), corners=True)
    path = write(tmp_path / "short.csv", head, [0, 0.1, 0.2], [0, 0.5, 0.5])
    trains = fire(read(path), ("SAI",), corners=True, tolerance=0.05)
    exact = fire(read(path), ("SAI",), corners=True)
    np.testing.assert_allclose(trains.times[0], exact.times[0], atol=5e-5)
    with refused("tolerance"):
        fire(read(path), corners=True, tolerance=0.0)


def test_the_recorded_family_takes_displacements_and_strains_of_its_own_length(tmp_path, press):
    trains = series.fire(read(press), ("SAI",), family="recorded")
    assert trains.family == "recorded"
    length = fitted()["SAI"].length
    path = write(tmp_path / "strain.csv", ["time", "strain"], TIME, PRESS / length)
    other = series.fire(read(path), ("SAI",), family="recorded")
    assert other.times[0] == pytest.approx(trains.times[0])
    with refused("tolerance"):
        series.fire(read(press), ("SAI",), family="recorded", tolerance=0.1)
    with refused("family"):
        series.fire(read(press), ("SAI",), family="recordd")


def test_files_of_another_origin_are_not_overwritten(press, tmp_path, capsys):
    """Such as the recording itself, or the spikes of a saved result."""
    spikes = ["spikes", "--type", "SAI", "-o", str(tmp_path), "--from"]
    recording = tmp_path / "spikes.csv"
    recording.write_bytes(Path(press).read_bytes())
    assert main([*spikes, str(recording)]) == 2
    assert "'spikes.csv' in" in capsys.readouterr().err
    assert recording.read_bytes() == Path(press).read_bytes()  # exact: left as it was
    recording.unlink()
    assert main([*spikes, press]) == 0
    assert main([*spikes, press]) == 0  # replaces its own
