"""SpikeTrains: counts and instantaneous rate."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from fefinger.neural.trains import Rerun, SpikeTrains


def trains(*times):
    n = len(times)
    return SpikeTrains(
        types=("SAI",) * n,
        names=tuple(f"SAI-{i + 1}" for i in range(n)),
        times=tuple(np.array(t, float) for t in times),
        t_start=0.0,
        t_stop=2.0,
        time=np.array([0.0, 2.0]),
        x_in=np.zeros((2, n)),
        current=np.zeros((2, n)),
        peak_mV=np.zeros(n),
        block_seconds=np.zeros(n),
        stimulus_driven=np.zeros(n, np.int64),
    )


def test_counts_follow_the_units():
    both = trains([0.5, 1.0], [0.25])
    assert len(both) == 2
    np.testing.assert_array_equal(both.count(), [2, 1])


def test_equal_trains_are_equal_and_others_are_not():
    one = trains([0.5, 1.0], [])
    assert one == trains([0.5, 1.0], [])
    assert hash(one) == hash(trains([0.5, 1.0], []))
    assert one != trains([0.5, 1.1], [])
    assert one != trains([0.5], [])
    assert one != replace(one, depths=np.full(2, 0.8))
    assert one != replace(one, family="recorded")
    assert one != "SAI"
    unknown = replace(one, depths=np.full(2, np.nan))
    assert unknown == replace(one, depths=np.full(2, np.nan))


def test_rate_is_one_over_the_interval_all_through_it():
    one = trains([0.5, 0.6, 1.0])
    t = [0.0, 0.5, 0.59, 0.6, 0.99, 1.0, 2.0]
    np.testing.assert_allclose(one.rate("SAI-1", t), [0, 10, 10, 2.5, 2.5, 0, 0])
    assert one.rate(0, 0.7) == pytest.approx(2.5)


@pytest.mark.parametrize("times", [[], [1.0]])
def test_rate_of_less_than_two_spikes_is_zero(times):
    np.testing.assert_array_equal(trains(times).rate(0, [0.0, 1.0, 1.5]), 0.0)


def test_a_spike_left_the_end_organs_a_conduction_delay_before():
    both = trains([0.5, 1.0], [0.25])
    np.testing.assert_array_equal(both.delays, [0.0, 0.0])
    far = replace(both, delays=np.array([0.01, 0.02]))
    np.testing.assert_allclose(far.at_end_organs(0), [0.49, 0.99])
    np.testing.assert_allclose(far.at_end_organs("SAI-2"), [0.23])
    np.testing.assert_array_equal(replace(both, delays=0.01).delays, [0.01, 0.01])
    with refused("delays"):
        replace(both, delays=np.zeros(3))


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"names": (1, 0)}, "names"),
        ({"names": ("left", "left")}, "names"),
        ({"names": "ab"}, "names"),
        ({"times": (np.zeros(0),)}, "times"),
        ({"x_in": np.zeros((2, 3))}, "x_in"),
    ],
)
def test_names_that_could_be_indices_and_fields_of_other_units_are_refused(change, field):
    with refused(field):
        replace(trains([0.5], [1.0]), **change)


def test_unknown_units_are_named():
    with pytest.raises(KeyError, match="no unit 'FAI' among SAI-1"):
        trains([]).index("FAI")
    with pytest.raises(IndexError):
        trains([]).index(3)


def test_the_bounds_of_a_type_are_of_the_sums_of_each_run():
    """Not the sum of the bounds of units: what one run adds to a unit it may take from another."""
    many = trains(*[[0.1, 0.2, 0.3]] * 20)
    swapped = np.where(np.arange(20) % 2, 2, 4)
    beside = many.beside(Rerun("a trial", swapped), Rerun("the mesh is coarse", swapped - 1))
    assert beside.bounds()[:, 0].tolist() == [3, 4]
    assert beside.totals() == {"SAI": (60, 40, 60)}
    assert beside.summary() == "SAI 60 (40 to 60) from 20 of 20 units"
    assert many.summary() == "SAI 60 from 20 of 20 units"
    table = beside.units_to_pandas()
    assert table["count_least"].tolist() == beside.bounds()[0].tolist()
