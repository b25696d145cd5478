"""What goes to and fro in a record, and what of it is noise of the recorder."""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, lfilter

import fefinger as ff
from fefinger.mechanics.evidence import vibration
from fefinger.mechanics.situation import Situation
from fefinger.scene.oscillation import white_noise
from fefinger.support.arrays import Array


PEAK, LONG = 2.6, 0.4  # N, s


def pulse(time: Array) -> Array:
    return PEAK * np.exp(-(((time - 0.08) / 0.03) ** 2))


def drawn(size: int, cutoff: float | None, rate: float, sigma: float) -> Array:
    """Noise of a root mean square, white or from a filter of fourth order."""
    noise = np.random.default_rng(3).normal(0.0, 1.0, size)
    if cutoff is not None:
        noise = lfilter(*butter(4, cutoff, fs=rate), noise)
    return sigma * noise / noise.std()


def recorded(time: Array, force: Array, *, clipped: bool = True) -> ff.Sampled:
    force = np.maximum(force, 0.0) if clipped else force
    return ff.Sampled(tuple(time.tolist()), force=tuple(force.tolist()))


@pytest.mark.parametrize("cutoff", [None, 200.0, 100.0])
@pytest.mark.parametrize("rate", [500, 1000, 5000])
@pytest.mark.parametrize("sigma", [0.01, 0.03, 0.1])
def test_noise_of_a_force_is_no_vibration_and_is_judged_by_its_size(
    rate: int, sigma: float, cutoff: float | None
) -> None:
    time = np.arange(0.0, LONG, 1 / rate)
    motion = recorded(time, pulse(time) + drawn(len(time), cutoff, rate, sigma))
    assert motion.highest_frequency is None
    case = Situation.of(ff.Scene(finger=ff.Finger.subject("a.h."), motion=motion))
    error, _ = vibration.left_out(case)
    assert error < 1.5 * np.sqrt(2) * sigma / PEAK  # the highest of the noise is in the peak too
    if sigma == 0.1 and cutoff is None:  # of noise about 0 half is left
        assert error > 0.5 * np.sqrt(2) * sigma / PEAK


@pytest.mark.parametrize("frequency", [50.0, 150.0])
@pytest.mark.parametrize("rate", [1000, 5000])
def test_a_vibration_is_found_beneath_white_noise(rate: int, frequency: float) -> None:
    time, amplitude, sigma = np.arange(0.0, LONG, 1 / rate), 0.05, 0.01
    held = np.minimum(time / 0.05, 1.0)
    swing = amplitude * np.sin(2 * np.pi * frequency * time) * (time > 0.1)
    motion = recorded(time, held + swing + drawn(len(time), None, rate, sigma))
    assert motion.highest_frequency == pytest.approx(frequency, rel=0.15)
    assert motion.noise == pytest.approx(sigma, rel=0.2)


@pytest.mark.parametrize("size", [0.004, 0.03])
def test_a_faint_vibration_that_starts_after_the_press_is_one(size: float) -> None:
    """As a waveform of a file about its preload is."""
    time = np.arange(0.0, LONG, 2e-4)
    texture = drawn(len(time), 300.0, 5000.0, size) * (time > 0.2)
    depth = 0.4 * (1 - np.cos(np.pi * np.minimum(time / 0.1, 1.0))) + texture
    motion = ff.Sampled(tuple(time.tolist()), tuple(depth.tolist()))
    assert motion.highest_frequency is not None
    assert motion.noise < 0.05 * size


def test_the_size_of_white_noise_is_told_beside_a_press_and_a_vibration() -> None:
    time = np.arange(0.0, 1.0, 1e-3)
    press = np.minimum(time / 0.2, 1.0) + 0.3 * np.sin(2 * np.pi * 80 * time)
    noise = drawn(len(time), None, 1000.0, 0.02)
    assert white_noise(press + noise) == pytest.approx(0.02, rel=0.1)
    assert white_noise(press) < 1e-3


def test_noise_is_no_sudden_press(monkeypatch: pytest.MonkeyPatch) -> None:
    time, cycle = np.arange(0.0, LONG, 1e-3), 1 / 400
    motion = recorded(time, pulse(time) + drawn(len(time), None, 1000.0, 0.1))
    assert vibration.suddenness(motion, cycle) < 0.2
    monkeypatch.setattr(vibration, "NOISY", 0.0)
    assert vibration.suddenness(motion, cycle) > 0.4


def test_a_press_is_linear_about_its_peak_and_a_vibration_about_its_preload() -> None:
    """`modal` presses tissue that stiffens as the linear finger there, which is softer above."""
    time = np.arange(0.0, LONG, 1e-3)
    noise = drawn(len(time), None, 1000.0, 0.03)
    smooth, noisy = (recorded(time, pulse(time) + each) for each in (0.0 * noise, noise))
    assert smooth.steady_level == pytest.approx(PEAK, rel=1e-3)
    assert noisy.steady_level == pytest.approx(PEAK, rel=0.03)
    swing = 0.2 * np.sin(2 * np.pi * 60 * time) * (time > 0.1)
    held = recorded(time, np.minimum(time / 0.05, 1.0) + swing)
    assert held.steady_level == pytest.approx(1.0, rel=0.02)


def test_inertia_changes_the_depth_under_a_noisy_force_by_less_than_the_noise_adds(
    operators: Path,
) -> None:
    sigma, time = 0.03, np.arange(0.0, 0.2, 2e-3)
    scene = ff.Scene(
        finger=ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse"),
        motion=recorded(time, pulse(time) / PEAK + drawn(len(time), None, 500.0, sigma / PEAK)),
        ask=ff.Ask(pressure=False, strain=False, fields=False),
    )
    without, moving = (
        np.interp(time, found.time, found.depth)
        for found in (ff.run(scene, mechanics=name) for name in ("condensed", "modal"))
    )
    change = float(np.abs(moving - without).max() / without.max())
    stated, source = vibration.left_out(Situation.of(scene))
    assert 0.1 * stated < change < stated < 0.02
    assert "noise of 0.0" in source
