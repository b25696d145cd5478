"""A plate that rolls over the finger."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.contact import active_set
from fefinger.contact.complementarity import Complementarity
from fefinger.contact.prony_history import Relaxation
from fefinger.results.records import Sites
from fefinger.support.checks import InputError


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
INSIDE = np.array([[0.5, 0.3, 1.5], [-1.0, 0.8, 2.0]])
SITES = Sites(INSIDE, np.tile([0.0, 0.0, -1.0], (2, 1)), np.full(2, 1.5), ("SAI", "FAI"))
DEPTHS = 0.5 + 0.4 * np.sin(np.linspace(0, 9, 50))


pytestmark = pytest.mark.usefixtures("operators")


@pytest.fixture
def rolling() -> ff.Loop:
    return ff.Loop(FINGER, angles=(15, 35), mechanics="condensed", deepest=1.2, sites=SITES)


def test_a_plate_that_keeps_its_angle_is_the_condensed_one(rolling: ff.Loop) -> None:
    fixed = ff.Loop(FINGER, ff.Flat(22.5), mechanics="condensed", deepest=1.2, sites=SITES)
    for depth in DEPTHS.tolist():
        found, expected = rolling.step(3e-3, depth=depth, angle=22.5), fixed.step(3e-3, depth=depth)
        for name in ("depth", "force", "contact_area", "x"):
            exact = getattr(expected, name)
            close = pytest.approx(exact, rel=1e-10, abs=1e-12, nan_ok=True)
            assert getattr(found, name) == close
        assert found.strain == pytest.approx(expected.strain, rel=1e-9, abs=1e-12)


def test_steps_repeat_the_same_mathematics_without_shortcuts(rolling: ff.Loop) -> None:
    contact, worst = rolling.prepared.contact, 0.0
    n, weights = len(contact.pressure), np.array(FINGER.prony.weights)
    memory, full = Relaxation(weights, np.array(FINGER.prony.v), 2 * n), contact.columns
    angles = 25 + 9 * np.sin(np.linspace(0, 12, 120))
    for k, angle in enumerate(angles.tolist()):
        depth = 0.5 + 0.6 * np.sin(0.3 * k)
        found = rolling.step(4e-3, depth=depth, angle=angle).pressure
        g, past = memory.history(4e-3)
        normal = np.array([-np.sin(np.radians(angle)), np.cos(np.radians(angle))])
        travel = depth + (contact.outline @ normal).min()
        flexibility = np.einsum("c,d,cidj->ij", normal, normal, full.reshape(2, n, 2, n))
        free = normal @ (contact.moments - (full @ past).reshape(2, n) / g)
        free -= travel * contact.weights
        exact = g * Complementarity(flexibility).solve(free)
        memory.advance(4e-3, (np.outer(normal, exact).ravel() - past) / g)
        worst = max(worst, np.abs(found - exact).max() / max(exact.max(), 1.0))
    assert worst < 1e-10
    assert contact.elastic == pytest.approx(memory.elastic, abs=1e-9)
    assert 0 < contact.lcp.counts[active_set.REBUILT] < 60  # most steps refine what they have


def test_strains_elsewhere_are_those_of_sites(rolling: ff.Loop) -> None:
    for angle, depth in zip(np.linspace(15, 33, 50).tolist(), DEPTHS.tolist(), strict=True):
        now = rolling.step(3e-3, depth=depth, angle=angle)
    found = (rolling.prepared.strains(INSIDE) @ rolling.prepared.contact.elastic).reshape(-1, 6)
    assert found == pytest.approx(now.strain, rel=1e-9, abs=1e-12)


def test_without_memory_the_way_does_not_matter() -> None:
    elastic = replace(FINGER, prony=ff.Prony((1.0,), ()))
    rolling = ff.Loop(elastic, angles=(15, 35), mechanics="condensed", deepest=1.2, sites=SITES)
    for angle, depth in zip(np.linspace(15, 33, 50).tolist(), DEPTHS.tolist(), strict=True):
        found = rolling.step(3e-3, depth=depth, angle=angle)
    fixed = ff.Loop(elastic, ff.Flat(33), mechanics="condensed", deepest=1.2, sites=SITES)
    expected = fixed.step(3e-3, depth=DEPTHS[-1])
    assert found.force == pytest.approx(expected.force, rel=1e-10)
    assert found.strain == pytest.approx(expected.strain, rel=1e-9, abs=1e-12)


def test_in_a_long_rest_the_tissue_forgets_the_way(rolling: ff.Loop) -> None:
    for angle in np.linspace(15, 33, 20).tolist():
        moving = rolling.step(3e-3, depth=0.8, angle=angle).force
    for _ in range(3):
        resting = rolling.step(1e3, depth=0.8, angle=33.0).force
    elastic = replace(FINGER, prony=ff.Prony((1.0,), ()))
    fixed = ff.Loop(elastic, ff.Flat(33), mechanics="condensed", deepest=1.2)
    expected = fixed.step(0.0, depth=0.8).force
    assert moving > 1.5 * expected
    assert resting == pytest.approx(expected, rel=1e-6)
    rolling.reset()
    now = rolling.now
    assert (now.depth, now.force, now.contact_area) == (0.0, 0.0, 0.0)
    assert not now.touching
    assert not now.pressure.any()
    assert not now.strain.any()
    assert rolling.step(1.0, depth=0.0, angle=33.0).force == 0.0


def test_angles_and_depths_that_were_not_given_get_a_sentence(rolling: ff.Loop) -> None:
    with refused("angle"):
        rolling.step(1e-3, depth=0.5, angle=50.0)
    with refused("depth"):
        rolling.step(1e-3, depth=np.nan, angle=20.0)
    with refused("step"):
        rolling.step(1e-3, depth=3.0, angle=20.0)


@pytest.mark.parametrize("angles", [(), (np.nan, 30.0), (10.0, 95.0)], ids=str)
def test_angles_that_no_plate_has_get_a_sentence(angles: tuple) -> None:
    with pytest.raises(InputError, match=r"angles?(\[0\])?: expected"):
        ff.Loop(FINGER, angles=angles, mechanics="condensed", deepest=1.2, sites=SITES)


def test_a_plate_that_rolls_finds_the_depth_of_a_force(rolling: ff.Loop) -> None:
    for angle, force in ((20.0, 0.2), (25.0, 0.3), (30.0, 0.05), (30.0, 0.0), (28.0, 0.1)):
        found = rolling.step(5e-3, force=force, angle=angle)
        assert found.force == pytest.approx(force, rel=1e-7, abs=1e-12)
    again = ff.Loop(FINGER, angles=(15, 35), mechanics="condensed", deepest=1.2, sites=SITES)
    assert again.step(5e-3, depth=rolling.now.depth, angle=28.0).touching
