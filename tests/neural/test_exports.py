"""Spike trains written in every form and read back by what users read them with."""

import csv
import importlib
from dataclasses import fields, replace
from datetime import UTC, datetime

import numpy as np
import pytest
from refusals import refused

from fefinger.neural import train_files
from fefinger.neural.trains import CSV_COLUMNS, UNIT_COLUMNS, UNITS, SpikeTrains
from fefinger.support.checks import InputError


RNG = np.random.default_rng(8)
TIMES = (np.sort(RNG.uniform(0, 2, 7)), np.zeros(0), np.sort(RNG.uniform(0, 2, 3)))
TRAINS = SpikeTrains(
    types=("SAI", "FAI", "SAI"),
    names=("SAI-1", "FAI", "SAI-2"),
    times=TIMES,
    t_start=0.0,
    t_stop=2.0,
    time=np.linspace(0, 2, 9),
    x_in=RNG.normal(size=(9, 3)),
    current=RNG.uniform(0, 50, (9, 3)),
    peak_mV=np.array([91.0, 3.0, 90.0]),
    block_seconds=np.array([0.0, 0.0, 0.1]),
    stimulus_driven=np.array([0, 1, 0]),
    delays=np.array([0.014, 0.013, 0.014]),
    positions=RNG.normal(size=(3, 3)),
    depths=np.array([0.8, 0.5, 0.8]),
    seed=12,
    trial=4,
    notes=("SAI-2: in depolarization block for 0.1 s",),
    reruns=("the mesh is coarse",),
    rerun_counts=np.array([[3, 0, 2]]),
)
BARE = replace(
    TRAINS,
    delays=np.zeros(3),
    positions=None,
    depths=None,
    seed=None,
    trial=0,
    notes=(),
    reruns=(),
    rerun_counts=None,
)
BOTH = pytest.mark.parametrize("trains", [TRAINS, BARE], ids=["full", "bare"])


def same(a, b):
    for field in fields(SpikeTrains):
        one, other = getattr(a, field.name), getattr(b, field.name)
        if field.name == "times":
            assert len(one) == len(other)
            for x, y in zip(one, other, strict=True):
                np.testing.assert_array_equal(x, y)  # exact: a file keeps every bit
        elif isinstance(one, np.ndarray):
            np.testing.assert_array_equal(one, other)  # exact: a file keeps every bit
            assert one.dtype == other.dtype
        else:
            assert one == other
            assert type(one) is type(other)


@BOTH
def test_npz_gives_everything_back_to_the_last_bit(trains, tmp_path):
    path = tmp_path / "spikes.npz"
    trains.to_npz(path)
    same(SpikeTrains.from_npz(path), trains)
    assert [file.name for file in tmp_path.iterdir()] == ["spikes.npz"]


def test_seeds_and_trials_of_more_than_64_bits_are_kept(tmp_path):
    path = tmp_path / "spikes.npz"
    trains = replace(TRAINS, seed=2**127 + 1, trial=2**64)
    trains.to_npz(path)
    same(SpikeTrains.from_npz(path), trains)
    trains.to_xarray().to_netcdf(tmp_path / "spikes.nc", engine="h5netcdf")


def test_npz_of_before_delays_were_stored_has_none(tmp_path):
    path = tmp_path / "spikes.npz"
    TRAINS.to_npz(path)
    with np.load(path) as file:
        older = {name: file[name] for name in file.files if name not in ("delays", "trial")}
    np.savez(path, **older)
    same(SpikeTrains.from_npz(path), replace(TRAINS, delays=np.zeros(3), trial=0))


def test_every_array_has_its_unit():
    arrays = {
        f.name for f in fields(SpikeTrains) if isinstance(getattr(TRAINS, f.name), np.ndarray)
    }
    assert set(UNITS) == arrays | {"times"}


def test_every_form_says_what_the_current_is_between_its_times(tmp_path):
    message = "generator current at these times, not linear between them"
    TRAINS.to_npz(tmp_path / "spikes.npz")
    with np.load(tmp_path / "spikes.npz") as file:
        assert any(message in meaning for meaning in file["meanings"])
    data = TRAINS.to_xarray()
    assert message in data["current"].attrs["long_name"]
    assert "linear between its times" in data["x_in"].attrs["long_name"]


