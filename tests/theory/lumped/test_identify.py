"""Identification from ramp and hold: the thesis's bias, its cure, and what the fits admit."""

from functools import cache

import numpy as np
import pytest
from fefinger.validation.oracles import synthetic
from scipy import optimize

from fefinger.scene import library
from fefinger.theory.lumped import confidence, identify, ramp_hold
from fefinger.theory.lumped import spring as lumped
from fefinger.theory.lumped.spring import Spring
from fefinger.theory.relaxation import Prony, hereditary_integral


SUBJECTS = {name: (Spring(row.b, row.m, 0.5), row.prony) for name, row in library.lumped().items()}
AH = SUBJECTS["a.h."]


@cache
def trial(name="a.h.", **options):
    made = synthetic.ramp_and_hold(*SUBJECTS[name], **options)
    return made.time, made.position, made.force


def truth(name="a.h."):
    return identify.Identification(*SUBJECTS[name], {}, 0.0, 1.0).parameters


def test_the_line_through_the_stiffness_looks_perfect_all_the_same():
    fit = identify.thesis(*trial(seed=0))
    assert fit.vaf_stiffness > 0.98
    assert fit.vaf_hold > 0.999
    assert fit.mse < 0.05
    off = abs(fit.spring.b - AH[0].b) / fit.uncertainty["b"]
    assert off > 4  # far outside of its own uncertainty


@pytest.mark.parametrize("name", SUBJECTS)
def test_the_joint_fit_recovers_every_subject_without_noise(name):
    fit = identify.joint(*trial(name, seed=None))
    for key, value in truth(name).items():
        assert fit.parameters[key] == pytest.approx(value, rel=1e-3), key
    assert fit.warnings == ()


@pytest.fixture(scope="module")
def scores():
    """Return the deviations of 8 noisy fits in their stated standard deviations."""
    rows = []
    for seed in range(8):
        fit = identify.joint(*trial(seed=seed))
        expected = truth()
        rows.append({k: (v - expected[k]) / fit.uncertainty[k] for k, v in fit.parameters.items()})
    return {key: np.array([row[key] for row in rows]) for key in rows[0]}


@pytest.mark.parametrize("key", ["b", "m", "x0", "c0", "c1", "c2", "c3", "v1", "v2", "v3"])
def test_the_joint_fit_is_right_within_its_stated_uncertainty(scores, key):
    """With 3 mN and 3 um of noise; the mean of 8 scores has a deviation of 0.35 itself."""
    score = scores[key]
    assert np.abs(score).max() < 3.5
    assert abs(score.mean()) < 1.2
    assert 0.55 < np.sqrt(np.mean(score**2)) < 1.6


def test_the_joint_fit_is_closer_than_the_thesis_to_b_and_c0():
    data = trial(seed=5)
    biased, cured = identify.thesis(*data), identify.joint(*data)
    for key in ("b", "c0", "c1"):
        value = truth()[key]
        errors = [abs(actual.parameters[key] / value - 1) for actual in (biased, cured)]
        assert errors[0] > 0.2, key
        assert errors[1] < 0.05, key


