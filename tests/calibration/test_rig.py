"""The rig of a record: its file, its low-pass, the noise of both channels, and model errors."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from fefinger.calibration import inverse, record_file, trace
from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.rig import Rig, lagged
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import Prony


PRONY = Prony((0.3, 0.42, 0.16, 0.12), (220.0, 9.0, 0.6))


def test_a_rig_is_read_from_its_file(tmp_path):
    file = tmp_path / "rig.toml"
    file.write_text("delay = [0.4, 0.1]\nlag = 1.5\nforce_noise = 12\n")
    rig = Rig.from_toml(file)
    assert rig == Rig(delay=(0.4, 0.1), lag=(1.5, 0.0), force_noise=12)
    assert [each.name for each in rig.unknowns()] == ["delay", "offset", "drift"]
    assert [each.name for each in rig.unknowns(" 2")] == ["delay", "offset 2", "drift 2"]
    assert rig.at({"delay": 0.5, "offset 2": 3.0}, " 2") == {
        **{"delay": 0.5, "lag": 1.5, "compliance": 0.0, "offset": 3.0, "drift": 0.0}
    }


BAD = {
    "a name": ("dely = 1", "dely"),
    "a text": ("delay = 'late'", "rig.delay"),
    "three": ("delay = [1, 2, 3]", "rig.delay"),
    "below 0": ("drift = [0, -1]", "rig.drift"),
    "no give": ("compliance = -0.1", "rig.compliance"),
    "no noise": ("force_noise = 0", "rig.force_noise"),
    "hardly any noise": ("position_noise = 1e-30", "rig.position_noise"),
    "a huge noise": ("force_noise = 1e30", "rig.force_noise"),
    "a huge mean": ("offset = -1e30", "rig.offset"),
    "a huge deviation": ("delay = [0, 1e30]", "rig.delay"),
    "a long list": (f"delay = {[0] * 10_000}", "rig.delay"),
    "no TOML": ("delay =", "--rig"),
}


@pytest.mark.parametrize(("text", "field"), BAD.values(), ids=BAD)
def test_a_rig_that_is_none_is_refused(tmp_path, text, field):
    file = tmp_path / "rig.toml"
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        Rig.from_toml(file)
    assert field in str(caught.value)
    assert len(str(caught.value)) < 300
    with refused("--rig"):
        Rig.from_toml(tmp_path / "none.toml")


def test_a_deviation_of_next_to_nothing_is_none():
    assert Rig(delay=(0.4, 1e-30)) == Rig(delay=0.4)


MORE = {
    "delay": (2000.0, 0.0),
    "lag": (2000.0, 0.0),
    "compliance": (5.0, 0.01),
    "offset": (1e5, 0.0),
    "drift": (0.0, 1e5),
}
NOISY = {"force_noise": 1e5, "position_noise": 50.0}


@pytest.mark.parametrize("name", MORE)
def test_a_rig_that_does_more_than_a_record_moves_is_refused_before_any_fit(name, law, monkeypatch):
    monkeypatch.setattr(record_file, "_lumped", None)
    with pytest.raises(InputError, match=rf"twin: rig\.{name}: expected a rig that does less than"):
        record_file.made("twin", *press(law), "coarse", Rig(**{name: MORE[name]}))


@pytest.mark.parametrize("name", NOISY)
def test_a_noise_as_large_as_a_record_is_refused_before_any_fit(name, law, monkeypatch):
    monkeypatch.setattr(record_file, "_lumped", None)
    with pytest.raises(InputError, match=rf"twin: rig\.{name}: expected less than the"):
        record_file.made("twin", *press(law), "coarse", Rig(**{name: NOISY[name]}))


def test_a_low_pass_answers_a_ramp_as_in_its_closed_form():
    time = np.linspace(0, 0.05, 51)
    lag = 0.007
    exact = time - lag * (1 - np.exp(-time / lag))
    np.testing.assert_allclose(lagged(time, time, lag), exact, atol=1e-12)
    assert lagged(time, time, 0.0) is time


def test_a_path_is_smoothed_as_far_as_its_noise_hides_and_no_further():
    rng, at = np.random.default_rng(0), np.linspace(0, 1, 120)
    sd = np.full(120, 0.01)
    for exact, freedom in ((at, 6), (at**3 - at, 12), (np.minimum(at, 0.5), 80)):
        smoother = trace.smoothing(at, exact + sd * rng.normal(size=120), sd)
        assert np.trace(smoother) < freedom
        np.testing.assert_allclose(smoother.sum(axis=1), 1.0, atol=1e-9)
        assert np.abs(smoother @ exact - exact).max() < 4 * sd[0]


def press(law, noise=0.0, seed=0):
    """Return time s, position mm and force N of a ramp and hold at 2 kHz, with position noise."""
    time = np.arange(0.0, 1.0, 5e-4)
    path = np.clip(60 * (time - 0.02), 0.0, 1.8)
    force = ForceLaw(law.at(2.4, 14.0), PRONY, 0.7).loading(time, path - 0.4)
    rng = np.random.default_rng(seed)
    measured = force + 3e-3 * rng.normal(size=len(time))
    return time, path + noise * rng.normal(size=len(time)), measured


def test_noise_of_the_position_has_the_covariance_that_draws_have(law):
    """Through smoothing, the slope of the force, and the memory of the tissue: 300 draws."""
    one = ForceLaw(law.at(2.4, 14.0), PRONY, 0.7)
    target = record_file.made("twin", *press(law, 0.01), "coarse", Rig(delay=(1.0, 0.0)))
    values = {"x0": 0.4}
    found = target._noise(one, values) - target.force_noise.covariance(target.trace.size)
    spread = np.linalg.cholesky(target.trace.spread + 1e-14 * np.eye(len(target.trace.path)))
    rng, here = np.random.default_rng(1), target.model(one, values)
    draws = []
    for _ in range(300):
        moved = target.trace.path + spread @ rng.normal(size=len(spread))
        draws.append(target_at(target, moved).model(one, values) - here)
    drawn = np.cov(np.array(draws).T)
    scale = float(np.abs(drawn).max())
    assert scale > (2 * target.force_noise.sd**2 / target.trace.size).min()
    assert np.abs(found - drawn).max() < 0.35 * scale


def target_at(target, path):
    return replace(target, trace=replace(target.trace, path=path))


@pytest.mark.parametrize("sizes", [(0.02, 1e-3), (1e-3, 0.02)])
def test_the_size_of_a_model_error_is_found_from_what_it_leaves(sizes):
    """Drawn, with a line fitted through: 400 data, whose line is no error of the model."""
    rng, at = np.random.default_rng(3), np.linspace(0, 1, 400)
    apart = np.abs(np.subtract.outer(at, at))
    kernels = [np.exp(-apart / 0.1), np.exp(-apart / 0.02)]
    base = 1e-6 * np.eye(400)
    whole = base + sum(s**2 * k for s, k in zip(sizes, kernels, strict=True))
    line = np.column_stack([np.ones(400), at])
    data = np.linalg.cholesky(whole) @ rng.normal(size=400) + line @ [0.0, 3.0]
    none = np.zeros(2)
    found = inverse.sizes(data, line, none, none, base, kernels, (1e-3, 1e-3))
    np.testing.assert_allclose(np.log(found), np.log(sizes), atol=0.3)  # 1 / sqrt(2 x 10)


PRESSES = {
    "relaxes within samples": (800.0, 2e3, 0.76, 66.0),
    "corner within an average": (200.0, 1e4, -2.03, 10.0),
}
"""Fastest rate 1/s, samples per s, delay ms and speed mm/s."""


@pytest.mark.parametrize(("v1", "rate", "delay", "speed"), PRESSES.values(), ids=PRESSES)
def test_a_model_of_the_truth_meets_the_averages_without_noise(law, v1, rate, delay, speed):
    true = ForceLaw(law.at(2.4, 14.0), Prony((0.3, 0.42, 0.16, 0.12), (v1, 9.0, 0.6)), 0.7)
    touch, corner = 0.1, 0.1 + 1.4 / speed
    fine = np.union1d(np.linspace(touch, corner, 4000), corner + np.geomspace(1e-6, 1.0, 4000))
    force = true.loading(fine, speed * np.minimum(fine - touch, corner - touch))
    time = np.arange(0.0, 1.0, 1 / rate)
    seen = np.interp(time - 1e-3 * delay, np.append(0.0, fine), np.append(0.0, force))
    path = np.clip(speed * (time - touch) + 1.5, 0.0, 2.9)
    target = record_file.made("twin", time, path, seen, "coarse", Rig(delay=(delay, 0.0)))
    off = np.abs(target.model(true, {"x0": 1.5}) - target.force)
    assert off.max() < 1e-3 * force.max()


def test_a_corner_is_found_where_noise_puts_the_first_of_a_hold_before_it():
    time = np.concatenate([np.linspace(0.0, 0.9, 10), [0.97, 1.07, 1.2, 1.4]])
    path = np.append(time[:10], np.ones(4))
    at, to_nodes = trace._nodes(time, path, 10)
    np.testing.assert_allclose(to_nodes @ path, np.minimum(at, 1.0), atol=1e-5)
