"""Shear waves in deformed tissue have their closed forms."""

import numpy as np
import pytest
from fefinger.validation.human.preload import shear_speed

from fefinger.fem.elements.forms import Elastic
from fefinger.fem.hyperelastic.material import material_of
from fefinger.scene.inertia import DENSITY


X, Y = np.eye(3)[:2]


def stretched(stretch: float) -> np.ndarray:
    return np.diag([stretch, stretch**-0.5, stretch**-0.5]) - np.eye(3)


@pytest.mark.parametrize("stretch", [0.6, 1.0, 1.4])
def test_a_stretched_neo_hookean_body_has_the_closed_form(stretch: float) -> None:
    material = material_of(Elastic(30.0, 0.48))
    speed = shear_speed(material, stretched(stretch), X, Y, 1.0)
    assert speed == pytest.approx(np.sqrt(material.shear * stretch**2 / DENSITY) / 1e3, rel=1e-9)


@pytest.mark.parametrize("stretch", [0.7, 1.3])
def test_a_stretched_exponential_body_has_the_closed_form(stretch: float) -> None:
    material = material_of(Elastic(30.0, 0.48), "demiray", exponent=2.0)
    rise = np.exp(2.0 * (stretch**2 + 2 / stretch - 3))
    exact = np.sqrt(material.shear * rise * stretch**2 / DENSITY) / 1e3
    assert shear_speed(material, stretched(stretch), X, Y, 1.0) == pytest.approx(exact, rel=1e-9)


def test_relaxation_raises_the_moduli_and_not_the_stress_of_the_preload() -> None:
    material = material_of(Elastic(30.0, 0.48))
    slow, fast = (shear_speed(material, stretched(1.0), X, Y, g) for g in (1.0, 4.0))
    assert fast == pytest.approx(2 * slow, rel=1e-12)
    slow, fast = (shear_speed(material, stretched(1.4), X, Y, g) for g in (1.0, 4.0))
    assert slow < fast < 2 * slow
