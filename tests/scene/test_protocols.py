"""The protocols of the thesis as built-in scenes: each parses, plans and runs without a mesh."""

from functools import cache

import numpy as np
import pytest
from fefinger.validation.thesis import array

import fefinger as ff
from fefinger import mechanics
from fefinger.calibration.array_sensor import ArraySensor
from fefinger.scene import builtin


NAMES = {name.split("-")[0]: name for name in builtin.names() if name[1:2].isdigit()}


@cache
def planned(protocol):
    return ff.explain(builtin.load(NAMES[protocol]))


@cache
def answer(protocol):
    """Run a protocol with the cheapest mechanics that is able, whatever its accuracy."""
    scene = builtin.load(NAMES[protocol])
    able = [
        r
        for r in planned(protocol).rungs
        if all(refusal.about != "ability" for refusal in r.refusals)
    ]
    return ff.run(scene, mechanics=able[0].mechanics)


def test_there_are_all_eleven():
    assert sorted(NAMES) == sorted(f"p{i}" for i in range(1, 12))


@pytest.mark.parametrize("protocol", sorted(NAMES))
def test_each_says_what_it_is_plans_and_runs_without_a_mesh(protocol):
    assert "Pawluk 1997" in builtin.text(NAMES[protocol]).replace("\n# ", " ")
    scene = builtin.load(NAMES[protocol])
    assert scene.name == NAMES[protocol]
    quick = mechanics.names()[: None if protocol == "p5" else -1]  # p5: pressures at the tip
    assert planned(protocol).mechanics in quick
    assert scene.ask.mechanics or not planned(protocol).chosen.refusals
    result = answer(protocol)
    assert result.plan.mechanics == ("lumped" if protocol in ("p1", "p2", "p3", "p4") else "hertz")
    assert result.time[-1] == pytest.approx(scene.motion.duration)
    assert np.isfinite(result.force).all()
    assert result.force.max() > 0


def test_p5_and_p6_are_read_by_the_array_of_the_thesis():
    sensor = ArraySensor()
    for protocol, seconds in (("p5", 10.0), ("p6", 1.325)):
        reading = array.read(answer(protocol), sensor)
        assert reading.pressure.shape[1] == 64
        assert len(reading.time) == pytest.approx(200 * seconds, abs=2)
        skew = np.ptp(reading.time, axis=1)
        assert skew == pytest.approx(np.full(len(skew), 63 / 64 / 200))
        carried = 1e-3 * reading.pressure.sum(axis=1) * sensor.pitch**2
        force = np.interp(reading.time.mean(axis=1), *_curve(answer(protocol)))
        assert carried == pytest.approx(force, abs=0.03 * force.max())


def _curve(result):
    return result.time, result.force


def test_p7_reaches_its_force_as_fast_as_an_approach_at_20_mm_per_s_and_holds_it():
    scene = builtin.load(NAMES["p7"])
    assert 1e3 / scene.indenter.radius == pytest.approx(340, abs=0.5)
    assert scene.motion.force == pytest.approx(20 * 9.80665e-3, rel=2e-3)
    lumped = ff.Scene(
        finger=ff.Finger.subject("a.h.", tissue="calibrated_ah"),
        motion=ff.Ramp(speed=20, depth=1.2, corner=0),
        ask=ff.Ask(pressure=False, strain=False, fields=False),
    )
    pressed = ff.run(lumped, mechanics="lumped")
    reached = np.interp(scene.motion.force, pressed.force, pressed.time)
    assert reached == pytest.approx(scene.motion.force / scene.motion.loading_rate, rel=0.1)
    result = answer("p7")
    holding = result.time > 0.1
    assert result.force[holding] == pytest.approx(0.196)
    assert (np.diff(result.depth[holding]) > 0).all()


def test_p8_locks_every_unit_to_the_cycle():
    result = answer("p8")
    motion = result.scene.motion
    turn = 2 * np.pi * motion.frequency * result.time
    assert result.depth == pytest.approx(0.25 * (1 - np.cos(turn)), abs=1e-12)
    for times in result.spikes.times:
        late = times[times > 2 / motion.frequency] * motion.frequency
        counts = np.bincount(np.floor(late).astype(int))[2:]
        assert np.ptp(counts) <= 1
        assert counts.max() >= 1


def test_p9_sa_fire_in_the_hold_and_fa_in_the_ramps_alone():
    result = answer("p9")
    motion = result.scene.motion
    start, stop = 2 / 8 + motion.corner, 2 / 8 + motion.corner + motion.hold
    held = {
        name: int(np.sum((times > start + 0.1) & (times < stop)))
        for name, times in zip(result.spikes.names, result.spikes.times, strict=True)
    }
    assert held["FAI"] == held["FAII"] == 0
    assert min(held["SAI"], held["SAII"]) >= 5
    assert min(result.spikes.count()) >= 1


def test_p10_is_the_ball_on_a_rigid_array():
    assert answer("p10").force.max() == pytest.approx(2.422, abs=0.005)
    soft = {f"finger.{layer}.modulus": 350.6 for layer in ("skin", "subcutaneous")}
    plane = ff.run(builtin.load(NAMES["p10"], soft), mechanics="hertz")
    assert plane.force.max() == pytest.approx(1.573, abs=0.002)


def test_p11_holds_a_current_under_which_sai_fires_evenly_and_saii_once():
    result = answer("p11")
    steady = result.time > 0.1
    assert np.ptp(result.strain[steady], axis=0).max() < 1e-12
    train = dict(zip(result.spikes.names, result.spikes.times, strict=True))
    late = np.diff(train["SAI"][train["SAI"] > 2.0])
    assert len(late) > 10
    assert np.ptp(late) < 1e-3 * late.mean()
    assert len(train["SAII"]) == 1
