"""The harmonic answer of closed contact against the whole constrained system."""

import numpy as np
import pytest
from scipy import linalg

from fefinger.contact.oscillators import ClosedContact


WEIGHTS, RATES = np.array([1.5, 0.4]), np.array([220.0, 10.0])
SIZE, MODES = 60, 25


@pytest.fixture
def system() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return stiffness, mass, three loads and the motion that their work is prescribed by."""
    rng = np.random.default_rng(5)
    chain = 2.2 * np.eye(SIZE) - np.eye(SIZE, k=1) - np.eye(SIZE, k=-1)
    mass = np.diag(rng.uniform(0.5, 1.5, SIZE)) * 1e-5
    loads = np.zeros((SIZE, 3))
    loads[3:9, 0], loads[9:15, 1], loads[15:22, 2] = 1.0, 0.7, 1.3
    return chain, mass, loads, np.array([1.0, 0.9, 1.2])


def whole(system, frequency: float, weights=WEIGHTS) -> complex:
    """Force per motion, from all unknowns and the pressures as multipliers."""
    stiffness, mass, loads, direction = system
    s = 2j * np.pi * frequency
    modulus = 1 + (weights * s / (s + RATES)).sum()
    count = loads.shape[1]
    matrix = np.block(
        [[modulus * stiffness + s**2 * mass, -loads], [loads.T, np.zeros((count, count))]]
    )
    right = np.concatenate([np.zeros(SIZE), direction])
    return complex(direction @ np.linalg.solve(matrix, right)[SIZE:])


def held(system, *, inertia: bool, weights=WEIGHTS) -> ClosedContact:
    stiffness, mass, loads, direction = system
    omega_squared, shapes = linalg.eigh(stiffness, mass)
    omega_squared, participation = omega_squared[:MODES], shapes[:, :MODES].T @ loads
    moved = np.linalg.solve(stiffness, loads)
    residual = loads.T @ moved - (participation.T / omega_squared) @ participation
    second = moved.T @ mass @ moved - (participation.T / omega_squared**2) @ participation
    return ClosedContact.of(
        omega_squared,
        participation,
        residual,
        direction,
        weights,
        RATES,
        second if inertia else None,
    )


@pytest.mark.parametrize("frequency", [1e-3, 5.0, 20.0, 40.0])
def test_the_stiffness_is_that_of_the_whole_system(system, frequency: float) -> None:
    exact = whole(system, frequency)
    errors = [
        abs(held(system, inertia=two).stiffness(np.array([frequency]))[0] / exact - 1)
        for two in (False, True)
    ]
    assert errors[1] < 1e-4
    assert errors[1] <= errors[0] + 1e-12


def test_the_second_static_term_raises_the_order_of_the_error(system) -> None:
    orders, elastic = [], 0.0 * WEIGHTS
    for two in (False, True):
        body = held(system, inertia=two, weights=elastic)
        first, second = (
            abs(body.stiffness(np.array([f]))[0] / whole(system, f, elastic) - 1)
            for f in (5.0, 10.0)
        )
        orders.append(np.log2(second / first))
    assert orders[0] == pytest.approx(2.0, abs=0.4)
    assert orders[1] > orders[0] + 1


def test_the_pressures_bear_the_force_and_the_loads_move_as_prescribed(system) -> None:
    body, frequency = held(system, inertia=False), np.array([15.0])
    _, _, loads, direction = system
    pressure, amplitude = body.amplitudes(frequency)
    omega_squared, shapes = linalg.eigh(*system[:2])
    participation = shapes[:, :MODES].T @ loads
    residual = (
        loads.T @ np.linalg.solve(system[0], loads)
        - (participation.T / omega_squared[:MODES]) @ participation
    )
    np.testing.assert_allclose(
        pressure[0] @ residual + amplitude[0] @ participation, direction, rtol=1e-9
    )
    force = body.modulus(frequency)[0] * pressure[0] @ direction
    assert force == pytest.approx(body.stiffness(frequency)[0], rel=1e-9)
