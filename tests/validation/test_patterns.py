"""Contact of patterns on the stack by Fourier transforms, against closed forms and `layered`."""

import numpy as np
import pytest
from fefinger.validation.afferents.patterns import Pad
from fefinger.validation.oracles.layer import paraboloid_at

from fefinger.support.checks import ConvergenceError
from fefinger.theory.contact import subsurface
from fefinger.theory.contact.stack import Layer, Stack


LAYERS = Stack((Layer(1.0, 100.0, 0.48), Layer(3.0, 34.0, 0.48)))
PAD = Pad(LAYERS, radius=8.0, points=192, spacing=0.16)


def plate(at):
    """Return the heights of a plate."""
    return np.zeros(at.shape[:-1])


@pytest.fixture(scope="module")
def pressed():
    """Return the pressure under a plate 0.4 mm deep, and the exact contact."""
    return PAD.pressure(plate, 0.4), paraboloid_at(LAYERS, 8.0, depth=0.4)


def test_the_force_of_a_plate_is_that_of_the_exact_contact(pressed):
    pressure, exact = pressed
    assert pressure.sum() * PAD.spacing**2 == pytest.approx(exact.force, rel=0.005)
    assert pressure.min() >= 0.0
    assert pressure.max() == pytest.approx(float(exact.pressure([0.0])[0]), rel=0.005)


def test_the_strain_below_a_plate_is_that_of_hankel_transforms(pressed):
    pressure, exact = pressed
    r = np.array([0.0, 0.8, 1.6])
    places = np.column_stack([np.zeros(3), r])
    strain = PAD.strain(pressure, 0.6, places)
    field = subsurface.subsurface_field(LAYERS, [exact], r, z=np.full(3, 0.6))
    radial, hoop, axial, shear = field.strain[0]
    scale = np.abs(axial).max()
    parts = (strain[:, 1, 1], strain[:, 0, 0], strain[:, 2, 2], strain[:, 1, 2])
    for part, expected in zip(parts, (radial, hoop, axial, shear), strict=True):
        assert part == pytest.approx(expected, abs=0.02 * scale)


def test_the_gap_closes_in_contact_and_nothing_pulls(pressed):
    pressure, _ = pressed
    rest = PAD.sink(pressure) + np.sum(PAD.places**2, axis=-1) / 16.0 - 0.4
    assert np.abs(rest[pressure > 0]).max() < 1e-6
    assert rest[pressure == 0].min() > -1e-6


def test_a_force_that_is_given_ends_in_the_pressure_of_its_depth(pressed):
    pressure, _ = pressed
    force = pressure.sum() * PAD.spacing**2
    found = PAD.pressure_by_force(plate, force, np.where(pressure > 0, 1.0, 0.0))
    assert found.sum() * PAD.spacing**2 == pytest.approx(force, rel=1e-12)
    assert found == pytest.approx(pressure, abs=1e-3 * pressure.max())


def test_what_does_not_converge_says_so(monkeypatch):
    monkeypatch.setattr("fefinger.validation.afferents.patterns.ITERATIONS", 2)
    with pytest.raises(ConvergenceError, match="gap in contact"):
        PAD.pressure(plate, 0.4)
