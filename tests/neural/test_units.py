"""Units with many end organs: what the rules agree on, where they part, delay and seeded noise."""

from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.neural.filters import spring
from refusals import refused

from fefinger.neural import afferent_units
from fefinger.neural.afferent_units import simulate_units
from fefinger.neural.endorgans import END_ORGANS, GAINS, PoleZero, transduce
from fefinger.neural.membranes import HodgkinHuxley
from fefinger.neural.variation import Variation
from fefinger.support.vocabulary import RULES, TYPES


EVERY_RULE = pytest.mark.parametrize("rule", RULES)
TIME = np.concatenate([np.linspace(0, 0.1, 101), [0.3, 0.5]])
RAMP = np.minimum(TIME / 0.1, 1.0)


def one(share, rule="mean", kind="SAI", **options):
    """One unit whose branches get these shares of 1 mm."""
    drive = RAMP[:, None] * np.asarray(share, float)
    options = {"check": False} | options
    return simulate_units(
        TIME, drive, types=(kind,), unit=np.zeros(drive.shape[1], int), rule=rule, **options
    )


@EVERY_RULE
def test_a_flat_probe_gives_the_answer_of_one_end_organ(rule):
    types, organs = TYPES, (5, 1, 3, 1)
    unit = np.repeat(np.arange(4), organs)
    order = np.random.default_rng(0).permutation(len(unit))
    drive = np.tile(RAMP[:, None], len(unit))
    many = simulate_units(TIME, drive, types=types, unit=unit[order], rule=rule)
    single = simulate_units(TIME, np.tile(RAMP[:, None], 4), types=types)
    assert single.count().min() > 0
    for a, b in zip(many.times, single.times, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)
    np.testing.assert_allclose(many.current, single.current, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(many.x_in, single.x_in, rtol=1e-12)
    np.testing.assert_allclose(many.peak_mV, single.peak_mV, rtol=1e-9)
    assert many.notes == single.notes
    assert many.t_stop == single.t_stop


def test_the_rules_part_where_the_branches_differ():
    counts = {rule: len(one([1.0, 0.0, 0.0, 0.0], rule).times[0]) for rule in RULES}
    alone = len(one([1.0]).times[0])
    assert counts["mean"] < alone
    assert counts["max"] == counts["first"] == alone


def test_the_largest_current_is_taken_at_every_time():
    rise = np.column_stack([RAMP, np.where(TIME > 0.2, 3.0, 0.0) * (TIME - 0.2)])
    unit = np.zeros(2, int)
    both = simulate_units(TIME, rise, types=("SAI",), unit=unit, rule="max", check=False)
    each = [simulate_units(TIME, rise[:, i : i + 1], types=("SAI",), check=False) for i in (0, 1)]
    np.testing.assert_allclose(both.current, np.maximum(each[0].current, each[1].current))
    np.testing.assert_allclose(both.x_in[:, 0], rise.mean(axis=1))


def test_the_first_branch_to_fire_is_the_strongest_and_silences_the_rest():
    together = one([1.0, 0.8, 0.5], "first").times[0]
    strongest = one([1.0]).times[0]
    np.testing.assert_allclose(together[0], strongest[0], atol=1e-9)
    assert len(together) == len(strongest)
    apart = sum(len(one([share]).times[0]) for share in (1.0, 0.8, 0.5))
    assert len(together) < apart


def test_a_race_survives_half_the_step_and_half_the_samples():
    assert one([1.0, 0.7, 0.4], "first", check=True).notes == ()


@pytest.mark.parametrize("rule", ["mean", "max"])
def test_how_many_units_are_held_in_memory_changes_nothing(rule, monkeypatch):
    types = ("SAI", "SAI", "FAI", "SAI", "SAI", "FAII")
    unit = np.repeat(np.arange(6), [3, 2, 4, 1, 5, 1])
    drive = np.outer(RAMP, np.random.default_rng(2).uniform(0.2, 1.0, len(unit)))
    options = {"types": types, "unit": unit, "rule": rule, "check": False}
    together = simulate_units(TIME, drive, **options)
    monkeypatch.setattr(afferent_units, "_DENSE", 1)
    apart = simulate_units(TIME, drive, **options)
    assert together.count().min() > 0
    np.testing.assert_allclose(apart.current, together.current, rtol=1e-12)
    for a, b in zip(apart.times, together.times, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)


def test_a_filter_of_ones_own_replaces_that_of_its_type():
    bare = one([0.02], organs={"SAI": spring(2.0, 1.0, 1.0)}).current[:, 0]
    np.testing.assert_allclose(bare, 100 * -np.expm1(-3.199 * 0.4 * 0.02 * RAMP), rtol=1e-9)


def test_delays_move_every_spike_and_the_end():
    late = one([1.0], delays=0.015)
    np.testing.assert_allclose(late.times[0], one([1.0]).times[0] + 0.015)
    assert late.t_stop == pytest.approx(TIME[-1] + 0.015)
    assert late.delays == 0.015


def test_a_seed_reproduces_and_another_differs_whatever_the_other_units_do():
    def fired(seed, count):
        return simulate_units(
            TIME,
            np.tile(RAMP[:, None], count),
            types=("SAI",) * count,
            unit=np.arange(count),
            variation=Variation(seed=seed, noise=2.0, spread=0.3),
            check=False,
        )

    two, three, other = fired(1, 2), fired(1, 3), fired(2, 2)
    for i in range(2):
        # The units of a type share the times at which their currents are sampled.
        np.testing.assert_allclose(two.times[i], three.times[i], atol=1e-8)
        assert not np.array_equal(two.times[i], other.times[i])
    assert (two.seed, other.seed, one([1.0]).seed) == (1, 2, None)


def test_noise_and_spread_have_the_sizes_that_were_asked():
    variation = Variation(seed=3, spread=0.4, noise=2.5)
    logs = np.log([variation.gain(i) for i in range(4000)])
    assert logs.std() == pytest.approx(0.4, rel=0.05)
    assert abs(logs.mean()) < 4 * 0.4 / np.sqrt(4000)
    knots = variation.current(0, 1e-3 * np.arange(4000), 0.0, 4.0, 2)
    np.testing.assert_allclose(knots.std(axis=0), 2.5, rtol=0.05)
    assert abs(np.corrcoef(knots.T)[0, 1]) < 4 / np.sqrt(4000)


def test_silent_variation_changes_nothing():
    still = one([1.0, 0.5], variation=Variation(seed=9))
    assert still.times[0] == pytest.approx(one([1.0, 0.5]).times[0], abs=1e-12)


def test_noise_does_not_depend_on_the_step():
    variation = Variation(seed=1, noise=3.0)
    coarse, fine = (one([0.5], variation=variation, dt=dt).times[0] for dt in (5e-5, 2.5e-5))
    np.testing.assert_allclose(coarse, fine, atol=2e-5)


class Other:
    """A membrane of another kind."""


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"unit": [0, 2]}, "unit"),
        ({"unit": [0.0, 0.5]}, "unit"),
        ({"rule": "sum"}, "rule"),
        ({"delays": -1.0}, "delays"),
        ({"depths": [1.0, 2.0]}, "depths"),
        ({"variation": Variation(seed=1, numbers=(0, 1))}, "numbers"),
        (
            {"rule": "first", "membrane": Other()},
            "rule",
        ),
    ],
)
def test_unusable_units_are_refused(change, field):
    options = {"types": ("SAI",), "unit": [0, 0]} | change
    with refused(field):
        simulate_units(TIME, np.zeros((len(TIME), 2)), **options)


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ({"seed": -1}, "seed"),
        ({"seed": 1, "trial": -1}, "trial"),
        ({"seed": 1, "noise": -1.0}, "noise"),
        ({"seed": 1, "spread": np.inf}, "spread"),
        ({"seed": 1, "numbers": (0, -1)}, "numbers"),
        ({"seed": 1, "numbers": (0.5,)}, "numbers"),
    ],
)
def test_unusable_variations_are_refused(values, field):
    with refused(field):
        Variation(**values)


