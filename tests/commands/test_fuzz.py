"""Nothing that a user can hand over ends in anything but an answer or one sentence.

Scenes, files and stored answers are mutated, always in the same way: each is accepted, with status
0, or refused in one sentence, with status 2. No other exception, and no warning of a library.
"""

import re
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import fefinger as ff
from fefinger.__main__ import main
from fefinger.scene import builtin
from fefinger.scene.toml import parse
from fefinger.studies import tasks
from fefinger.support.checks import InputError
from fefinger.support.text import flat


def often(examples: int) -> Callable[[Any], Any]:
    """Return settings of a number of examples: the same in every run, without a limit of time."""
    allowed = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
    return settings(
        max_examples=examples, derandomize=True, deadline=None, suppress_health_check=allowed
    )


KEYS = [(name, key) for name in builtin.names() for key, _ in flat(parse(builtin.text(name)))]
"""Scenes with each of their keys."""

SIZES = [0.0, -0.0, 1.0, 1e-300, 5e-324, 1.1e-30, 1e-9, 1e9, 9e29, 1e300, -1.0]
NUMBERS = st.one_of(st.sampled_from(SIZES), st.floats(), st.integers(), st.booleans())
TEXTS = st.one_of(st.text(max_size=20), st.sampled_from(["x" * 100_000, "\x1b[31m", "/etc/shadow"]))
VALUES = st.recursive(
    st.one_of(NUMBERS, TEXTS),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.sampled_from("aé "), inner, max_size=2)
    ),
    max_leaves=6,
)


def answered(capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    """Run a command; it answers, or refuses in one printable sentence with status 2."""
    status = main(words)
    shown = capsys.readouterr()
    assert status in (0, 2)
    sentences = re.findall(r"^(?:error|Error): \S.*", shown.err, re.MULTILINE)
    assert len(sentences) == (status == 2), shown.err
    assert all(len(line) < 3000 and line.isprintable() for line in shown.err.splitlines())


@often(40)
@given(st.sampled_from(KEYS), VALUES)
@example(("p7-curvature", "motion.force"), 1e-300)
@example(("p3-ramp-and-sinusoid", "motion.speed"), float("nan"))
@example(("p3-ramp-and-sinusoid", "motion.depth"), 10**400)
def test_a_scene_with_any_value(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], at: tuple[str, str], value: Any
) -> None:
    name, key = at
    scene = parse(builtin.text(name))
    table = scene if "." not in key else scene[key.partition(".")[0]]
    table[key.rpartition(".")[2]] = value
    (tmp_path / "scene.toml").write_text(tomli_w.dumps(scene), encoding="utf-8")
    answered(capsys, ["explain", str(tmp_path / "scene.toml")])


@pytest.mark.parametrize("key", ["finger.pad_radius", "finger.tip_radius", "finger.surface"])
@pytest.mark.parametrize("value", ["1e-300", "1.1e-30", "1e300", "-nan", "[1, 'a']", "{}", "''"])
@pytest.mark.parametrize("scene", ["flat-press", "curved-hold"])  # with a subject, and by sizes
def test_a_finger_with_any_value(
    capsys: pytest.CaptureFixture[str], scene: str, key: str, value: str
) -> None:
    answered(capsys, ["explain", scene, "--set", f"{key}={value}"])


RAW = {
    "deep": "[" * 1000 + "]" * 1000,
    "digits": "1" * 5000,
    "hexadecimal": "0x" + "F" * 5000,
    "deep tables": "{a = " * 500 + "1" + "}" * 500,
}


@pytest.mark.parametrize("value", RAW.values(), ids=RAW)
def test_values_beyond_all_bounds(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], value: str
) -> None:
    for field in ("motion.depth", ".".join("a" * 1000)):
        answered(capsys, ["explain", "flat-press", "--set", f"{field}={value}"])
        answered(capsys, ["study", "flat-press", "--over", f"{field}={value},1"])
        text = builtin.text("flat-press").replace("[motion]", f"[motion]\n{field} = {value}")
        (tmp_path / "scene.toml").write_text(text)
        answered(capsys, ["explain", str(tmp_path / "scene.toml")])


@often(60)
@given(st.data())
def test_a_scene_with_any_bytes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], data: st.DataObject
) -> None:
    text = builtin.text(data.draw(st.sampled_from(builtin.names()))).encode()
    (tmp_path / "scene.toml").write_bytes(damaged(data, text))
    with pytest.MonkeyPatch.context() as patched:  # what is read is not planned, which takes longer
        patched.setattr("fefinger.plan.explain", _read)
        answered(capsys, ["explain", str(tmp_path / "scene.toml")])