def test_the_same_seed_makes_the_same_trial_with_the_stated_noise():
    first, again, other = (synthetic.ramp_and_hold(*AH, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.force, again.force)  # exact: one call, made twice
    assert np.any(first.force != other.force)
    exact = synthetic.ramp_and_hold(*AH, seed=None)
    assert np.std(first.force - exact.force) == pytest.approx(3e-3, rel=0.02)
    assert np.std(first.position - exact.position) == pytest.approx(3e-3, rel=0.02)
    assert exact.force.max() == pytest.approx(2.5, rel=0.02)
    record = ramp_hold.split(first.time, first.position, first.force)
    assert record.force_noise == pytest.approx(3e-3, rel=0.05)
    assert record.position_noise == pytest.approx(3e-3, rel=0.05)


def test_the_touch_of_the_thesis_is_as_unsure_as_its_line():
    """It scatters by 0.02 mm; with m and b taken for sure it said 0.2 um."""
    fit = [identify.thesis(*trial(seed=seed)) for seed in range(12)]
    scatter = np.std([each.spring.x0 for each in fit], ddof=1)
    stated = np.median([each.uncertainty["x0"] for each in fit])
    assert 0.4 < scatter / stated < 2.0


def near(actual, deviations=3.5):
    """Return whether every parameter agrees with a.h.'s within its stated uncertainty."""
    return all(
        abs(actual.parameters[key] - value) < deviations * actual.uncertainty[key]
        for key, value in truth().items()
    )


def test_a_ramp_of_many_samples_is_averaged_and_still_fits():
    assert near(identify.joint(*trial(seed=0, speed=20.0, hold=4.0)))


def test_a_ramp_too_slow_for_the_fast_term_is_told():
    """The stiffness is 20 % low then, by more than it says."""
    slow = trial(seed=0, speed=2.0, hold=4.0, sample_rate=2e3)
    fit = identify.joint(*slow)
    assert "term 1 has faded" in fit.warnings[-1]
    assert "ramp faster" in fit.warnings[-1]
    assert identify.thesis(*slow).spring.b > 0


def test_a_corner_between_few_samples_stays_sharp():
    """At 1 kHz nine points are 0.5 mm: b came out at 0.35 N/mm instead of 0.18."""
    fit = identify.joint(*trial(seed=None, sample_rate=1e3))
    assert fit.spring.b == pytest.approx(AH[0].b, rel=0.02)
    assert fit.prony.v[0] == pytest.approx(AH[1].v[0], rel=0.02)


def test_a_search_that_goes_astray_starts_again():
    """It left out the fast term, and advised a longer hold."""
    fit = identify.joint(*trial(seed=4, speed=8.0))
    assert fit.prony.v[1:] == pytest.approx(AH[1].v[1:], rel=0.05)
    assert not any("slower than the hold" in each for each in fit.warnings)


def moved(time, position, *, noise=3e-3, seed=0):
    """Return the record of a.h. under a position, with noise."""
    rng = np.random.default_rng(seed)
    force = lumped.force(*AH, time, position)
    return (
        time,
        position + rng.normal(0, noise, len(time)),
        force + rng.normal(0, noise, len(time)),
    )


def test_a_gentle_ramp_of_few_samples_is_not_smoothed_away():
    """The least jerk in 40 samples; b was 26 % high, six deviations."""
    time = np.arange(0.0, 6.0, 1e-3)
    u = np.clip(time / 0.04, 0.0, 1.0)
    fit = identify.joint(*moved(time, 0.2 + 1.85 * u**3 * (10 - 15 * u + 6 * u**2)))
    assert near(fit)


@pytest.mark.parametrize("rate", [1e3, 1e4])
def test_an_indenter_that_goes_too_far_and_comes_back_still_holds(rate: float) -> None:
    """The way through was taken for the hold: of 20 samples that there were to be, or 2.4 ms."""
    time = np.arange(0.0, 6.0, 1 / rate)
    after = np.maximum(time - 0.04, 0.0)
    ring = 0.03 * np.exp(-after / 0.01) * np.sin(after / 0.005)
    data = moved(time, 0.2 + 1.85 * np.clip(time / 0.04, 0.0, 1.0) + ring)
    record = ramp_hold.split(*data)
    assert 5.8 < record.hold_seconds < 5.96
    assert record.beyond < record.hold
    assert near(identify.joint(*data))
    assert identify.thesis(*data).spring.b < AH[0].b


def test_a_record_that_begins_in_contact_is_refused():
    time, position, force = trial(seed=0)
    with pytest.raises(ValueError, match="begins before touch, at 0 N, received"):
        identify.joint(time[200:], position[200:], force[200:])
    with pytest.raises(ValueError, match="tare the force"):
        identify.thesis(time, position, force + 0.1)


def test_a_force_that_is_not_tared_is_told():
    time, position, force = trial(seed=0)
    for offset, message in (
        (-0.05, "the force is -0.0"),
        (0.01, "the force is 0.0"),
        (0.03, "touch"),
    ):
        fit = identify.joint(time, position, force + offset)
        assert fit.warnings[-1].startswith(message)
        assert "tare the force" in fit.warnings[-1]


def test_what_the_data_say_nothing_of_is_unknown_and_the_rest_is_not():
    design = np.array([[1.0, 0.0], [1.0, 0.0], [1.0, 0.0]])
    actual = confidence.covariance(design, np.array([0.1, -0.1, 0.0]))
    assert actual[0, 0] == pytest.approx(0.02 / 3)
    assert actual[1, 1] == np.inf


def test_a_ramp_that_starts_and_stops_gently_is_identified_as_well():
    """10 ms corners, from rest at touch: the thesis's line takes the steady part alone."""
    spring, prony = AH
    time = np.arange(0, 5.1, 1e-4)
    speed = 60.0 * np.clip(np.minimum(time - 0.03, 0.07 - time) / 0.01, 0, 1)
    position = spring.x0 + np.append(0.0, np.cumsum(speed[1:] + speed[:-1]) / 2 * 1e-4)
    rng = np.random.default_rng(0)
    force = lumped.force(spring, prony, time, position) + rng.normal(0, 3e-3, len(time))
    data = time, position + rng.normal(0, 3e-3, len(time)), force
    biased, cured = identify.thesis(*data), identify.joint(*data)
    assert 0.6 < biased.spring.b / spring.b < 0.9
    for key, value in truth().items():
        assert abs(cured.parameters[key] - value) < 3.5 * cured.uncertainty[key], key


def test_what_follows_the_hold_is_left_out():
    time, position, force = trial(seed=None, hold=2.0)
    back = np.linspace(0, 1, 3000)[1:]
    more = (
        np.append(time, time[-1] + 0.1 * back),
        np.append(position, position[-1] - 1.0 * back),
        np.append(force, force[-1] * (1 - back)),
    )
    plain, longer = identify.joint(time, position, force), identify.joint(*more)
    assert longer.parameters == pytest.approx(plain.parameters, rel=5e-3)


def test_more_exponentials_than_there_are_get_a_warning():
    prony = Prony((0.3, 0.5, 0.2), (100.0, 2.0))
    made = synthetic.ramp_and_hold(AH[0], prony, seed=0)
    two, three = (
        identify.joint(made.time, made.position, made.force, terms=terms) for terms in (2, 3)
    )
    assert two.warnings == ()
    assert two.prony.v == pytest.approx(prony.v, rel=0.1)
    assert any("fit fewer terms" in sentence for sentence in three.warnings)


def test_a_search_of_the_thesis_that_is_cut_short_is_told(monkeypatch):
    """As the fits of a.h. with 4 terms or d.p. and p.w. with 5, after 500 evaluations."""
    whole = identify.thesis(*trial())
    assert not any("converged" in each for each in whole.warnings)
    search = optimize.least_squares

    def short(*arguments, **options):
        return search(*arguments, **options | {"max_nfev": 3})

    monkeypatch.setattr(optimize, "least_squares", short)
    fit = identify.thesis(*trial())
    touch, hold, *_ = fit.warnings
    assert touch == f"x0 = {fit.spring.x0:.4g} mm had not converged after 3 evaluations"
    assert hold.startswith("the 3 terms had not converged after 3 evaluations; they leave")
    assert f"leave {100 * (1 - fit.vaf_hold):.2g} % of the variance of the hold" in hold
    assert fit.prony.weights[0] == pytest.approx(whole.prony.weights[0], rel=0.1)


def test_a_hold_that_is_too_short_gets_a_warning():
    fit = identify.joint(*trial(seed=0, hold=0.8))
    assert any("slower than the hold" in sentence for sentence in fit.warnings)


@pytest.mark.parametrize("degree", range(5))
def test_the_derivative_is_exact_for_polynomials_on_unequal_points(degree):
    x = np.cumsum(np.random.default_rng(0).uniform(0.5, 1.5, 30)) / 10
    exact = degree * x ** max(degree - 1, 0)
    np.testing.assert_allclose(ramp_hold.derivative(x, x**degree), exact[2:-2], atol=1e-10)


def test_smoothing_keeps_straight_lines_and_reduces_noise_by_three():
    line = np.linspace(0, 1, 200)
    np.testing.assert_allclose(ramp_hold.smooth(line)[4:-4], line[4:-4], rtol=1e-12)
    noise = np.random.default_rng(0).normal(size=20_000)
    assert ramp_hold.smooth(noise).std() == pytest.approx(1 / 3, rel=0.05)


def test_accounted_variance_is_one_minus_the_mse_of_the_thesis():
    measured, model = np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 1.0, 2.0, 2.0])
    assert ramp_hold.accounted(measured, model) == pytest.approx(1 - 1 / 5)


