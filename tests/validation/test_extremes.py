"""Edges in small: any number in its range is answered with its invariants kept, or refused."""

import time
import warnings
from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation import page, suites
from fefinger.validation.extremes import drawn as extremes_drawn
from fefinger.validation.extremes import suite
from fefinger.validation.extremes.bodies import _bar, _complementarity, _stacked
from fefinger.validation.extremes.invariants import invariants
from fefinger.validation.extremes.nerve import MEMBRANES, _checked
from fefinger.validation.extremes.scenes import answered, ramp
from fefinger.validation.extremes.trial import THEORY, TookTooLongError, Trial, ending, limited
from fefinger.validation.oracles.sphere import Sphere
from hypothesis import given, settings
from hypothesis import strategies as st
from refusals import refused

import fefinger as ff
from fefinger.mechanics import condensed, hertz, layered, linear, lumped, solid
from fefinger.mechanics.press.time_steps import time_grid, too_long
from fefinger.mechanics.situation import Situation
from fefinger.neural.endorgans import PoleZero
from fefinger.neural.membranes import HodgkinHuxley
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import Prony, creep_integral, hereditary_integral


few = settings(derandomize=True, database=None, deadline=None, max_examples=25)

FORCE_ONLY = ff.Ask(pressure=False, strain=False, fields=False)


def logs(low, high):
    return st.floats(np.log10(low), np.log10(high)).map(lambda power: float(10**power))


@st.composite
def series(draw):
    rates = draw(st.lists(logs(1e-6, 1e6), min_size=1, max_size=10))
    left = draw(st.one_of(logs(1e-9, 0.5), logs(1e-9, 0.5).map(lambda near: 1 - near)))
    shares = np.array(draw(st.lists(logs(1e-6, 1), min_size=len(rates), max_size=len(rates))))
    return Prony((left, *(shares / shares.sum() * (1 - left)).tolist()), tuple(rates))


def kept(findings):
    for name, (violation, limit) in findings.items():
        assert violation <= limit, name


def ends(ask, group="hertz"):
    end = ending(Trial(group, "test", "test", ask))
    assert end.kind in ("answered", "refused"), end.text
    return end.kind


@settings(few, max_examples=6)
@given(st.floats(0, 0.5), logs(1e-3, 1e3))
def test_a_bar_of_slivers_has_its_modulus_and_ratio(poisson, longer):
    kept(_bar(poisson, longer))


@few
@given(logs(1e-9, 1e9), st.floats(0, 0.4999))
def test_layers_are_in_series_at_any_contrast(contrast, poisson):
    kept(_stacked(contrast, poisson))


@settings(few, max_examples=8)
@given(logs(1, 1e14), st.booleans())
def test_contact_neither_pulls_nor_penetrates(spread, tie):
    kept(_complementarity(spread, tie))


@settings(few, max_examples=8)
@given(st.sampled_from(sorted(MEMBRANES)), st.floats(-1e4, 1e4), logs(1e-9, 0.05))
def test_a_membrane_fires_in_order_or_refuses(name, current, seconds):
    time_, currents = np.array([0.0, seconds]), np.array([current, current])
    ends(lambda: _checked(MEMBRANES[name], time_, currents))


@few
@given(series(), st.lists(st.floats(0, 10), min_size=2, max_size=20))
def test_creep_of_a_relaxed_signal_is_the_signal(prony, signal):
    times = np.linspace(0, 1, len(signal))
    back = hereditary_integral(prony, times, np.append(0.0, signal[1:]))
    fine = np.linspace(0, 1, 2000)
    fast = np.array(prony.v).max() * fine[1] > 0.1  # what is no line between samples
    if not fast and prony.long_time > 1e-3:
        smooth = np.sin(3 * fine)
        relaxed = hereditary_integral(prony, fine, smooth)
        assert creep_integral(prony, fine, relaxed) == pytest.approx(smooth, abs=2e-3)
    assert np.isfinite(creep_integral(prony, times, back)).all()


