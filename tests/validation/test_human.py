"""Suite `human`: what it compares, on presses of shipped tables and of its report."""

import numpy as np
import pytest
from fefinger.validation.human import suite
from fefinger.validation.human.presses import DEFAULT, REPORT

from fefinger.mechanics.evidence.presses import read
from fefinger.scene import library
from fefinger.scene.finger import Finger


def test_stiffness_is_the_slope_of_a_curve() -> None:
    depth = np.linspace(0, 2, 401)
    assert suite.stiffness(depth, depth**2, 1.0) == pytest.approx(2.0, rel=2e-3)


def test_the_wave_speed_is_that_of_rayleigh_in_an_incompressible_half_space() -> None:
    """c²/c_s² is the root of x³ - 8 x² + 24 x - 16 = 0 at a Poisson's ratio of 0.5."""
    root = min(np.roots([1, -8, 24, -16]).real)
    skin = Finger.subject(DEFAULT, tissue=library.PUBLISHED).skin
    shear = np.sqrt(1e3 * skin.modulus / 3 / 1000)
    found = suite.wave_speed(library.PUBLISHED, "skin", instantaneous=False)
    assert found == pytest.approx(np.sqrt(root) * shear, rel=1e-3)


def test_the_held_presses_bear_their_forces() -> None:
    for force, row in read(REPORT)["held"].items():
        assert row["force_N"] == pytest.approx(float(force), rel=1e-6)
        x, pressure = np.array(row["x_mm"]), np.array(row["pressure_kPa"])
        assert (np.diff(x) >= 0).all()
        assert pressure.max() < 2.5 * row["highest_kPa"]
    assert read(REPORT)["deep"][DEFAULT]["force_N"][-1] > 5.2


def test_the_pressure_along_the_pad_has_no_places_on_the_back_of_the_tip() -> None:
    for row in read(REPORT)["held"].values():
        x, pressure = np.array(row["x_mm"]), np.array(row["pressure_kPa"])
        assert (pressure[(x >= 0) & (x <= x[pressure > 0].max())] > 0).all()
