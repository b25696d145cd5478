"""What a calibrated finger has to show: subjects, records and frames."""

import json
from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.calibration.subject_target import target_of
from fefinger.validation.oracles import synthetic
from refusals import refused

from fefinger.calibration import array_sensor, inverse, record_file, record_target
from fefinger.calibration.array_sensor import ArraySensor
from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.outcome import line
from fefinger.calibration.targets import Forces, prony_of
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.support import inputs
from fefinger.support.checks import InputError
from fefinger.theory.lumped.spring import Spring
from fefinger.theory.relaxation import Prony


ROW = library.lumped()["a.h."]
PRONY = Prony((0.3, 0.42, 0.16, 0.12), (220.0, 9.0, 0.6))


def test_a_subject_is_the_line_of_table_2_1():
    found = target_of("a.h.")
    assert line(found.force, found.stiffness) == pytest.approx((2.1, 0.18))
    scatter = np.random.default_rng(0).normal(0, found.stiffness_sd, (4000, len(found.force)))
    noisy = found.stiffness + scatter
    vaf = 1 - (scatter**2).sum() / ((noisy - noisy.mean()) ** 2).sum()
    assert vaf == pytest.approx(0.98, abs=2e-3)
    with refused("subject"):
        target_of("ah.")


@pytest.mark.parametrize(
    ("modulus", "ratio", "words"),
    [(34.0, 10.0, "Maeno 1998"), (4.6, 3.1, "the tissue of the finger that was given: a factor")],
)
def test_a_prior_says_what_it_is_taken_from(law, modulus, ratio, words):
    forces = Forces(target_of("a.h."), law, modulus, ratio, 14.0)
    by_name = {each.name: each for each in forces.unknowns}
    assert by_name["modulus"].prior[0] == modulus
    for name in ("modulus", "skin_ratio"):
        assert words in by_name[name].source


def test_stiffness_against_force_does_not_know_the_scale_of_depth(law):
    one = law.at(2.0, 14.0)
    force = np.array([0.5, 2.0])
    x = one.depth(0.3 * force / 1.7)
    slope = 1.7 * (one.force(x + 1e-5) - one.force(x - 1e-5)) / 2e-5 / 0.3
    np.testing.assert_allclose(ForceLaw(one, PRONY, 1.7).stiffness(force), slope, rtol=1e-6)


def test_a_finger_of_the_family_is_found_again_from_its_own_stiffness(law):
    wanted = target_of("a.h.")
    k = ForceLaw(law.at(2.4, 14.0), wanted.prony, 25.0 / 34.0).stiffness(wanted.force)
    forces = Forces(replace(wanted, stiffness=k), law, 34.0, 3.0, 14.0)
    found = inverse.solve(forces.residual, forces.unknowns, forces.starts())
    for name, value in {"exponent": 2.4, "modulus": 25.0}.items():  # the prior of 34 kPa pulls
        assert found.values[name] == pytest.approx(value, abs=0.5 * found.deviations[name])
    assert found.values["skin_ratio"] == 3.0
    assert found.misfit < 0.01
    assert prony_of(found.values).weights[0] == pytest.approx(wanted.prony.weights[0], rel=0.05)


def trial(hold=4.0, seed=0):
    made = synthetic.ramp_and_hold(Spring(ROW.b, ROW.m, 0.5), PRONY, seed=seed, hold=hold)
    return np.column_stack([made.time, made.position, made.force])[::2]


def growing(table):
    held = np.where(table[:, 0] > 0.1, 2.0 + 0.2 * table[:, 0], table[:, 2])
    return np.column_stack([table[:, :2], held])


def changed(table, column, change):
    table = table.copy()
    table[:, column] = change(table[:, column])
    return table


BAD = {
    "a sensor at its end": (
        lambda t: changed(t, 2, lambda f: np.minimum(f, 0.6 * f.max())),
        r"expected a peak, received .* N in \d+ successive samples, as from a sensor at the end",
    ),
    "a force that is late": (
        lambda t: changed(t, 2, lambda f: np.interp(t[:, 0] - 0.05, t[:, 0], f)),
        "expected a force that rises with the position, received one that does not",
    ),
    "a force that grows at rest": (growing, "force that falls in the hold|rises on the ramp"),
    "one force in the hold": (
        lambda t: changed(t, 2, lambda f: np.where(t[:, 1] < 0.95 * t[:, 1].max(), f, f.max())),
        "hold: expected a force that falls, because a finger relaxes",
    ),
    "a pillow": (lambda t: t * [1.0, 20.0, 0.02], "which no fingertip has"),
}
"""Besides those that `lumped_fit` refuses as well."""


@pytest.mark.parametrize(("spoil", "message"), BAD.values(), ids=BAD)
def test_a_record_that_cannot_be_used_gets_a_sentence(tmp_path, spoil, message, write):
    file = write(tmp_path / "bad.csv", spoil(trial()))
    with pytest.raises(InputError, match=message):
        record_file.record(file, "coarse")


