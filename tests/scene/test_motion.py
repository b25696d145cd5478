"""Motions: closed forms against quadrature, levels reached exactly, and what is refused."""

import pickle

import numpy as np
import pytest

import fefinger as ff
from fefinger.scene.motion import Motion
from fefinger.scene.motions import (
    FrequencySweep,
    Ramp,
    RampHold,
    RampSinusoid,
    Sinusoid,
    Trapezoid,
    Vibration,
)
from fefinger.scene.samples import Sampled
from fefinger.scene.sliding import SampledPath, Slide
from fefinger.scene.toml import MOTIONS
from fefinger.support.checks import InputError


SINE = {"amplitude": 0.4, "frequency": 4, "cycles": 5}
CORNERS = (0.0, 0.01, 0.02)
EVERY = [
    motion
    for corner in CORNERS
    for motion in (
        Ramp(60, 1.5, corner=corner),
        RampHold(60, 1.5, hold=0.1, corner=corner),
        RampHold(60, 1.5, hold=0, corner=corner),
        Trapezoid(60, 1.5, hold=0.1, corner=corner),
        Trapezoid(60, 1.5, hold=0, corner=corner),
        RampSinusoid(20, 1.5, settle=0.1, corner=corner, **SINE),
        RampSinusoid(20, 1.5, corner=corner, **SINE),
        Vibration(0.5, amplitude=0.4, frequency=4, held=0.1, corner=corner),
        Sampled([0, 0.1, 0.2, 0.5, 1], [0, 1, 2, 0.5, 0.5], corner=corner),
        Ramp(loading_rate=2, force=1, corner=corner),
        RampHold(loading_rate=2, force=1, hold=0.1, corner=corner),
        Trapezoid(loading_rate=2, force=1, hold=0.1, corner=corner),
        RampSinusoid(loading_rate=2, force=1, settle=0.1, corner=corner, **SINE),
        Sampled([0, 0.3, 1], force=[0, 1, 0.5], corner=corner),
    )
]


@pytest.mark.parametrize("kind", MOTIONS)
def test_every_kind_is_a_final_class_with_one_line_of_bases(kind):
    made = MOTIONS[kind]
    assert made.__final__
    assert issubclass(made, Motion)
    assert [len(each.__bases__) for each in made.__mro__[:-1]] == [1] * (len(made.__mro__) - 1)


@pytest.mark.parametrize("motion", EVERY, ids=str)
def test_a_motion_is_equal_to_what_its_words_and_its_pickle_make(motion):
    assert eval(repr(motion)) == motion
    assert pickle.loads(pickle.dumps(motion)) == motion
    assert hash(pickle.loads(pickle.dumps(motion))) == hash(motion)


def test_a_motion_gives_its_unit_and_the_frequency_of_its_wave():
    assert (Ramp(60, 1).unit, Ramp(loading_rate=2, force=1).unit) == ("mm", "N")
    assert Ramp(60, 1).wave_frequency is None
    assert RampSinusoid(20, 1.5, **SINE).wave_frequency == WAVE.wave_frequency == 4


TIMES, LEVELS, PLACES = (0, 0.3, 1), (0, 1, 0.5), (0, 1, 2)


