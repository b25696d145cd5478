"""Records as rigs write them: one press in many files, and the sentences on what cannot be told."""

import io
import zlib

import h5py
import numpy as np
import pytest
from refusals import refused
from scipy.io import savemat

from fefinger.commands.calibrate import _named
from fefinger.support import recording_files
from fefinger.support.checks import InputError
from fefinger.support.recordings import Recording


WANTED = ("time", "position", "force")
PRESS = np.column_stack([np.arange(6) * 1e-3, [0, 0.25, 0.5, 0.75, 1, 1], [0, 0, 0.5, 1, 2, 1.75]])
"""Time s, position mm, force N."""


def rows(table, separator=",", decimal=".", end=""):
    lines = (separator.join(f"{x:.9g}" for x in row) + end for row in table.tolist())
    return "".join(f"{line.replace('.', decimal)}\n" for line in lines)


LVM = """LabVIEW Measurement\t
Writer_Version\t2
Separator\tTab
Decimal_Separator\t,
Multi_Headings\tNo
X_Columns\t{columns}
***End_of_Header***\t
\t
Channels\t2\t
Samples\t6\t6\t
Y_Unit_Label\tmm\tmN\t
X_Dimension\tTime\tTime\t
X0\t0,0E+0\t0,0E+0\t
Delta_X\t0,001\t0,001\t
***End_of_Header***\t\t
X_Value\tPosition\tForce\tComment
"""


def lvm(columns):
    table = PRESS * [1, 1, 1e3]
    body = rows(table, "\t", ",", "\t")
    if columns == "No":
        body = "".join(f"\t{line}\n" for line in rows(table[:, 1:], "\t", ",", "\t").splitlines())
    return LVM.format(columns=columns) + body


def segments(columns, start="0,003"):
    """Write the press in two segments of three rows, the second of which begins at `start`."""
    lines = lvm(columns).replace("Multi_Headings\tNo", "Multi_Headings\tYes").splitlines(True)
    header, body = lines[8:-6], lines[-6:]
    again = [line.replace("0,0E+0", start) for line in header]
    return "".join([*lines[:8], *header, *body[:3], "\t\n", *again, *body[3:]])


def in_commas(text):
    return text.replace("Separator\tTab", "Separator\tComma").replace(",", ".").replace("\t", ",")


