"""Suite `waves`: its closed forms agree with the books, and its modes are drawn."""

import numpy as np
import pytest
from fefinger.validation.waves import bodies, drawings, finger
from scipy import special

from fefinger.view.figures import style


def test_the_roots_of_a_ball_are_those_of_its_equations() -> None:
    x = bodies.torsional_root()
    assert special.spherical_jn(2, x) == pytest.approx(x * special.spherical_jn(3, x))
    assert x == pytest.approx(2.501, abs=1e-3)
    # Between those of nu = 1/3, 2.65 (Love), and higher ones of stiffer balls.
    assert 2.64 < bodies.spheroidal_root() < 2.69


def test_lambs_integral_is_that_of_statics_at_rest() -> None:
    nu, modulus = bodies.PULP.poisson, bodies.PULP.modulus
    static = 16 * (1 - nu**2) * bodies.DISC / (3 * np.pi * modulus)
    assert bodies.half_space_exact(1e-2).real == pytest.approx(static, rel=1e-4)


def test_a_wave_in_the_half_space_takes_energy_away() -> None:
    assert all(bodies.half_space_exact(f).imag < 0 for f in (1.0, 100.0, 1000.0))


@pytest.mark.usefixtures("operators")
def test_the_lowest_modes_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the whole suite draws them otherwise."""
    monkeypatch.setattr(finger, "MESH", "coarse")
    finger.finger.cache_clear()
    with style():
        drawn = drawings._shapes()
    finger.finger.cache_clear()
    assert len(drawn.axes) == 2 * (drawings.SHAPES // 2)
    assert all(axis.get_title("left").endswith(" Hz") for axis in drawn.axes)
