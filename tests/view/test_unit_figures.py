"""Figures of many units: what their axes show."""

import dataclasses

import numpy as np

from fefinger.result import Result
from fefinger.view import unit_figures


def test_the_map_of_rates_shows_the_pressed_pad_and_all_units(synthetic: Result) -> None:
    assert synthetic.spikes is not None
    assert synthetic.pad is not None
    assert synthetic.pressure is not None
    count = len(synthetic.spikes)
    places = np.column_stack([np.linspace(-0.1, 0.1, count), *np.zeros((2, count))])
    spikes = dataclasses.replace(synthetic.spikes, positions=places)
    pressed = synthetic.pad.points[synthetic.pressure[synthetic.peak] > 0, :2]
    assert np.ptp(pressed, axis=0).max() > 1.0
    drawn = unit_figures.rate_map(dataclasses.replace(synthetic, spikes=spikes))
    axis = drawn.axes[0]
    for limits, across in zip((axis.get_xlim(), axis.get_ylim()), pressed.T, strict=True):
        assert limits[0] < across.min()
        assert across.max() < limits[1]