TEXTS = {
    "plain": "time,position,force\n" + rows(PRESS),
    "order and units": "F [mN],t (ms),x (µm)\n" + rows(PRESS[:, [2, 0, 1]] * [1e3, 1e3, 1e3]),
    "decimal commas": "Zeit [s];Weg [mm];Kraft [N]\n" + rows(PRESS, ";", ","),
    "tabs and commas": "Time\tPosition\tForce\n" + rows(PRESS, "\t", ",", "\t"),
    "units in a line": "Rig 3\nDate,today\n\nTime,Position,Force\n(s),(mm),(N)\n" + rows(PRESS),
    "comments": "# subject 4\n# time_s displacement_m force_N\n" + rows(PRESS * [1, 1e-3, 1], " "),
    "by unit": "clock (ms),gap (um),cell (N),temperature\n"
    + rows(np.column_stack([PRESS * [1e3, 1e3, 1], np.full(6, 21.0)])),
    "lvm": lvm("One"),
    "lvm without times": lvm("No"),
    "lvm of two segments": segments("One"),
    "lvm of two segments without times": segments("No"),
    "lvm with commas": in_commas(lvm("One")),
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
@pytest.mark.parametrize("encoding", ["utf-8-sig", "cp1252", "utf-16"])
def test_a_press_is_read_from_a_text(tmp_path, text, encoding):
    file = tmp_path / "press.txt"
    file.write_text(text, encoding=encoding)
    found = recording_files.read(str(file), file).pick(WANTED)
    np.testing.assert_allclose(found, PRESS, rtol=1e-9, atol=1e-12)


def test_a_press_is_read_from_matlab_and_hdf5(tmp_path):
    time, position, force = PRESS.T
    files = [tmp_path / name for name in ("a.mat", "b.mat", "c.h5", "d.mat")]
    savemat(files[0], {"trial": {"t": time, "pos": position, "force": force}, "note": "thumb"})
    savemat(files[1], {"fs": 1000.0, "position": position, "force": force, "taps": [1.0, 2.0]})
    for file in files[2:]:  # MATLAB's own files of version 7.3 are HDF5, with rows
        with h5py.File(file, "w") as out:
            out["run/time"] = time[None]
            out["run/position"] = 1e3 * position
            out["run/force"] = force
            out["run/position"].attrs["units"] = "um"
    for file in files:
        found = recording_files.read(str(file), file).pick(WANTED)
        np.testing.assert_allclose(found, PRESS, rtol=1e-9, atol=1e-12)


def test_a_column_that_cannot_be_told_is_asked_for_and_taken(tmp_path):
    file = tmp_path / "press.csv"
    file.write_text("a,b,c\n" + rows(PRESS * [1e3, 1, 1e3]))
    found = recording_files.read(str(file), file)
    with pytest.raises(InputError, match=r"one column 'time' \(s\), received none .*'a,b,c'; say"):
        found.pick(WANTED)
    named = {"time": "A in ms", "position": "b", "force": "3 in mN"}
    np.testing.assert_allclose(found.pick(WANTED, named), PRESS, rtol=1e-12)
    for wrong, message in (
        ({"time": "d"}, "time: expected one of the columns 'a,b,c', or its number, received 'd'"),
        ({"time": "a in mm"}, "expected a unit of s, such as s, sec, .*, received 'mm'"),
        ({"angle": "a"}, "--column: expected one of time, position, force .* received 'angle'"),
    ):
        with pytest.raises(InputError, match=message):
            found.pick(WANTED, named | wrong)


BAD = {
    "empty": ("", "a header and rows of numbers below it, received an empty file"),
    "words": ("time,position,force\nn,n,n\n", "rows of numbers below it, received the lines"),
    "short row": ("time,position,force\n0,1,2\n0,1\n1,2,3\n", "line 3: expected 3 values, rec"),
    "commas twice": ("time,position\n0,0,1,0\n0,1,1,0\n", "expected 2 values, .* write 0.5 for"),
    "gap": ("time,position,force\n0,1,2\n1,,2\n2,2,2\n", "line 3, column position: .* received ''"),
    "nan": ("time,position,force\n0,1,2\n1,nan,2\n", "line 3, column position: .*received nan"),
    "two forces": (
        "time,x,force_a,force_b\n0,1,2,3\n1,1,2,3\n",
        "received 2, force_a, force_b",
    ),
    "two loads": ("time,x,force 1,force\n0,1,2,3\n1,1,2,3\n", None),
    "volts": ("time,x,force (V)\n0,1,2\n1,1,2\n", r"column 'force \(V\)': expected force in N"),
    "again": ("time,x,force\n0,1,2\n0,1,2\n", "line 3: expected a time above 0 s, .* repeated"),
    "back": ("time,x,force\n1,1,2\n0,1,2\n", "line 3: expected a time above 1 s, .* earlier"),
}


@pytest.mark.parametrize(("text", "message"), BAD.values(), ids=BAD)
def test_what_is_no_record_is_refused_with_its_place(tmp_path, text, message):
    file = tmp_path / "bad.csv"
    file.write_text(text)
    if message is None:
        assert recording_files.read(str(file), file).pick(WANTED)[0, 2] == pytest.approx(3.0)
        return
    with pytest.raises(InputError, match=message) as refused:
        recording_files.read(str(file), file).pick(WANTED)
    assert str(refused.value).startswith(str(file))


def _without_rows(file):
    file.write_text(lvm("No").partition("X_Value")[0])


def _without_step(file):
    file.write_text(lvm("No").replace("Delta_X\t0,001\t0,001", "Delta_X"))


def _with_endless_steps(file):
    file.write_text(lvm("No").replace("Delta_X\t0,001", "Delta_X\tinf"))


def _begun_again(file):
    file.write_text(segments("No", start="0,0E+0"))


def _of_other_columns(file):
    head, rows = segments("One").rsplit("X_Value", 1)
    file.write_text(head + "X_Value" + rows.replace("Force", "Load"))


def _of_other_times(file):
    lines = lvm("One").replace("Position\tForce", "Position\tX_Value\tForce").splitlines()
    body = [line.replace("\t", "\t0,5\t") for line in lines[-6:]]
    file.write_text("\n".join([*lines[:-6], *body]))


def _far_away(file):
    file.write_text("time,position (m),force\n0,0,0\n1,1e306,1\n")


def _with_long_doubles(file):
    with h5py.File(file, "w") as out:
        out["time"] = PRESS[:, 0].astype(np.longdouble) * np.longdouble("1e4000")


def _of_no_type(file):
    """Give the last values of a file a type that there is not, at which SciPy ends Python."""
    savemat(file, {"trial": {"t": PRESS[:, 0]}})
    content = bytearray(file.read_bytes())
    content[-PRESS[:, 0].nbytes - 8] = 255
    file.write_bytes(content)


UNUSUAL = {
    "names alone.lvm": (_without_rows, "names and rows of numbers below"),
    "no step.lvm": (_without_step, "expected Delta_X, the time between rows, received none"),
    "endless.lvm": (_with_endless_steps, "expected a finite number, received nan"),
    "again.lvm": (_begun_again, "line 29: expected .* times that go on, received 0 s after 0.002"),
    "columns.lvm": (
        _of_other_columns,
        "columns as in the first one, received .X_Value,Position,Load",
    ),
    "times.lvm": (_of_other_times, "expected the same times X_Value of all channels"),
    "far.csv": (_far_away, r"line 3, column position \(m\): expected a size of at most 1e\+30"),
    "long.h5": (_with_long_doubles, "column time: expected a finite number, received inf"),
    "type.mat": (_of_no_type, "expected a MATLAB file, received (a damaged one|another)"),
}


@pytest.mark.parametrize(("name", "case"), UNUSUAL.items(), ids=UNUSUAL)
def test_a_file_that_is_nearly_one_of_its_kind_is_refused(tmp_path, name, case):
    write, message = case
    write(tmp_path / name)
    with pytest.raises(InputError, match=message):
        recording_files.read(name, tmp_path / name).pick(WANTED)


@pytest.mark.parametrize("name", ["a.mat", "a.h5", "a.csv", "a.lvm"])
def test_bytes_that_are_no_file_of_their_kind_are_refused(tmp_path, name):
    file = tmp_path / name
    file.write_bytes(
        b"LabVIEW Measurement\nChannels\t2\n" if name == "a.lvm" else b"\x00\x01\x02\x03" * 40
    )
    with pytest.raises(InputError, match="expected a"):
        recording_files.read(str(file), file)
    with refused("file"):
        recording_files.read("file", tmp_path / f"no{name}")


def hdf5(file, **options):
    """Write a press to an HDF5 file, with its units."""
    with h5py.File(file, "w") as out:
        for name, unit, column in zip(WANTED, ("s", "mm", "N"), PRESS.T, strict=True):
            out.create_dataset(name, data=column, **options).attrs["units"] = unit
    return file


def an_entry_of_no_length(content):
    """Make an entry that the library would read forever."""
    heap = content.index(b"GCOL") + 16
    content[heap : heap + 16] = bytes(16)


def an_entry_beyond_its_heap(content):
    heap = content.index(b"GCOL") + 16
    content[heap + 8 : heap + 16] = b"\xff" * 8


def without_names(content):
    """Damage the names, at which the library raises RuntimeError."""
    content[:] = content.replace(b"SNOD", b"xxxx")


def cut_short(content):
    del content[-64:]


def wrong_chunk(content):
    with h5py.File(io.BytesIO(bytes(content))) as file:
        place = file["force"].id.get_chunk_info(0).byte_offset
    content[place] ^= 0xFF


DAMAGE = (an_entry_of_no_length, an_entry_beyond_its_heap, without_names, cut_short, wrong_chunk)


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_hdf5_file_is_refused_in_a_sentence(tmp_path, damage):
    file = hdf5(tmp_path / "a.h5", chunks=(6,), compression="gzip", fletcher32=True)
    content = bytearray(file.read_bytes())
    damage(content)
    file.write_bytes(content)
    with pytest.raises(
        InputError, match=r"a\.h5: expected an HDF5 file, received a damaged"
    ) as told:
        recording_files.read("a.h5", file)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("unit", "size"),
    [(np.array(["mN"], object), 1e-3), (np.bytes_(b"mN"), 1e-3), (5, 1), ([1, 2], 1)],
    ids=str,
)
def test_a_unit_that_is_no_text_is_none(tmp_path, unit, size):
    file = hdf5(tmp_path / "a.h5")
    with h5py.File(file, "r+") as out:
        out["force"].attrs["units"] = unit
        out.create_dataset("nothing", data=h5py.Empty("f8"))
    np.testing.assert_allclose(recording_files.read("a", file).pick(WANTED), PRESS * [1, 1, size])


