"""Drives against closed forms, and their independence of the frame."""

import numpy as np
import pytest
from refusals import refused

from fefinger.neural.drives import DEFAULT_DRIVE, DRIVE_BY_NAME, POISSON
from fefinger.support.vocabulary import DRIVES, TYPES


UP = np.array([[0.0, 0.0, 1.0]])
NAMES = pytest.mark.parametrize("name", DRIVES)


def evaluate(name, strain, normal=UP):
    return DRIVE_BY_NAME[name](np.asarray(strain, float)[None, None], normal)[0, 0]


def uniaxial(e):
    """Uniaxial stress along the normal with Poisson's ratio POISSON."""
    return np.diag([-POISSON * e, -POISSON * e, e])


@pytest.mark.parametrize(
    ("name", "pressed", "pulled"),
    [
        ("compressive", 0.1, 0.1 * POISSON),
        ("tensile", 0.1 * POISSON, 0.1),
        ("tangent", 0.1 * POISSON, -0.1 * POISSON),
        ("energy", 0.1, 0.1),
        ("von_mises", 0.2 / 3 * (1 + POISSON), 0.2 / 3 * (1 + POISSON)),
    ],
)
def test_uniaxial_stress_along_the_normal(name, pressed, pulled):
    assert evaluate(name, uniaxial(-0.1)) == pytest.approx(pressed)
    assert evaluate(name, uniaxial(0.1)) == pytest.approx(pulled)


@pytest.mark.parametrize(
    ("name", "across", "within"),
    [
        ("compressive", 0.05, 0.05),
        ("tensile", 0.05, 0.05),
        ("tangent", 0.0, 0.05),
        ("energy", 0.05 * np.sqrt(2 / (1 + POISSON)), 0.05 * np.sqrt(2 / (1 + POISSON))),
        ("von_mises", 0.1 / np.sqrt(3), 0.1 / np.sqrt(3)),
    ],
)
def test_pure_shear_across_and_within_the_skin(name, across, within):
    shear = np.zeros((3, 3))
    shear[0, 2] = shear[2, 0] = 0.05
    assert evaluate(name, shear) == pytest.approx(across, abs=1e-15)
    assert evaluate(name, shear[:, [0, 2, 1]][[0, 2, 1]]) == pytest.approx(within)


def test_energy_is_the_work_of_hookes_law():
    strain = np.random.default_rng(0).normal(size=(3, 3))
    strain = 0.05 * (strain + strain.T)
    shear = 1 / (2 * (1 + POISSON))
    lame = POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    stress = 2 * shear * strain + lame * np.trace(strain) * np.eye(3)
    assert evaluate("energy", strain) ** 2 == pytest.approx(np.sum(stress * strain))


@NAMES
def test_a_rotation_of_body_and_normal_changes_nothing_and_the_sign_of_the_normal_neither(name):
    rng = np.random.default_rng(2)
    for _ in range(20):
        strain = rng.normal(size=(3, 3))
        strain = strain + strain.T
        normal = rng.normal(size=(1, 3))
        normal /= np.linalg.norm(normal)
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        value = evaluate(name, strain, normal)
        assert evaluate(name, turn @ strain @ turn.T, normal @ turn.T) == pytest.approx(value)
        assert evaluate(name, strain, -normal) == pytest.approx(value)


@NAMES
def test_drives_are_homogeneous_and_vectorized(name):
    rng = np.random.default_rng(3)
    strain = rng.normal(size=(4, 2, 3, 3))
    strain = strain + np.swapaxes(strain, -1, -2)
    normals = np.eye(3)[:2]
    values = DRIVE_BY_NAME[name](strain, normals)
    assert values.shape == (4, 2)
    np.testing.assert_allclose(DRIVE_BY_NAME[name](3.0 * strain, normals), 3.0 * values)
    assert values[2, 1] == pytest.approx(evaluate(name, strain[2, 1], normals[1:]))


def test_every_drive_is_computed_by_the_function_of_its_name():
    assert tuple(DRIVE_BY_NAME) == DRIVES
    assert [function.__name__ for function in DRIVE_BY_NAME.values()] == list(DRIVES)


def test_every_type_has_a_default_drive():
    assert tuple(DEFAULT_DRIVE) == TYPES
    assert set(DEFAULT_DRIVE.values()) <= set(DRIVES)


def test_normals_that_are_not_unit_vectors_are_refused():
    with refused("normals"):
        evaluate("tangent", np.eye(3), 2.0 * UP)