@pytest.mark.parametrize(
    ("former", "given", "named", "motion"),
    [
        ("ForceRamp", (2, 1), {}, Ramp(loading_rate=2, force=1)),
        ("ForceRampHold", (2, 1), {"hold": 3}, RampHold(loading_rate=2, force=1, hold=3)),
        ("ForceTrapezoid", (2, 1), {"hold": 3}, Trapezoid(loading_rate=2, force=1, hold=3)),
        ("ForceRampSinusoid", (2, 1), SINE, RampSinusoid(loading_rate=2, force=1, **SINE)),
        ("ForceSinusoid", (0.4, 4, 5), {}, Sinusoid(control="force", **SINE)),
        (
            *("ForceSweep", (1,), {"amplitude": 0.1, "start": 5, "stop": 50}),
            FrequencySweep(force=1, amplitude=0.1, start=5, stop=50, loading_rate=10),
        ),
        ("ForceSampled", (TIMES, LEVELS), {}, Sampled(TIMES, force=LEVELS)),
        ("ForceSlide", (40, 1), {"distance": 5}, Slide(40, force=1, distance=5, approach=5)),
        (
            *("ForceSampledPath", (TIMES, PLACES, PLACES, LEVELS), {}),
            SampledPath(TIMES, PLACES, PLACES, force=LEVELS),
        ),
    ],
)
def test_a_former_class_of_force_makes_the_motion_and_says_so(former, given, named, motion):
    with pytest.warns(DeprecationWarning, match=type(motion).__name__):
        assert getattr(ff, former)(*given, **named) == motion
    assert motion.kind.startswith("force-")
    assert motion.hardest == motion.peak
    assert motion.deepest is None


@pytest.mark.parametrize("motion", EVERY, ids=str)
def test_value_is_the_integral_of_rate(motion):
    for t0, t1 in zip(motion.breakpoints[:-1], motion.breakpoints[1:], strict=True):
        nodes, weights = np.polynomial.legendre.leggauss(60)
        t = t0 + (t1 - t0) * (nodes + 1) / 2
        area = (t1 - t0) / 2 * weights @ motion.rate(t)
        change = np.diff(motion.value([t0, t1]))[0]
        assert area == pytest.approx(change, abs=1e-12)


@pytest.mark.parametrize("motion", EVERY, ids=str)
def test_rate_jumps_only_where_corners_are_sharp(motion):
    inner = np.array(motion.breakpoints[1:-1])
    before, after = motion.rate(inner - 1e-12), motion.rate(inner + 1e-12)
    jumps = np.abs(after - before).max(initial=0)
    if motion.corner > 0:
        assert jumps < 1e-6
    elif len(inner):
        assert jumps > 0.1


@pytest.mark.parametrize("motion", EVERY, ids=str)
def test_peak_is_the_largest_value(motion):
    t = np.linspace(0, motion.duration, 200_001)
    assert motion.value(t).max() == pytest.approx(motion.peak, abs=1e-4)
    assert motion.value(t).max() <= motion.peak * (1 + 1e-12)


def drawn(seed):
    """Return a seeded motion of every kind, of depth and of force."""
    draw = np.random.default_rng(seed)
    pace, level, hold = 10 ** draw.uniform([-1, -2, -2], [2, 0.5, 0.5])
    part = draw.choice([0.0, 1.0, draw.uniform()])  # of the longest corner
    sine = {
        "amplitude": level * draw.uniform(0.05, 0.95),
        "frequency": 10 ** draw.uniform(-1, 2),
        "cycles": int(draw.integers(1, 4)),
    }
    ramp, longest = level / pace, min(level / pace, 2 * hold)
    short = part * min(longest, sine["cycles"] / sine["frequency"])
    time = np.cumsum(draw.uniform(0.1, 1, 8)) - 0.1
    time[0], levels = 0.0, level * np.maximum(draw.uniform(-0.5, 1, 8), 0)
    levels[draw.integers(8)] = level
    closest = part * np.diff(time).min() / 2
    for control, rate in (("depth", "speed"), ("force", "loading_rate")):
        end = {rate: pace, control: level}
        yield Ramp(corner=part * ramp, **end)
        yield RampHold(hold=hold, corner=part * longest, **end)
        yield Trapezoid(hold=hold, corner=part * ramp, **end)
        yield Trapezoid(hold=0, corner=part * ramp / 2, **end)
        yield RampSinusoid(settle=hold, corner=short, **end, **sine)
        yield RampSinusoid(corner=short, **end, **sine)
        yield Sinusoid(control=control, **sine)
        yield Sampled(tuple(time), corner=closest, **{control: tuple(levels)})


