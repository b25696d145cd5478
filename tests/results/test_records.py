"""Records of results: candidates, harmonic answers, and the Green-Lagrange strain."""

from dataclasses import replace

import numpy as np
import pytest

from fefinger import mechanics
from fefinger.results import key_numbers
from fefinger.results.candidate import MECHANICS, Candidate, meshed
from fefinger.results.records import Harmonic, Rung, apart
from fefinger.support.tensors import logarithmic


@pytest.mark.parametrize("label", ["hertz", "lumped", "linear coarse", "solid fine"])
def test_a_label_of_a_report_is_read_and_written(label):
    candidate = Candidate.of(label)
    assert candidate.label == label
    rung = Rung(candidate.mechanics, 1.0, 0.1, "a report", resolution=candidate.resolution)
    assert rung.candidate == candidate


def test_the_fine_mesh_has_the_scatter_and_spikes_of_the_standard_one():
    assert Candidate("solid", "fine").measured == Candidate("solid", "standard")
    assert Candidate("solid", "coarse").measured == Candidate("solid", "coarse")
    assert Candidate("hertz").measured == Candidate("hertz")


def test_every_mechanics_has_its_traits():
    assert mechanics.names() == tuple(MECHANICS)
    assert [mechanics.get(name).name for name in MECHANICS] == list(MECHANICS)
    assert meshed() == ("condensed", "pressed", "modal", "linear", "solid")
    assert [name for name, traits in MECHANICS.items() if traits.finite] == ["pressed", "solid"]


def spring_and_damper(stiffness, damping):
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


def test_its_text_shows_range_and_preload_not_the_arrays():
    text = repr(spring_and_damper(1.0, 0.0))
    assert text == "<Harmonic: 2 from 20 to 200 Hz, about 0.5 N at 0.9 mm>"


def test_the_impedance_of_a_damper_is_among_the_numbers_of_a_result(synthetic):
    response = replace(synthetic.response, harmonic=spring_and_damper(0.0, 2e-3))
    numbers = {
        each.name: each for each in key_numbers.key_numbers(replace(synthetic, response=response))
    }
    assert numbers["impedance"].value == "2 and 2 N s/m"
    assert numbers["impedance"].about == "at 20 and 200 Hz"


def test_a_delay_is_followed_from_a_first_phase_of_90_degrees():
    strain = np.zeros((2, 1, 3, 3), complex)
    strain[:, 0, 2, 2] = [-1j, -1j]  # a quarter of a cycle late at 20 and at 200 Hz
    answer = replace(spring_and_damper(1.0, 0.0), strain_parts=apart(strain))
    assert answer.site_delay()[:, 0] == pytest.approx([0.25 / 20, 0.25 / 200])


def test_a_result_of_solid_has_the_green_lagrange_strain_of_its_deformation(synthetic):
    shape = synthetic.strain.shape
    gradient = 0.3 * np.random.default_rng(1).normal(size=shape)
    gradient[0] = 0.0
    gradient[0, 0, 0, 1] = 0.8  # simple shear: E_xy = 0.4, E_yy = 0.32 and nothing else
    own = replace(synthetic.response, mechanics="solid", strain=logarithmic(gradient))
    found = replace(synthetic, response=own).green_lagrange
    f = np.eye(3) + gradient
    assert found == pytest.approx((np.swapaxes(f, -1, -2) @ f - np.eye(3)) / 2, abs=1e-12)
    assert found[0, 0] == pytest.approx(np.array([[0, 0.4, 0], [0.4, 0.32, 0], [0, 0, 0]]))


def test_small_strain_is_no_green_lagrange_strain(synthetic):
    assert synthetic.response.mechanics == "linear"
    assert synthetic.green_lagrange is None
    unasked = replace(synthetic.response, mechanics="solid", strain=None)
    assert replace(synthetic, response=unasked).green_lagrange is None
