"""The suite `neural`: what it says about itself, that it can fail, and that it is drawn."""

from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation import suites
from fefinger.validation.neural import drawings, gains, phases, sinusoids, sweep
from fefinger.validation.neural.connor_stevens import ConnorStevens
from fefinger.validation.neural.filters import derivative

from fefinger.neural.membranes import IntegrateAndFire


@pytest.mark.parametrize(
    ("membrane", "measure", "holds"),
    [
        (IntegrateAndFire(), sinusoids.shift, lambda octaves: octaves >= 2),
        (ConnorStevens(), lambda name: phases.spread(name, 16.0), lambda n: n == 0),
    ],
)
def test_claims_fail_on_a_membrane_that_lacks_the_property(monkeypatch, membrane, measure, holds):
    """The shifting peak and the locking are the membrane's."""
    spring = sweep.MODELS["spring"]
    name = f"spring on {type(membrane).__name__}"
    tones = spring.frequencies if membrane == IntegrateAndFire() else (16.0,)
    monkeypatch.setitem(
        sweep.MODELS, name, replace(spring, name=name, membrane=membrane, frequencies=tones)
    )
    assert holds(measure("spring"))
    assert not holds(measure(name))


def test_the_lowest_threshold_is_looked_for_beyond_what_is_published():
    for kind, (low, high) in gains.BEST.items():
        assert gains.tones(kind)[0] < low
        assert gains.tones(kind)[-1] >= 4 * high
    low, high = gains.SMALLEST
    assert gains.AMPLITUDES[0] < low
    assert gains.AMPLITUDES[-1] > high


def test_the_threshold_of_faii_falls_on_beyond_its_band():
    edge = gains.BEST["FAII"][1]
    inside, outside = (gains.threshold_at("FAII", tone) for tone in (edge, 2 * edge))
    assert outside < 0.8 * inside


def test_the_best_tone_of_faii_is_short_of_its_band():
    cases = {case.name: case for case in suites.cases("neural", quick=False)}
    case = cases["gains: frequency of the lowest threshold of FAII"]
    assert suites.Outcome(case, case.expected.value).verdict == "short"
    assert suites.Outcome(case, 512.0).verdict == "fail"  # then it is in the band, and can be said
    assert "1000 Hz" in case.shortfall


@pytest.mark.parametrize("kind", ["FAI", "FAII"])
def test_the_lowest_threshold_is_that_in_the_band(monkeypatch, kind):
    _, high = gains.BEST[kind]
    falling = tuple(1 / tone for tone in gains.tones(kind))
    monkeypatch.setattr(gains, "thresholds", lambda kind: falling)
    assert gains.best_tone(kind) > high
    assert gains.lowest_in_band(kind) == 1 / high


def test_the_steady_state_is_that_of_the_filter_after_many_cycles():
    organ, tone = sweep.END_ORGANS["SAII"], 3.0
    turn = np.arange(12 * 2000 + 1) / 2000
    late = turn >= 11
    followed = organ.respond(turn / tone, 1.0 - np.cos(2 * np.pi * turn))
    steady = sweep.current(organ, tone, turn)
    np.testing.assert_allclose(np.maximum(followed, 0)[late], steady[late], atol=1e-5)


def test_figures_are_in_the_axes_of_the_thesis():
    for drawn in (
        drawings._response("spring"),
        drawings._course("FAI"),
        drawings._force(),
        drawings._gains(),
    ):
        for axis in drawn.axes:
            assert axis.get_ylabel() or axis.collections
            assert axis.lines or axis.collections or axis.patches
    captions = " ".join(text for _, text in (*drawings.RESPONSES, *drawings.COURSES))
    for number in ("4-4b", "4-5b", "4-8", "4-9", "4-10a", "4-11b", "4-13", "4-14b", "4-16", "4-17"):
        assert number in captions


@pytest.mark.parametrize("poles", [(200.0,), (200.0, 300.0)])
def test_below_its_poles_the_filter_is_a_derivative(poles):
    pure = sweep.Derivative(len(poles)).frequency_response([0.5, 2.0])
    response = derivative(*poles).frequency_response([0.5, 2.0])
    np.testing.assert_allclose(response, pure, rtol=0.02)
    assert derivative(*poles).frequency_response(0.0) == 0.0