def test_creep_keeps_its_digits_for_rates_that_are_far_apart():
    prony = Prony((1e-12, *(10 * ((1 - 1e-12) / 10,))), tuple(np.logspace(-6, 6, 10)))
    ceiling, k, lam = prony.creep()
    assert (lam > 0).all()
    assert (np.diff(lam) > 0).all()
    assert 1 + k.sum() == pytest.approx(ceiling)
    for rate in lam:  # the roots of the modulus at s = -lam
        shares = np.array(prony.weights[1:]) * rate / (np.array(prony.v) - rate)
        assert shares.sum() == pytest.approx(prony.long_time, abs=1e-9 * np.abs(shares).max())


def test_a_small_sphere_is_a_paraboloid_to_all_digits():
    part = 1e-12
    ball = Sphere.at_depth(14.0, 14 * part, modulus=80.0, poisson=0.3)
    assert ball.force == pytest.approx(4 / 3 * 80 / 0.91 * 14**2 * part**1.5, rel=1e-11)
    around = [Sphere(1.0, a, 80.0, 0.3).force for a in (0.1 * (1 - 1e-9), 0.1 * (1 + 1e-9))]
    assert around[1] == pytest.approx(around[0], rel=1e-8)


def test_a_membrane_without_a_state_is_refused():
    with pytest.raises(InputError, match=r"out of the range of its rates; use smaller currents"):
        HodgkinHuxley().fire([0.0, 0.05], [-1e4, -1e4])


def test_poles_that_cancel_are_refused():
    with pytest.raises(InputError, match="differ by 1e-06 of themselves"):
        PoleZero((0.0, 0.0), (10.0, 10.0 * (1 + 1e-9)))


@pytest.mark.parametrize("fast", [True, False])
def test_slow_motions_take_longer_steps_and_endless_ones_are_refused(fast):
    slow = time_grid(ff.Ramp(1e-4, 1.5), fast=fast)
    assert 5000 <= len(slow) - 1 <= 26_000
    assert len(time_grid(ff.Sinusoid(0.3, 1e-4, 3), fast=fast)) < 80_000
    wave = time_grid(ff.Sinusoid(0.3, 20, 200), fast=fast)  # of 10 s, no cycle of which is long
    assert np.diff(wave).max() <= 1e-3 * (1 + 1e-9)
    endless = ff.Sinusoid(0.3, 200, 100_000)
    (reason,) = too_long(endless, fast=False)
    assert "at most 250000 time steps, which fit into memory, received one of 4000000" in reason
    with refused("motion"):
        time_grid(endless, fast=fast)
    scene = ff.Scene(
        finger=ff.Finger.subject("a.h.", tissue="maeno1998"), motion=endless, ask=FORCE_ONLY
    )
    assert not [each for each in lumped.refuse(Situation.of(scene)) if each.about == "ability"]
    for other in (hertz, layered, linear):
        assert any(each.reason == reason for each in other.refuse(Situation.of(scene))), other.name


def test_samples_in_ms_get_a_hint():
    beats = np.arange(3000.0)
    (hint,) = too_long(ff.Sampled(tuple(beats), tuple(beats % 2)), fast=False, most=1000)
    assert hint.endswith("so far apart as if their times were in ms; give them in s")


def scene(**parts):
    whole = {
        "finger": ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998"),
        "ask": FORCE_ONLY,
    }
    return ff.Scene(**(whole | {"motion": ff.Ramp(60, 0.5)} | parts))


def test_end_organs_in_the_bone_are_refused():
    small = ff.Finger(1.6, 1.0, pad_radius=1.4, skin=ff.Tissue(136, 0.48, 0.1))
    asked = scene(finger=small, motion=ff.Ramp(6, 0.06, corner=0), ask=ff.Ask(fields=False))
    for each in (hertz, layered):
        with pytest.raises(InputError, match=r"end organs above the bone, less than 0.5 mm"):
            each.respond(asked)


def test_a_contact_wider_than_its_radius_is_refused_whatever_is_asked():
    deep = scene(indenter=ff.Sphere(2), motion=ff.Ramp(60, 3.0))
    assert any("Hertz ends there" in each.reason for each in hertz.refuse(Situation.of(deep)))
    with pytest.raises(InputError, match=r"narrower than its relative radius of 1.75 mm"):
        hertz.respond(deep)


@pytest.mark.parametrize("each", [hertz, lumped])
def test_a_force_that_presses_through_the_tissue_is_refused(each):
    with refused("motion.force"):
        each.respond(scene(motion=ff.RampHold(loading_rate=1e8, force=1e7, hold=100, corner=0)))


