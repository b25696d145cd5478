"""Tables of elastic presses between their depths."""

from dataclasses import replace

import numpy as np
import pytest

from fefinger.mechanics.press.depth_table import PARTS, DepthTable, DisplacementBasis
from fefinger.mechanics.press.elastic_press import depths
from fefinger.support.arrays import Array


RADIUS, SPACING = 10.0, 0.4


def table(power: float = 1.5, count: int = 25, rate: float = 0.0) -> DepthTable:
    """Contact of a ball whose vertices come into contact one by one, as on a mesh."""
    depth = depths(10.0, 2.5)[:count]
    distance = np.hypot(*np.meshgrid(*2 * [SPACING * np.arange(-12, 13)])).ravel()
    pressure = np.sqrt(np.maximum(RADIUS * depth[:, None] - distance**2, 0.0))
    row = np.zeros((len(depth), 1))
    return DepthTable(
        depth=depth,
        force=3.0 * depth**power,
        moment=np.zeros((len(depth), 3)),
        area=np.pi * RADIUS * depth,
        stiffening=rate * depth**2,
        work=np.ones((len(depth), len(depth))),
        pressure=pressure,
        gap=row,
        modes=DisplacementBasis(row, np.zeros((1, 3), dtype=np.int16)),
        reach=3.0,
        modulus=1.0,
    )


@pytest.mark.parametrize("power", [1.2, 1.5, 2.5])
def test_between_depths_a_force_follows_its_power_of_the_depth(power: float) -> None:
    given = table(power)
    assert np.allclose(given.force_at_nodes, 3.0 * given.nodes**power, rtol=1e-9, atol=0)


def test_tissue_that_stiffens_has_a_measure_that_grows_faster_than_the_depth() -> None:
    soft, stiffens = table(), table(rate=0.2)
    exact = stiffens.nodes ** ((1 + 1.5) / 2)
    exact *= soft.measure[-1] / exact[-1]
    assert soft.measure == pytest.approx(exact, rel=1e-6)
    assert stiffens.measure / soft.measure[-1] == pytest.approx(
        exact / exact[-1] * np.exp(0.2 * stiffens.nodes**2), rel=2e-3
    )
    assert (np.diff(stiffens.measure) > 0).all()


def test_depths_that_bear_nothing_have_a_measure_that_rises() -> None:
    given = table()
    first = replace(given, force=np.where(given.depth < given.depth[3], 0.0, given.force))
    assert (np.diff(first.measure) > 0).all()
    assert first.measure[-1] == pytest.approx(given.measure[-1])


def test_depths_of_a_table_are_nodes_and_keep_their_force() -> None:
    given = table()
    np.testing.assert_allclose(given.nodes[::PARTS], given.depth, rtol=1e-12)
    np.testing.assert_allclose(given.force_at_nodes[::PARTS], given.force, rtol=1e-12)
    assert (np.diff(given.nodes) > 0).all()
    steps = np.diff(np.sqrt(given.nodes))[PARTS:]
    assert np.allclose(steps, steps[0])


def test_a_first_depth_that_bears_nothing_is_kept() -> None:
    given = table()
    force = np.where(given.depth > 0.02, given.force, 0.0)
    borne = replace(given, force=force).force_at_nodes
    first = int(np.argmax(given.depth > 0.02)) - 1
    assert first == 1
    assert (borne[: first * PARTS + 1] == 0).all()
    assert (np.diff(borne[first * PARTS :]) > 0).all()


def cut(given: DepthTable, count: int) -> DepthTable:
    """Return a table to its first depths alone."""
    rows: dict[str, Array] = {
        name: getattr(given, name)[:count]
        for name in ("depth", "force", "moment", "area", "pressure", "gap")
    }
    return replace(
        given, modes=DisplacementBasis(given.modes.amplitudes[:count], given.modes.shapes), **rows
    )


def test_a_deeper_table_gives_the_same_values_at_lesser_depths() -> None:
    deep = table()
    short = cut(deep, 18)
    shared = len(short.nodes) - PARTS  # the slope at the last depth has one neighbor alone
    np.testing.assert_allclose(short.nodes, deep.nodes[: len(short.nodes)], rtol=1e-12)
    forces = (each.force_at_nodes[:shared] for each in (short, deep))
    np.testing.assert_allclose(*forces, rtol=1e-12)
    for values in ("pressure", "area"):
        ours, theirs = (each.bounded(getattr(each, values)) for each in (short, deep))
        assert np.allclose(ours[:shared], theirs[:shared], rtol=1e-12, atol=1e-12)