def still(time, position, force):
    return time, np.zeros_like(position), force


BAD = {
    "no contact": (still, "position that changes"),
    "no hold": (lambda t, x, f: (t[:350], x[:350], f[:350]), "hold: expected at least 20"),
    "too few": (lambda t, x, f: (t[:30], x[:30], f[:30]), "at least 40 samples"),
    "backward": (lambda t, x, f: (-t, x, f), "times that increase"),
    "nan": (lambda t, x, f: (t, x, np.where(t > 1, np.nan, f)), "finite numbers"),
    "unequal": (lambda t, x, f: (t, x[1:], f), "one shape"),
    "few on the ramp": (lambda t, x, f: (t[::40], x[::40], f[::40]), "ramp in contact: expected"),
}


@pytest.mark.parametrize(("spoil", "message"), BAD.values(), ids=BAD)
@pytest.mark.parametrize("fit", [identify.thesis, identify.joint])
def test_a_record_that_cannot_be_used_gets_a_sentence(fit, spoil, message):
    with pytest.raises(ValueError, match=message):
        fit(*spoil(*trial(seed=None)))


def test_a_spring_that_softens_is_refused():
    time, position, _ = trial(seed=None)
    depth = np.maximum(position - 0.5, 0)
    with pytest.raises(ValueError, match="stiffness against force: expected a rising line"):
        identify.thesis(time, position, np.sqrt(depth))


@pytest.mark.parametrize(
    ("speed", "lead", "noise"), [(20, 0.0, 0.0), (20, 0.2, 2e-3), (30, 1.0, 0)]
)
def test_a_fast_term_that_the_hold_alone_does_not_show_is_found_on_the_ramp(
    speed: float, lead: float, noise: float
) -> None:
    """The hold let its rate run to infinity, and both columns went with it."""
    time = np.arange(0.0, lead + 1.5 / speed + 20.0, 1e-3)
    depth = np.clip((time - lead) * speed, 0.0, 1.5)
    prony = Prony((0.27, 0.4, 0.19, 0.14), (226.0, 8.6, 0.61))
    force = hereditary_integral(prony, time, Spring(1.162, 1.05).force(depth))
    force += np.random.default_rng(0).normal(0.0, 1.0, len(time)) * noise
    fit = identify.joint(time, depth, force)
    assert fit.spring.b == pytest.approx(1.162, rel=0.1)
    assert fit.spring.m == pytest.approx(1.05, rel=0.05)
    assert fit.prony.v == pytest.approx(prony.v, rel=0.1)
    assert np.isfinite(list(identify.thesis(time, depth, force).parameters.values())).all()
