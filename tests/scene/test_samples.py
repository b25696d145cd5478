"""Motions of samples: the band that they vibrate in, uneven times, gaps, noise and WAV files."""

import re
import wave
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.mechanics import modal
from fefinger.mechanics.evidence import vibration
from fefinger.mechanics.situation import Situation
from fefinger.results import key_numbers
from fefinger.scene.cautions import missing, noise, samples, warnings
from fefinger.support import inputs
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


RATE, HUM = 4000, 150.0  # Hz


def sampled(time: Array, depth: Array) -> ff.Sampled:
    return ff.Sampled(tuple(time.tolist()), tuple(depth.tolist()))


def hum(time: Array) -> Array:
    """Depth in mm: a ramp, and from 0.2 s on a vibration about its end."""
    swing = 0.03 * np.sin(2 * np.pi * HUM * (time - 0.2))
    return np.minimum(time / 0.1, 1.0) * 0.8 + np.where(time > 0.2, swing, 0.0)


def press(time: Array, seconds: float) -> Array:
    """Depth in mm: a ramp of some seconds with sharp corners, and a rest."""
    return np.minimum(time / seconds, 1.0)


def test_uneven_samples_vibrate_as_even_ones() -> None:
    time = np.arange(0.0, 0.4, 1 / RATE)
    even = sampled(time, hum(time))
    scatter = np.random.default_rng(0).uniform(-0.2, 0.2, len(time)) / RATE
    scatter[0] = 0.0
    uneven = sampled(time + scatter, hum(time + scatter))
    assert HUM < even.highest_frequency < 1.5 * HUM
    assert uneven.highest_frequency == pytest.approx(even.highest_frequency, rel=0.1)
    assert uneven.oscillation_amplitude == pytest.approx(even.oscillation_amplitude, rel=0.05)
    assert uneven.sample_rate == pytest.approx(RATE, rel=0.01)
    middle = np.linspace(0.25, 0.35, 50)
    assert uneven.vibration(middle) == pytest.approx(even.vibration(middle), abs=2e-3)


@pytest.mark.parametrize("seconds", [0.05, 0.2, 1.0])
@pytest.mark.parametrize("rate", [1000, 5000])
def test_the_corners_of_a_ramp_are_no_vibration(rate: int, seconds: float) -> None:
    time = np.arange(0.0, 2.0, 1 / rate)
    back = np.minimum(press(time, seconds), press(2.0 - time, seconds))
    for depth in (press(time, seconds), back):
        motion = sampled(time, depth)
        assert motion.highest_frequency is None
        assert motion.noise == 0.0
        assert warnings(motion) == ()


def test_a_triangle_vibrates_near_its_own_frequency_and_not_at_its_corners() -> None:
    time = np.arange(0.0, 2.0, 5e-4)
    motion = sampled(time, 0.5 + 0.1 * (2 * np.abs(2 * ((4 * time) % 1) - 1) - 1))
    assert 4.0 <= motion.highest_frequency < 20.0


@pytest.mark.parametrize(("rate", "seconds"), [(2000, 0.1), (1000, 1.0)])
def test_noise_of_a_record_is_no_vibration(rate: int, seconds: float) -> None:
    time, scatter = np.arange(0.0, 2.0, 1 / rate), 1e-3  # mm
    recorded = press(time, seconds) + np.random.default_rng(1).normal(0.0, scatter, len(time))
    recorded[0] = 3e-4
    motion = sampled(time, recorded)
    assert motion.highest_frequency is None
    assert warnings(motion) == ()
    if seconds == 1.0:  # a steeper ramp has corners above the noise
        assert motion.noise == pytest.approx(scatter, rel=0.2)
        (note,) = noise(motion)
        assert "taken for noise" in note
    scene = ff.Scene(finger=ff.Finger.subject("a.h."), motion=motion, ask=ff.Ask(rel_error=0.1))
    assert ff.choose(scene).mechanics == "pressed"


def test_a_gap_in_a_vibration_is_warned_of_and_a_rest_with_few_samples_is_not() -> None:
    time = np.arange(0.0, 0.4, 1 / RATE)
    kept = (time < 0.25) | (time > 0.27)
    (warning,) = warnings(sampled(time[kept], hum(time[kept])))
    assert "no samples from 0.2497 to 0.2702 s; a straight line joins them" in warning
    rested = (time < 0.12) | (time > 0.19)
    assert sampled(time[rested], hum(time[rested])).gaps == ()
    assert sampled(time[rested], hum(time[rested])).highest_frequency > HUM


