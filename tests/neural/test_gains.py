"""The stored gains are what their rule computes."""

import pytest
from fefinger.validation.neural.gains import THRESHOLDS, responds, threshold_gain

from fefinger.neural.generators import GAINS
from fefinger.support.vocabulary import TYPES


@pytest.mark.parametrize("kind", TYPES)
def test_stored_gain_is_the_computed_one_to_its_digits(kind):
    assert 0.0 <= GAINS[kind] / threshold_gain(kind, digits=1e-5) - 1.0 < 1e-3


@pytest.mark.parametrize("kind", TYPES)
def test_the_response_begins_at_the_gain(kind):
    assert responds(kind, GAINS[kind])
    assert responds(kind, 1.01 * GAINS[kind])
    assert not responds(kind, 0.99 * GAINS[kind])


def test_every_type_states_source_and_confidence():
    assert tuple(THRESHOLDS) == tuple(GAINS) == TYPES
    assert all(threshold.source and threshold.confidence for threshold in THRESHOLDS.values())
