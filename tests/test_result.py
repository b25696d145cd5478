"""A saved result loads as it was, and nothing half-written is left behind."""

import csv
import dataclasses
import os
import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr
from refusals import refused

from fefinger.commands.run import fired_record
from fefinger.pages import report
from fefinger.pipeline import run
from fefinger.plan import explain
from fefinger.result import Result, load
from fefinger.results import netcdf
from fefinger.results.key_numbers import cautions, rows
from fefinger.results.netcdf import LAYOUT, RECORDS
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.motions import Vibration
from fefinger.scene.samples import Sampled
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Hard, Tissue
from fefinger.support import atomic_write
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import Prony


SINGLE = {
    field
    for (_, field), label in LAYOUT.items()
    if label.dims[:1] in (("time",), ("frame",)) and netcdf.SINGLE.intersection(label.dims)
}
"""Fields that a file holds in single precision."""


def assert_same(a: Any, b: Any, place: str = "result") -> None:
    """Compare records field by field, arrays exactly (nan equals nan) and with their types.

    Values of single precision in the file are within half of its last digit.
    """
    assert type(a) is type(b), place
    if dataclasses.is_dataclass(a) and not isinstance(a, type):
        for field in dataclasses.fields(a):
            name = f"{place}.{field.name}"
            assert_same(getattr(a, field.name), getattr(b, field.name), name)
    elif isinstance(a, np.ndarray):
        assert a.dtype == b.dtype, place
        last = 2.0**-24 if place.rpartition(".")[2] in SINGLE else 0.0
        np.testing.assert_allclose(a, b, rtol=last, atol=1e-44 if last else 0.0, err_msg=place)
    elif isinstance(a, dict):
        assert a.keys() == b.keys(), place
        for key in a:
            assert_same(a[key], b[key], f"{place}[{key!r}]")
    elif isinstance(a, tuple | list):
        assert len(a) == len(b), place
        for number, (x, y) in enumerate(zip(a, b, strict=True)):
            assert_same(x, y, f"{place}[{number}]")
    else:
        assert a == b, place  # exact: a file keeps every bit


def without(result: Result, *names: str) -> Result:
    """Return the result without some fields of its response, and without spikes if named."""
    gone = dict.fromkeys(name for name in names if name != "spikes")
    spikes = None if "spikes" in names else result.spikes
    response = dataclasses.replace(result.response, **gone)
    return dataclasses.replace(result, response=response, spikes=spikes)