def test_gaps_of_a_record_are_noted_and_level_rests_are_none() -> None:
    time = np.arange(0.0, 2.0, 1e-3)
    kept = (time < 0.5) | (time > 0.9)
    (note,) = missing(sampled(time[kept], press(time[kept], 1.0)))
    assert note == "The motion has no samples from 0.499 to 0.901 s; a straight line joins them."
    assert missing(sampled(time, press(time, 1.0))) == ()
    rested = (time < 1.2) | (time > 1.6)
    assert missing(sampled(time[rested], press(time[rested], 1.0))) == ()
    vibrated = np.arange(0.0, 0.4, 1 / RATE)
    left = vibrated[(vibrated < 0.25) | (vibrated > 0.27)]
    assert missing(sampled(left, hum(left))) == ()  # a warning says it


def test_gaps_of_a_record_are_noted_where_the_object_slides_at_one_depth() -> None:
    time = np.arange(0.0, 2.0, 1e-3)
    kept = time[(time < 0.5) | (time > 0.9)]
    still, level = (0.0,) * len(kept), (0.5,) * len(kept)
    slid = ff.SampledPath(tuple(kept.tolist()), tuple((5 * kept).tolist()), still, depth=level)
    (note,) = missing(slid)
    assert "no samples from 0.499 to 0.901 s" in note
    assert missing(replace(slid, x=still)) == ()


def test_a_poor_record_is_a_caution_beside_the_answer(synthetic: ff.Result) -> None:
    time = np.arange(0.0, 2.0, 1e-3)
    noisy = press(time, 1.0) + np.random.default_rng(1).normal(0.0, 2e-3, len(time))
    noisy[0] = 0.0
    kept = (time < 0.5) | (time > 0.9)

    def cautions(depth: Array, *spikes: str) -> list[str]:
        scene = replace(
            synthetic.scene,
            motion=sampled(time[kept], depth[kept]),
            ask=replace(synthetic.scene.ask, spikes=spikes),
        )
        return key_numbers.cautions(replace(synthetic, scene=scene))

    cause, noise_, gap = cautions(noisy, "FAII")
    assert re.match(r"the samples of the motion have noise of 0.0\d+ mm .*, which FAII may", noise_)
    assert gap.startswith("the motion has no samples from 0.499 to 0.901 s")
    assert cautions(noisy, "SAI") == [gap]
    assert cautions(press(time, 1.0), "FAII") == [cause, gap]


def test_noise_of_a_force_about_zero_counts_as_none() -> None:
    time = np.arange(0.0, 2.0, 1e-3)
    force = np.maximum(time - 0.5, 0.0)
    scatter = np.clip(np.random.default_rng(2).normal(0.0, 3e-3, len(time)), -0.02, 0.02)
    scatter[0] = -8e-3
    motion = ff.Sampled(tuple(time.tolist()), force=tuple((force + scatter).tolist()))
    assert motion.value(0.0) == motion.trajectory.value(0.0) == 0.0
    assert motion.value(time) == pytest.approx(np.maximum(force + scatter, 0.0), abs=1e-12)
    *_, note = samples(motion)
    assert note.startswith("The samples of the force go down to -0.00")
    assert not any("go down" in each for each in samples(sampled(time, force - 0.01)))


@pytest.mark.parametrize(
    ("depth", "accepted"),
    [
        ([0.2, -1.0, -1.0, 0.2], False),
        ([0.0, -1.0, -1.0, 0.0], False),
        ([0.0, 0.004, -1.0, 0.0], False),
        ([0.1, -0.5], False),
        ([-10.0, 0.05, -10.0], True),  # from far off the skin, and back
        ([0.0, 1.0, -5.0], True),
        ([0.0, 0.4, -0.2], True),
    ],
)
def test_a_press_with_the_other_sign_is_refused(depth: list[float], accepted: bool) -> None:
    time = tuple(range(len(depth)))
    if accepted:
        assert ff.Sampled(time, tuple(depth)).peak == max(depth)
        return
    with refused("motion.depth"):
        ff.Sampled(time, tuple(depth))


