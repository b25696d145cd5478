"""Records as instruments write them: rates, gaps, rounding, filters, and what they do to a fit."""

from collections.abc import Callable

import numpy as np
import pytest
from fefinger.validation.oracles import synthetic
from fefinger.validation.thesis.claims import two_pole

from fefinger.scene import library
from fefinger.support.arrays import Array
from fefinger.theory.lumped import identify, ramp_hold
from fefinger.theory.lumped.spring import Spring


Samples = tuple[Array, Array, Array]

SUBJECTS = {name: (Spring(row.b, row.m, 0.5), row.prony) for name, row in library.lumped().items()}


def trial(name: str = "a.h.", *, seed: int | None = 3, **options: float) -> Samples:
    made = synthetic.ramp_and_hold(*SUBJECTS[name], seed=seed, **options)
    return made.time, made.position, made.force


def scores(fit: identify.Identification, name: str = "a.h.") -> dict[str, float]:
    """Return by how many of its deviations every parameter is off."""
    truth = identify.Identification(*SUBJECTS[name], {}, 0.0, 1.0).parameters
    return {k: (v - truth[k]) / fit.uncertainty[k] for k, v in fit.parameters.items()}


def corner(position: Array) -> int:
    return int(np.argmax(position > position[-100:].mean() - 0.01))


def kept(chosen: Callable[[Array, float], Array]) -> Samples:
    """Return the samples of a trial that are `chosen` by their times and that of the corner."""
    time, position, force = trial()
    these = chosen(time, time[corner(position)])
    return time[these], position[these], force[these]


