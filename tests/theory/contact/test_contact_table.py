"""The table of contacts against contacts solved one by one, and against Hertz and Huber."""

import math

import numpy as np
import pytest
from fefinger.validation.oracles.layer import paraboloid_at
from oracles.solved_contact import load_within

from fefinger.theory.contact.contact_table import STEP, TooWideError, tabulate, tabulate_to
from fefinger.theory.contact.hertz import Hertz
from fefinger.theory.contact.indentation import paraboloid, subsurface_field
from fefinger.theory.contact.stack import Layer, Stack


FINGER = Stack((Layer(1.0, 100.0, 0.49), Layer(4.0, 34.0, 0.48)))
TABLE = tabulate(FINGER, 10.0, widest=6.0)
DEPTHS = [2e-3, 0.03, 0.3, 1.1, 2.0]


@pytest.mark.parametrize("depth", DEPTHS)
def test_any_depth_is_the_contact_solved_there(depth):
    """Tolerances: what the docstring of LEVELS promises."""
    solved = paraboloid_at(FINGER, 10.0, depth=depth)
    assert float(TABLE.force(depth)) == pytest.approx(solved.force, rel=1e-6)
    assert float(TABLE.contact_radius(depth)) == pytest.approx(solved.contact_radius, rel=1e-6)


def test_the_force_within_a_radius_is_that_of_the_contacts_solved_there():
    r = np.array([0.0, 0.1, 0.5, 2.0, 5.0, 9.0])
    actual = TABLE.load([0.0, *DEPTHS], r)
    assert np.abs(actual[0]).max() == 0
    for row, depth in zip(actual[1:], DEPTHS, strict=True):
        solved = paraboloid_at(FINGER, 10.0, depth=depth)
        np.testing.assert_allclose(row, load_within(solved, r), atol=3e-6 * solved.force)


@pytest.mark.parametrize("wanted", [{"depth": 0.01}, {"depth": 1.1}, {"force": 5.0}])
def test_a_table_reaches_what_is_wanted_and_one_step_less_does_not(wanted):
    table = tabulate_to(FINGER, 10.0, **wanted)
    ((quantity, least),) = wanted.items()
    wide = table.contacts[-1].contact_radius
    assert math.log(wide, STEP) == pytest.approx(round(math.log(wide, STEP)), abs=1e-9)
    assert getattr(table.contacts[-1], quantity) >= least
    narrower = paraboloid(FINGER, 10.0, contact_radius=wide / STEP)
    assert getattr(narrower, quantity) < least
    nearly = {quantity: 0.999 * least}
    assert tabulate_to(FINGER, 10.0, **nearly) is table


def test_strain_is_that_of_the_contacts_solved_there():
    r, z = np.array([0.0, 1.0, 3.0, 5.0]), np.array([0.5, 0.7, 1.2, 2.0])
    actual = TABLE.strain(DEPTHS, r, z=z)
    contacts = [paraboloid_at(FINGER, 10.0, depth=depth) for depth in DEPTHS]
    solved = subsurface_field(FINGER, contacts, r, z=z).strain
    scale = np.abs(solved).max(axis=(1, 2))
    assert np.max(np.abs(actual - solved).max(axis=(1, 2)) / scale) < 1.5e-4


def test_a_half_space_is_hertz_and_huber_at_every_depth():
    table = tabulate(Stack((Layer(math.inf, 34.0, 0.45),)), 10.0, widest=4.0)
    depth = np.array([0.001, 0.05, 0.4, 1.5])
    contacts = [Hertz(10.0, one, modulus=34.0, poisson=0.45) for one in depth]
    np.testing.assert_allclose(table.force(depth), [h.force for h in contacts], rtol=1e-12)
    np.testing.assert_allclose(
        table.contact_radius(depth), [h.contact_radius for h in contacts], rtol=1e-12
    )
    r, z = np.array([0.0, 0.9, 3.0]), np.array([0.6, 0.6, 1.5])
    for strain, h in zip(table.strain(depth, r, z=z), contacts, strict=True):
        expected = h.strain(r, z)
        np.testing.assert_allclose(strain, expected, atol=1e-4 * np.abs(expected).max())


def test_force_is_inverted_from_nothing_to_the_deepest():
    depth = np.linspace(0, TABLE.deepest, 30)
    np.testing.assert_allclose(TABLE.depth(TABLE.force(depth)), depth, atol=1e-12)
    assert float(TABLE.force(0.0)) == 0
    assert float(TABLE.contact_radius(0.0)) == 0


def test_touch_strains_nothing():
    assert not TABLE.strain([0.0], [0.0, 1.0], z=[0.5, 0.5]).any()


def test_a_contact_wider_than_the_radius_is_refused_and_one_as_wide_is_not():
    widest = paraboloid(FINGER, 3.0, contact_radius=3.0)
    assert tabulate_to(FINGER, 3.0, depth=widest.depth * (1 - 1e-9)).contacts[-1].depth == (
        pytest.approx(widest.depth)
    )
    for wanted, unit in (("depth", "mm"), ("force", "mN")):
        limit = f"contact is at most as wide as the radius .* {unit}$"
        with pytest.raises(TooWideError, match=limit):
            tabulate_to(FINGER, 3.0, **{wanted: 1.001 * getattr(widest, wanted)})
    for wanted in ({"depth": 0.0}, {"force": math.nan}, {}):
        with pytest.raises(ValueError, match="above 0"):
            tabulate_to(FINGER, 3.0, **wanted)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: TABLE.force(-0.1), "depths in 0 to"),
        (lambda: TABLE.force(1.01 * TABLE.deepest), "depths in 0 to"),
        (lambda: TABLE.depth(3000.0), "a force in 0 to"),
        (lambda: TABLE.strain([0.1], [0.0], z=[0.1]), r"at least 0\.02 contact radii"),
        (lambda: tabulate(FINGER, 10.0, widest=1.0, levels=3), "at least 4 levels"),
        (lambda: TABLE.load(math.nan, 1.0), "depths in 0 to"),
        (lambda: tabulate(FINGER, 10.0, widest=11.0), "at most the radius 10 mm"),
    ],
)
def test_what_is_out_of_range_is_refused(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()


def test_under_a_thin_and_stiff_skin_the_force_rises_from_the_first_touch():
    """It was negative at a thousandth of the depth, and 35 times too large."""
    stack = Stack((Layer(0.05, 5e3, 0.45), Layer(5.0, 10.0, 0.5)))
    table = tabulate(stack, 10.0, widest=3.9)
    depths = np.geomspace(1e-6, 1.0, 400) * table.deepest
    assert (np.diff(table.force(depths)) > 0).all()
    assert (np.diff(table.contact_radius(depths)) > 0).all()
    np.testing.assert_allclose(table.depth(table.force(depths)), depths, rtol=1e-9)
    for wide in (0.05, 0.3, 2.0):
        solved = paraboloid(stack, 10.0, contact_radius=wide)
        assert float(table.force(solved.depth)) == pytest.approx(solved.force, rel=1e-3)
