"""Spectra against closed forms: sinusoids, evenly spaced spikes, spikes at random."""

import numpy as np
import pytest

from fefinger.neural import signal_spectrum, spike_spectrum
from fefinger.support.checks import InputError


def at(spectrum, frequency):
    """Return the amplitudes at the frequency next to one in Hz."""
    return spectrum.amplitude[np.argmin(np.abs(spectrum.frequency - frequency))]


def test_sinusoids_have_their_amplitudes_beside_a_ramp_and_beside_larger_ones():
    rng = np.random.default_rng(1)
    time = np.unique(np.append([0.0, 2.0], rng.uniform(0, 2, 20_000)))
    waves = 3.0 * np.sin(2 * np.pi * 50 * time + 0.4) + 0.01 * np.sin(2 * np.pi * 131 * time)
    ramp = 7.0 + 20.0 * time
    found = signal_spectrum(time, np.column_stack([waves + ramp, ramp]), 0.5, 1.5)
    assert found.amplitude.shape == (len(found.frequency), 2)
    assert at(found, 50)[0] == pytest.approx(3.0, rel=0.01)
    assert at(found, 131)[0] == pytest.approx(0.01, rel=0.05)
    assert found.amplitude[:, 1].max() < 1e-9
    between = np.abs(found.frequency - 90) < 20
    assert found.amplitude[between, 0].max() < 2e-3


def test_a_line_between_two_frequencies_of_the_span_is_no_lower():
    time = np.arange(0, 0.5, 1e-4)
    found = signal_spectrum(time, np.cos(2 * np.pi * 41.0 * time), time[0], time[-1])
    assert found.amplitude.max() == pytest.approx(1.0, rel=0.01)
    assert found.frequency[found.amplitude.argmax()] == pytest.approx(41.0, abs=0.5)


def test_a_unit_that_fires_evenly_has_twice_its_rate_at_all_multiples():
    """Of a comb of pulses: r (1 + 2 cos 2 pi r t + 2 cos 4 pi r t + ...)."""
    spikes = np.arange(0.003, 2.0, 1 / 40)
    found = spike_spectrum([spikes], 0.5, 1.5)
    for multiple in (40, 80, 120, 480):
        assert at(found, multiple) == pytest.approx(80.0, rel=0.02)
    assert at(found, 60) < 1.0


def test_units_that_fire_in_turn_do_not_cancel_and_silent_ones_count():
    spikes = np.arange(0.003, 2.0, 1 / 40)
    found = spike_spectrum([spikes, spikes + 1 / 80, [], []], 0.5, 1.5)
    assert at(found, 40) == pytest.approx(80.0 / np.sqrt(2), rel=0.02)


def test_spikes_at_random_times_have_the_level_floor_of_their_number():
    """A Poisson process has the density 2 r per Hz; a Hann window of T s passes 1.5 / T Hz."""
    rng = np.random.default_rng(2)
    rate, length = 20.0, 1.0
    trains = [np.sort(rng.uniform(0, length, rng.poisson(rate * length))) for _ in range(50)]
    found = spike_spectrum(trains, 0.0, length)
    inside = (found.frequency > 5) & (found.frequency < 500)
    floor = np.sqrt(np.mean(found.amplitude[inside] ** 2))
    assert floor == pytest.approx(np.sqrt(2 * 1.5 / length * 2 * rate), rel=0.05)


def test_spans_that_are_too_short_or_beyond_the_signal_are_refused():
    time = np.linspace(0, 1, 101)
    for span in ((0.5, 1.2), (0.5, 0.55), (0.6, 0.5)):
        with pytest.raises(InputError, match="expected a span of 16 samples or more"):
            signal_spectrum(time, time, *span)
    with pytest.raises(InputError, match="received 0 and 1 s"):
        spike_spectrum([], 0.0, 1.0)
    with pytest.raises(InputError, match="stop"):
        spike_spectrum([[0.5]], 1.0, 0.5)
