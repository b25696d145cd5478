"""Warnings of motions that are too fast for statics, or start in contact."""

from dataclasses import replace

import numpy as np
import pytest

import fefinger as ff
from fefinger.scene.cautions import jump, quasistatic, wave_speed


def test_what_is_not_quasi_static_is_warned_of():
    ask = ff.Ask(pressure=False, strain=False, fields=False)
    soft = ff.Scene(
        finger=ff.Finger.subject("a.h.", tissue="maeno1998"), motion=ff.Ramp(60, 0.5), ask=ask
    )
    assert wave_speed(soft.finger) == pytest.approx(3390, abs=5)  # mm/s, at 34 kPa
    slow = ff.run(soft, mechanics="lumped")
    assert not [note for note in slow.notes if "quasi-static" in note]
    fast = ff.run(replace(soft, motion=ff.Ramp(1e4, 0.5, corner=0)), mechanics="lumped")
    (note,) = (note for note in fast.notes if "quasi-static" in note)
    assert "speed / wave speed = 10 / 3.39 m/s = 3 > 0.22" in note
    vibrating = replace(soft, motion=ff.Sinusoid(0.05, 200, 3))
    shaken = ff.run(vibrating, mechanics="lumped")
    (note,) = (note for note in shaken.notes if "quasi-static" in note)
    assert "frequency x thickness / wave speed = 200 Hz x 5 mm / 6.23 m/s = 0.16 > 0.05" in note
    still = quasistatic(soft, np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.5, 0.5]))
    assert still == ()  # a jump has no speed


def test_a_motion_that_starts_in_contact_is_warned_of() -> None:
    (message,) = jump(ff.Sampled((0.0, 0.1), (0.3, 0.5)))
    assert "starts at 0.3 mm, which the indenter reaches in a jump" in message
    assert (
        jump(ff.Sampled((0.0, 0.1), (0.0, 0.5))) == jump(ff.Sampled((0.0, 0.1), (-0.2, 0.5))) == ()
    )


def test_a_path_that_vibrates_across_the_travel_is_warned_of() -> None:
    time = np.arange(0.0, 0.2, 1 / 4000)
    finger = ff.Finger.subject("a.h.", tissue="maeno1998")

    def warned(x: np.ndarray, indenter: ff.Flat | ff.Grating) -> tuple[str, ...]:
        motion = ff.SampledPath(time.tolist(), x.tolist(), [0.0] * 800, depth=[0.5] * 800)
        scene = ff.Scene(finger=finger, indenter=indenter, motion=motion)
        return quasistatic(scene, time, motion.value(time))

    rough, shaken = ff.Flat(30, friction=0.5), 0.02 * np.sin(2 * np.pi * 200 * time)
    for indenter in (rough, ff.Grating(3, 1.5, 0.3)):
        (note,) = warned(shaken, indenter)
        assert "frequency x thickness / wave speed = 2" in note
    assert warned(shaken, ff.Flat(30)) == ()  # its surface stays where it is
    slide, noise = 20 * time, 1e-3 * np.random.default_rng(0).normal(size=800)
    assert warned(slide, rough) == warned(slide + noise, rough) == ()
