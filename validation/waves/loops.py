"""Stepping through time with inertia, on half a coarse finger, against second methods."""

from collections.abc import Callable
from functools import cache

import numpy as np
from fefinger.validation.waves.bodies import RATES, WEIGHTS

from fefinger.contact.active_set import DONE
from fefinger.contact.inertial import InertialContact
from fefinger.contact.oscillators import ClosedContact, Complex, Oscillators
from fefinger.contact.stepper import Target
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.press.modal_body import ModalBody
from fefinger.mechanics.press.modal_press import contact_of
from fefinger.mechanics.vibrations import Vibrations
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.support.arrays import Array


SUBJECT, TISSUE = "a.h.", "maeno1998"

DEPTH = 1.0
"""mm of preload."""

LONG = 1e4
"""s of a step after which tissue is relaxed."""


@cache
def finger(mesh: str = "coarse") -> Finger:
    """Return the finger of all cases."""
    return Finger.subject(SUBJECT, tissue=TISSUE, resolution=mesh)


@cache
def loop(mesh: str = "coarse") -> Loop:
    """Return a finger under the standard plate."""
    plate = Flat(30)
    return Loop(finger(mesh), plate, mechanics="modal", deepest=1.2 * DEPTH, substep=2.5e-5)


def vibrations() -> Vibrations:
    """Return its vibrations."""
    return Vibrations.of(loop().prepared, 1.2 * DEPTH)


def stepped_body() -> ModalBody:
    """Return its body, of the modes that are stepped."""
    body = loop().prepared.body
    assert body is not None
    return body


def static_difference() -> float:
    """Return the largest relative difference from `condensed` in steps that are long."""
    moving = loop()
    still = Loop(moving.finger, Flat(30), mechanics="condensed", deepest=1.2 * DEPTH)
    moving.reset()
    worst = 0.0
    for depth, seconds in ((0.3, 0.1), (0.9, 0.5), (0.9, 2.0), (0.5, 1.0), (1.0, 300.0)):
        one, other = still.step(seconds, depth=depth), moving.rest(seconds, depth=depth)
        pairs = ((one.strain, other.strain), (one.pressure, other.pressure))
        worst = max([worst, abs(other.force / one.force - 1)])
        worst = max([worst, *(np.abs(b - a).max() / np.abs(a).max() for a, b in pairs)])
    return float(worst)


def driven(body: InertialContact, dt: float, count: int, path: Callable[[Array], Array]) -> Array:
    """Return forces (count,) in mN along a path of depths from relaxed contact at its start."""
    at_rest = float(path(np.zeros(1))[0])
    for _ in range(3):
        _step(body, LONG, at_rest)
    forces = np.empty(count)
    for k, depth in enumerate(path(dt * np.arange(1.0, count + 1)).tolist()):
        _step(body, dt, depth)
        forces[k] = body.projected @ body.pressure
    return forces


def _step(body: InertialContact, dt: float, depth: float) -> None:
    """Advance by `dt` s to a depth in mm."""
    outcome = body.advance(dt, Target(depth))
    if outcome != DONE:
        raise ArithmeticError(body.failures[outcome])


def amplitude(forces: Array, dt: float, frequency: float, cycles: int) -> complex:
    """Complex amplitude of the last cycles of forces at a frequency, against a sine."""
    count = round(cycles / (frequency * dt))
    time = dt * np.arange(len(forces) - count + 1.0, len(forces) + 1)
    angle = 2 * np.pi * frequency * time
    basis = np.column_stack([np.sin(angle), np.cos(angle), np.ones(count), time - time[0]])
    parts = np.linalg.lstsq(basis, forces[-count:], rcond=None)[0]
    return complex(parts[0], parts[1])


def one_mode(steps: int) -> complex:
    """Relative complex error of the force on one mode and a residual flexibility.

    `steps` per cycle.
    """
    frequency, participation = 80.0, np.array([[1.2]])
    oscillators = Oscillators.of(np.array([(2 * np.pi * 100.0) ** 2]), WEIGHTS, RATES)
    residual = np.array([[2e-6]])
    dt = 1 / (frequency * steps)
    body = InertialContact(
        oscillators, participation, residual, np.zeros(1), np.ones(1), 1.001 * dt
    )
    small, cycles = 1e-6, 40
    forces = driven(
        body, dt, cycles * steps, lambda t: 1e-3 + small * np.sin(2 * np.pi * frequency * t)
    )
    held = ClosedContact.of(
        oscillators.omega_squared, participation, residual, np.ones(1), WEIGHTS, RATES
    )
    exact = held.stiffness(np.array([frequency]))[0]
    return complex(amplitude(forces, dt, frequency, 4) / small / exact - 1)


def one_mode_difference() -> float:
    """Return the error of the force on one mode, extrapolated from two lengths of steps."""
    coarse, fine = one_mode(1000), one_mode(2000)
    return abs((4 * fine - coarse) / 3)