def test_a_small_matlab_file_that_unpacks_to_gigabytes_is_refused_unread(tmp_path, monkeypatch):
    """It holds a stream of zeros; the library is not asked."""
    monkeypatch.setattr("scipy.io.loadmat", None)
    packer = zlib.compressobj(1)
    packed = b"".join(packer.compress(bytes(10**7)) for _ in range(26)) + packer.flush()
    element = (15).to_bytes(4, "little") + len(packed).to_bytes(4, "little") + packed
    small = (15).to_bytes(4, "little") + (0).to_bytes(4, "little")
    file = tmp_path / "a.mat"
    head = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"
    file.write_bytes(head + small + element)
    with pytest.raises(InputError, match="a: expected a MATLAB file with at most 250 MB"):
        recording_files.read("a", file)


@pytest.mark.parametrize("shape", [(10**6, 10**6), (5 * 10**6,)], ids=["square", "long"])
def test_numbers_that_do_not_fit_into_memory_are_refused_before_they_are_read(tmp_path, shape):
    file = hdf5(tmp_path / "a.h5")
    with h5py.File(file, "r+") as out:
        for name in "abcd":
            out.create_dataset(name, shape=shape, chunks=(1000,) * len(shape), dtype="i1")
    with pytest.raises(InputError, match=r"a: expected at most [\d.e+]+ (numbers|rows)"):
        recording_files.read("a", file)


def test_times_in_milliseconds_are_told_unless_a_unit_is_stated():
    values = np.column_stack([np.arange(100.0), np.ones(100)])
    for header, unit, told in (("time", "", True), ("t (s)", "", False), ("time", "s", False)):
        found = Recording("f", (header, "force"), (unit, ""), values, int)
        if told:
            with pytest.raises(InputError, match="100 samples 1 apart, as if they were in ms"):
                found.pick(("time", "force"))
        else:
            assert len(found.pick(("time", "force"))) == 100
    assert len(Recording("f", ("time", "force"), ("", ""), values, int).pick(("time",), slow=True))


@pytest.mark.parametrize("text", ["force", "=a", "force="])
def test_a_column_is_named_by_a_quantity_and_a_header(text):
    with refused("--column"):
        _named(None, None, (text,))
    assert _named(None, None, ("force=a = b in mN",)) == {"force": "a = b in mN"}
