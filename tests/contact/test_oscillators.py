"""Viscoelastic modes against the frequency answer and an integrator."""

import numpy as np
import pytest
from fefinger.validation.waves.loops import energies
from scipy.integrate import solve_ivp

from fefinger.contact.oscillators import Oscillators, complex_modulus
from fefinger.support.checks import ConvergenceError


WEIGHTS, RATES = np.array([1.5, 0.5, 0.4]), np.array([224.0, 14.0, 0.63])
SQUARES = (2 * np.pi * np.array([40.0, 163.0, 900.0])) ** 2
RELAXATIONS = [
    (WEIGHTS, RATES),
    (np.array([20.0]), np.array([6283.0])),  # overdamped
    (np.empty(0), np.empty(0)),
]


@pytest.mark.parametrize(("weights", "rates"), RELAXATIONS)
def test_the_poles_add_up_to_the_frequency_answer(weights, rates):
    modes = Oscillators.of(SQUARES, weights, rates)
    frequency = np.array([0.0, 3.0, 150.0, 2000.0])
    s = 2j * np.pi * frequency[:, None, None]
    found = (modes.residues / (s - modes.poles)).sum(axis=2)
    below = SQUARES * complex_modulus(weights, rates, frequency)[:, None] + s[..., 0] ** 2
    np.testing.assert_allclose(found, 1.0 / below, rtol=1e-8)
    assert (modes.poles.real <= 1e-9).all()


def test_at_rest_the_modulus_is_one_and_in_sudden_strain_the_sum():
    modulus = complex_modulus(WEIGHTS, RATES, np.array([0.0, 1e9]))
    assert modulus.real == pytest.approx([1.0, 1.0 + WEIGHTS.sum()])
    assert np.abs(modulus.imag).max() < 1e-4


@pytest.mark.parametrize(("weights", "rates"), RELAXATIONS)
def test_a_step_under_a_force_that_is_linear_in_time_is_exact_at_any_length(weights, rates):
    modes = Oscillators.of(SQUARES[:1], weights, rates)

    def equations(t, y):
        a, speed, *memory = y
        stress = a + weights @ np.array(memory)
        return [speed, t - SQUARES[0] * stress, *(speed - rates * np.array(memory))]

    end = 0.02
    exact = solve_ivp(equations, (0, end), np.zeros(2 + len(rates)), rtol=1e-11, atol=1e-16)
    for count in (1, 7):
        dt, filtered = end / count, np.zeros_like(modes.poles)
        for k in range(count):
            decay, earlier, before, after = modes.filters(dt, swing=False)
            assert not earlier.any()
            filtered = decay * filtered + before * (k * dt) + after * (k + 1) * dt
        found = (modes.residues * filtered).sum(axis=1).real
        assert found[0] == pytest.approx(exact.y[0, -1], rel=1e-6)


def test_every_filter_weighs_a_constant_force_alike():
    modes = Oscillators.of(SQUARES, WEIGHTS, RATES)
    for swing in (True, False):
        _, *shares = modes.filters(1e-3, swing=swing)
        exact = np.expm1(modes.poles * 1e-3) / modes.poles
        np.testing.assert_allclose(sum(shares), exact, rtol=1e-9)


@pytest.mark.parametrize("dt", [1e-6, 1e-5, 1e-4, 3e-4])
def test_neither_one_pressure_nor_alternating_ones_pull_a_mode_backward(dt):
    resolved = SQUARES[np.sqrt(SQUARES * (1 + WEIGHTS.sum())) * dt < 2]
    modes = Oscillators.of(resolved, WEIGHTS, RATES)
    decay, earlier, before, after = modes.filters(dt, swing=True)
    gains = (modes.residues * after).sum(axis=1).real
    alternating = (modes.residues * (after - before + earlier) / (1 + decay)).sum(axis=1).real
    assert len(gains) > 0
    assert (gains > 0).all()
    assert (alternating > 0).all()


def test_energies_balance_the_work_of_a_force():
    modes, dt, force = Oscillators.of(SQUARES, WEIGHTS, RATES), 2e-5, np.zeros(3)
    filtered, work, lost, last = np.zeros_like(modes.poles), 0.0, 0.0, (np.zeros(3), 0.0)
    decay, _, before, after = modes.filters(dt, swing=False)
    for k in range(1, 2000):
        fresh = np.sin(2 * np.pi * np.array([60.0, 170.0, 300.0]) * k * dt)
        filtered = decay * filtered + before * force[:, None] + after * fresh[:, None]
        amplitude = (modes.residues * filtered).sum(axis=1).real
        stored, kinetic, power = energies(modes, filtered)
        work += (force + fresh) / 2 @ (amplitude - last[0])
        lost += dt * (power + last[1]) / 2
        force, last = fresh, (amplitude, power)
    assert stored + kinetic + lost == pytest.approx(work, rel=2e-3)
    assert min(stored, kinetic, lost) > 0


def test_poles_that_coincide_are_refused_in_a_sentence():
    # One branch of weight 8: the three poles of w = v / 3 sqrt(3) are one.
    with pytest.raises(ConvergenceError, match="coincide"):
        Oscillators.of(np.array([1.0 / 27.0]), np.array([8.0]), np.array([1.0]))