def _read(*_: Any) -> None:
    raise InputError("scene: it can be read")


def damaged(data: st.DataObject, content: bytes) -> bytes:
    """Flip bytes, insert some, or leave out a part."""
    start = data.draw(st.integers(0, len(content) - 1))
    length = data.draw(st.sampled_from([0, 1, 4, 100, len(content)]))
    new = st.one_of(st.binary(max_size=8), st.sampled_from([b"\n", b"9" * 400, b"[", b"nan", b","]))
    return content[:start] + data.draw(new) + content[start + length :]


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write one good file of each kind into a folder."""
    import trimesh
    from scipy.io import wavfile

    folder, t = tmp_path_factory.mktemp("good"), np.linspace(0, 1, 20)
    np.savetxt(folder / "motion.csv", np.column_stack([t, t]), "%.3f", ",", header="time,depth")
    heights = np.arange(25.0).reshape(5, 5) / 100
    np.savez(folder / "relief.npz", x=t[:5], y=t[:5], height=heights)
    np.savetxt(folder / "relief.csv", heights, "%.2f", ",")
    wavfile.write(folder / "motion.wav", 1000, np.sin(t).astype(np.float32))
    trimesh.creation.box((14, 14, 10)).export(folder / "finger.stl")
    ff.spikes(t, t, types=("SAI",)).to_npz(folder / "trains.npz")
    tissue = {"skin": {"modulus": 100.0, "poisson": 0.48, "thickness": 1.0}}
    tissue |= {"subcutaneous": {"modulus": 34.0, "poisson": 0.48}}
    (folder / "tissue.toml").write_text(tomli_w.dumps(tissue))
    return folder


READERS: dict[str, Callable[[Path], object]] = {
    "motion.csv": ff.Sampled.from_file,
    "motion.wav": lambda file: ff.Sampled.from_wav(file, amplitude=0.1, preload=0.5),
    "relief.npz": ff.Relief.from_file,
    "relief.csv": lambda file: ff.Relief.from_file(file, pitch=0.5),
    "finger.stl": ff.Finger.from_surface,
    "tissue.toml": lambda file: ff.Finger(14, 11, tissue=str(file)),
    "trains.npz": ff.SpikeTrains.from_npz,
}


@pytest.mark.parametrize("name", READERS)
@often(25)
@given(data=st.data())
def test_a_file_with_any_bytes(good: Path, tmp_path: Path, name: str, data: st.DataObject) -> None:
    file = tmp_path / name
    file.write_bytes(damaged(data, (good / name).read_bytes()))
    try:
        READERS[name](file)
    except InputError as error:
        said = str(error)
    else:
        said = ""
    assert "\n" not in said


FAR = "facet normal 0 0 1\nouter loop\nvertex 1e308 0 0\nvertex 1 0 0\nvertex 0 1e308 0\nendloop\n"


def test_files_that_unpack_to_much_or_lie_far_away(tmp_path: Path) -> None:
    (tmp_path / "far.stl").write_text(f"solid x\n{FAR}endfacet\nendsolid\n")
    with zipfile.ZipFile(tmp_path / "scan.zip", "w") as archive:
        archive.write(tmp_path / "far.stl", "scan.stl")
    row = zlib.compress(bytes(30_001) * 10)
    sizes = struct.pack(">II5B", 30_000, 30_000, 8, 0, 0, 0, 0)
    parts = [(b"IHDR", sizes), (b"IDAT", row), (b"IEND", b"")]
    chunks = [
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in parts
    ]
    (tmp_path / "black.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))
    for read, message in (
        (lambda: ff.Finger.from_surface(tmp_path / "far.stl"), "below 1e\\+06 mm"),
        (lambda: ff.Relief.from_file(tmp_path / "far.stl", pitch=0.1), "below 1e\\+06 mm"),
        (lambda: ff.Finger.from_surface(tmp_path / "scan.zip"), "STL, OBJ, PLY or VTK"),
        (
            lambda: ff.Relief.from_file(tmp_path / "black.png", pitch=0.1, height=0.3),
            "at most 1000000 pixels",
        ),
    ):
        with pytest.raises(InputError, match=message):
            read()


@often(60)
@given(st.data())
def test_a_stored_answer_with_any_bytes(tmp_path: Path, data: st.DataObject) -> None:
    record = {"rows": [{"at": "peak", "force_N": 1.25, "seed": None}], "date": "2026-01-01"}
    file = tmp_path / "answer.json"
    tasks.write_record(file, record)
    file.write_bytes(damaged(data, file.read_bytes()))
    assert tasks.read_record(file) in (None, record)
