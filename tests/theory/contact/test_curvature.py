"""Relative curvature and compliance in series."""

import math

import pytest
from fefinger.validation.oracles.fingerpad import series_modulus

from fefinger.theory.contact.hertz import equivalent_radius, relative_radius


def test_radii_and_compliances_add_in_series():
    assert relative_radius(14.0, math.inf) == 14.0
    assert relative_radius(10.0, 10.0) == 5.0
    assert relative_radius(10.0, -20.0) == 20.0
    assert equivalent_radius(4.0, 9.0) == 6.0
    assert series_modulus((540.0, 0.5), (math.inf, 0.5)) == pytest.approx(720.0)
    assert series_modulus((540.0, 0.5), (1000.0, 0.5)) == pytest.approx(467.5, abs=0.05)
    assert series_modulus((50.0, 0.3), (50.0, 0.3)) == pytest.approx(25.0 / 0.91)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: relative_radius(10.0, 0.0), "other than 0"),
        (lambda: relative_radius(10.0, -8.0), "touch in a point"),
        (lambda: series_modulus((math.inf, 0.5)), "at least one that deforms"),
        (lambda: series_modulus((-1.0, 0.5)), "E > 0 kPa"),
    ],
)
def test_what_cannot_be_used_gets_a_sentence(call, message):
    with pytest.raises(ValueError, match=message):
        call()