def dense(motion):
    """Return times (n,) s all over a motion, many of them between any two of its breakpoints."""
    return np.linspace(motion.breakpoints[:-1], motion.breakpoints[1:], 401, axis=1).ravel()


def test_no_time_of_any_motion_is_above_its_peak():
    for motion in (motion for seed in range(100) for motion in drawn(seed)):
        highest = motion.value(dense(motion)).max()
        assert highest <= motion.peak * (1 + 1e-12), motion
        assert highest == pytest.approx(motion.peak, rel=1e-3), motion


def test_no_force_that_is_asked_for_pulls_by_rounding():
    for motion in (motion for seed in range(100) for motion in drawn(seed)):
        if motion.by_force:
            assert motion.value(dense(motion)).min() >= 0, motion


def test_a_force_ramp_back_to_none_ends_at_none():
    # The ramp back of this one rounds to -1e-18 N.
    assert Trapezoid(loading_rate=3, force=0.3, hold=0.2).value([0.42, 9.0]).min() >= 0


def test_a_wave_that_still_rises_is_highest_after_the_crest_of_its_sine():
    motion = RampSinusoid(10, 2, amplitude=1, frequency=10, cycles=1, corner=0.1)
    t = np.linspace(0, motion.duration, 1_000_001)
    assert motion.peak == pytest.approx(motion.value(t).max(), rel=1e-10)
    start = motion.duration - 0.1
    assert motion.peak > 2 + 1.3 * (motion.value(start + 0.025) - 2)


@pytest.mark.parametrize("motion", EVERY, ids=str)
def test_it_moves_in_the_intervals_called_moving_and_nowhere_else(motion):
    t = np.linspace(0, motion.duration, 5003)[1:-1]
    moving = np.any([(t > t0) & (t < t1) for t0, t1 in motion.moving], axis=0)
    assert np.all(motion.rate(t[~moving]) == 0)
    assert np.mean(motion.rate(t[moving]) != 0) > 0.99


def test_a_corner_is_a_parabola_that_delays_the_ramp_by_half_of_itself():
    motion = RampHold(60, 1.5, hold=5, corner=0.01)
    assert motion.breakpoints == pytest.approx((0, 0.01, 0.025, 0.035, 5.035))
    assert motion.value(0.004) == pytest.approx(60 / 0.01 * 0.004**2 / 2)
    assert motion.value(0.02) == pytest.approx(60 * (0.02 - 0.005))
    assert motion.value([0.035, 1.0, 5.035]).tolist() == [1.5, 1.5, 1.5]


def test_a_rest_lasts_as_long_as_asked_with_and_without_corners():
    for corner in CORNERS:
        motion = Trapezoid(60, 1.5, hold=1, corner=corner)
        (_, stop), (start, _) = motion.moving
        assert start - stop == pytest.approx(1)
        assert motion.value(motion.duration) == pytest.approx(0, abs=1e-12)


def test_the_sine_starts_upward_about_the_depth_as_in_the_thesis():
    motion = RampSinusoid(20, 1.5, amplitude=0.4, frequency=4, cycles=5, corner=0)
    start = 1.5 / 20
    assert motion.duration == pytest.approx(start + 5 / 4)
    t = start + np.array([1, 2, 3, 4]) / 16
    assert motion.value(t) == pytest.approx([1.9, 1.5, 1.1, 1.5])
    assert motion.rate(start) == pytest.approx(2 * np.pi * 4 * 0.4)


WAVE = Sinusoid(amplitude=0.5, frequency=4, cycles=3)