@cache
def finger_error(steps: int, frequency: float = 200.0) -> float:
    """Return the relative error of the force on a finger, in `steps` per cycle."""
    dt = 1 / (200.0 * steps)
    small, cycles = 1e-6, 30
    forces = driven(
        contact_of(stepped_body(), 1.001 * dt),
        dt,
        cycles * steps,
        lambda t: DEPTH + small * np.sin(2 * np.pi * frequency * t),
    )
    exact = _held().stiffness(np.array([frequency]))[0]
    return float(abs(amplitude(forces, dt, frequency, 4) / small / exact - 1))


def finger_order() -> float:
    """Return the order of that error in the length of the step."""
    return float(np.log2(finger_error(60) / finger_error(120)))


def _held() -> ClosedContact:
    """Return the finger held at the preload, with the first static term alone, as through time."""
    parts = stepped_body()
    pressure = vibrations().vibrating.preload(DEPTH, None)[1]
    active = np.flatnonzero(pressure > 0)
    o = parts.oscillators
    return ClosedContact.of(
        *(o.omega_squared, parts.participation[:, active]),
        parts.residual_flexibility[np.ix_(active, active)],
        *(parts.static.patch.projected[active], o.weights, o.rates),
    )


def energy_difference() -> float:
    """Return work less stored, kinetic and lost energy of a fast press, over the work."""
    dt, speed = 2e-5, 200.0
    body = contact_of(stepped_body(), 1.001 * dt)
    o, residual = stepped_body().oscillators, stepped_body().residual_flexibility
    work = lost = last_force = last_loss = last_depth = 0.0
    top = DEPTH / speed
    for k in range(1, int(4 * top / dt) + 1):
        x = min(k * dt / top, 1.0)
        depth = DEPTH * x * x * (3 - 2 * x)
        _step(body, dt, depth)
        force = float(body.projected @ body.pressure)
        work += (force + last_force) / 2 * (depth - last_depth)
        stored, kinetic, power = energies(o, body.modes.filtered)
        elastic, loss = _of_residual(body, residual)
        lost += dt * (power + loss + last_loss) / 2
        last_force, last_depth, last_loss = force, depth, power + loss
    return abs(work - stored - kinetic - elastic - lost) / work


def energies(modes: Oscillators, filtered: Complex) -> tuple[float, float, float]:
    """Return stored and kinetic energy in nJ and lost power in nW.

    filtered (n, m + 2): the force of each mode, filtered by each of its poles.
    """
    each = modes.residues * filtered
    amplitude = each.sum(axis=1).real
    speed = (each * modes.poles).sum(axis=1).real
    stored, lost = float(modes.omega_squared @ amplitude**2) / 2, 0.0
    for weight, rate in zip(modes.weights, modes.rates, strict=True):
        held = (each * modes.poles / (modes.poles + rate)).sum(axis=1).real
        share = weight * float(modes.omega_squared @ held**2)
        stored, lost = stored + share / 2, lost + rate * share
    return stored, float(speed @ speed) / 2, lost


def _of_residual(body: InertialContact, residual: Array) -> tuple[float, float]:
    """Return stored energy in nJ and lost power in nW of the residual flexibility."""
    pad, lost = body.history, 0.0
    stored = float(pad.elastic @ residual @ pad.elastic) / 2
    for weight, rate, term in zip(pad.weights, pad.rates, pad.terms, strict=True):
        held = float(term @ residual @ term) / weight
        stored, lost = stored + held / 2, lost + rate * held
    return stored, lost


def largest_growth() -> float:
    """Return the largest real part over the modulus of all poles of a finger."""
    poles = stepped_body().oscillators.poles
    return float((poles.real / np.abs(poles)).max())


def before_the_knock() -> float:
    """Return the share of the answer to a knock, in energy, that comes before it.

    The flexibility at the indenter of a held finger, from its inverse; the knock is as smooth as
    the band is wide.
    """
    count, step = 2**14, 0.5
    frequency = np.asarray(step * np.arange(1.0, count), dtype=np.float64)
    flexibility = np.append(0.0, 1 / _held().stiffness(frequency))
    flexibility[0] = flexibility[1].real
    window = np.exp(-((np.append(0.0, frequency) / (0.35 * frequency[-1])) ** 2) * 8)
    # A delay of a quarter of the period puts what comes before the knock in front of it.
    delay = 0.25 / step
    shift = np.exp(-2j * np.pi * np.append(0.0, frequency) * delay)
    answer = np.fft.irfft(flexibility * window * shift)
    before = int(0.249 * len(answer))
    return float(np.sum(answer[:before] ** 2) / np.sum(answer**2))


def nonlinearity() -> float:
    """Return the force of twice the amplitude over twice the force, less 1."""
    frequency, dt = 150.0, 1 / (150.0 * 60)

    def force(small: float) -> complex:
        body = contact_of(stepped_body(), 1.001 * dt)
        path = driven(body, dt, 900, lambda t: DEPTH + small * np.sin(2 * np.pi * frequency * t))
        return amplitude(path, dt, frequency, 3)

    return float(abs(force(2e-6) / (2 * force(1e-6)) - 1))
