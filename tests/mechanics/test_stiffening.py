"""The thesis's modulus t(u), fitted to a finger."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import optimize

import fefinger as ff
from fefinger.mechanics.stiffening import Stiffening
from fefinger.scene import pawluk1997
from fefinger.support.checks import ConvergenceError, InputError


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
DEPTHS = np.linspace(0.1, 1.4, 14)


pytestmark = pytest.mark.usefixtures("operators")


def test_it_finds_the_t_that_made_the_forces() -> None:
    given = Stiffening(b=0.8, m=1.3)
    elastic = replace(FINGER, prony=ff.Prony((1.0,), ()))
    finger = ff.Loop(elastic, mechanics="condensed", deepest=1.4, stiffening=given)
    forces = [finger.step(0.0, depth=depth).force for depth in DEPTHS.tolist()]
    found = Stiffening.fitted(FINGER, DEPTHS, forces)
    assert (found.b, found.m) == pytest.approx((given.b, given.m), rel=1e-5)
    assert found(-1.0) == 0.0


@pytest.mark.parametrize("factor", [1e-9, 1e9])
def test_weak_and_strong_forces_are_fitted_as_well(factor: float) -> None:
    forces = np.expm1(1.3 * DEPTHS)
    plain, scaled = (Stiffening.fitted(FINGER, DEPTHS, each * forces) for each in (1.0, factor))
    assert scaled.b == pytest.approx(factor * plain.b, rel=1e-6)
    assert (scaled.m, scaled.misfit) == pytest.approx((plain.m, plain.misfit), rel=1e-6)


def test_a_search_that_is_cut_short_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    search = optimize.least_squares

    def short(*arguments, **options):
        return search(*arguments, **options | {"max_nfev": 2})

    monkeypatch.setattr(optimize, "least_squares", short)
    with pytest.raises(ConvergenceError, match="not settled after 2 evaluations, at b = "):
        Stiffening.fitted(FINGER, DEPTHS, np.expm1(1.3 * DEPTHS))


def test_it_fits_the_lumped_finger_of_the_same_subject() -> None:
    lumped = pawluk1997.lumped()["a.h."]
    forces = lumped.prony.long_time * lumped.b / lumped.m * np.expm1(lumped.m * DEPTHS)
    fitted = Stiffening.fitted(FINGER, DEPTHS, forces)
    elastic = replace(FINGER, prony=ff.Prony((1.0,), ()))
    finger = ff.Loop(elastic, ff.Flat(30), mechanics="condensed", deepest=1.4, stiffening=fitted)
    found = np.array([finger.step(0.0, depth=depth).force for depth in DEPTHS.tolist()])
    error = np.abs(found - forces).max() / forces.max()
    assert fitted.misfit == pytest.approx(error, rel=1e-6)
    assert fitted.m < 0.5  # of 2.1 without a bone: the finger stiffens by itself
    assert 0.01 < error < 0.2


@pytest.mark.parametrize(
    ("depths", "forces", "words"),
    [
        ([1.0], [1.0], "two or more"),
        ([0.5, 1.0], [1.0], "as many forces"),
        ([0.5, 1.0], [0.0, 0.0], "the largest is above 0 N"),
        ([0.5, 1.0], [0.1, np.nan], "finite forces"),
    ],
)
def test_what_cannot_be_fitted_gets_a_sentence(depths: list, forces: list, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Stiffening.fitted(FINGER, depths, forces)


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ((0.0, 1.0), "stiffening.b: expected a finite number in 1/mm above 0"),
        ((-0.1, 1.0), "stiffening.b"),
        ((np.nan, 1.0), "stiffening.b"),
        ((np.inf, 1.0), "stiffening.b"),
        ((0.1, -1e-9), "stiffening.m: expected a finite number in 1/mm at least 0"),
        ((0.1, np.nan), "stiffening.m"),
        ((0.1, np.inf), "stiffening.m"),
        ((0.1, 1.0, np.nan), "stiffening.misfit"),
    ],
)
def test_parameters_that_are_none_get_a_sentence(numbers: tuple, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Stiffening(*numbers)


def test_a_depth_without_a_t_gets_a_sentence() -> None:
    with pytest.raises(InputError, match="depth: expected a finite number"):
        Stiffening(0.1, 1.0)(np.nan)
    with pytest.raises(InputError, match="m times depth of at most 600"):
        Stiffening(0.1, 1000.0)(2.0)
    assert Stiffening(0.1, 1000.0)(-2.0) == 0.0
