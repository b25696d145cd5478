"""The stored gains are what their rule computes."""

import numpy as np
import pytest
from fefinger.validation.neural.gains import responds, threshold_gain

from fefinger.neural.gains import GAINS, RAMP_SPEED, THRESHOLDS
from fefinger.neural.units import simulate_units
from fefinger.support.vocabulary import TYPES


@pytest.mark.parametrize("kind", TYPES)
def test_stored_gain_is_the_computed_one_to_its_digits(kind):
    assert 0.0 <= GAINS[kind] / threshold_gain(kind, digits=1e-5) - 1.0 < 1e-3


@pytest.mark.parametrize("kind", TYPES)
def test_the_response_begins_at_the_gain(kind):
    assert responds(kind, GAINS[kind])
    assert responds(kind, 1.01 * GAINS[kind])
    assert not responds(kind, 0.99 * GAINS[kind])


@pytest.mark.parametrize(
    ("depth", "lowest", "highest"),
    [(0.1, 0.0, 0.0), (0.2, 0.0, 10.0), (0.5, 0.0, 15.0), (1.0, 10.0, 30.0)],
)
def test_sustained_rates_of_sai_lie_in_the_published_range(depth, lowest, highest):
    """Noise-free rates of TouchSim's SA1 units under pins of 0.5 and 1 mm."""
    time = np.array([0.0, depth / RAMP_SPEED, depth / RAMP_SPEED + 3.0])
    shape = np.minimum(time, time[1])[:, None]
    (times,) = simulate_units(time, shape * RAMP_SPEED, types=("SAI",)).times
    assert lowest <= np.sum(times > time[-1] - 1.0) <= highest


def test_every_type_states_source_and_confidence():
    assert tuple(THRESHOLDS) == tuple(GAINS) == TYPES
    assert all(threshold.source and threshold.confidence for threshold in THRESHOLDS.values())