def test_the_membrane_can_be_the_standard_one():
    fast = one([1.0], membrane=HodgkinHuxley(rate_divisor=1.0)).times[0]
    assert len(fast) > 2 * len(one([1.0]).times[0])


def test_noise_does_not_depend_on_how_long_the_run_is_nor_draws_on_the_other_units():
    variation, at = Variation(seed=4, noise=1.0, spread=0.3), np.linspace(0, 0.1, 21)
    for branches in (1, 3):
        short = variation.current(2, at, 0.0, 0.1, branches)
        np.testing.assert_allclose(short, variation.current(2, at, 0.0, 1.0, branches), rtol=1e-12)
    separate = replace(variation, numbers=(2,))
    np.testing.assert_allclose(separate.current(0, at, 0.0, 0.1, 3), short, rtol=1e-12)
    assert separate.gain(0) == pytest.approx(variation.gain(2), rel=1e-12)


def test_a_trial_has_noise_of_its_own_and_the_gains_of_all():
    first, at = Variation(seed=4, noise=1.0, spread=0.3), np.linspace(0, 0.1, 21)
    later = replace(first, trial=1)
    assert later.gain(2) == pytest.approx(first.gain(2), rel=1e-12)
    assert not np.allclose(later.current(2, at, 0.0, 0.1, 1), first.current(2, at, 0.0, 0.1, 1))


def test_draws_of_units_are_none_of_those_of_places():
    gain = Variation(seed=4, spread=1.0).gain(2)
    assert np.log(gain) != np.random.default_rng([4, 2]).normal()


@pytest.mark.parametrize(
    ("organs", "field"),
    [
        ({"SA1": END_ORGANS["SAI"]}, "organs.SA1"),
        ({"SAI": None}, "organs.SAI"),
    ],
)
def test_filters_that_no_unit_would_have_are_refused(organs, field):
    with refused(field):
        one([1.0], organs=organs)


def fired(x, times, kind, **options):
    drive = np.array(x)[:, None]
    options = {"unit": [0], "check": False} | options
    return simulate_units(times, drive, types=[kind], **options).times[0]


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
def test_a_tolerance_holds_where_the_current_bends_within_a_step(tolerance):
    press = [0.0, 0.4, 0.4], [0.0, 0.05, 0.1], "FAII"
    exact = fired(*press, dt=1e-6)
    assert len(exact) == 1
    # The reference itself is good to 2e-9 s.
    np.testing.assert_allclose(fired(*press, tolerance=tolerance), exact, atol=tolerance + 2e-9)


def test_a_generator_that_bends_behind_a_straight_filter_is_sampled_as_finely_as_it_needs():
    organs, time = {"SAI": PoleZero((), (), 1.0)}, np.array([0.0, 0.02, 0.8])
    x = np.array([0.0, 0.4, 0.4])
    fine = np.linspace(0, 0.8, 80_001)
    current = transduce("SAI", time, x, gain=GAINS["SAI"], organ=organs["SAI"], at=fine)
    (exact,) = HodgkinHuxley().fire(fine, current, stimulus_driven=False).times
    assert len(exact) > 10
    np.testing.assert_allclose(fired(x, time, "SAI", organs=organs), exact, atol=1e-6)
