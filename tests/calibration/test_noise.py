"""Noise that samples share with their neighbors: in averages, and as a record shows it."""

import numpy as np
import pytest
from scipy.signal import lfilter

from fefinger.calibration.noise import Noise, estimated, of_hold, white
from fefinger.theory.lumped.ramp_hold import split


def of_first_order(kept, count, rng):
    """Draw noise (n,) of variance 1 whose autocovariance is kept^lag."""
    begun = rng.normal(size=count + 1000)
    return lfilter([np.sqrt(1 - kept**2)], [1, -kept], begun)[1000:]


def mean_of_first_order(kept, count):
    """Return the standard deviation of its mean over `count` samples: a geometric series."""
    twice = 2 * kept * (1 - kept**count) / (1 - kept) ** 2
    return np.sqrt(count * (1 + kept) / (1 - kept) - twice) / count


@pytest.mark.parametrize("count", [1, 10, 300])
def test_an_average_of_noise_of_first_order_has_the_deviation_of_its_closed_form(count):
    noise = Noise(0.9 ** np.arange(400))
    assert noise.of_average(count) == pytest.approx(mean_of_first_order(0.9, count), rel=1e-9)
    assert noise.scaled(3.0).of_average(count) == pytest.approx(3 * noise.of_average(count))
    assert white(0.5).of_average(count) == pytest.approx(0.5 / np.sqrt(count))


def test_averages_of_unequal_length_have_the_covariance_of_all_pairs_of_their_samples():
    size = np.array([1, 3, 20, 2])
    averaging = np.repeat(np.eye(4), size, axis=1) / size[:, None]
    apart = np.abs(np.subtract.outer(np.arange(26), np.arange(26)))
    noise = Noise(2.0 * 0.8 ** np.arange(40))
    exact = averaging @ (2.0 * 0.8**apart) @ averaging.T
    np.testing.assert_allclose(noise.covariance(size), exact, atol=1e-12)
    np.testing.assert_allclose(white(0.5).covariance(size), np.diag(0.25 / size), atol=1e-15)


@pytest.mark.parametrize("kept", [0.7, 0.98])
def test_noise_of_first_order_is_found_in_what_a_record_shows_of_it(kept):
    """In the median of 20 records, of 400 samples at rest and 12 000 held; one scatters by 40 %."""
    rng, counts = np.random.default_rng(5), (1, 30, 300)
    found = [
        estimated([of_first_order(kept, n, rng) for n in (400, 12_000)], 12_500, 1.0)
        for _ in range(20)
    ]
    for count in counts:
        middle = np.median([each.of_average(count) for each in found])
        assert middle == pytest.approx(mean_of_first_order(kept, count), rel=0.25)
        assert middle > 1.5 / np.sqrt(count) or count == 1  # white noise would be surer


def test_white_noise_on_a_relaxing_force_counts_as_white():
    rng, time = np.random.default_rng(2), np.arange(0.0, 4.0, 4e-4)
    for _ in range(5):
        path = np.clip(60 * (time - 0.2), 0.0, 1.8)
        force = np.where(time > 0.23, 0.4 + 0.6 * np.exp(-9 * (time - 0.23)), 0.0)
        force += np.where(time <= 0.23, np.clip((time - 0.2) / 0.03, 0, 1), 0.0)
        record = split(time, path, force + 0.01 * rng.normal(size=len(time)))
        found = estimated([record.force[:200], of_hold(record)], len(time), 0.02)
        assert not found.colored
        assert found.sd == 0.02
    assert not estimated([np.zeros(5)], 10, 0.02).colored
