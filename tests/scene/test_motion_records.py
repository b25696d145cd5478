"""Records as labs have them, as motions: columns, first times, tares, and forces below 0."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.results import key_numbers
from fefinger.scene.cautions import samples
from fefinger.support import recording_files
from fefinger.support.arrays import Array
from fefinger.view import figures


TIME = np.arange(0.0, 1.2, 2e-3)
DEPTH = 1.2 * (np.clip((TIME - 0.2) / 0.1, 0, 1) - np.clip((TIME - 0.9) / 0.05, 0, 1))  # mm
FORCE = 0.5 * (DEPTH / 1.2) ** 2  # N
NOISE = np.random.default_rng(5).normal(0.0, 5e-3, len(TIME))  # of a sensor in N


def write(path: Path, header: str, *columns: Array, separator: str = ",") -> Path:
    rows = [separator.join(f"{x:.9g}" for x in row) for row in np.column_stack(columns).tolist()]
    path.write_text("\n".join([header, *rows]))
    return path


LABS = {
    "plain": ("time,depth", (TIME, DEPTH)),
    "capitals": ("Time (s),Position (mm)", (TIME, DEPTH)),
    "units": ("Time (ms),Force (mN),Weg (um)", (1e3 * TIME, 1e3 * FORCE, 1e3 * DEPTH)),
    "axes of force": ("t,Fx (N),Fz (N),stage (mm)", (TIME, 0 * TIME, FORCE, DEPTH)),
    "later": ("time_s,depth_mm", (TIME + 12.5, DEPTH)),
    "trigger": ("time,depth,force,temperature", (TIME - 0.2, DEPTH, FORCE, TIME)),
}


@pytest.mark.parametrize(("header", "columns"), LABS.values(), ids=LABS)
def test_a_record_is_a_motion_by_names_and_units(
    tmp_path: Path, header: str, columns: tuple[Array, ...]
) -> None:
    motion = ff.Sampled.from_csv(write(tmp_path / "press.csv", header, *columns))
    assert motion.value(TIME) == pytest.approx(DEPTH, abs=1e-9)
    assert motion.duration == pytest.approx(TIME[-1])
    with_force = len(columns) > 2
    assert (motion.beside(TIME) is not None) == with_force
    if with_force:
        assert motion.beside(TIME) == pytest.approx(FORCE, abs=1e-9)
        by_force = ff.Sampled.from_csv(tmp_path / "press.csv", control="force")
        assert by_force.value(TIME) == pytest.approx(FORCE, abs=1e-9)
        assert by_force.beside(TIME) == pytest.approx(DEPTH, abs=1e-9)


def test_columns_that_cannot_be_told_are_asked_for_and_named_in_the_scene(tmp_path: Path) -> None:
    write(tmp_path / "press.csv", "t;ch1;ch2", TIME, DEPTH, 1e3 * FORCE, separator=";")
    table = {"kind": "sampled", "file": "press.csv"}
    scene = {"finger": {"subject": "a.h."}, "motion": table}
    with refused("motion.file") as caught:
        ff.Scene.from_dict(scene, folder=tmp_path)
    assert "columns = {depth = 'ch2 in mm'} in [motion]" in str(caught.value)
    table["columns"] = {"depth": "ch1", "force": "3 in mN"}
    motion = ff.Scene.from_dict(scene, folder=tmp_path).motion
    assert motion.value(TIME) == pytest.approx(DEPTH, abs=1e-9)
    assert motion.beside(TIME) == pytest.approx(FORCE, abs=1e-9)
    for wrong in ("ch1", {"depth": "ch1", "force": "ch1"}, {"gap": "ch1"}):
        table["columns"] = wrong
        with refused("motion.columns"):
            ff.Scene.from_dict(scene, folder=tmp_path)


def test_a_path_is_read_beside_its_depth(tmp_path: Path) -> None:
    file = write(
        tmp_path / "path.csv", "time,x,y,z,tilt", TIME, 5 * TIME, 0 * TIME, DEPTH, 3 * TIME
    )
    motion = ff.SampledPath.from_csv(file)
    assert motion.value(TIME) == pytest.approx(DEPTH, abs=1e-9)
    assert motion.shift(TIME)[:, 0] == pytest.approx(5 * TIME, abs=1e-9)
    assert motion.tilt is not None
    assert motion.tilt[-1] == pytest.approx(3 * TIME[-1])


def by_force(force: Array, start: float = 0.0) -> ff.Sampled:
    return ff.Sampled(tuple((TIME + start).tolist()), force=tuple(force.tolist()))


def test_noise_before_contact_is_taken_as_it_scatters() -> None:
    noise = np.clip(NOISE, -0.017, 0.017)
    noise[3] = -0.017
    motion = by_force(0.5 * FORCE + noise)  # 7 % of the peak
    assert motion.tare == 0.0
    assert motion.value(TIME) == pytest.approx(np.maximum(0.5 * FORCE + noise, 0.0), abs=1e-12)
    assert any("go down to -0.017 N, 6." in note for note in samples(motion))


def test_a_sensor_that_is_not_tared_is() -> None:
    motion = by_force(FORCE + NOISE - 0.05, start=-0.5)
    assert motion.value(TIME) == pytest.approx(np.maximum(FORCE + NOISE, 0.0), abs=2e-3)
    first, *_, tared, below = samples(motion)
    assert first.startswith("The samples of the motion begin at -0.5 s")
    assert tared.startswith("Before contact the force reads -0.05")
    assert "count as 0" in below
    assert by_force(FORCE + 0.05).tare == 0.0  # it may rest in contact
    assert by_force(FORCE).tare == 0.0


@pytest.mark.parametrize("part", [0.04, 0.1])
def test_a_swing_after_release_counts_as_no_force_and_is_cautioned_of(
    part: float, synthetic: ff.Result
) -> None:
    swing = -part * FORCE.max() * np.exp(-(((TIME - 0.98) / 0.01) ** 2))
    motion = by_force(FORCE + swing)
    assert motion.value(TIME) == pytest.approx(np.maximum(FORCE + swing, 0.0), abs=1e-12)
    assert motion.pulling == pytest.approx(part * FORCE.max(), rel=0.05)
    for each, count in ((motion, 1), (by_force(FORCE), 0)):
        scene = ff.Scene(finger=synthetic.scene.finger, motion=each)
        found = key_numbers._record(scene)
        assert sum("which counts as 0: the swing of the probe" in one for one in found) == count


def test_a_force_of_the_other_sign_is_refused() -> None:
    with refused("motion.force"):
        by_force(NOISE - FORCE)


def test_the_misfit_to_what_was_measured_is_said_and_drawn(synthetic: ff.Result) -> None:
    time = synthetic.time
    force = 1.1 * synthetic.force
    motion = ff.Sampled(tuple(time.tolist()), tuple(synthetic.depth.tolist()), measured=force)
    result = replace(synthetic, scene=replace(synthetic.scene, motion=motion))
    rows = dict(key_numbers.rows(result))
    misfit = float(np.sqrt(np.mean((0.1 * synthetic.force) ** 2)) / force.max())
    assert f"which is {100 * misfit:.2g} % of the peak off" in rows["measured"]
    assert "measured" not in dict(key_numbers.rows(synthetic))
    lines = [line.get_label() for line in figures.force(result).axes[0].lines]
    assert lines == ["answer", "measured"]
    with refused("motion.measured"):
        replace(motion, measured=(1.0, 2.0))


def test_a_long_record_is_read_as_a_short_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = [
        write(tmp_path / "a.csv", "Rig 3\nµ\n\nTime (s),Position (mm)", TIME, DEPTH),
        write(tmp_path / "b.csv", "time\tdepth", TIME, DEPTH, separator="\t"),
        write(tmp_path / "c.csv", "time;depth", TIME, DEPTH, separator=";"),
    ]
    files[2].write_text(files[2].read_text().replace(".", ","))
    short = [recording_files.read("f", file) for file in files]
    monkeypatch.setattr(recording_files, "PEEKED", 1000)
    called: list[object] = []
    decode = recording_files._text
    monkeypatch.setattr(
        recording_files, "_text", lambda *given: [called.append(given), decode(*given)][1]
    )
    for file, before in zip(files, short, strict=True):
        found = recording_files.read("f", file)
        np.testing.assert_array_equal(found.values, before.values)
        assert found.headers == before.headers
        assert found.line(5) == before.line(5)
    assert len(called) == 1  # decimal commas alone take the longer way
    rows = files[0].read_text().splitlines()
    rows[300] = "0.6,x"
    files[0].write_text("\n".join(rows))
    with refused("f") as caught:
        recording_files.read("f", files[0])
    assert "line 301, column Position (mm)" in str(caught.value)
