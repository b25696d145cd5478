"""The lumped finger against closed forms, quadrature, a second integration and printed numbers."""

import numpy as np
import pytest

from fefinger.scene import library
from fefinger.theory.lumped import spring as lumped
from fefinger.theory.lumped.spring import Spring
from fefinger.theory.relaxation import Prony, hereditary_integral


ROWS = library.lumped()
SUBJECTS = {name: (Spring(row.b, row.m), row.prony) for name, row in ROWS.items()}
AH = SUBJECTS["a.h."]
EVERY = pytest.mark.parametrize(("spring", "prony"), SUBJECTS.values(), ids=SUBJECTS)


def test_the_spring_is_zero_before_touch_and_its_stiffness_grows_with_its_force():
    spring = Spring(b=0.18, m=2.1, x0=0.4)
    x = np.linspace(0.4, 3.0, 2001)
    np.testing.assert_array_equal(spring.force([-1.0, 0.0, 0.4]), 0.0)
    middle = (x[1:] + x[:-1]) / 2
    slope = np.diff(spring.force(x)) / np.diff(x)
    np.testing.assert_allclose(slope, spring.stiffness(spring.force(middle)), rtol=1e-6)
    np.testing.assert_allclose(spring.position(spring.force(x)), x, rtol=1e-12)


@EVERY
@pytest.mark.parametrize("speed", [0.1, 8.0, 60.0, 1e3])
def test_a_ramp_of_two_samples_is_the_closed_form(spring, prony, speed):
    depths = np.array([0.5, 1.0, 2.0])
    closed = lumped.constant_velocity(spring, prony, depths, speed)
    for depth, expected in zip(depths, closed, strict=True):
        got = lumped.force(spring, prony, [0.0, depth / speed], [0.0, depth])
        assert got[-1] == pytest.approx(expected, rel=1e-12)


@EVERY
def test_the_force_at_constant_speed_lies_between_relaxed_and_instantaneous(spring, prony):
    elastic = spring.force(2.0)
    slow, fast = (lumped.constant_velocity(spring, prony, 2.0, v) / elastic for v in (1e-7, 1e7))
    assert float(slow) == pytest.approx(prony.long_time, rel=1e-6)
    assert float(fast) == pytest.approx(1.0, rel=1e-4)


