"""A plate that rolls over the finger."""

from dataclasses import replace

import numpy as np
import pytest

import fefinger as ff
from fefinger.fem.contact import lcp_compiled
from fefinger.fem.contact.complementarity import Complementarity
from fefinger.fem.contact.viscoelastic import Relaxation
from fefinger.mechanics.realtime.condensed import Condensed
from fefinger.mechanics.realtime.rolling import Rolling
from fefinger.results.records import Sites
from fefinger.support.checks import InputError


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
INSIDE = np.array([[0.5, 0.3, 1.5], [-1.0, 0.8, 2.0]])
SITES = Sites(INSIDE, np.tile([0.0, 0.0, -1.0], (2, 1)), np.full(2, 1.5), ("SAI", "FAI"))
DEPTHS = 0.5 + 0.4 * np.sin(np.linspace(0, 9, 50))


pytestmark = pytest.mark.usefixtures("operators")


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


def test_steps_repeat_the_same_mathematics_without_shortcuts(rolling: Rolling) -> None:
    n, worst = len(rolling.vertices), 0.0
    plate, weights = rolling._plate, np.array(FINGER.prony.weights)
    memory, full = Relaxation(weights, np.array(FINGER.prony.v), 2 * n), rolling._plate.columns
    angles = 25 + 9 * np.sin(np.linspace(0, 12, 120))
    for k, angle in enumerate(angles.tolist()):
        depth = 0.5 + 0.6 * np.sin(0.3 * k)
        found = rolling.step(depth, angle, 4e-3).pressure
        g, past = memory.history(4e-3)
        normal = np.array([-np.sin(np.radians(angle)), np.cos(np.radians(angle))])
        travel = depth + (rolling._outline @ normal).min()
        flexibility = np.einsum("c,d,cidj->ij", normal, normal, full.reshape(2, n, 2, n))
        free = normal @ (plate.moments - (full @ past).reshape(2, n) / g) - travel * plate.weights
        exact = g * Complementarity(flexibility).solve(free)
        memory.advance(4e-3, (np.outer(normal, exact).ravel() - past) / g)
        worst = max(worst, np.abs(found - exact).max() / max(exact.max(), 1.0))
    assert worst < 1e-10
    assert rolling.elastic == pytest.approx(memory.elastic, abs=1e-9)
    assert 0 < rolling._state.counts[lcp_compiled.REBUILT] < 60  # most steps refine what they have


def test_strains_elsewhere_are_those_of_sites(rolling: Rolling) -> None:
    for angle, depth in zip(np.linspace(15, 33, 50).tolist(), DEPTHS.tolist(), strict=True):
        now = rolling.step(depth, angle, 3e-3)
    found = (rolling.strains(INSIDE) @ rolling.elastic).reshape(-1, 6)
    assert found == pytest.approx(now.strain, rel=1e-9, abs=1e-12)


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
    now = rolling.now
    assert (now.depth, now.force, now.contact_area) == (0.0, 0.0, 0.0)
    assert np.isnan([now.x, now.y]).all()
    assert not now.pressure.any()
    assert not now.strain.any()
    assert rolling.step(0.0, 33.0, 1.0).force == 0.0


def test_angles_and_depths_that_were_not_given_get_a_sentence(rolling: Rolling) -> None:
    with pytest.raises(InputError, match="angle: expected"):
        rolling.step(0.5, 50.0, 1e-3)
    with pytest.raises(InputError, match="depth: expected a finite"):
        rolling.step(np.nan, 20.0, 1e-3)
    with pytest.raises(InputError, match="contact at their rim"):
        rolling.step(3.0, 20.0, 1e-3)


@pytest.mark.parametrize("angles", [(), (np.nan, 30.0), (10.0, 95.0)], ids=str)
def test_angles_that_no_plate_has_get_a_sentence(angles: tuple) -> None:
    with pytest.raises(InputError, match=r"angles?: expected"):
        Rolling(FINGER, angles=angles, deepest=1.2, sites=SITES)