def test_a_sinusoid_starts_at_touch_and_at_rest_and_ends_so():
    t = np.linspace(0, 0.75, 1001)
    assert WAVE.value(t) == pytest.approx(0.5 * (1 - np.cos(8 * np.pi * t)), abs=1e-12)
    assert WAVE.rate(t[1:-1]) == pytest.approx(
        0.5 * 8 * np.pi * np.sin(8 * np.pi * t[1:-1]), abs=1e-9
    )
    assert WAVE.value([-1, 0, 0.125, 0.75, 2]) == pytest.approx([0, 0, 1, 0, 0], abs=1e-12)
    assert WAVE.value(0.0) == 0
    assert (WAVE.peak, WAVE.duration) == (1.0, 0.75)
    assert WAVE.moving == ((0.0, 0.75),)
    assert WAVE.breakpoints == (0.0, 0.75)
    assert Sinusoid(control="force", amplitude=0.5, frequency=4, cycles=3).value(t).min() >= 0


def test_depth_and_force_kinds_share_their_shape():
    t = np.linspace(0, 2, 777)
    depth = RampSinusoid(2, 1, settle=0.1, **SINE)
    force = RampSinusoid(loading_rate=2, force=1, settle=0.1, **SINE)
    assert np.array_equal(depth.value(t), force.value(t))  # exact: one function
    assert (depth.control, force.control) == ("depth", "force")


def test_samples_are_joined_by_straight_lines_and_collinear_ones_make_no_break():
    motion = Sampled([0, 1, 2, 3], [0, 1, 2, 0])
    assert motion.value([0.5, 1.5, 2.5, 9]) == pytest.approx([0.5, 1.5, 1, 0])
    assert motion.breakpoints == (0.0, 2.0, 3.0)


@pytest.mark.parametrize("jump", [1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e3])
def test_what_is_slow_is_not_lost_beside_a_jump(jump, scale):
    time = scale * np.array([0, jump, 1000, 2000, 3000])
    depth = np.array([0, 0.5, 0.5001, 0.6, 0.5])
    motion = Sampled(tuple(time.tolist()), tuple(depth.tolist()))
    assert motion.value(time) == pytest.approx(depth, abs=1e-12)
    assert motion.peak == pytest.approx(0.6, abs=1e-12)
    path = SampledPath(motion.time, motion.depth, (0.0,) * 5, depth=(0.5,) * 5)
    assert path.shift(time)[:, 0] == pytest.approx(depth, abs=1e-12)


def test_no_sample_of_a_fine_curve_is_missed():
    time = np.linspace(0, 1, 100_001)
    depth = 1e-3 * (1 - np.cos(2 * np.pi * time)) + np.where(time > 0.5, 0.3, 0.0)
    motion = Sampled(tuple(time.tolist()), tuple(depth.tolist()))
    assert np.abs(motion.value(time) - depth).max() < 1e-11


@pytest.mark.parametrize("corner", [0.0, None])
def test_a_sudden_end_of_a_long_rest_is_not_lost(corner):
    motion = Trapezoid(2e6, 1.0, hold=1e6, corner=corner)
    assert motion.value([5e5, motion.duration]) == pytest.approx([1, 0], abs=1e-3)
    rest = RampHold(1e-3, 1.0, hold=1e-10, corner=corner)  # shorter than its digits, but still
    assert rest.value(rest.duration) == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("start", [0.0, 1e3])
def test_rounding_of_even_samples_makes_no_break(start):
    time = start + np.arange(2001) * 1e-3
    time[0] = 0.0
    ramp = np.where(time > start, 0.3 + 0.1 * (time - start), 0.3)
    noise = 1e-14 * np.random.default_rng(1).standard_normal(2001)
    for depth in (ramp, 0.3 + 1e-16 * np.arange(2001), 0.3 + noise):
        motion = Sampled(tuple(time.tolist()), tuple(depth.tolist()))
        assert len(motion.breakpoints) <= 3
        assert motion.value(time) == pytest.approx(depth, abs=1e-9)


def test_samples_may_stay_at_one_depth_from_the_start():
    motion = Sampled((0, 1, 2), (0.5, 0.5, 0.5))
    assert motion.value(np.array([0.0, 0.7, 2.0])) == pytest.approx([0.5, 0.5, 0.5])


