"""Profiles and receptive fields of responses whose shape is known."""

from dataclasses import replace

import numpy as np
import pytest

from fefinger.neural import rate_profile, receptive_fields
from fefinger.neural.populations import Surface
from fefinger.neural.trains import SpikeTrains
from fefinger.support.checks import InputError


X = np.linspace(-5, 5, 101)
XY = np.stack(np.meshgrid(X, X, indexing="ij"), axis=-1).reshape(-1, 2)
PROBES = Surface(
    np.column_stack([XY, np.zeros(len(XY))]),
    np.tile([0.0, 0.0, 1.0], (len(XY), 1)),
    np.full(len(XY), 0.01),
)


def test_the_field_of_a_gaussian_response_is_its_circle_of_half_height():
    center, sigma = np.array([0.7, -0.4]), 0.8
    response = 20 * np.exp(-np.sum((XY - center) ** 2, axis=1) / (2 * sigma**2))
    field, none = receptive_fields(PROBES, np.column_stack([response, np.zeros(len(XY))]))
    np.testing.assert_allclose(field.center, [*center, 0.0], atol=1e-3)
    assert field.area == pytest.approx(2 * np.pi * sigma**2 * np.log(2), rel=0.02)
    assert field.diameter == pytest.approx(2 * sigma * np.sqrt(2 * np.log(2)), rel=0.01)
    assert field.peak == response.max()
    assert (none.area, none.peak) == (0.0, 0.0)
    assert np.isnan(none.center).all()


def trains():
    positions = np.array([[3.0, 0, 0], [-1.0, 5, 0], [1.0, 0, 0], [0.0, 0, 0]])
    return SpikeTrains(
        types=("SAI", "SAI", "SAI", "FAI"),
        names=("a", "b", "c", "d"),
        times=tuple(np.linspace(0.1, 0.9, n) for n in (3, 1, 2, 7)),
        t_start=0.0,
        t_stop=1.0,
        time=np.array([0.0, 1.0]),
        x_in=np.zeros((2, 4)),
        current=np.zeros((2, 4)),
        peak_mV=np.zeros(4),
        block_seconds=np.zeros(4),
        stimulus_driven=np.zeros(4, np.int64),
        positions=positions,
    )


def test_a_profile_orders_the_units_of_a_type_along_the_direction():
    place, rate = rate_profile(trains(), (2.0, 0, 0), 0.0, 2.0, "SAI")
    np.testing.assert_allclose(place, [-1, 1, 3])
    np.testing.assert_allclose(rate, [0.5, 1.0, 1.5])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: receptive_fields(PROBES, np.zeros((3, 2))), "responses: expected \\(10201, n_"),
        (lambda: receptive_fields(PROBES, np.zeros((10201, 2)), share=0.0), "share: expected"),
        (lambda: rate_profile(trains(), (1, 0, 0), 0, 1, "FAII"), "a type among FAI, SAI"),
        (lambda: rate_profile(trains(), (0, 0, 0), 0, 1, "SAI"), "not zero"),
        (
            lambda: rate_profile(replace(trains(), positions=None), (1, 0, 0), 0, 1, "SAI"),
            "with positions",
        ),
    ],
)
def test_unusable_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