def test_a_force_that_is_read_in_steps_is_of_a_sensor_within_its_range(tmp_path, write):
    """Its peak stays on one step for many samples, and so does all else."""
    table = changed(trial(), 2, lambda f: np.round(f / 0.3) * 0.3)
    assert record_file.record(write(tmp_path / "steps.csv", table), "coarse").force.max() > 1


def test_a_press_as_deep_as_the_tissue_is_refused(tmp_path, write):
    found = record_file.record(write(tmp_path / "press.csv", trial()), "coarse")
    deep = found.position.max() - found.lumped.spring.x0
    record_file.check_depth(found, Finger(width=14, thickness=2.1 * deep, tissue="maeno1998"))
    with pytest.raises(InputError, match=r"press of less than .* mm, the tissue under the pad"):
        record_file.check_depth(found, Finger(width=14, thickness=1.9 * deep, tissue="maeno1998"))


def test_a_force_that_wanders_at_rest_is_tared_until_the_position_moves(tmp_path, write):
    table, count = trial(), 800
    table[:, 0] += (count - 1) * np.diff(table[:2, 0]) - table[0, 0]
    wander = 0.03 * np.cos(2 * np.pi * np.arange(count) / 40)
    rest = np.column_stack([np.linspace(0, table[0, 0], count), np.zeros(count), wander])
    table = changed(np.vstack([rest[:-1], table]), 2, lambda f: f + 0.05)
    found = record_file.record(write(tmp_path / "press.csv", table), "coarse")
    assert found.tare == pytest.approx(0.05, abs=0.01)


def test_a_motion_to_be_predicted_is_tared_by_the_rest_before_contact(tmp_path, write):
    table = changed(trial(), 2, lambda f: f + 0.05)
    _, _, force = record_file.motion(write(tmp_path / "a.csv", table))
    np.testing.assert_allclose(force, trial()[:, 2], atol=3e-3)


HEADS = "time,position," + ",".join(f"p{i}" for i in range(1, 65))


def table_of_frames(one, factor=1.0):
    depth = one.depth
    return np.column_stack([depth / 0.2, depth, factor * one.array_pressure])


def test_frames_are_read_about_their_center(tmp_path, formula, write):
    one = formula(1.0)
    found = array_sensor.frames(write(tmp_path / "f.csv", table_of_frames(one), HEADS))
    assert found.pressure.shape == found.depth.shape == (24, 64)
    np.testing.assert_allclose(found.distance, np.hypot(*ArraySensor().positions.T), atol=1e-6)
    assert found.depth[3, 63] > found.depth[3, 0]  # read later


FRAMES = {
    "MPa": (lambda t: np.column_stack([t[:, :2], 1e-3 * t[:, 2:]]), "as if it were in MPa"),
    "Pa": (lambda t: np.column_stack([t[:, :2], 1e3 * t[:, 2:]]), "as if it were in Pa"),
    "none": (lambda t: np.column_stack([t[:, :2], 0 * t[:, 2:]]), "pressures above 0"),
    "unsorted": (lambda t: t[::-1], "received an earlier time"),
    "too few": (lambda t: t[:2], "expected 4 frames or more"),
}


@pytest.mark.parametrize(("spoil", "message"), FRAMES.values(), ids=FRAMES)
def test_frames_that_cannot_be_used_get_a_sentence(tmp_path, spoil, message, formula, write):
    file = write(tmp_path / "f.csv", spoil(table_of_frames(formula())), HEADS)
    with pytest.raises(InputError, match=message):
        array_sensor.frames(file)
    with pytest.raises(InputError, match="one column 'p3'"):
        array_sensor.frames(write(tmp_path / "g.csv", np.ones((5, 4)), "time,position,p1,p2"))


def test_what_a_mesh_makes_is_that_of_its_report():
    rows = json.loads(inputs.read_report("mesh-curves.json"))["rows"]
    for mesh, row in rows.items():
        assert record_target.MESH[mesh] >= row["rms"]
        assert row["length_mm"] / 3 < record_target.LENGTH < 3 * row["length_mm"]
    assert record_target.MESH["coarse"] == pytest.approx(rows["coarse"]["rms"], rel=0.1)
    assert record_target.MESH["standard"] < record_target.MESH["coarse"]


def test_the_misfit_of_the_lumped_model_is_measured_like_all_others():
    """One where all is noise, or less: what is allowed for the mesh is not in this record."""
    trial = synthetic.ramp_and_hold(Spring(ROW.b, ROW.m, 0.5), ROW.prony, seed=0)
    found = record_file.made("twin", trial.time, trial.position, trial.force, "coarse")
    assert 0.1 < found.lumped_misfit < 1.2
    bent = replace(found.trace, force=found.force + 5 * np.sqrt((found.factor**2).sum(axis=1)))
    assert replace(found, trace=bent).lumped_misfit == pytest.approx(25.0, rel=0.2)
