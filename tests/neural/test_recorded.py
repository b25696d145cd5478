"""Units of the family `recorded` against closed forms, scipy and their own refinement."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from scipy import signal, stats

from fefinger.neural import recorded_compiled as compiled
from fefinger.neural.endorgans import PoleZero
from fefinger.neural.recorded import (
    BOUNDS,
    LATENCY,
    LONGEST,
    Recorded,
    combined,
    fitted,
    record,
    simulate_recorded,
    units_of,
)
from fefinger.neural.stepped import ROOM
from fefinger.neural.streaming import RecordedAfferents
from fefinger.neural.variation import Variation, numbered
from fefinger.support.vocabulary import TYPES


PLAIN = Recorded(
    drive="compressive",
    length=1.0,
    gain=1.0,
    static=1.0,
    corner=30.0,
    order=1.0,
    upper=1e5,
    negative=0.0,
    largest=1e4,
    adapting=0.0,
    adaptation=1.0,
    recovery=0.0,
    recovering=0.01,
    membrane=0.02,
    refractory=0.003,
    noise=0.0,
    jitter=0.0,
    spread=0.5,
)
TIME = np.linspace(0.0, 2.0, 2001)
LONG = np.linspace(0.0, 40.0, 4001)


def fire(unit, x, time=TIME, **options):
    """Return the spike times of one unit of SAI with these parameters."""
    options = {"check": False, **options}
    trains = simulate_recorded(
        time, np.asarray(x)[:, None], types=("SAI",), parameters={"SAI": unit}, **options
    )
    return trains.times[0]


def rate(unit, current):
    """Return the rate in Hz in a constant current: no noise or recovery, adaptation complete."""
    left = current * (1.0 - unit.adapting)
    return 1.0 / (unit.refractory - unit.membrane * math.log1p(-1.0 / left))


def generated(unit, time, x):
    """Return the generator currents (n_t,) over threshold of one unit at rest at first."""
    units = units_of([unit])
    states = compiled.rested(units, x[:1])
    return compiled.fire(units, states, time, x[:, None], np.array([1e-4]))[1][:, 0]


def sine(frequency, amplitude, seconds=1.0):
    """Return times and a sine of some mm about 0."""
    time = np.linspace(0.0, seconds, round(40 * seconds * frequency) + 1)
    return time, amplitude * np.sin(2 * np.pi * frequency * time)


@pytest.mark.parametrize("current", [1.05, 1.5, 3.0, 12.0])
@pytest.mark.parametrize("membrane", [0.002, 0.02])
def test_the_rate_in_a_constant_current_is_that_of_the_leaky_integrator(current, membrane):
    unit = replace(PLAIN, membrane=membrane)
    times = fire(unit, np.full(TIME.shape, current), step=2e-5)
    assert np.diff(times) == pytest.approx(1.0 / rate(unit, current), rel=2e-3)


def test_below_threshold_no_unit_fires_and_its_potential_is_the_current():
    x = np.full(TIME.shape, 0.9)
    trains = simulate_recorded(TIME, x[:, None], types=("SAI",), parameters={"SAI": PLAIN})
    assert trains.count().sum() == 0
    assert trains.peak_mV == pytest.approx([40.0 * 0.9 / (1.0 + 0.9 / PLAIN.largest)], rel=1e-9)


@pytest.mark.parametrize(
    ("order", "corner", "static", "upper"),
    [(1, 30.0, 0.2, 1e5), (1, 9.0, 0.0, 80.0), (2, 120.0, 0.0, 400.0), (2, 90.0, 0.3, 100.0)],
)
def test_the_filter_is_that_of_scipy(order, corner, static, upper):
    unit = replace(
        PLAIN, order=float(order), corner=corner, static=static, upper=upper, negative=1.0
    )
    x = np.cumsum(np.random.default_rng(4).normal(size=TIME.shape)) * 0.01
    out = generated(unit, TIME, x)
    p, q = 2 * np.pi * corner, 2 * np.pi * upper
    system = q * np.poly([-static * p] * order), np.poly([-p] * order + [-q])
    _, y, _ = signal.lsim(system, x - x[0], TIME)
    _, start, _ = signal.lsim(system, np.full(TIME.shape, x[0]), TIME)
    assert out == pytest.approx(np.abs(y + start), abs=2e-3 * np.abs(y).max())
    frequency = np.array([1.0, 30.0, 400.0])
    poles = PoleZero(
        (static * corner,) * order, tuple(corner * (1 + 1e-3 * k) for k in range(order))
    )
    assert unit.frequency_response(frequency) == pytest.approx(
        poles.frequency_response(frequency) / (1 + 1j * frequency / upper), rel=2e-3
    )


def test_the_generator_saturates_and_weighs_both_signs():
    unit = replace(PLAIN, gain=3.0, largest=5.0, negative=0.25)
    x = np.array([0.0, 0.1, 2.0, 1e3, -2.0, -1e6])
    out = generated(unit, np.arange(12.0), np.repeat(x, 2))[1::2]  # late in a hold: no lag
    u = np.array([0.0, 0.3, 6.0, 3e3, 6.0, 3e6])
    assert out == pytest.approx(u / (1 + u / 5.0) * np.where(x < 0, 0.25, 1.0))


@pytest.mark.parametrize("adapting", [0.2, 0.6])
def test_the_rate_adapts_with_its_time_constant_to_the_part_that_remains(adapting):
    unit = replace(PLAIN, adapting=adapting, adaptation=4.0)
    times = fire(unit, np.full(LONG.shape, 6.0), LONG)
    assert np.diff(times[-10:]) == pytest.approx(1.0 / rate(unit, 6.0), rel=2e-3)
    for at in (2.0, 8.0):
        left = 6.0 * (1.0 - adapting * (1.0 - np.exp(-at / 4.0)))
        near = np.searchsorted(times, at)
        assert 1.0 / np.diff(times)[near] == pytest.approx(rate(PLAIN, left), rel=0.01)


@pytest.mark.parametrize("frequency", [20.0, 50.0, 100.0])
def test_a_unit_is_entrained_one_to_one_between_its_bounds(frequency):
    """The refractory time allows one impulse per cycle, and forbids a second one."""
    unit = replace(PLAIN, static=0.0, membrane=0.001, refractory=0.7 / frequency, gain=10.0)
    time, x = sine(frequency, 1.0)
    times = fire(unit, x, time)
    assert np.diff(times)[3:] == pytest.approx(1 / frequency, rel=1e-3)
    assert len(times) == pytest.approx(frequency, abs=1)


def test_no_unit_fires_faster_than_its_refractory_time():
    unit = replace(PLAIN, gain=1e4, noise=1.0)
    times = fire(unit, np.full(TIME.shape, 100.0))
    assert np.diff(times).min() >= unit.refractory
    assert len(times) == pytest.approx(2.0 / unit.refractory, rel=0.05)


@pytest.mark.parametrize("kind", TYPES)
def test_halving_the_step_moves_spikes_of_the_fitted_units_little(kind):
    unit = replace(fitted()[kind], noise=0.0, jitter=0.0)
    time, x = sine(30.0, 0.4, 0.5)
    options = {"types": (kind,), "parameters": {kind: unit}, "check": False}
    trains = [
        simulate_recorded(time, 0.5 + x[:, None], step=LONGEST[kind] / part, **options).times[0]
        for part in (1, 2, 16)
    ]
    fine = trains[-1]
    assert abs(len(trains[0]) - len(fine)) <= 1
    apart = [np.abs(each[:, None] - fine).min(axis=1) for each in trains[:2]]
    assert np.median(apart[0]) < 3e-4
    assert np.median(apart[1]) <= np.median(apart[0])


@pytest.mark.parametrize("frequency", [200.0, 400.0, 600.0, 800.0])
def test_a_strong_vibration_does_not_silence_a_pacinian_unit(frequency):
    """A generator that saturates both signs alike gives a constant current, which adapts away."""
    rates = []
    for amplitude in (0.025, 0.1, 0.5):
        time, x = sine(frequency, amplitude, 0.5)
        trains = simulate_recorded(time, x[:, None], types=("FAII",), check=False)
        rates.append(2.0 * trains.count()[0])
    assert min(rates) > 0.8 * max(rates) > 0.2 * frequency


@pytest.mark.parametrize("kind", ["FAI", "FAII"])
def test_fast_adapting_units_are_silent_in_slow_presses_and_long_holds(kind):
    """Whatever their noise: 16 units in a press of 1 mm within 1000 s, and in a hold as long."""
    time = np.linspace(0.0, 2000.0, 2001)
    x = np.tile(np.minimum(1e-3 * time, 1.0)[:, None], 16)
    vary = Variation(seed=2, spread=0.0, noise=None)
    trains = simulate_recorded(time, x, types=(kind,) * 16, variation=vary, check=False, step=1e-3)
    assert trains.count().sum() == 0


@pytest.mark.parametrize("kind", ["FAI", "FAII"])
def test_fast_adapting_units_fire_at_onset_and_at_release(kind):
    time = np.arange(0.0, 2.2, 5e-4)
    x = 0.7 * np.clip(np.minimum(50 * (time - 0.1), 50 * (2.0 - time)), 0.0, 1.0)
    (times,) = simulate_recorded(time, x[:, None], types=(kind,), check=False).times
    onset, release = np.abs(times - 0.11) < 0.05, np.abs(times - 1.99) < 0.05
    assert onset.any()
    assert release.any()
    assert np.all(onset | release)


def test_slowly_adapting_units_fire_on_in_a_hold_of_minutes():
    time = np.linspace(0.0, 400.0, 4001)
    (times,) = simulate_recorded(
        time, np.minimum(time, 1.0)[:, None], types=("SAI",), check=False
    ).times
    first, late = (np.sum((times > start) & (times < start + 10.0)) for start in (1.0, 390.0))
    assert 0.05 * first < late < 0.6 * first


@pytest.mark.parametrize(("mean", "fires"), [(0.2, False), (1.2, True)])
def test_noise_fades_below_threshold_and_makes_no_impulse_alone(mean, fires):
    unit = replace(PLAIN, noise=0.8, membrane=0.001)
    assert bool(len(fire(unit, np.full(LONG.shape, mean), LONG))) == fires


def test_jitter_displaces_each_impulse_alone_and_leaves_the_others():
    """Phases at one impulse per cycle have its standard deviation, and its latency on the mean."""
    unit = replace(PLAIN, static=0.0, membrane=0.001, refractory=0.014, gain=10.0)
    time, x = sine(50.0, 1.0, 20.0)
    still, times = (fire(replace(unit, jitter=size), x, time) for size in (0.0, 7e-4))
    assert len(still) == pytest.approx(1000, abs=2)
    assert len(still) - len(times) in (0, 1)  # the last one may be beyond the end
    moved = (times - still[: len(times)])[3:]
    assert moved.std() == pytest.approx(7e-4, rel=0.1)
    assert moved.mean() == pytest.approx(3.5 * 7e-4, abs=1e-4)
    assert moved.min() >= 0.0
    assert abs(np.corrcoef(moved[1:], moved[:-1])[0, 1]) < 0.12


def test_jitter_keeps_the_refractory_time_and_the_series():
    """To the end of the series, wherever it ends: impulses do not pile up there."""
    unit = replace(PLAIN, gain=1e4, jitter=2e-3)
    for last in range(1900, 2001, 5):
        time = TIME[:last]
        times = fire(unit, np.full(time.shape, 100.0), time)
        assert np.diff(times).min() >= unit.refractory - 1e-12
        assert times.min() >= time[0]
        assert times.max() < time[-1]


@pytest.mark.parametrize("kind", ["FAI", "FAII"])
def test_no_impulse_comes_before_its_stimulus(kind):
    """First spikes of 300 units in a fast ramp from 0.1 s on; one without noise has the latency."""
    time, x = np.array([0.0, 0.1, 0.105, 0.3]), np.array([0.0, 0.0, 1.0, 1.0])

    def first(noise):
        vary = Variation(seed=5, spread=0.0, noise=noise)
        trains = simulate_recorded(
            time, np.tile(x[:, None], 300), types=(kind,) * 300, variation=vary, check=False
        )
        return np.array([times[0] for times in trains.times])

    drawn, still = first(None), first(0.0)
    assert drawn.min() > 0.1
    assert drawn.std() > 2e-4
    assert np.ptp(still) == 0.0
    assert still[0] > 0.1 + fitted()[kind].latency == 0.1 + 3.5 * fitted()[kind].jitter
    assert drawn.mean() == pytest.approx(still[0], abs=2e-4)


def test_noise_is_normal_and_the_same_in_whatever_order_it_is_drawn():
    stream = np.uint64(12345)
    values = np.array([compiled.normal(stream, k) for k in range(-2000, 2000)])
    assert compiled.normal(stream, 17) == pytest.approx(values[2017], rel=1e-12)
    assert np.abs(values).max() < LATENCY
    assert values.mean() == pytest.approx(0.0, abs=0.06)
    assert values.std() == pytest.approx(1.0, abs=0.05)
    assert stats.kstest(values, "norm").pvalue > 1e-3
    assert abs(np.corrcoef(values[1:], values[:-1])[0, 1]) < 0.06
    other = np.array([compiled.normal(np.uint64(12346), k) for k in range(2000)])
    assert abs(np.corrcoef(other, values[2000:])[0, 1]) < 0.08


def test_a_seed_gives_the_same_spikes_and_another_seed_others():
    x = np.full((len(TIME), 3), 2.0)
    unit = {"SAI": replace(PLAIN, noise=0.5)}

    def times(seed, **options):
        vary = Variation(seed=seed, spread=None, noise=None, **options)
        return simulate_recorded(
            TIME, x, types=("SAI",) * 3, parameters=unit, variation=vary, check=False
        ).times

    first, again, other = times(1), times(1), times(2)
    # exact: one call, made twice
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert not any(np.array_equal(a, b) for a, b in zip(first, other, strict=True))
    assert not np.array_equal(first[0], first[1])
    swapped = times(1, numbers=tuple(numbered(("SAI",) * 3)[[1, 0, 2]]))
    np.testing.assert_allclose(swapped[0], first[1], rtol=1e-12)


def test_another_trial_is_other_noise_of_the_same_units():
    x = np.full((len(TIME), 3), 2.0)
    unit = {"SAI": replace(PLAIN, noise=0.5, jitter=5e-4)}

    def fired(**options):
        vary = Variation(seed=1, spread=0.5, noise=None, **options)
        return simulate_recorded(
            TIME, x, types=("SAI",) * 3, parameters=unit, variation=vary, check=False
        )

    plain, first, *others = fired(), fired(trial=0), fired(trial=1), fired(trial=2)
    # exact: trial 0 is the call without trials
    assert all(np.array_equal(a, b) for a, b in zip(plain.times, first.times, strict=True))
    for other in others:
        # exact: only the noise is drawn anew
        np.testing.assert_array_equal(other.current, first.current)
        assert not any(np.array_equal(a, b) for a, b in zip(other.times, first.times, strict=True))
    assert not np.array_equal(others[0].times[0], others[1].times[0])
    assert [trains.trial for trains in (plain, *others)] == [0, 1, 2]
    # Means over trials differ less than single trials: they are of the same unit.
    means = np.array([fired(trial=k).count() for k in range(12)]).mean(axis=0)
    assert np.abs(means - first.count()).max() < 0.2 * first.count().min()


def test_the_spread_of_a_population_is_that_of_its_type():
    vary = Variation(seed=3, spread=None)
    factors = np.log([vary.gain(i, 0.5) for i in range(2000)])
    assert factors.std() == pytest.approx(0.5, rel=0.05)
    assert Variation(seed=3, spread=0.0).gain(0, 0.5) == 1.0


def test_the_input_of_a_unit_is_the_largest_or_the_mean_of_its_end_organs():
    organs = np.array([[1.0, 3.0, 5.0], [4.0, 2.0, 6.0]])
    columns = (np.array([0, 1]), np.array([2]))
    assert combined(organs, columns, "max").tolist() == [[3.0, 5.0], [4.0, 6.0]]
    assert combined(organs, columns, "mean").tolist() == [[2.0, 5.0], [3.0, 6.0]]
    assert combined(organs[:, ::-1], columns[::-1], "max").tolist() == [[1.0, 5.0], [4.0, 6.0]]
    with refused("rule"):
        combined(organs, columns, "first")


def test_delays_shift_every_spike():
    x = np.full((len(TIME), 1), 3.0)
    options = {"types": ("SAI",), "parameters": {"SAI": PLAIN}, "check": False}
    here = simulate_recorded(TIME, x, **options)
    there = simulate_recorded(TIME, x, delays=0.01, **options)
    assert there.times[0] == pytest.approx(here.times[0] + 0.01)
    assert (here.delays, there.delays) == (0.0, 0.01)
    assert there.family == "recorded"


@pytest.mark.parametrize("shift", [-5.0, 5.0, -0.4321])
@pytest.mark.parametrize("noise", [0.0, None])
def test_spikes_shift_with_their_series(shift, noise):
    time = np.arange(0.0, 0.8, 1e-3)
    x = 0.6 * np.clip((time - 0.1) / 0.03, 0.0, 1.0) + 0.02 * np.sin(2 * np.pi * 60.0 * time)
    vary = Variation(seed=4, spread=0.0, noise=noise)
    here, there = (
        simulate_recorded(
            time + by, np.tile(x[:, None], 4), types=TYPES, variation=vary, check=False
        )
        for by in (0.0, shift)
    )
    assert here.count().min() > 3
    for mine, theirs in zip(here.times, there.times, strict=True):
        assert theirs - shift == pytest.approx(mine, abs=1e-6)
    assert (there.t_start, there.t_stop) == pytest.approx(time[[0, -1]] + shift, rel=1e-12)


def test_stepped_units_fire_as_those_of_a_whole_series():
    rng = np.random.default_rng(2)
    unit = replace(PLAIN, noise=0.3, jitter=5e-4, static=0.3, gain=80.0, negative=0.3)
    rows = np.zeros((801, 5, 6))
    rows[:, :, 2] = -0.2 * np.sin(9 * np.arange(801) * 1e-3)[:, None] ** 2 * rng.uniform(0.5, 1, 5)
    owner, types = [0, 0, 1, 1, 2], ("SAI", "FAI", "SAI")
    parameters = {"SAI": unit, "FAI": replace(unit, drive="tangent")}
    x = np.empty((801, 5))
    x[:, [0, 1, 4]] = -rows[:, [0, 1, 4], 2]
    x[:, 2:4] = 0.0
    whole = simulate_recorded(
        np.arange(801) * 1e-3, x, types=types, unit=owner, parameters=parameters, check=False
    )
    normals = np.tile([0.0, 0.0, -1.0], (5, 1))
    stepped = RecordedAfferents(types, normals, unit=owner, parameters=parameters)
    fired = [[], [], []]
    for k, row in enumerate(rows):
        count = stepped.step(row, 1e-3 if k else 0.0)
        assert count == len(stepped.fired())
        for i, time in stepped.fired():
            fired[i].append(time)
    assert len(fired[0]) > 5
    for mine, theirs in zip(fired, whole.times, strict=True):
        assert np.array(mine) == pytest.approx(theirs, abs=1e-9)


def pressed(strain):
    """Strain (4, 6) of one unit of each type, whose drive is this."""
    return np.tile([strain, strain, -strain, 0.0, 0.0, 0.0], (4, 1))


NORMALS = np.tile([0.0, 0.0, -1.0], (4, 1))


def test_every_step_reports_the_spikes_within_it_and_all_together_are_those_of_the_series():
    """The latency takes some impulses of FAI and FAII into the steps that follow."""
    time = np.arange(500) * 1e-3
    drive = 0.1 * np.minimum(time / 0.02, 1.0) + 0.01 * np.sin(2 * np.pi * 200.0 * time)
    units, fired = RecordedAfferents(TYPES, NORMALS, seed=3), [[], [], [], []]
    for k in range(1, len(time)):
        assert units.step(pressed(drive[k]), 1e-3) == len(units.fired())
        for i, at in units.fired():
            assert time[k - 1] - 1e-9 < at < time[k] + 1e-9
            fired[i].append(at)
    vary = Variation(seed=3, spread=0.0, noise=None)
    lengths = [fitted()[kind].length for kind in TYPES]
    x = np.tile(drive[:, None], 4)
    whole = simulate_recorded(time, x, lengths=lengths, types=TYPES, variation=vary, check=False)
    assert whole.count().min() > 5
    for mine, theirs in zip(fired, whole.times, strict=True):
        assert np.array(mine) == pytest.approx(theirs, abs=1e-9)


def test_units_at_rest_again_report_nothing_of_before():
    units = RecordedAfferents(TYPES, NORMALS)
    units.step(pressed(0.2), 0.0)
    assert units.step(pressed(0.2), 0.1) > 0
    units.reset()
    assert units.fired() == []
    assert units.step(pressed(0.0), 1e-2) == 0


def test_a_long_step_of_recorded_units_loses_no_spikes():
    """A ramp of 0.4 s, in one step, in some and in many of the same integration steps."""
    parameters = {kind: replace(unit, refractory=2.3e-3) for kind, unit in fitted().items()}
    trains = []
    for count in (400, 5, 1):
        units, fired = RecordedAfferents(TYPES, NORMALS, parameters=parameters, seed=3), []
        for k in range(1, count + 1):
            number = units.step(pressed(0.5 * k / count), 0.4 / count)
            assert number == len(units.fired())
            start, stop = 0.4 * (k - 1) / count, 0.4 * k / count
            assert all(start - 1e-9 < at < stop + 1e-9 for _, at in units.fired())
            fired += units.fired()
        trains.append([[at for i, at in fired if i == unit] for unit in range(4)])
    assert min(len(train) for train in trains[0][:3]) > 2 * ROOM
    for many, some, one in zip(*trains, strict=True):
        assert some == pytest.approx(many, abs=1e-6)
        assert one == pytest.approx(many, abs=1e-6)
    with refused("dt"):
        units.step(pressed(0.5), 1e300)


def one_by_one(units, i, time, x, longest):
    """Impulses of unit i without jitter, and its last current: the equations of `Recorded`."""

    def noise(t):
        knot, part = divmod(t / compiled.KNOTS, 1.0)
        left, right = (compiled.normal(units.stream[i], int(knot) + k) for k in (0, 1))
        return left + (right - left) * part

    def output(modes):
        y = units.at_rest[i] * entered + units.share[i] @ modes
        return compiled.generator(y, units.gain[i], units.negative[i], 1 / units.largest[i])

    entered, modes = x[0], np.full(3, x[0])
    current, adapted, taken, v, free, times = output(modes), 0.0, 0.0, 0.0, 0.0, []
    for start, length, change in zip(time, np.diff(time), np.diff(x), strict=False):
        steps = max(1, math.ceil(length / longest - 1e-9))
        h = length / steps
        fade = np.exp(-units.pole[i] * h)
        adapt = 1 - math.exp(-h / units.adaptation[i])
        forget = math.exp(-h / units.recovering[i])
        for t in start + h * np.arange(steps):
            entered += change / steps
            modes = fade * modes + change * (1 - fade) / (units.pole[i] * length)
            before, current = current, output(modes)
            mean = (before + current) / 2
            drive = mean - units.adapting[i] * (adapted + adapt * (mean - adapted) / 2)
            drive += units.noise[i] * min(mean, 1.0) * noise(t + h / 2) - taken * (1 + forget) / 2
            adapted, taken = adapted + adapt * (mean - adapted), taken * forget
            begin = max(free, t)
            if begin >= t + h:
                continue
            now = v + (drive - v) * (1 - math.exp(-(t + h - begin) / units.membrane[i]))
            if now >= 1:
                times.append(begin + (t + h - begin) * max(0.0, (1 - v) / (now - v)))
                now, free, taken = 0.0, times[-1] + units.refractory[i], taken + units.recovery[i]
            v = now
    return times, current


def test_units_side_by_side_fire_as_each_by_itself():
    """Blocks of lanes, full and not, of types with unequal steps, against one unit at a time."""
    rng = np.random.default_rng(5)
    time = np.cumsum(rng.uniform(2e-4, 2e-3, 400))
    kinds = rng.choice(TYPES, 21)
    x = np.abs(np.cumsum(rng.normal(size=(400, 21)), axis=0)) * 0.03
    still = {kind: replace(unit, jitter=0.0) for kind, unit in fitted().items()}
    units = units_of([still[kind] for kind in kinds], seed=3)
    steps = np.array([LONGEST[kind] for kind in kinds])
    states = compiled.rested(units, x[0], time[0])
    together, current = compiled.fire(units, states.copy(), time, x, steps)
    assert sum(map(len, together)) > 100
    for i, times in enumerate(together):
        expected, last = one_by_one(units, i, time, x[:, i], steps[i])
        assert times == pytest.approx(expected, abs=1e-9)
        assert current[-1, i] == pytest.approx(last, rel=1e-9)


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: replace(PLAIN, gain=-1.0), "gain"),
        (lambda: replace(PLAIN, order=1.5), "order"),
        (lambda: replace(PLAIN, corner=60.0, upper=65.0), "upper"),
        (lambda: replace(PLAIN, drive="pressure"), "drive"),
        (
            lambda: RecordedAfferents(("SAI",), np.eye(3), unit=[0, 0, 0]).step(
                np.ones((1, 6)), 1e-3
            ),
            "strain",
        ),
        (
            lambda: RecordedAfferents(("SAI",), np.eye(3)[:1]).step(np.full((1, 6), np.nan), 1e-3),
            "strain",
        ),
        (lambda: RecordedAfferents(("SAI", "FAI"), np.eye(3)[:2], unit=[1, 0]), "unit"),
        (lambda: RecordedAfferents(("SAI",), np.eye(3)[:1], factors=[-1.0]), "factors"),
        (lambda: RecordedAfferents(("SAI",), np.eye(3)[:1], factors=[np.nan]), "factors"),
        (lambda: RecordedAfferents(("SAI",), np.eye(3)[:1], factors=[1, 1]), "factors"),
        (lambda: RecordedAfferents(("SAI",), np.eye(3)[:1], seed=-1), "seed"),
        (
            lambda: RecordedAfferents(("SAI",), np.eye(3)[:1], parameters={"SA1": PLAIN}),
            "parameters.SA1",
        ),
        (
            lambda: simulate_recorded(
                [0, 1], [[0], [0]], types=("SAI",), parameters={"SAI": {"gain": 2.0}}
            ),
            "parameters.SAI",
        ),
    ],
)
def test_bad_input_is_refused_in_a_sentence(make, field):
    with refused(field):
        make()


def test_the_file_of_parameters_has_every_type_within_its_bounds_and_its_provenance():
    contents = record()
    assert set(contents["types"]) == set(TYPES)
    for kind, unit in fitted().items():
        table = contents["types"][kind]
        assert set(table) == {"drive", *BOUNDS}
        assert all(set(table[name]) == {"value", "error", "how"} for name in BOUNDS)
        assert unit.drive in ("compressive", "tangent")
    assert {"command", "data", "finger", "probe"} <= set(contents["provenance"])
    assert json.loads(json.dumps(contents)) == contents


def test_other_runs_bound_a_count_by_gains_trials_and_steps():
    """Against units whose gains are changed by hand, and against trials that are run."""
    x = np.interp(TIME, [0.0, 0.1, 2.0], [0.0, 0.7, 0.7])[:, None] * np.ones(4)
    found = simulate_recorded(TIME, x, types=TYPES)
    counts = dict(zip(found.reruns, found.rerun_counts, strict=True))
    assert sum(change.startswith("other trial") for change in counts) == 4
    for sign, words in ((-1, "lower"), (1, "higher")):
        changed = {}
        for kind, unit in fitted().items():
            row = record()["types"][kind]
            error = row["gain"]["error"]
            off = row["spread"]["value"] if error is None else error / row["gain"]["value"]
            changed[kind] = replace(unit, gain=unit.gain * math.exp(sign * off))
        other = simulate_recorded(TIME, x, types=TYPES, parameters=changed, check=False)
        assert other.count().tolist() == counts[f"gains {words} by their error"].tolist()
        assert other.count()[0] * sign > found.count()[0] * sign
    least, most = found.bounds()
    assert (least <= found.count()).all()
    assert (most >= found.count()).all()
    assert f"SAI {found.count()[0]} ({least[0]} to {most[0]})" in found.summary()
    quiet = Variation(seed=0, noise=0.0)
    silent = simulate_recorded(TIME, x, types=TYPES, variation=quiet)
    assert not any(change.startswith("other trial") for change in silent.reruns)
    trials = [
        simulate_recorded(
            TIME, x, types=TYPES, variation=Variation(seed=0, noise=None, trial=k), check=False
        ).count()[0]
        for k in range(20, 40)
    ]
    assert abs(np.mean(trials) - counts["other trial 1"][0]) < 6 * np.std(trials) + 1