def test_a_vibration_from_first_touch_is_no_sudden_press() -> None:
    finger = ff.Finger.subject("a.h.", tissue="calibrated_ah_viscous")
    motion = ff.Sinusoid(0.4, 150, 20)
    assert vibration.suddenness(motion, 1e-3) == pytest.approx(0.0, abs=1e-9)
    case = Situation.of(ff.Scene(finger=finger, motion=motion))
    assert modal.refuse(case) == ()
    time = np.arange(0.0, 0.4, 1 / RATE)
    ramp = 8.0 * 1e-3 / 8 / 0.83  # the change of speed in an eighth of a cycle, over peak / cycle
    assert vibration.suddenness(sampled(time, hum(time)), 1e-3) < 2 * ramp * 8


def test_beyond_the_modes_nothing_of_the_oscillation_is_known() -> None:
    def error(frequency: float) -> float:
        motion = ff.RampSinusoid(20, 1.0, amplitude=0.01, frequency=frequency, cycles=20)
        finger = ff.Finger.subject("a.h.", tissue="maeno1998_viscous")
        return vibration.vibration_error(Situation.of(ff.Scene(finger=finger, motion=motion)))

    assert error(200.0) < 0.1
    assert error(5000.0) == 1.0


def write(path: Path, width: int, channels: int, samples: Array) -> Path:
    """Write samples (n, channels) from -1 to 1 as a WAV file of some bytes per sample."""
    whole = np.round(samples * (2 ** (8 * width - 1) - 1)).astype(np.int64).ravel()
    data = b"".join(int(value).to_bytes(width, "little", signed=True) for value in whole)
    with wave.open(str(path), "wb") as file:
        file.setnchannels(channels)
        file.setsampwidth(width)
        file.setframerate(8000)
        file.writeframes(data)
    return path


@pytest.mark.parametrize("width", [2, 3, 4])
@pytest.mark.parametrize("channels", [1, 2])
def test_a_wave_file_of_any_width_and_channels_is_its_first_channel(
    tmp_path: Path, width: int, channels: int
) -> None:
    sound = 0.5 * np.sin(2 * np.pi * 200 * np.arange(800) / 8000)
    both = np.stack([sound, -sound], axis=1)[:, :channels]
    motion = ff.Sampled.from_wav(
        write(tmp_path / "hum.wav", width, channels, both), amplitude=0.02, preload=0.8, settle=0.1
    )
    played = motion.value(0.2 + np.arange(800) / 8000)
    assert played == pytest.approx(0.8 + 0.02 * sound, abs=0.02 * 2.0 ** (2 - 8 * width) + 1e-12)


def test_a_wave_file_of_one_sample_is_refused(tmp_path: Path) -> None:
    file = write(tmp_path / "one.wav", 2, 1, np.array([[0.5]]))
    with pytest.raises(InputError, match="expected 2 to 4000000 samples, received 1"):
        ff.Sampled.from_wav(file, amplitude=0.02, preload=0.8)


def test_a_wave_file_with_a_broken_chunk_is_said(tmp_path: Path) -> None:
    file = write(tmp_path / "cut.wav", 2, 1, np.full((9, 1), 0.5))
    file.write_bytes(file.read_bytes().replace(b"data", b"dat\xff"))
    with pytest.raises(InputError, match="a chunk of it is broken"):
        ff.Sampled.from_wav(file, amplitude=0.02, preload=0.8)


def test_a_wave_file_of_hours_is_refused_before_it_is_read(tmp_path: Path, monkeypatch) -> None:
    file = write(tmp_path / "hum.wav", 2, 1, np.full((9, 1), 0.5))
    with monkeypatch.context() as patch:
        patch.setattr(inputs, "MOST", 8)
        with pytest.raises(InputError, match="expected 2 to 8 samples, received 9"):
            ff.Sampled.from_wav(file, amplitude=0.02, preload=0.8)
    with file.open("r+b") as opened:
        opened.truncate(65_000_000)  # sparse
    monkeypatch.setattr("scipy.io.wavfile.read", None)
    with pytest.raises(InputError, match="at most 64 MB"):
        ff.Sampled.from_wav(file, amplitude=0.02, preload=0.8)


def test_a_key_of_another_kind_of_motion_names_that_kind() -> None:
    sweep = "kind = 'sweep'\nforce = 0.8\namplitude = 0.02\nstart = 20\nstop = 300"
    text = f"[finger]\nsubject = 'a.h.'\n[motion]\n{sweep}"
    with pytest.raises(InputError, match=r"motion\.force is a key of .*'force-sweep'"):
        ff.Scene.from_toml(text)