def test_a_contact_smaller_than_a_facet_is_told_from_none():
    shallow = scene(motion=ff.Ramp(60, 1e-3, corner=0))
    reasons = [each.reason for each in linear.refuse(Situation.of(shallow))]
    assert any("the mesh is too coarse for it" in reason for reason in reasons)
    with pytest.raises(InputError, match="smaller than a facet of the pad; press deeper"):
        linear.respond(shallow)
    assert not any("too coarse" in each.reason for each in linear.refuse(Situation.of(scene())))


@pytest.mark.usefixtures("operators")
@pytest.mark.parametrize("each", [linear, condensed, solid])
def test_a_ball_between_the_vertices_of_the_pad_is_refused_by_depth_and_by_force(each):
    ball = {
        "finger": ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998"),
        "indenter": ff.Sphere(0.5),
    }
    for motion in (ff.Ramp(20, 0.1), ff.Ramp(loading_rate=2.0, force=0.05)):
        with pytest.raises(
            InputError, match="at least 3 vertices of the pad under it, rec"
        ) as refusal:
            each.respond(ff.Scene(motion=motion, **ball))
        assert "deeper" not in str(refusal.value)  # it has no more vertices under it there
        assert "hertz" not in str(refusal.value)  # which ends at a depth of its radius


def broken(**findings):
    return Trial("hertz", "test", "test", lambda: findings)


def test_the_judge_sees_what_fails():
    assert ending(broken(fine=(0.5, 1.0))).worst == 0.5
    assert ending(broken(wrong=(2.0, 1.0))).text == "answered, but wrong: 2 > 1"
    assert ending(broken(lost=(np.nan, 1.0))).kind == "failed"
    assert ending(broken(lost=(1.0, 0.0))).kind == "failed"
    assert ending(broken(lost=(np.inf, 1.0))).kind == "failed"


def test_what_was_checked_is_told_with_its_numbers():
    end = ending(broken(rising=(0.0, 1e-9), back=(1.23456e-4, 1e-3), finite=(0.0, 0.0)))
    assert end.text == (
        "off by rising 0 of 1e-09, back 0.000123 of 0.001, finite 0; nearest to its limit: back"
    )
    assert ending(broken()).text == "answered, but nothing was checked of it"


def test_a_quick_look_has_a_scene_on_a_mesh_of_each_kind():
    quick = [trial for trial in suite.trials(quick=True) if trial.group in extremes_drawn.COUNTS]
    assert {trial.group for trial in quick} == set(extremes_drawn.COUNTS) - {"layered"}
    assert len(quick) < 100


def raising(error):
    def ask():
        raise error

    return ask


def test_only_sentences_refuse():
    sentence = ValueError("Hertz: expected a depth, received none")
    for group, error, kind in (
        ("hertz", InputError("x: expected"), "refused"),
        ("hertz", sentence, "failed"),
        (THEORY, sentence, "refused"),
        (THEORY, ValueError("shapes not aligned"), "failed"),
        ("hertz", ZeroDivisionError("x"), "failed"),
        ("hertz", MemoryError(), "failed"),
    ):
        assert ending(Trial(group, "test", "test", raising(error))).kind == kind, error

    def grumble():
        warnings.warn("overflow", RuntimeWarning, stacklevel=1)
        return {"fine": (0.0, 1.0)}

    assert "warned of RuntimeWarning" in ending(Trial("hertz", "test", "test", grumble)).text
    wrong = replace(broken(fine=(0.0, 1.0)), wants="refused")
    assert ending(wrong).kind == "failed"
    wrong = replace(Trial("hertz", "test", "test", raising(InputError("no"))), wants="answered")
    assert ending(wrong).kind == "failed"


def test_what_never_ends_is_stopped():
    started = time.process_time()

    def endless():
        with limited(0.05):
            while time.process_time() < started + 5:
                pass

    with pytest.raises(TookTooLongError):
        endless()


