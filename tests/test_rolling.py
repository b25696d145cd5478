"""A plate that rolls over the finger."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fefinger as ff
from fefinger.checks import InputError
from fefinger.realtime import Condensed
from fefinger.records import Sites
from fefinger.rolling import Rolling


FINGER = ff.Finger.subject("a.h.", resolution="coarse")
INSIDE = np.array([[0.5, 0.3, 1.5], [-1.0, 0.8, 2.0]])
SITES = Sites(INSIDE, np.tile([0.0, 0.0, -1.0], (2, 1)), np.full(2, 1.5), ("SAI", "FAI"))
DEPTHS = 0.5 + 0.4 * np.sin(np.linspace(0, 9, 50))


@pytest.fixture(autouse=True)
def _own_cache(operators: Path) -> None:
    """Keep to the operators of this session."""


@pytest.fixture
def rolling() -> Rolling:
    return Rolling(FINGER, angles=(15, 35), deepest=1.2, sites=SITES)


def test_a_plate_that_keeps_its_angle_is_the_condensed_one(rolling: Rolling) -> None:
    fixed = Condensed(FINGER, ff.Flat(22.5), deepest=1.2, sites=SITES)
    for depth in DEPTHS.tolist():
        found, expected = rolling.step(depth, 22.5, 3e-3), fixed.step(depth, 3e-3)
        for name in ("depth", "force", "contact_area", "x"):
            exact = getattr(expected, name)
            close = pytest.approx(exact, rel=1e-10, abs=1e-12, nan_ok=True)
            assert getattr(found, name) == close
        assert found.strain == pytest.approx(expected.strain, rel=1e-9, abs=1e-12)


def test_without_memory_the_way_does_not_matter() -> None:
    elastic = replace(FINGER, prony=ff.Prony((1.0,), ()))
    rolling = Rolling(elastic, angles=(15, 35), deepest=1.2, sites=SITES)
    for angle, depth in zip(np.linspace(15, 33, 50).tolist(), DEPTHS.tolist(), strict=True):
        found = rolling.step(depth, angle, 3e-3)
    expected = Condensed(elastic, ff.Flat(33), deepest=1.2, sites=SITES).step(DEPTHS[-1], 3e-3)
    assert found.force == pytest.approx(expected.force, rel=1e-10)
    assert found.strain == pytest.approx(expected.strain, rel=1e-9, abs=1e-12)


def test_in_a_long_rest_the_tissue_forgets_the_way(rolling: Rolling) -> None:
    for angle in np.linspace(15, 33, 20).tolist():
        moving = rolling.step(0.8, angle, 3e-3).force
    for _ in range(3):
        resting = rolling.step(0.8, 33.0, 1e3).force
    elastic = replace(FINGER, prony=ff.Prony((1.0,), ()))
    expected = Condensed(elastic, ff.Flat(33), deepest=1.2).step(0.8, 0.0).force
    assert moving > 1.5 * expected
    assert resting == pytest.approx(expected, rel=1e-6)
    rolling.reset()
    assert rolling.step(0.0, 33.0, 1.0).force == 0.0


def test_angles_and_depths_that_were_not_given_get_a_sentence(rolling: Rolling) -> None:
    with pytest.raises(InputError, match="angle: expected"):
        rolling.step(0.5, 50.0, 1e-3)
    with pytest.raises(InputError, match="reached the rim"):
        rolling.step(3.0, 20.0, 1e-3)
