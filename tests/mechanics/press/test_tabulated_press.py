"""Relaxation about a preload, and the stiffness of a tabulated press there."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import fefinger as ff
from fefinger.contact.oscillators import complex_modulus
from fefinger.mechanics.press.tabulated_press import (
    PreloadRelaxation,
    TabulatedPress,
    about_preload,
)
from fefinger.theory.relaxation import creep_integral, hereditary_integral


STIFFNESS, SHARE, FREQUENCY = 2.0, 0.15, 20.0
TABULATED = 1.9
"""Stiffness of the press between its depths, where the finger has STIFFNESS."""

FINGER = ff.Finger.subject("a.h.", tissue="maeno1998")
PRONY = FINGER.prony


@dataclass(frozen=True)
class Linear:
    """A finger of constant stiffness, in place of a tabulated press."""

    press: Any
    table: Any

    def elastic_force(self, depth: np.ndarray) -> np.ndarray:
        """Force in N at depths in mm."""
        return TABULATED * np.clip(depth, 0.0, self.table.deepest)


def relaxation() -> PreloadRelaxation:
    table = Linear(SimpleNamespace(finger=FINGER), SimpleNamespace(deepest=3.0))
    return PreloadRelaxation(cast(TabulatedPress, table), SHARE, 1.0, STIFFNESS)


def amplitude(time: np.ndarray, values: np.ndarray) -> complex:
    """Complex amplitude against a sine over the last ten cycles, beside a straight line."""
    last = time >= time[-1] - 10 / FREQUENCY
    angle = 2 * np.pi * FREQUENCY * time[last]
    basis = np.column_stack([np.sin(angle), np.cos(angle), np.ones_like(angle), time[last]])
    found = np.linalg.lstsq(basis, values[last], rcond=None)[0]
    return complex(found[0], found[1])


def modulus() -> complex:
    weights = FINGER.prony.weights
    decaying = np.array(weights[1:]) / weights[0]
    return complex(complex_modulus(decaying, np.array(FINGER.prony.v), np.array([FREQUENCY]))[0])


def test_a_vibration_has_the_stiffness_of_the_finger_at_its_preload() -> None:
    about, small = relaxation(), 0.01
    motion = ff.RampSinusoid(20, 1.0, amplitude=small, frequency=FREQUENCY, cycles=60, settle=1.0)
    time = np.linspace(0, motion.duration, 40001)
    relaxed = hereditary_integral(PRONY, time, motion.value(time)) / PRONY.long_time
    tabulated = TABULATED * ((1 + SHARE) * relaxed - SHARE * motion.value(time))
    ratio = amplitude(time, tabulated + about.force(motion, time)) / amplitude(
        time, motion.vibration(time)
    )
    exact = STIFFNESS * ((1 + SHARE) * modulus() - SHARE)
    assert ratio == pytest.approx(exact, rel=1e-3)


def test_by_force_the_depth_is_that_of_the_inverse() -> None:
    about, small = relaxation(), 0.02
    sine = {"amplitude": small, "frequency": FREQUENCY, "cycles": 60}
    motion = ff.RampSinusoid(loading_rate=20, force=1.0, settle=1.0, **sine)
    time = np.linspace(0, motion.duration, 40001)
    prony = about_preload(FINGER, SHARE).prony
    tabulated = prony.long_time * creep_integral(prony, time, motion.value(time)) / TABULATED
    ratio = amplitude(time, tabulated + about.depth(motion, time)) / amplitude(
        time, motion.vibration(time)
    )
    exact = 1 / (STIFFNESS * ((1 + SHARE) * modulus() - SHARE))
    assert ratio == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("motion", [ff.RampHold(20, 1.0, hold=1), ff.Trapezoid(20, 1.0, hold=0)])
def test_a_motion_that_does_not_vibrate_is_left_as_it_is(
    motion: ff.RampHold | ff.Trapezoid,
) -> None:
    time = np.linspace(0, motion.duration, 101)
    assert not relaxation().force(motion, time).any()


def test_the_long_time_modulus_stays() -> None:
    before, after = FINGER.prony, about_preload(FINGER, SHARE).prony
    ratios = np.array(after.weights) / after.long_time * before.long_time / before.weights
    assert ratios == pytest.approx([1.0, *[1 + SHARE] * len(before.v)])
    assert after.v == before.v