def test_the_invariants_see_a_response_that_lies():
    made, response = answered("hertz", {"motion": ramp(60, 0.5)})
    kept(invariants(made, response))
    force = response.force
    lies = {
        "no pull": replace(response, force=force - 0.01 * force.max()),
        "finite": replace(response, pressure=response.pressure * np.nan),
        "asked": replace(response, depth=response.depth * 1.001),
        "balance": replace(response, pressure=response.pressure * 1.01),
        "area": replace(response, contact_area=0 * response.contact_area),
        "rising": replace(response, force=np.append(force[:-1], force[-3])),
    }
    for name, lie in lies.items():
        violation, limit = invariants(made, lie)[name]
        assert not violation <= limit, name
    cycle = {"motion": ff.Trapezoid(20, 0.4, hold=0.0)}
    made, response = answered("hertz", cycle)
    violation, limit = invariants(made, replace(response, force=response.force[::-1]))["work"]
    assert violation > limit


PRESSED = {"plate": ff.Flat(30), "ball": ff.Sphere(8), "ball aside": ff.Sphere(8, (1.0, 1.0))}


@pytest.mark.parametrize("indenter", PRESSED.values(), ids=PRESSED)
def test_a_pressure_that_carries_more_or_less_than_the_force_is_seen(indenter):
    jump = ff.Sampled((0.0, 1.0), (0.6, 0.6))
    made, response = answered("linear", {"indenter": indenter, "motion": jump})
    kept(invariants(made, response))
    for factor in (0.99, 1.01, 10.0):
        lie = replace(response, pressure=factor * response.pressure)
        violation, limit = invariants(made, lie)["balance"]
        assert violation > limit, factor
    for factor in (0.1, 10.0):
        lie = replace(response, contact_area=factor * response.contact_area)
        violation, limit = invariants(made, lie)["area of pressure"]
        assert violation > limit, factor


def test_finite_strain_gives_the_pressure_across_the_travel():
    _, response = answered("linear", {"motion": ff.Sampled((0.0, 1.0), (0.6, 0.6))})
    made = scene(indenter=ff.Sphere(8), motion=ff.Sampled((0.0, 1.0), (0.6, 0.6)))
    finite = replace(response, mechanics="solid")
    assert invariants(made, finite)["balance"][0] < 1e-12
    assert invariants(made, response)["balance"][0] > 1e-2


def test_what_a_press_prescribes_is_not_compared_with_itself():
    names = [case.name for case in suites.cases("condensed", quick=False)]
    told = [name for name in names if name.startswith("depth in every step")]
    assert told == ["depth in every step, sphere, off center, by force"]


def test_the_suite_has_its_trials_and_tells_what_came_out():
    every = suite.trials(quick=False)
    assert len(every) >= 200
    names = [(trial.group, trial.edge, trial.name) for trial in every]
    assert len(set(names)) == len(names)
    assert {trial.group for trial in every} >= set(extremes_drawn.COUNTS)
    quick = suites.cases("extremes", quick=True)
    (outcome,) = (suites._measured(quick[0]),)
    assert outcome.verdict == "pass"
    assert outcome.note.startswith(("answered: ", "refused: "))


def test_the_page_says_how_the_trials_ended_from_their_record_alone():
    kept = "answered: with finite, balance; nearest to its limit: balance"
    told = {
        "linear, depth: 1 mm": (kept, 0.5, "pass"),
        "linear, depth: 9 mm": ("refused: press less", 0.0, "pass"),
        "nerve, pace: fast": ("answered, but finite: 3 > 0", 1e6, "fail"),
    }
    cases = [
        {"name": name, "note": said, "value": value, "verdict": verdict}
        for name, (said, value, verdict) in told.items()
    ]
    found = suite.finding_of(cases)
    assert found["texts"] == [
        "Of 3 trials at extreme values 1 are answered and satisfy all invariants, 1 are refused "
        "with a message, 1 failed."
    ]
    (table,) = found["tables"]
    assert table["rows"] == [
        ["linear", "1", "1", "0", "50 % (balance; depth)"],
        ["nerve", "0", "0", "1", ""],
    ]
    ((caption, drawn),) = suite.figures_of(cases)
    assert caption.startswith(found["texts"][0])
    assert len(drawn.axes) == 1


def test_what_was_told_is_on_the_page():
    case = suites.cases("extremes", quick=True)[0]
    record = suites.as_json({"extremes": (suites.Outcome(case, 0.0, "", "refused: a sentence"),)})
    assert "refused: a sentence" in page.html(record, {}, {})
