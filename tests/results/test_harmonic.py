"""Harmonic answers: their short text, and the impedance among the numbers of a result."""

from dataclasses import replace

import numpy as np
import pytest

from fefinger.result import Result
from fefinger.results import key_numbers
from fefinger.results.harmonic import Harmonic, apart


def spring_and_damper(stiffness: float, damping: float) -> Harmonic:
    """Return the answer of a spring (N/mm) beside a damper (N s/mm) at 20 and 200 Hz."""
    frequency = np.array([20.0, 200.0])
    return Harmonic(
        frequency,
        apart(stiffness + 2j * np.pi * frequency * damping),
        strain_parts=np.zeros((2, 1, 3, 3, 2)),
        skin_points=np.zeros((1, 3)),
        skin_parts=np.zeros((2, 1, 3, 2)),
        error=np.zeros(2),
        modes=np.zeros(1),
        preload_depth=0.9,
        preload_force=0.5,
        contact_area=40.0,
    )


def test_its_text_shows_range_and_preload_not_the_arrays() -> None:
    text = repr(spring_and_damper(1.0, 0.0))
    assert text == "<Harmonic: 2 from 20 to 200 Hz, about 0.5 N at 0.9 mm>"


def test_the_impedance_of_a_damper_is_among_the_numbers_of_a_result(synthetic: Result) -> None:
    response = replace(synthetic.response, harmonic=spring_and_damper(0.0, 2e-3))
    numbers = {
        each.name: each for each in key_numbers.key_numbers(replace(synthetic, response=response))
    }
    assert numbers["impedance"].value == "2 and 2 N s/m"
    assert numbers["impedance"].about == "at 20 and 200 Hz"


def test_a_delay_is_followed_from_a_first_phase_of_90_degrees() -> None:
    strain = np.zeros((2, 1, 3, 3), complex)
    strain[:, 0, 2, 2] = [-1j, -1j]  # a quarter of a cycle late at 20 and at 200 Hz
    answer = replace(spring_and_damper(1.0, 0.0), strain_parts=apart(strain))
    assert answer.site_delay()[:, 0] == pytest.approx([0.25 / 20, 0.25 / 200])