@pytest.fixture(scope="module")
def whole(synthetic: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the synthetic result, saved with an empty report."""
    folder = tmp_path_factory.mktemp("whole")
    with pytest.MonkeyPatch.context() as patched:
        write = "fefinger.pages.report.write"
        patched.setattr(write, lambda result, path: Path(path).write_text("report"))
        synthetic.save(folder)
    return folder


@pytest.fixture
def copied(whole: Path, tmp_path: Path) -> Path:
    """Return a copy of its file, to be damaged."""
    return Path(shutil.copy(whole / "result.nc", tmp_path))


@pytest.mark.usefixtures("plain_report")
@pytest.mark.parametrize(
    "missing",
    [
        (),
        ("spikes",),
        ("fields",),
        ("pressure", "pad", "centroid", "contact_area"),
        ("sites", "strain", "reference", "fields", "spikes"),
    ],
)
def test_a_saved_result_loads_equal(
    synthetic: Result, tmp_path: Path, missing: tuple[str, ...]
) -> None:
    result = without(synthetic, *missing)
    written = result.save(tmp_path / "out")
    names = ["result.nc", "result.vtkhdf", "spikes.csv", "units.csv", "report.html"]
    gone = {"fields": {"result.vtkhdf"}, "spikes": {"spikes.csv", "units.csv"}}
    left_out = set().union(*(gone.get(each, set()) for each in missing))
    expected = [name for name in names if name not in left_out]
    assert [Path(path).name for path in written] == expected
    assert sorted(os.listdir(tmp_path / "out")) == sorted(expected)
    assert_same(load(tmp_path / "out"), result)


@pytest.mark.usefixtures("plain_report")
def test_a_result_of_before_errors_were_stated_of_each_thing_loads_without_them(
    synthetic: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    encode = netcdf._encode

    def former(value: Any, place: str, variables: dict[str, Any]) -> Any:
        found = encode(value, place, variables)
        late = {"Rung": "errors", "Plan": "trust", "Refusal": "field", "Fields": "energy"}
        if isinstance(found, dict) and found.get("record") in late:
            del found[late[found["record"]]]
        return found

    monkeypatch.setattr(netcdf, "_encode", former)
    refusal = dataclasses.replace(synthetic.plan.overridden[0], field="motion.depth")
    dataclasses.replace(
        synthetic, plan=dataclasses.replace(synthetic.plan, overridden=(refusal,))
    ).save(tmp_path)
    found = load(tmp_path).plan
    assert found.trust == ""
    assert found.overridden == (dataclasses.replace(refusal, field=""),)
    assert [rung.errors for rung in found.rungs] == [{}, {}]
    assert found.chosen.error == synthetic.plan.chosen.error


@pytest.mark.usefixtures("plain_report")
def test_a_result_of_before_delays_and_trials_loads_without_them(
    synthetic: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    encode = netcdf._encode

    def former(value: Any, place: str, variables: dict[str, Any]) -> Any:
        found = encode(value, place, variables)
        if isinstance(found, dict) and found.get("record") == "SpikeTrains":
            del variables[found.pop("delays")["array"]], found["trial"]
        return found

    assert synthetic.spikes is not None
    far = dataclasses.replace(synthetic.spikes, delays=np.full(4, 0.01))
    monkeypatch.setattr(netcdf, "_encode", former)
    dataclasses.replace(synthetic, spikes=far).save(tmp_path)
    assert_same(load(tmp_path), synthetic)


TISSUE_SET = """
pad_radius = 15.0
[prony]
c = [0.4, 0.6]
v = [10.0]
[skin]
modulus = 90.0
poisson = 0.45
thickness = 0.9
law = "demiray"
exponent = 3.0
[subcutaneous]
modulus = 30.0
poisson = 0.49
"""


@pytest.mark.usefixtures("plain_report")
def test_a_result_loads_without_the_files_of_its_finger(synthetic: Result, tmp_path: Path) -> None:
    named = {name: tmp_path / name for name in ("tissue.toml", "scan.stl", "bone.stl")}
    for file in named.values():
        file.write_text(TISSUE_SET)
    finger = Finger(
        14,
        10,
        subject_name="a.h.",
        tissue=str(named["tissue.toml"]),
        surface=str(named["scan.stl"]),
        bone_surface=str(named["bone.stl"]),
        subcutaneous=Tissue(30, 0.49, prony=Prony((0.5, 0.5), (2.0,))),
        nail=Hard(2e6),
    )
    scene = dataclasses.replace(synthetic.scene, finger=finger)
    result = dataclasses.replace(synthetic, scene=scene)
    result.save(tmp_path / "out")
    for file in named.values():
        file.unlink()
    found = load(tmp_path / "out")
    assert_same(found, result)
    assert found.scene.finger.skin.exponent == 3.0
    found.save(tmp_path / "again")
    assert_same(load(tmp_path / "again"), result)


@pytest.mark.usefixtures("plain_report")
def test_a_saved_scene_runs_again_without_the_file_of_its_tissue(
    synthetic: Result, tmp_path: Path
) -> None:
    file = tmp_path / "tissue.toml"
    file.write_text(TISSUE_SET)
    finger = Finger(14, 10, subject_name="a.h.", tissue=str(file), pad_radius=13)
    ask = Ask(mechanics="lumped", pressure=False, strain=False, fields=False)
    scene = dataclasses.replace(synthetic.scene, finger=finger, ask=ask)
    dataclasses.replace(synthetic, scene=scene).save(tmp_path / "out")
    refusals = [rung.refusals for rung in explain(scene).rungs]
    file.unlink()
    found = load(tmp_path / "out").scene
    assert found == scene
    assert [rung.refusals for rung in explain(found).rungs] == refusals
    assert Scene.from_toml(found.to_toml()) == scene
    assert dataclasses.replace(found.finger, width=15).skin == finger.skin
    notes = run(found).notes
    assert f"The file of the tissue, {file}, is gone; this scene has kept its values." in notes
    assert any("pad_radius 13 mm instead of 14 mm" in note for note in notes)
    with pytest.raises(InputError, match="expected a TOML file with a tissue set"):
        Finger(14, 10, tissue=str(file))


@pytest.mark.usefixtures("plain_report")
def test_a_long_sampled_motion_is_saved_whole(synthetic: Result, tmp_path: Path) -> None:
    time = np.linspace(0, 1, 6000)
    motion = Sampled(time=tuple(time), depth=tuple(1 - np.cos(np.pi * time)))
    result = dataclasses.replace(
        synthetic, scene=dataclasses.replace(synthetic.scene, motion=motion)
    )
    result.save(tmp_path)
    assert load(tmp_path).scene == result.scene  # exact: a file keeps every bit


@pytest.mark.usefixtures("plain_report")
def test_the_energy_on_the_mesh_is_saved(synthetic: Result, tmp_path: Path) -> None:
    fields = synthetic.fields
    assert fields is not None
    energy = np.random.default_rng(1).random((*fields.pressure.shape, 2))
    response = dataclasses.replace(
        synthetic.response, fields=dataclasses.replace(fields, energy=energy)
    )
    result = dataclasses.replace(synthetic, response=response)
    result.save(tmp_path)
    assert_same(load(tmp_path), result)
    with xr.open_dataset(tmp_path / "result.nc", engine="h5netcdf", decode_times=False) as data:
        saved = data["mesh_energy"].sel(limit="elastic")
        assert (saved == energy[..., 1].astype(np.float32)).all()  # exact: a file keeps every bit


def test_every_saved_array_says_its_unit_and_meaning(synthetic: Result, whole: Path) -> None:
    with xr.open_dataset(whole / "result.nc", engine="h5netcdf") as data:
        for name, variable in data.data_vars.items():
            assert variable.attrs["long_name"], name
            assert name in ("scene", "record") or variable.attrs["units"], name
        assert data["pressure"].dims == ("time", "pad")
        assert data["strain"].dims == ("time", "site", "axis", "axis_2")
        assert data["unit_current"].sel(unit="FAI-1").shape == synthetic.time.shape


def test_a_result_is_a_dataset_as_it_is_on_disk(synthetic: Result, whole: Path) -> None:
    with xr.open_dataset(whole / "result.nc", engine="h5netcdf", decode_times=False) as saved:
        xr.testing.assert_identical(synthetic.to_xarray(), saved.load())


def test_every_array_of_the_records_has_a_place_in_the_file() -> None:
    for name, record in RECORDS.items():
        for field in dataclasses.fields(record):
            if "Array" in str(field.type) or "ndarray" in str(field.type):
                assert (name, field.name) in LAYOUT


@pytest.mark.usefixtures("plain_report")
def test_a_result_shows_its_numbers_and_not_its_arrays(synthetic: Result) -> None:
    text = repr(synthetic)
    assert text.startswith(f"Result of {synthetic.scene.name}\npeak force")
    assert "within 4 %" in text
    assert len(text.splitlines()) <= 10
    assert synthetic.spikes is not None
    assert repr(synthetic.spikes).endswith(f"{synthetic.spikes.summary()}>")


@pytest.mark.parametrize(
    ("area", "expected"),
    [(0.46, "(true value {:.2g} to {:.2g} mm²)"), (1.2, "at least {:.2g} mm², upper limit not")],
)
def test_a_large_error_is_told_as_a_range_with_what_would_be_better(
    synthetic: Result, area: float, expected: str
) -> None:
    hertz, rung = synthetic.plan.rungs
    rungs = (
        dataclasses.replace(hertz, errors={"area": 0.1}),
        dataclasses.replace(rung, errors={"area": area}),
    )
    plan = dataclasses.replace(synthetic.plan, rungs=rungs)
    text = repr(dataclasses.replace(synthetic, plan=plan))
    assert synthetic.contact_area is not None
    answer = float(f"{synthetic.contact_area.max():.3g}")
    assert expected.format(answer / (1 + area), answer / abs(1 - area)) in text
    assert "contact area may be far off" in text
    assert "hertz states 10 % (--mechanics hertz)" in text
    alone = dataclasses.replace(plan, rungs=rungs[1:])  # as where the mechanics was named
    text = repr(dataclasses.replace(synthetic, plan=alone))
    assert "for the contact area, the reference is solid (--mechanics solid)" in text


def test_spikes_csv_holds_every_spike_with_its_place(synthetic: Result, whole: Path) -> None:
    assert synthetic.spikes is not None
    with open(whole / "spikes.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["unit", "type", "x_mm", "y_mm", "z_mm", "time_s"]
    # exact: the table has every digit
    assert [float(row["time_s"]) for row in rows] == np.concatenate(synthetic.spikes.times).tolist()
    assert synthetic.spikes.positions is not None
    place = [float(rows[-1][name]) for name in ("x_mm", "y_mm", "z_mm")]
    assert rows[-1]["unit"] == "FAI-1"
    assert place == synthetic.spikes.positions[2].tolist()  # exact: the table has every digit


@pytest.mark.usefixtures("plain_report")
def test_files_of_an_earlier_result_do_not_stay(synthetic: Result, tmp_path: Path) -> None:
    synthetic.save(tmp_path)
    without(synthetic, "fields", "spikes").save(tmp_path)
    assert sorted(os.listdir(tmp_path)) == ["report.html", "result.nc"]


@pytest.mark.parametrize("name", ["result.nc", "result.vtkhdf", "spikes.csv", "report.html"])
def test_a_file_that_no_result_wrote_is_not_overwritten(
    synthetic: Result, tmp_path: Path, name: str
) -> None:
    (tmp_path / name).write_text("mine")
    with pytest.raises(InputError, match=f"'{name}' in .* would be overwritten"):
        synthetic.save(tmp_path)
    assert [path.read_text() for path in tmp_path.iterdir()] == ["mine"]


@pytest.mark.usefixtures("plain_report")
def test_a_file_that_the_result_in_the_folder_does_not_hold_is_not_overwritten(
    synthetic: Result, tmp_path: Path
) -> None:
    without(synthetic, "fields", "spikes").save(tmp_path)
    (tmp_path / "spikes.csv").write_text("mine")
    with pytest.raises(InputError, match=r"'spikes\.csv' in .* no result of fefinger there holds"):
        synthetic.save(tmp_path)
    (tmp_path / "spikes.csv").unlink()
    (tmp_path / "study.json").write_text("{}")  # the page is that of the study
    with pytest.raises(InputError, match=r"'report\.html'"):
        synthetic.save(tmp_path)


@pytest.mark.usefixtures("plain_report")
@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_an_interruption_leaves_no_half_written_file(
    synthetic: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: type[BaseException]
) -> None:
    def stop(result: Result, path: Path) -> None:
        Path(path).write_text("half")
        raise error

    synthetic.save(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    monkeypatch.setattr(report, "write", stop)
    with pytest.raises(error):
        without(synthetic, "fields", "spikes").save(tmp_path)
    # exact: the files are the same ones
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_file_in_the_place_of_the_folder_is_refused(synthetic: Result, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="output folder: expected a folder, received the file"):
        synthetic.save(tmp_path / "file")


def test_a_folder_that_cannot_be_made_is_refused(synthetic: Result, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="output folder: expected a folder that can be written"):
        synthetic.save(tmp_path / "file" / "out")


@pytest.mark.parametrize("path", ["nowhere", "empty", "empty/result.nc"])
def test_a_missing_result_is_named(tmp_path: Path, path: str) -> None:
    (tmp_path / "empty").mkdir()
    with refused("result"):
        load(tmp_path / path)


def test_a_file_that_is_no_result_is_refused(tmp_path: Path) -> None:
    (tmp_path / "result.nc").write_text("not HDF5")
    with pytest.raises(InputError, match="damaged or foreign file"):
        load(tmp_path)


def test_another_netcdf_file_is_refused(tmp_path: Path) -> None:
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with pytest.raises(InputError, match=r"'.*other\.nc' is not a result of fefinger"):
        load(tmp_path / "other.nc")


@pytest.mark.usefixtures("plain_report")
def test_a_result_of_another_version_is_refused_and_replaced(
    synthetic: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as other:
        other.setattr(netcdf, "FORMAT", "fefinger result 9")
        synthetic.save(tmp_path)
    found = "by another version of fefinger: format 'fefinger result 9', this version reads '.* 1'"
    with pytest.raises(InputError, match=found):
        load(tmp_path)
    synthetic.save(tmp_path)
    assert_same(load(tmp_path), synthetic)


def test_a_truncated_result_is_refused(copied: Path) -> None:
    copied.write_bytes(copied.read_bytes()[: copied.stat().st_size // 2])
    with refused("result"):
        load(copied.parent)


@pytest.mark.parametrize("part", [b"FHDB", b"BTLF"])  # blocks of links and of their names
def test_a_result_with_damaged_links_is_refused(copied: Path, part: bytes) -> None:
    content = copied.read_bytes()
    assert part in content
    copied.write_bytes(content.replace(part, b"xxxx"))
    with refused("result"):
        load(copied.parent)


@pytest.mark.parametrize("part", ["force", "strain", "spikes", "record", "scene"])
def test_a_flipped_bit_in_the_values_is_noticed(synthetic: Result, copied: Path, part: str) -> None:
    assert synthetic.force is not None
    assert synthetic.spikes is not None
    stored = {
        "force": synthetic.force.tobytes(),
        "spikes": np.concatenate(synthetic.spikes.times).tobytes(),
        "record": b"converged: every contact step",
        "scene": synthetic.scene.to_toml().encode(),
    }
    content = bytearray(copied.read_bytes())
    if part in stored:
        place = content.index(stored[part]) + len(stored[part]) // 2
    else:  # it is compressed
        with h5py.File(copied) as file:
            chunk = file[part].id.get_chunk_info(0)
        place = chunk.byte_offset + chunk.size // 2
    content[place] ^= 1
    copied.write_bytes(content)
    with refused("result"):
        load(copied.parent)


def test_a_heap_of_texts_that_hdf5_would_read_forever_is_refused(copied: Path) -> None:
    content = bytearray(copied.read_bytes())
    heap = content.index(b"GCOL") + 16
    content[heap : heap + 16] = bytes(16)
    copied.write_bytes(content)
    with refused("result"):
        load(copied.parent)
    assert netcdf.stored(copied) is None


def test_an_array_that_does_not_fit_into_its_file_is_refused_before_it_is_read(
    copied: Path,
) -> None:
    with h5py.File(copied, "r+") as file:
        del file["pressure"]
        file.create_dataset("pressure", shape=(10**6, 10**6), chunks=(1000, 1000), dtype="f8")
    with refused("result"):
        load(copied.parent)


@pytest.mark.usefixtures("plain_report")
def test_a_result_of_before_the_checksum_loads(synthetic: Result, tmp_path: Path) -> None:
    path = Path(synthetic.save(tmp_path)[0])
    with h5py.File(path, "r+") as file:
        del file.attrs[netcdf.DIGEST]
    assert_same(load(tmp_path), synthetic)


def test_another_record_is_no_result(whole: Path, tmp_path: Path) -> None:
    with xr.open_dataset(whole / "result.nc", engine="h5netcdf") as kept:
        other = kept.load().assign(record='{"dict": {}}')
    other.to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with refused("result"):
        load(tmp_path / "other.nc")


@pytest.mark.parametrize(
    ("mechanics", "largest", "told"),
    [("linear", 0.45, True), ("linear", 0.35, False), ("solid", 0.45, False)],
)
def test_strain_that_is_not_small_is_cautioned_of_where_it_counts_as_small(
    synthetic: Result, mechanics: str, largest: float, told: bool
) -> None:
    strain = synthetic.strain * largest / np.abs(np.linalg.eigvalsh(synthetic.strain)).max()
    response = dataclasses.replace(synthetic.response, mechanics=mechanics, strain=strain)
    found = cautions(dataclasses.replace(synthetic, response=response))
    assert any("as small strain" in each for each in found) == told


@pytest.mark.parametrize(
    ("changes", "mechanics", "apart"),
    [
        ({}, "linear", ("FAII",)),
        ({}, "modal", ()),
        ({"motion": Vibration(0.5, amplitude=0.01, frequency=200.0)}, "linear", ()),
        ({"ask": Ask(spikes=("SAI",))}, "linear", ()),
    ],
)
def test_units_that_nothing_in_the_mechanics_drives_are_not_printed_like_the_others(
    synthetic: Result, changes: dict[str, object], mechanics: str, apart: tuple[str, ...]
) -> None:
    scene = dataclasses.replace(synthetic.scene, **changes)
    response = dataclasses.replace(synthetic.response, mechanics=mechanics)
    result = dataclasses.replace(synthetic, scene=scene, response=response)
    assert result.unmodeled == apart
    assert sum("not modeled" in each for each in cautions(result)) == len(apart)
    spikes = dict(rows(result))["spikes"]
    assert ("FAII-1 0 (not modeled here)" in spikes) == bool(apart)
    assert spikes.count("not modeled") == len(apart)
    assert fired_record(result.spikes, apart)["unmodeled"] == list(apart)


def test_a_file_is_small_where_little_happens_and_no_smaller_than_memory_is_guarded(
    synthetic: Result, tmp_path: Path
) -> None:
    """Pressures of a short touch in a long rest: zeros are nearly nothing, the rest 4 bytes."""
    n_t, n_pad = 600, len(synthetic.pad.points)
    time = np.linspace(0, 2, n_t)
    rng = np.random.default_rng(2)
    pressure = np.zeros((n_t, n_pad))
    pressure[: n_t // 10] = rng.uniform(1.0, 20.0, (n_t // 10, n_pad))
    response = dataclasses.replace(
        without(synthetic, "spikes", "strain", "fields", "gap", "moment").response,
        time=time,
        pressure=pressure,
        **{name: np.ones(n_t) for name in ("depth", "force", "contact_area")},
        centroid=np.zeros((n_t, 2)),
    )
    result = dataclasses.replace(without(synthetic, "spikes"), response=response)
    file = tmp_path / "result.nc"
    data = netcdf.dataset(result)
    file.write_bytes(atomic_write.netcdf(data))
    size = file.stat().st_size
    assert size < 1.2 * 4 * pressure.size / 10 + 100_000
    assert load(file).pressure == pytest.approx(pressure, rel=1e-7)
    data["bomb"] = ("many", np.zeros(100 * size, np.float32))  # 400 times the file
    file.write_bytes(atomic_write.netcdf(data))
    with refused("result"):
        load(file)
