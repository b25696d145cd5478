"""End-organ filters against closed forms, their frequency response and refinement."""

import numpy as np
import pytest

from fefinger.neural.checked_signals import dense_times
from fefinger.neural.endorgans import END_ORGANS, PoleZero, chord_steps
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import TYPES


KINDS = pytest.mark.parametrize("kind", TYPES)
UNEVEN = np.concatenate([[0.0], np.geomspace(1e-5, 2.0, 60)])


@pytest.mark.parametrize("kind", ["SAI", "SAII"])
def test_slowly_adapting_step_and_ramp_are_their_closed_forms(kind):
    organ = PoleZero(END_ORGANS[kind].zeros, END_ORGANS[kind].poles, gain=0.7)
    z, p = (2 * np.pi * f[0] for f in (organ.zeros, organ.poles))
    step = 0.7 * (z / p + (1 - z / p) * np.exp(-p * UNEVEN))
    ramp = 0.7 * (z / p * UNEVEN + (1 - z / p) * -np.expm1(-p * UNEVEN) / p)
    np.testing.assert_allclose(organ.respond(UNEVEN, np.ones_like(UNEVEN)), step, rtol=1e-12)
    np.testing.assert_allclose(organ.respond(UNEVEN, UNEVEN), ramp, rtol=1e-12)


@pytest.mark.parametrize("kind", ["FAI", "FAII"])
def test_fast_adapting_step_and_ramp_are_their_closed_forms(kind):
    """The ramp starts with a jump of velocity, which needs no initial condition (B.33)."""
    organ = PoleZero(END_ORGANS[kind].zeros, END_ORGANS[kind].poles, gain=0.7)
    p1, p2 = (2 * np.pi * f for f in organ.poles)
    e1, e2 = np.exp(-p1 * UNEVEN), np.exp(-p2 * UNEVEN)
    step = 0.7 * (p2 * e2 - p1 * e1) / (p2 - p1)
    ramp = 0.7 * (e1 - e2) / (p2 - p1)
    np.testing.assert_allclose(organ.respond(UNEVEN, np.ones_like(UNEVEN)), step, atol=1e-13)
    np.testing.assert_allclose(organ.respond(UNEVEN, UNEVEN), ramp, atol=1e-15)


@KINDS
def test_steady_sinusoid_is_the_frequency_response(kind):
    organ = END_ORGANS[kind]
    frequency = organ.poles[0]
    time = np.linspace(0, 12 / frequency, 12 * 2000 + 1)
    last = slice(-2000, None)
    wave = np.sin(2 * np.pi * frequency * time)
    turn = np.exp(-2j * np.pi * frequency * time[last])
    response = 2j * np.mean(organ.respond(time, wave)[last] * turn)
    assert response == pytest.approx(complex(organ.frequency_response(frequency)), rel=3e-5)


@KINDS
def test_sampling_a_piecewise_linear_input_more_finely_changes_nothing(kind):
    rng = np.random.default_rng(1)
    knots = np.cumsum(rng.exponential(size=15) * rng.choice([1e-4, 1e-2, 0.3], size=15))
    values = rng.normal(size=(15, 2))
    fine = np.unique(np.concatenate([knots, rng.uniform(knots[0], knots[-1], 200)]))
    signal = np.column_stack([np.interp(fine, knots, column) for column in values.T])
    refined = END_ORGANS[kind].respond(fine, signal)
    between = END_ORGANS[kind].respond(knots, values, at=fine)
    assert between.shape == (len(fine), 2)
    np.testing.assert_allclose(between, refined, atol=1e-12)
    at_knots = END_ORGANS[kind].respond(knots, values)
    np.testing.assert_allclose(refined[np.searchsorted(fine, knots)], at_knots, atol=1e-12)


@KINDS
def test_nothing_comes_out_before_something_goes_in(kind):
    out = END_ORGANS[kind].respond([0.0, 1.0, 1.0, 2.0], [0.0, 0.0, 1.0, 1.0], at=[0.5, 1.0, 1.5])
    assert out[0] == 0.0
    assert out[1] == pytest.approx(1.0)
    late = END_ORGANS[kind].respond([0.0, 50.0], [1.0, 1.0])[-1]
    assert late == pytest.approx(0.0 if kind.startswith("FA") else 0.1, abs=1e-15)


def test_every_type_has_an_end_organ():
    assert tuple(END_ORGANS) == TYPES


@pytest.mark.parametrize(
    ("zeros", "poles"),
    [
        ((0.0,), (1.0, 2.0)),
        ((0.0,), (0.0,)),
        ((-1.0,), (1.0,)),
        ((0.0, 0.0), (1.0, 1.0)),
        ((np.nan,), (1.0,)),
    ],
)
def test_impossible_filters_are_refused(zeros, poles):
    with pytest.raises(InputError, match="as many zeros as poles"):
        PoleZero(zeros, poles)


@KINDS
def test_straight_lines_between_the_samples_of_chord_steps_keep_the_error(kind):
    time = np.array([0.0, 0.01, 0.05, 0.05, 0.3, 1.5])
    x_in = np.array([[0.0, 0.0], [0.2, 0.1], [1.0, -0.4], [1.2, 0.5], [1.2, 0.5], [0.3, 0.5]])
    error = 1e-4
    organ = END_ORGANS[kind]
    steps = np.minimum(chord_steps(organ, time, x_in, error), 0.1)
    at = dense_times(time, steps)
    middle = 0.5 * (at[1:] + at[:-1])[np.diff(at) > 1e-12]
    sampled = organ.respond(time, x_in, at)
    for unit in range(2):
        chords = np.interp(middle, at, sampled[:, unit])
        strayed = np.abs(chords - organ.respond(time, x_in, middle)[:, unit])
        assert strayed.max() <= error * (1 + 1e-9)
        assert strayed.max() > 0.05 * error or kind == "FAII"
    assert len(at) < 6000 or kind == "FAII"


def test_a_jump_keeps_the_value_before_it():
    at = dense_times(np.array([0.0, 0.1, 0.1, 0.2]), 0.05)
    assert np.all(np.diff(at) > 0)
    before, after = END_ORGANS["SAI"].respond([0, 0.1, 0.1, 0.2], [0, 0, 1, 1], at[2:4])
    assert before == 0.0
    assert after == pytest.approx(1.0, abs=1e-9)