@pytest.mark.parametrize("rate", [100, 20, 10])
def test_a_hold_that_is_sampled_slowly_later_on_is_averaged_by_time(rate: int) -> None:
    """By their number, groups of the tail spanned seconds: v3 was 65 deviations off."""

    def slower(time: Array, end: float) -> Array:
        return (time < end + 0.5) | (np.arange(len(time)) % (10_000 // rate) == 0)

    fit = identify.joint(*kept(slower))
    assert max(map(abs, scores(fit).values())) < 2
    assert fit.warnings == ()


def test_a_second_without_samples_in_the_hold_costs_nothing_else() -> None:
    fit = identify.joint(*kept(lambda time, end: (time < end + 0.5) | (time > end + 2.5)))
    assert max(map(abs, scores(fit).values())) < 3
    assert fit.warnings == ()


@pytest.mark.parametrize(("before", "after"), [(0.005, 0.005), (0.0, 0.02), (0.02, 0.1)])
def test_samples_that_are_missing_at_the_corner_are_told(before: float, after: float) -> None:
    """Seven deviations off without a word, or an error from within the search."""
    data = kept(lambda time, end: (time < end - before) | (time > end + after))
    fit = identify.joint(*data)
    (message,) = (each for each in fit.warnings if "no samples from" in each)
    assert "about the corner of the ramp" in message


@pytest.mark.parametrize(("step", "noise"), [(0.012, 0.0), (0.012, 1.0), (0.005, 0.0)])
def test_a_force_in_steps_has_the_noise_of_its_rounding(step: float, noise: float) -> None:
    """It was taken to have none: all three terms were called not identified."""
    time, position, force = trial()
    exact = trial(seed=None)[2]
    rounded = np.round((exact + noise * (force - exact)) / step) * step
    record = ramp_hold.split(time, position, rounded)
    assert record.force_noise >= 0.99 * step / np.sqrt(12)
    fit = identify.joint(time, position, rounded)
    assert max(map(abs, scores(fit).values())) < 3.5
    assert fit.warnings == ()


@pytest.mark.parametrize("step", [0.005, 0.01])
def test_a_position_in_steps_is_no_position_without_noise(step: float) -> None:
    """14 deviations off, or refused for positions that do not differ."""
    time, position, force = trial()
    fit = identify.joint(time, np.round(position / step) * step, force)
    assert max(map(abs, scores(fit).values())) < 3.5


def test_an_even_ramp_without_noise_is_not_taken_for_a_rounded_one() -> None:
    record = ramp_hold.split(*trial(seed=None))
    assert max(record.force_noise, record.position_noise) < 1e-5


@pytest.mark.parametrize("cutoff", [200.0, 1000.0])
def test_noise_that_went_through_a_filter_counts_as_a_whole(cutoff: float) -> None:
    """From sample to sample there is hardly any of it: one fiftieth was seen at 200 Hz."""
    time, position, force = trial()
    exact = trial(seed=None)[2]
    noise = two_pole(time, force - exact, cutoff)
    record = ramp_hold.split(time, position, exact + noise)
    assert record.force_noise == pytest.approx(np.std(noise), rel=0.1)
    fit = identify.joint(time, position, exact + noise)
    assert max(map(abs, scores(fit).values())) < 3.5
    assert fit.warnings == ()


def late(time: Array, force: Array) -> Array:
    return np.asarray(np.interp(time - 5e-4, time, force))


@pytest.mark.parametrize(
    ("spoil", "terms"),
    [
        (lambda t, f: f, 2),
        (late, 3),
        (lambda t, f: f + 0.05 * t, 3),
    ],
    ids=["a term too few", "force behind position", "drift"],
)
def test_a_model_that_misses_the_record_says_so(
    spoil: Callable[[Array, Array], Array], terms: int
) -> None:
    time, position, force = trial()
    fit = identify.joint(time, position, spoil(time, force), terms=terms)
    assert any(each.startswith("the model misses the record by") for each in fit.warnings)


@pytest.mark.parametrize("rate", [5e3, 1e4])
def test_the_line_of_a_ramp_of_many_samples_is_as_sure_as_of_few(rate: float) -> None:
    """Beyond 400 samples it was of hardly smoothed ones: seven of ten such ramps were refused."""
    few, many = (
        identify.thesis(*trial("d.p.", speed=10.0, hold=3.0, sample_rate=each))
        for each in (2e3, rate)
    )
    assert many.spring.b == pytest.approx(few.spring.b, abs=0.03)
    assert many.uncertainty["b"] < 1.5 * few.uncertainty["b"]


def test_a_search_that_looks_good_enough_is_still_compared() -> None:
    """It ended at half of its error, 72 deviations off in b, where smoothing had made it small."""
    data = trial("p.w.", speed=10.0, sample_rate=2e3, hold=2.0, peak_force=5.0, seed=35)
    fit = identify.joint(*data)
    assert max(map(abs, scores(fit, "p.w.").values())) < 3.5


@pytest.mark.parametrize("seed", [104, 105])
def test_a_ramp_that_hides_the_fast_term_is_told_though_the_term_looks_slow(seed: int) -> None:
    """The noise that hides it makes its rate small, with which the ramp seemed fast enough."""
    data = trial("d.s.", speed=10.0, sample_rate=2e3, hold=2.0, peak_force=5.0, seed=seed)
    assert any("ramp faster" in each for each in identify.joint(*data).warnings)


def test_a_record_without_a_line_is_fitted_from_a_typical_finger(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The line is a start alone; of a finger that begins without stiffness there may be none."""
    data = trial()
    usual = identify.joint(*data)

    def none(record: ramp_hold.RampHold) -> None:
        raise ValueError

    monkeypatch.setattr(identify, "stiffness_line", none)
    fit = identify.joint(*data)
    assert fit.parameters == pytest.approx(usual.parameters, rel=1e-3)


def test_a_ramp_without_a_rest_gets_a_sentence() -> None:
    time = np.linspace(0.0, 2.0, 50)
    with pytest.raises(ValueError, match="hold: expected a rest of at least"):
        ramp_hold.split(time, time, np.maximum(time - 0.5, 0.0))


def test_an_indenter_that_goes_far_beyond_its_hold_gets_a_sentence() -> None:
    """At 1 kHz: there was an index out of bounds."""
    time = np.arange(0.0, 4.0, 1e-3)
    way = 3.0 * np.clip(time / 0.05, 0.0, 1.0)
    position = np.where(time > 0.05, 1.0 + 2.0 * np.exp(-(time - 0.05) / 0.02), way)
    force = Spring(0.2, 1.5, 0.3).force(position)
    with pytest.raises(ValueError, match="hold: expected at least 20 samples"):
        identify.thesis(time, position, force)
