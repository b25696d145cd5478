"""A load that moves over a half-space: its limits."""

import math

import numpy as np
import pytest

from fefinger.theory.contact.elastic import amplification


def test_a_slow_load_displaces_more_by_the_square_of_its_speed() -> None:
    slow = np.array([1e-4, 1e-2, 0.05])
    assert [amplification(speed) for speed in slow] == pytest.approx(0.75 * slow**2, rel=5e-3)


def test_at_the_speed_of_rayleigh_waves_there_is_no_limit() -> None:
    # Their speed is the root of 4 a = (1 + a²)², in a body that is incompressible.
    (a,) = (root.real for root in np.roots([1, 1, 3, -1]) if abs(root.imag) < 1e-9)
    rayleigh = math.sqrt(1 - a**2)
    assert rayleigh == pytest.approx(0.9553, abs=1e-4)
    assert amplification(0.999 * rayleigh) > 100
    assert amplification(1.001 * rayleigh) == amplification(3.0) == math.inf