def test_csv_has_one_row_per_spike_with_times_to_the_last_bit(tmp_path):
    TRAINS.to_csv(tmp_path / "spikes.csv")
    with open(tmp_path / "spikes.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == CSV_COLUMNS
    for i in (0, 2):
        mine = [row for row in rows if row["unit"] == TRAINS.names[i]]
        # exact: csv has every digit
        np.testing.assert_array_equal([float(row["time_s"]) for row in mine], TIMES[i])
        # exact: CSV has every digit
        assert {float(row["y_mm"]) for row in mine} == {TRAINS.positions[i, 1]}
    assert len(rows) == 10
    BARE.to_csv(tmp_path / "spikes.csv")
    assert (tmp_path / "spikes.csv").read_text().splitlines()[1].startswith("SAI-1,SAI,,,,")


@BOTH
def test_pandas_has_one_row_per_spike(trains):
    table = trains.to_pandas()
    assert list(table["unit"]) == ["SAI-1"] * 7 + ["SAI-2"] * 3
    np.testing.assert_array_equal(table["time_s"], np.concatenate(TIMES))  # exact: handed on
    np.testing.assert_array_equal(table["delay_s"], trains.delays[[0] * 7 + [2] * 3])
    expected = trains.depths is not None
    assert table["depth_mm"].notna().all() == expected
    assert table["x_mm"].notna().all() == expected


@BOTH
def test_the_table_of_units_has_silent_ones(trains, tmp_path):
    table = trains.units_to_pandas()
    assert tuple(table.columns) == UNIT_COLUMNS
    assert table["unit"].tolist() == list(trains.names)
    assert table["count"].tolist() == [7, 0, 3]
    np.testing.assert_array_equal(table["delay_s"], trains.delays)
    assert (table["t_start_s"] == 0.0).all()
    assert (table["t_stop_s"] == 2.0).all()
    rates = table["count"] / (table["t_stop_s"] - table["t_start_s"])
    assert rates.groupby(table["type"]).mean().to_dict() == {"FAI": 0.0, "SAI": 2.5}
    assert table["z_mm"].isna().all() == (trains.positions is None)
    trains.units_to_csv(tmp_path / "units.csv")
    with open(tmp_path / "units.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == UNIT_COLUMNS
    assert [row["count"] for row in rows] == ["7", "0", "3"]
    for name in ("x_mm", "depth_mm", "delay_s"):
        written = [float(row[name]) if row[name] else np.nan for row in rows]
        np.testing.assert_array_equal(written, table[name])  # exact: csv has every digit


@BOTH
def test_xarray_has_the_signals_and_the_spikes_of_each_unit(trains):
    data = trains.to_xarray()
    np.testing.assert_array_equal(data["x_in"].sel(unit="FAI"), trains.x_in[:, 1])
    of_last = data["spike_time"].values[data["spike_unit"].values == 2]
    np.testing.assert_array_equal(of_last, TIMES[2])  # exact: handed on
    assert data["current"].attrs["units"] == "uA/cm2"
    assert ("positions" in data) == (trains.positions is not None)
    assert data.attrs.get("seed") == trains.seed
    assert data.attrs["trial"] == trains.trial
    np.testing.assert_array_equal(data["delays"].sel(unit="FAI"), trains.delays[1])
    assert data["delays"].attrs["units"] == "s"


@BOTH
def test_neo_has_a_train_per_unit_and_the_signals(trains):
    pytest.importorskip("neo", reason="the extra neo is not installed")
    (segment,) = trains.to_neo().segments
    assert [train.name for train in segment.spiketrains] == list(trains.names)
    for i, train in enumerate(segment.spiketrains):
        np.testing.assert_array_equal(train.rescale("s").magnitude, TIMES[i])  # exact: a unit of 1
        assert (float(train.t_start), float(train.t_stop)) == (0.0, 2.0)
        assert train.annotations["afferent_class"] == trains.types[i]
        assert train.annotations["delay_s"] == trains.delays[i]
        assert ("position_mm" in train.annotations) == (trains.positions is not None)
    x_in, current = segment.irregularlysampledsignals
    np.testing.assert_array_equal(x_in.rescale("mm").magnitude, trains.x_in)  # exact: a unit of 1
    np.testing.assert_array_equal(current.magnitude, trains.current)
    assert current.dimensionality.string == "(uA/cm**2)"
    assert "not linear between" in current.description


@BOTH
def test_nwb_passes_its_validator_and_holds_the_units(trains, tmp_path):
    pynwb = pytest.importorskip("pynwb", reason="the extra nwb is not installed")
    path, started = tmp_path / "spikes.nwb", datetime(2024, 5, 1, tzinfo=UTC)
    trains.to_nwb(path, started=started)
    assert not pynwb.validate(path=str(path))
    with pynwb.NWBHDF5IO(str(path), "r") as io:
        file = io.read()
        assert file.session_start_time == started
        table = file.units.to_dataframe()
        series = file.stimulus["skin_displacement"]
        np.testing.assert_allclose(series.data[:] * series.conversion, 1e-3 * trains.x_in)
        times = series.timestamps
        if times is None:
            times = series.starting_time + np.arange(len(series.data)) / series.rate
        np.testing.assert_allclose(times[:], trains.time, rtol=1e-9, atol=1e-12)
        assert file.subject.subject_id == "simulated"
        assert file.units.resolution == pytest.approx(np.diff(trains.time).min())
    assert list(table["afferent_class"]) == list(trains.types)
    assert list(table["unit_name"]) == list(trains.names)
    np.testing.assert_array_equal(table["delay_s"], trains.delays)
    for i in range(3):
        np.testing.assert_array_equal(table["spike_times"].iloc[i], TIMES[i])  # exact: handed on
    np.testing.assert_array_equal(table["depth_mm"].isna().all(), trains.depths is None)


def test_nwb_has_the_subject_and_the_resolution_that_are_given(tmp_path):
    pynwb = pytest.importorskip("pynwb", reason="the extra nwb is not installed")
    path, who = tmp_path / "spikes.nwb", {"subject_id": "s07", "species": "Homo sapiens"}
    about = {"institution": "Lab", "keywords": ["edge"]}
    TRAINS.to_nwb(path, subject=who, resolution=1 / 30000, about=about)
    with pynwb.NWBHDF5IO(str(path), "r") as io:
        file = io.read()
        assert file.subject.subject_id == "s07"
        assert file.units.resolution == pytest.approx(1 / 30000)
        assert file.institution == "Lab"
    for field, wrong in (("subject", {"sx": "F"}), ("about", {"lap": "x"}), ("resolution", 0)):
        with refused(field):
            TRAINS.to_nwb(path, **{field: wrong})


def test_neo_reads_the_nwb_file(tmp_path):
    neo = pytest.importorskip("neo", reason="the extra neo is not installed")
    pytest.importorskip("pynwb", reason="the extra nwb is not installed")
    path = tmp_path / "spikes.nwb"
    TRAINS.to_nwb(path)
    reader = neo.io.NWBIO(str(path), mode="r")
    try:
        (block,) = reader.read_all_blocks()
        actual = [np.asarray(train.magnitude) for s in block.segments for train in s.spiketrains]
        signals = [each for s in block.segments for each in s.irregularlysampledsignals]
        (displacement,) = signals or [s.analogsignals[0] for s in block.segments]
        depths = displacement.rescale("mm").magnitude
    finally:
        reader._io_nwb.close()
    np.testing.assert_allclose(depths, TRAINS.x_in)
    assert len(actual) == 3
    for times, expected in zip(actual, TIMES, strict=True):
        np.testing.assert_array_equal(times, expected)  # exact: a file keeps every bit


def test_files_that_are_no_spike_trains_are_refused(tmp_path):
    np.savez(tmp_path / "other.npz", a=1)
    (tmp_path / "text.npz").write_text("hello")
    for name, message in (
        ("other.npz", "expected the format 'fefinger spike trains 1', received None"),
        ("text.npz", "which cannot be read: it is none, or damaged$"),
        ("missing.npz", "which does not exist"),
    ):
        with pytest.raises(InputError, match=message):
            SpikeTrains.from_npz(tmp_path / name)


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match="expected a folder that exists"):
        TRAINS.to_csv(tmp_path / "no" / "spikes.csv")


def test_a_file_that_cannot_be_written_gets_a_sentence(tmp_path):
    with pytest.raises(InputError, match=r"cannot be written: .*; choose another file"):
        TRAINS.to_csv(tmp_path)


@pytest.mark.parametrize(("form", "extra"), [("to_neo", "neo"), ("to_nwb", "nwb")])
def test_a_missing_extra_is_named(form, extra, monkeypatch, tmp_path):
    def missing(name):
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(train_files, "import_module", missing)
    assert importlib.import_module is not missing
    arguments = (tmp_path / "spikes.nwb",) if form == "to_nwb" else ()
    with pytest.raises(InputError, match=f"fefinger\\[{extra}\\]"):
        getattr(TRAINS, form)(*arguments)


def test_files_that_are_damaged_or_of_another_kind_are_refused(tmp_path):
    path = tmp_path / "spikes.npz"
    TRAINS.to_npz(path)
    with np.load(path) as file:
        arrays = dict(file)
    whole = path.read_bytes()
    damaged = {"short": whole[: len(whole) // 2], "empty": b"", "inside": bytearray(whole)}
    damaged["inside"][200:260] = bytes(60)
    for name, content in damaged.items():
        (tmp_path / f"{name}.npz").write_bytes(content)
    np.save(tmp_path / "one.npy", np.zeros(3))
    np.savez(tmp_path / "twice.npz", **arrays | {"names": ["FAI", "FAI", "SAI"]})
    with pytest.raises(InputError, match=r"twice.npz: names: .* received FAI more than once"):
        SpikeTrains.from_npz(tmp_path / "twice.npz")
    del arrays["offsets"]
    np.savez(tmp_path / "less.npz", **arrays)
    for name in ("short.npz", "empty.npz", "inside.npz", "one.npy"):
        with pytest.raises(InputError, match="which cannot be read"):
            SpikeTrains.from_npz(tmp_path / name)
    with pytest.raises(InputError, match=r"expected every array of spike trains.*'offsets'"):
        SpikeTrains.from_npz(tmp_path / "less.npz")
