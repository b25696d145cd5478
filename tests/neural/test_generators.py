"""Generators: the linear law, its saturating form, and freedom from block."""

import numpy as np
import pytest

from fefinger.neural.endorgans import (
    GENERATOR_BY_NAME,
    LARGEST_CURRENT,
    linear,
    saturating,
    transduce,
)
from fefinger.neural.membranes import HodgkinHuxley
from fefinger.support.vocabulary import GENERATORS, TYPES


def test_saturating_is_linear_when_small_and_bounded_when_large():
    x = np.array([0.0, 1e-6, 1e-4])
    np.testing.assert_allclose(saturating(x, 50.0), linear(x, 50.0), rtol=1e-4)
    assert saturating(np.array([1e9]), 50.0)[0] == LARGEST_CURRENT
    assert np.all(np.diff(saturating(np.linspace(0, 5, 50), 50.0)) > 0)


@pytest.mark.parametrize("divisor", [1.0, 6.0], ids=["standard", "slowed"])
@pytest.mark.parametrize("rise", [0.0, 0.01, 1.0])
def test_the_largest_current_never_blocks_a_membrane(divisor, rise):
    firing = HodgkinHuxley(divisor).fire([0, rise, 4.0], [0, LARGEST_CURRENT, LARGEST_CURRENT])
    assert firing.block_seconds[0] == 0.0
    held = firing.times[0][firing.times[0] > 2.0]
    assert 1 / np.diff(held).max() > (147.0 if divisor == 1.0 else 27.0)


def test_every_generator_is_computed_by_the_function_of_its_name():
    assert tuple(GENERATOR_BY_NAME) == GENERATORS
    assert [function.__name__ for function in GENERATOR_BY_NAME.values()] == list(GENERATORS)


@pytest.mark.parametrize("generator", GENERATORS)
@pytest.mark.parametrize("kind", TYPES)
def test_currents_are_never_negative_and_do_not_depend_on_the_sampling(kind, generator):
    time, x = np.array([0.0, 0.1, 0.5, 0.6, 1.0]), np.array([0.0, 1.0, 1.0, 0.0, 0.0])
    fine = np.unique(np.append(np.linspace(0, 1, 997), time))
    between = transduce(kind, time, x, gain=40.0, generator=generator, at=fine)
    refined = transduce(kind, fine, np.interp(fine, time, x), gain=40.0, generator=generator)
    np.testing.assert_allclose(between, refined, atol=1e-10)
    assert between.min() == 0.0
    assert between.max() > 0.0