def test_a_csv_file_gives_the_same_motion_as_its_arrays(tmp_path):
    file = tmp_path / "press.csv"
    file.write_text("time (s),depth (mm)\n0,0\n0.1,1.25\n\n0.2,0.5\n")
    assert Sampled.from_csv(file) == Sampled((0, 0.1, 0.2), (0, 1.25, 0.5))
    file.write_text("time,force\n0,0\n0.1,1\n")
    assert Sampled.from_csv(file, control="force", corner=0.02).peak == pytest.approx(0.9 + 0.1)


@pytest.mark.parametrize(
    ("motion", "corner"),
    [
        (Ramp(60, 1.5), 0.01),
        (Ramp(60, 0.3), 0.005),
        (RampHold(60, 0.3, hold=1), 0.005),
        (RampHold(60, 1.5, hold=0), 0.01),
        (RampHold(60, 1.5, hold=0.002), 0.004),
        (Trapezoid(600, 1.5, hold=0), 0.0025),
        (RampSinusoid(20, 1.5, amplitude=0.1, frequency=250, cycles=1), 0.004),
        (RampSinusoid(20, 1.5, settle=0.001, amplitude=0.1, frequency=4, cycles=1), 0.002),
        (RampHold(loading_rate=500, force=1, hold=1), 0.002),
    ],
    ids=repr,
)
def test_a_corner_that_is_not_given_is_as_long_as_the_parts_of_the_motion_allow(motion, corner):
    assert motion.corner == pytest.approx(corner, rel=1e-12)
    assert motion.peak == pytest.approx(getattr(motion, "depth", None) or motion.force, rel=0.1)
    t = np.linspace(0, motion.duration, 100_001)
    assert np.abs(np.diff(motion.rate(t)[:-1])).max() < 0.02 * np.abs(motion.rate(t)).max()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Ramp(0, 1), r"motion.speed: expected a finite number in mm/s above 0, received 0"),
        (lambda: Ramp(60, -1), r"motion.depth: .*above 0, received -1"),
        (
            lambda: Ramp(60, None),
            "motion.depth: missing; a motion takes speed and depth, or loading_rate and force",
        ),
        (lambda: Ramp(60, 1, force=1), r"motion.speed: expected none in a motion of force \(N\)"),
        (lambda: Ramp(60, 1, loading_rate=1), "motion.loading_rate: expected none in a motion of"),
        (
            lambda: Sinusoid(1, 4, 1, control="load"),
            "motion.control: expected one of 'depth', 'force'",
        ),
        (lambda: RampHold(60, 1, hold=None), r"motion.hold: .*received None"),
        (lambda: Ramp("60", 1), r"motion.speed: expected a finite number.*received '60'"),
        (lambda: Ramp(True, 1), r"motion.speed: .*received True"),
        (lambda: Ramp(float("nan"), 1), r"motion.speed: .*received nan"),
        (lambda: RampHold(60, 1, hold=-1), r"motion.hold: .*at least 0 and .*, received -1"),
        (lambda: Ramp(600, 1, corner=0.01), r"motion.corner: expected at most 0.00333333 s"),
        (
            lambda: RampHold(600, 1, hold=1, corner=0.01),
            r"motion.corner: expected at most 0.00166667 s",
        ),
        (lambda: Ramp(loading_rate=0, force=1), r"motion.loading_rate: .*N/s above 0, received 0"),
        (
            lambda: Sinusoid(1, frequency=4, cycles=1.5),
            "motion.cycles: expected a whole number at least 1, received 1.5",
        ),
        (lambda: Sinusoid(0, frequency=4, cycles=1), "motion.amplitude: expected"),
        (
            lambda: RampSinusoid(20, 1, amplitude=1, frequency=4, cycles=1.5),
            r"motion.cycles: expected a whole number at least 1, received 1.5",
        ),
        (
            lambda: RampSinusoid(20, 1, amplitude=1, frequency=400, cycles=1, corner=0.01),
            r"motion.corner: expected at most the length of the sinusoid, 0.0025 s",
        ),
        (
            lambda: RampSinusoid(loading_rate=2, force=1, amplitude=1, frequency=4, cycles=1),
            r"motion.amplitude: expected less than the mean force of 1 N.*cannot pull",
        ),
        (lambda: Sampled([0, 1], [0]), r"motion.depth: expected as many values as times"),
        (lambda: Sampled([0], [0]), r"motion.depth: .*at least 2, received 1 values"),
        (lambda: Sampled([0, 2, 1], [0, 1, 2]), r"motion.time\[2\]: expected a time above 2.0 s"),
        (lambda: Sampled([0, 1, 1], [0, 1, 2]), r"motion.time\[2\]: .*keep one of each time"),
        (lambda: Sampled([0, 1], [0, float("nan")]), r"motion.depth\[1\]: .*received nan"),
        (lambda: Sampled([0, 1], [-1, 0]), r"motion.depth: .*never touches"),
        (lambda: Sampled("01", [0, 1]), r"motion.time: expected a list of numbers"),
        (lambda: Sampled([0, 1, 2], [0, 1, 0], corner=2), r"motion.corner: expected at most 1 s"),
        (
            lambda: Sampled([0, 1e-300], [0, 1]),
            r"motion: .* at most 1e\+100 per s, received 1e\+300",
        ),
        (lambda: Sampled([0, 1e-300], [0, 1e20]), r"motion: .* received inf; check whether times"),
        (lambda: RampHold(10, 1, hold=1, corner=1e-310), r"motion.corner: expected at least 1e-99"),
        (lambda: Trapezoid(1e7, 1, hold=1e6, corner=0), "motion: .* parts longer than rounding"),
        (lambda: Trapezoid(20, 1, hold=1, corner=1e-30), "motion.corner: .* above rounding"),
        (lambda: Sampled([0, 1], [-1e30, 1]), "motion.depth: .* at least -1000 mm, received -1e"),
        (lambda: Sampled([0, 1, 2], force=[0, 1, -1]), r"motion.force: .*cannot pull"),
    ],
)
def test_what_cannot_be_done_is_said_in_a_sentence(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_a_vibration_is_whole_cycles_about_a_preload_that_was_held():
    motion = Vibration(0.5, amplitude=0.1, frequency=30.2, seconds=0.5, held=3.0, corner=0.0)
    start = motion.recorded_from
    assert start == pytest.approx(0.05 + 3.0)
    assert motion.duration == pytest.approx(start + 15 / 30.2)
    quarter = 0.25 / 30.2
    assert motion.value([start - 1, start, start + quarter]) == pytest.approx([0.5, 0.5, 0.6])
    assert Vibration(0.5, amplitude=0.1, frequency=0.2).duration == pytest.approx(120 + 5, abs=0.1)
    assert RampHold(60, 1.5, hold=0.1).recorded_from == 0


def test_the_vibration_of_a_motion_is_what_swings_about_its_slow_course() -> None:
    shaped = RampSinusoid(20, 1.0, amplitude=0.05, frequency=100, cycles=10, settle=0.2)
    time = np.linspace(0, shaped.duration, 2001)
    slow = shaped.value(time) - shaped.vibration(time)
    assert slow[time > 0.1] == pytest.approx(1.0, abs=1e-9)
    assert np.abs(shaped.vibration(time)).max() == pytest.approx(0.05, rel=1e-2)
    assert not RampHold(20, 1.0, hold=1).vibration(time).any()
    samples = np.arange(4000) / 4000
    depth = 1.0 + 0.05 * np.sin(2 * np.pi * 100 * samples)
    sampled = Sampled(tuple(samples.tolist()), tuple(depth.tolist()))
    middle = samples[400:-400]
    assert sampled.vibration(middle) == pytest.approx(depth[400:-400] - 1.0, abs=5e-3)