def wandering(seed=3, count=40):
    """Return a trajectory of straight lines that enters, leaves and jumps."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.exponential(0.05, count))
    position = 0.6 + 0.8 * np.cumsum(rng.normal(0, 0.4, count)) / np.sqrt(count)
    time[20] = time[19]  # a step
    return time, position + np.where(np.arange(count) % 17 == 5, -1.5, 0.0)


@EVERY
def test_straight_lines_are_exact_against_a_fine_hereditary_integral(spring, prony):
    """The second method convolves a piecewise linear T, with an error of (m dx)^2 / 12."""
    spring = Spring(spring.b, spring.m, 0.3)
    time, position = wandering()
    got = lumped.force(spring, prony, time, position)
    parts = 1000
    share = np.arange(1, parts + 1) / parts
    fine_t, fine_x = (
        np.append(v[0], (v[:-1, None] + np.diff(v)[:, None] * share).ravel())
        for v in (time, position)
    )
    fine = hereditary_integral(prony, fine_t, spring.force(fine_x))[::parts]
    assert np.abs(got - fine).max() < 1e-5 * np.abs(fine).max()
    assert got.min() < 0 < got.max()


def test_where_a_step_is_held_the_force_is_the_relaxation_function():
    spring, prony = AH
    time = np.concatenate([[0.0, 0.0], np.geomspace(1e-4, 50, 30)])
    position = np.append(0.0, np.full(len(time) - 1, 1.5))
    expected = spring.force(1.5) * prony.relaxation(time[1:])
    np.testing.assert_allclose(
        lumped.force(spring, prony, time, position)[1:], expected, rtol=1e-12
    )


def test_a_small_sinusoid_gives_the_spectrum_of_the_relaxation():
    """P = K i w G(i w) X for a small amplitude; K: stiffness at the relaxed preload."""
    from fefinger.validation.oracles import impedance

    spring, prony = AH
    frequency, cycles, n = 5.0, 60, 400
    turn = np.arange(cycles * n + 1) / n
    x = 1.5 + 1e-5 * np.sin(2 * np.pi * turn)
    # Long relaxed: the slow part of the offset has gone before the sinusoid starts.
    force = lumped.force(spring, prony, np.r_[0.0, 100 + turn / frequency], np.r_[1.5, x])[
        -n - 1 : -1
    ]
    phasor = 2 / n * np.sum(force * np.exp(-2j * np.pi * turn[-n - 1 : -1]))
    preload = prony.long_time * float(spring.force(1.5))
    z = impedance.impedance(spring, prony, frequency, preload)
    expected = -1j * z * 2j * np.pi * frequency * 1e-5
    assert phasor == pytest.approx(expected, rel=2e-3)


def test_changes_of_force_scale_with_the_offset():
    """Eq. 2.21: exact for what a motion adds to a relaxed offset."""
    spring, prony = SUBJECTS["means"]
    turn = np.linspace(0, 3, 600)
    added = []
    for offset in (1.0, 1.7):
        time, x = np.r_[0.0, 1e3 + turn], np.r_[offset, offset + 0.1 * np.sin(4 * turn)]
        force = lumped.force(spring, prony, time, x)
        added.append(force[1:] - prony.long_time * spring.force(offset))
    np.testing.assert_allclose(added[1], added[0] * np.exp(spring.m * 0.7), rtol=1e-9, atol=1e-13)


def figure_2_4(per_cycle=2500):
    turn = np.arange(5 * per_cycle) / per_cycle
    return np.r_[0.0, 0.075 + turn / 4], np.r_[0.0, 1.5 + 0.4 * np.sin(2 * np.pi * turn)]


def test_an_indenter_that_leaves_the_skin_never_pulls_and_finds_it_again():
    time, position = figure_2_4()
    free, glued = (f(*AH, time, position) for f in (lumped.contact_force, lumped.force))
    assert free.min() == 0
    before = np.cumsum(glued < 0) == 0
    off = np.abs(free - glued)[before]  # by a loop over times and by passes over all of them
    assert off.max() < 1e-12 * glued.max()
    assert 0.5 < np.mean(free > 0) < 1
    # The skin is let go for a moment, so a little less of it is left to push back later.
    assert 0 < glued[-2500:].max() - free[-2500:].max() < 0.01


def test_the_free_skin_obeys_zero_force_by_a_second_method():
    """While off, P = 0 makes T the creep of the force history: J convolved with dP."""
    spring, prony = AH
    time = np.concatenate([np.linspace(0, 0.02, 800), np.linspace(0.02001, 0.2, 4000)])
    position = np.where(time < 0.01, 100 * time, np.maximum(2.0 - 100 * time, -0.3))
    force = lumped.contact_force(spring, prony, time, position)
    surface = lumped.position_under(spring, prony, time, force)
    off = force == 0
    assert off.mean() > 0.5
    assert np.all(surface[off][1:] >= position[off][1:] - 1e-4)
    assert surface[~off] == pytest.approx(position[~off], abs=1e-4)


def test_contact_loss_converges_with_the_step():
    spring, prony = AH
    actual = []
    for per_cycle in (125, 250, 500, 4000):
        time, position = figure_2_4(per_cycle)
        actual.append(lumped.contact_force(spring, prony, time, position)[-per_cycle:].max())
    errors = np.abs(np.array(actual[:-1]) / actual[-1] - 1)
    assert errors[0] < 3e-4
    assert errors[-1] < 1e-5


@EVERY
def test_position_under_a_force_turns_the_force_around(spring, prony):
    spring = Spring(spring.b, spring.m, -0.2)
    time = np.linspace(0, 2, 4001)
    position = -0.2 + 1.2 * np.minimum(time / 0.05, 1.0) + 0.05 * np.sin(20 * time)
    force = lumped.force(spring, prony, time, position)
    got = lumped.position_under(spring, prony, time, force)
    assert np.abs(got - position)[10:].max() < 2e-5


@EVERY
def test_under_a_constant_force_the_finger_creeps_to_its_relaxed_depth(spring, prony):
    time = np.array([0.0, 1.0, 1e4])
    depth = lumped.position_under(spring, prony, time, [1.0, 1.0, 1.0])
    assert depth[0] == pytest.approx(spring.position(1.0), rel=1e-12)
    assert depth[-1] == pytest.approx(spring.position(1.0 / prony.long_time), rel=1e-9)
    assert depth[0] < depth[1] < depth[2]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Spring(0.0, 2.0), "b > 0 N/mm"),
        (lambda: Spring(0.1, float("nan")), "finite"),
        (lambda: lumped.force(*AH, [0, 1], [0, 1, 2]), r"signal \(n_t,\)"),
        (lambda: lumped.force(*AH, [0, -1], [0, 1]), "never decrease"),
        (lambda: lumped.constant_velocity(*AH, 1.0, 0.0), "speed above 0"),
        (lambda: lumped.position_under(*AH, [0, 1], [0, -1]), "forces of 0 or more"),
    ],
)
def test_what_cannot_be_used_gets_a_sentence(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_a_finger_without_relaxation_is_its_spring():
    spring = Spring(0.2, 1.9)
    time, position = wandering()
    got = lumped.force(spring, Prony((1.0,), ()), time, position)
    np.testing.assert_allclose(got, spring.force(position), rtol=1e-14)
