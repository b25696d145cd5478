"""Dynamic stiffness of a vibration in a study, against a closed form."""

import cmath

import numpy as np
import pytest

import fefinger as ff
from fefinger.studies.force_depth import dynamic_stiffness


MOTION = ff.RampSinusoid(20.0, 1.0, amplitude=0.05, frequency=80.0, cycles=6, settle=0.1)


def test_it_is_the_complex_ratio_whatever_drifts() -> None:
    time = np.unique(np.concatenate([np.linspace(0, MOTION.duration, 1200), MOTION.breakpoints]))
    depth = MOTION.value(time)
    ratio = cmath.rect(1.7, np.radians(25.0))
    turned = np.imag(ratio * np.exp(2j * np.pi * 80.0 * (time - MOTION.trajectory.wave.start)))
    force = 0.5 + 0.3 * (MOTION.duration - time) + 0.05 * turned
    found = dynamic_stiffness(MOTION, time, depth, force)
    assert found == pytest.approx(ratio, rel=1e-6)


def test_it_is_none_without_a_vibration_and_where_contact_is_lost() -> None:
    time = np.linspace(0, MOTION.duration, 1200)
    depth = MOTION.value(time)
    assert dynamic_stiffness(ff.Ramp(20.0, 1.0), time, depth, depth) is None
    assert dynamic_stiffness(MOTION, time, depth, np.maximum(depth - 1.0, 0.0)) is None


@pytest.mark.parametrize(("start", "stop"), [(20.0, 80.0), (80.0, 20.0)])
def test_of_a_sweep_it_is_that_at_the_end(start: float, stop: float) -> None:
    sweep = ff.FrequencySweep(1.0, amplitude=0.05, start=start, stop=stop, seconds=4.0)
    time = np.unique(np.concatenate([np.linspace(0, sweep.duration, 8000), sweep.breakpoints]))
    depth = sweep.value(time)
    force = 1.0 + 1.7 * (depth - 1.0) + 0.001 * sweep.rate(time)
    found = dynamic_stiffness(sweep, time, depth, force)
    assert found == pytest.approx(1.7 + 0.002j * np.pi * stop, rel=0.05)
