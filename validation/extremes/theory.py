"""Closed forms at the edges that scenes do not reach, called directly."""

from collections.abc import Callable, Iterator
from decimal import Decimal, getcontext
from functools import cache, partial

import numpy as np
from fefinger.validation.extremes.invariants import ROUNDING, falling, not_finite, off
from fefinger.validation.extremes.scenes import SERIES, ramp
from fefinger.validation.extremes.scenes import answered as answered_scene
from fefinger.validation.extremes.trial import (
    ANSWERED,
    REFUSED,
    THEORY,
    Findings,
    Row,
    Trial,
    grouped,
)
from fefinger.validation.oracles.fingerpad import Fingerpad
from fefinger.validation.oracles.impedance import impedance
from fefinger.validation.oracles.sphere import Sphere

from fefinger.scene.motions import Sinusoid
from fefinger.theory.contact import ting
from fefinger.theory.contact.elliptic import Elliptic
from fefinger.theory.contact.hertz import Hertz
from fefinger.theory.contact.indentation import Contact, paraboloid
from fefinger.theory.contact.stack import Layer, Stack
from fefinger.theory.lumped import spring as lumped
from fefinger.theory.relaxation import Prony, hereditary_integral


EXACT = 1e-13
"""Relative, for what a few roundings should leave of an exact number."""

PLAIN = Prony((0.3, 0.7), (10.0,))


@cache
def trials() -> tuple[Trial, ...]:
    """Return the problems of theory."""
    return grouped(THEORY, _springs, _series, _contacts, _layers, _many)


def _springs() -> Iterator[Row]:
    """b/m (exp(m x) - 1) for m near 0 and large, and the finger that it makes."""
    for m in (1e-300, 1e-12, 1e-6, 1.0, 100.0, 590.0):
        yield "exponential", f"m = {m:g} 1/mm", partial(_spring, m), ANSWERED
        yield "exponential", f"force back to position, m = {m:g}", partial(_inverse, m), ANSWERED
        yield "exponential", f"relaxing, m = {m:g} 1/mm", partial(_relaxing, m), ANSWERED
    for m in (800.0, 1e6, 1e300):
        for name, ask in {
            "force": lambda m: lumped.Spring(0.2, m).force([1.0]),
            "relaxing": lambda m: lumped.force(lumped.Spring(0.2, m), PLAIN, [0, 1], [0, 1]),
            "at constant velocity": lambda m: lumped.constant_velocity(
                lumped.Spring(0.2, m), PLAIN, [1.0], 60.0
            ),
            "pressure": lambda m: Fingerpad(14.0, m, 30.0, PLAIN).force([1.0]),
        }.items():
            yield "exponential", f"{name}, m = {m:g} 1/mm", partial(_refused, ask, m), REFUSED
    for m in (1e-12, 1e-3, 500.0):
        yield "exponential", f"depth under a force, m = {m:g}", partial(_pad, m), ANSWERED


def _refused(ask: Callable[[float], object], value: float) -> Findings:
    return {"finite": not_finite(np.asarray(ask(value)))}


def _spring(m: float) -> Findings:
    """Compare with 60 digits, from 1e-12 mm to 1 mm."""
    getcontext().prec = 60
    x = np.logspace(-12, 0, 13)
    big = Decimal(m)
    stiff = Decimal.from_float(0.2)
    exact = [
        float(stiff * (((big * each).exp() - 1) / big if m > 1e-40 else each))
        for each in map(Decimal.from_float, x.tolist())
    ]
    forces = lumped.Spring(0.2, m).force(x)
    relative = float(np.abs(forces / exact - 1).max())
    return {"60 digits": (relative, EXACT * max(1.0, m)), "rising": falling(forces)}


def _inverse(m: float) -> Findings:
    spring = lumped.Spring(0.2, m)
    x = np.logspace(-9, 0, 10)
    back = spring.position(spring.force(x))
    return {"back": (float(np.abs(back / x - 1).max()), 1e-9)}


def _relaxing(m: float) -> Findings:
    """Compare with constant velocity in closed form; and out again the work is not negative."""
    spring = lumped.Spring(0.2, m)
    time = np.linspace(0, 0.02, 400)
    forces = lumped.force(spring, PLAIN, time, 50 * time)
    closed = lumped.constant_velocity(spring, PLAIN, 50 * time, 50.0)
    cycle = np.append(50 * time, 50 * time[::-1][1:])
    at = np.append(time, 0.02 + time[1:])
    force = lumped.contact_force(spring, PLAIN, at, cycle)
    work = float(np.sum((force[1:] + force[:-1]) / 2 * np.diff(cycle)))
    return {
        "closed form": off(forces, closed, 1e-9),
        "no pull": (max(0.0, -float(force.min())), 0.0),
        "work": (max(0.0, -work / float(force.max())), ROUNDING),
    }


def _pad(m: float) -> Findings:
    pad = Fingerpad(14.0, m, 30.0, PLAIN)
    force = pad.force([1e-6, 1e-2, 1.0])
    return {"back": off(pad.force(pad.depth_at(force)) / force, np.ones(3), 1e-9)}


def _series() -> Iterator[Row]:
    """Prony series of one to ten terms, their creep, and steps of 1e-6 to 1e3 s."""
    extra = {
        "G(inf) = 1e-12, rates 1e-6 to 1e6": Prony(
            (1e-12, *(10 * ((1 - 1e-12) / 10,))), tuple(np.logspace(-6, 6, 10))
        ),
        "two rates 1e-12 apart": Prony((0.2, 0.4, 0.4), (5.0, 5.0 * (1 + 1e-12))),
        "a weight of nothing": Prony((0.3, 0.7, 0.0), (5.0, 50.0)),
    }
    for name, prony in (SERIES | extra).items():
        yield "Prony", f"step and ramp: {name}", partial(_step, prony), ANSWERED
        yield "Prony", f"creep: {name}", partial(_creep, prony), ANSWERED
        yield "Prony", f"contact in and out: {name}", partial(_contact, prony), ANSWERED


TIMES = np.concatenate([[0.0], np.logspace(-6, 3, 181)])


def _step(prony: Prony) -> Findings:
    """Compare the relaxation of a step and the rise of a ramp with G and its integral."""
    step = hereditary_integral(prony, TIMES, np.ones(len(TIMES)))
    line = hereditary_integral(prony, TIMES, TIMES)
    shares, rates = np.array(prony.weights), np.array(prony.v)
    exact = shares[0] * TIMES - np.expm1(-np.outer(TIMES, rates)) @ (shares[1:] / rates)
    return {
        "G": off(step, prony.relaxation(TIMES), EXACT),
        "falling": falling(-step, 1e-15),
        "integral of G": (float(np.abs(line[1:] / exact[1:] - 1).max()), 1e-9),
    }


def _creep(prony: Prony) -> Findings:
    """Return whether the creep function undoes relaxation, at every time and for every rate.

    J(0) = 1; its rates are positive and lie between those of G; G(s) J(s) = 1 / s² in Laplace's s.
    """
    ceiling, k, lam = prony.creep()
    shares, rates = np.array(prony.weights), np.array(prony.v)
    s = np.logspace(-15, 9, 97)[:, None]
    stiff = shares[0] + (shares[1:] * s / (s + rates)).sum(axis=1)
    soft = 1 + (k * lam / (s + lam)).sum(axis=1)
    ordered = np.sort(rates)
    outside = int(np.sum(lam > ordered * (1 + EXACT))) + int(np.sum(lam <= 0))
    outside += int(np.sum(lam[1:] < ordered[:-1] * (1 - EXACT)))
    return {
        "finite": not_finite(k, lam, ceiling),
        "between the rates": (float(outside), 0.0),
        "J(inf) = 1 / G(inf)": off(1 + k.sum(), ceiling, 1e-9),
        "no weight below 0": (max(0.0, -float(k.min(initial=0.0))), 0.0),
        "undoes": (float(np.abs(stiff * soft - 1).max()), 1e-8),
    }


def _contact(prony: Prony) -> Findings:
    """Return the invariants of Hertz's contact that is pressed and let go, three times."""
    time = np.linspace(0, 3, 601)
    depth = np.abs(np.sin(np.pi * time))
    nodes = ting.radius_nodes(1.0)
    history = ting.press_by_depth(prony, time, depth, nodes)
    force = history.stress(nodes**1.5)
    work = float(np.sum((force[1:] + force[:-1]) / 2 * np.diff(depth)))
    most = float(force.max())
    elastic = off(force, depth**1.5, 1e-2) if prony.c[0] > 0.999 else (0.0, 1.0)
    return {
        "finite": not_finite(force, history.stressed, history.strained),
        "no pull": (max(0.0, -float(force.min()) / most), 1e-12),
        "no more than elastic": (max(0.0, float((force - depth**1.5).max())), 1e-3),
        "elastic where nothing relaxes": elastic,
        "work": (max(0.0, -work / most), 1e-3),
    }


def _contacts() -> Iterator[Row]:
    """Return half-spaces under contacts 1e-12 to 1 as deep as the radius, at all nu."""
    for part in (1e-12, 1e-6, 1e-2, 1.0):
        for poisson in (0.0, 0.5):
            name = f"depth / R = {part:g}, nu = {poisson:g}"
            yield "Hertz", name, partial(_hertz, part, poisson), ANSWERED
    yield "Hertz", "depth / R = 1.01", partial(_hertz, 1.01, 0.3), REFUSED
    yield "Hertz", "first touch", _first_touch, ANSWERED
    for part in (1e-12, 1e-6, 1e-3, 1.3):
        yield "sphere", f"depth / R = {part:g}", partial(_sphere, part), ANSWERED
    yield "sphere", "depth / R = 1.4", partial(_sphere, 1.4), REFUSED
    for ratio in (1.0, 1 + 1e-15, 1 + 1e-8, 10.0, 1e6):
        yield "ellipse", f"R' / R'' = {ratio:.17g}", partial(_ellipse, ratio), ANSWERED
    yield "ellipse", "R' / R'' = 1e7", partial(_ellipse, 1e7), REFUSED
    for frequency in (1e-9, 1e-3, 1e9):
        yield "impedance", f"{frequency:g} Hz", partial(_impedance, frequency), ANSWERED
    yield "impedance", "0 Hz", partial(_impedance, 0.0), REFUSED


def _hertz(part: float, poisson: float) -> Findings:
    """Return the field from the rim inward and outward, and that scale does not matter."""
    fields = []
    for size in (1e-6, 1.0, 1e6):
        body = Hertz(14 * size, 14 * part * size, 80.0, poisson)
        grid = np.meshgrid([0, 0.5, 1, 2, 1e6], [0, 1e-9, 1, 1e6])
        r, z = (body.contact_radius * at for at in grid)
        fields.append((body.force / size**2, body.stress(r, z), body.displacement(r, z) / size))
    one, other = fields[1], (fields[0], fields[2])
    pressure = -one[1][2][0]
    return {
        "finite": not_finite(*one[1:], *one[:1]),
        "no pull": (max(0.0, -float(pressure.min())), ROUNDING),
        "scale of force": max(off(each[0], one[0], EXACT) for each in other),
        "scale of stress": max(off(each[1], one[1], 1e-9) for each in other),
        "scale of displacement": max(off(each[2], one[2], 1e-9) for each in other),
    }


def _first_touch() -> Findings:
    body = Hertz(14.0, 0.0, 80.0, 0.5)
    return {"nothing": (float(np.abs(body.stress([0, 1.0], [0, 1.0])).max()) + body.force, 0.0)}


def _sphere(part: float) -> Findings:
    """Return the force against Hertz, which it is at small depths and falls below at large ones."""
    ball = Sphere.at_depth(14.0, 14 * part, modulus=80.0, poisson=0.3)
    ratio = ball.force / (4 / 3 * 80 / 0.91 * 14**0.5 * (14 * part) ** 1.5)
    limit = 1e-9 + part
    return {"Hertz": (abs(ratio - 1), limit), "below": (max(0.0, ratio - 1), ROUNDING)}


def _ellipse(ratio: float) -> Findings:
    body = Elliptic(2.0 * ratio, 2.0, 1e-3, 80.0, 0.3)
    findings = {"finite": not_finite(body.force, *body.semi_axes)}
    if ratio - 1 < 1e-6:
        findings["circle"] = off(body.force, Hertz(2.0, 1e-3, 80.0, 0.3).force, 1e-7)
    again = Elliptic(2e6 * ratio, 2e6, 1e3, 80.0, 0.3)
    return findings | {"scale": off(again.force / 1e12, body.force, 1e-9)}


def _impedance(frequency: float) -> Findings:
    """Return whether the phase is that of something that stores and loses, and takes no energy."""
    spring = lumped.Spring(0.2, 2.0)
    z = impedance(spring, PLAIN, np.array([frequency]), 0.5)
    stiffness = z * 2j * np.pi * frequency
    return {
        "finite": not_finite(z.real, z.imag),
        "no energy made": (max(0.0, -float(stiffness.imag.min() / np.abs(stiffness).max())), 0.0),
    }


def _layers() -> Iterator[Row]:
    """Stacks with moduli 1e9 apart, films, and contacts far smaller and wider than they are."""
    for contrast in (1e-9, 1e-3, 1.0, 1e3, 1e9):
        for poisson in (0.0, 0.5):
            name = f"moduli 1 to {contrast:g}, nu = {poisson:g}"
            yield "stack", name, partial(_stack, contrast, poisson, 1.0), None
    for wide in (1e-6, 1e-3, 30.0, 90.0):
        yield "stack", f"contact radius {wide:g} thicknesses", partial(_wide, wide), ANSWERED
    yield "stack", "contact radius 300 thicknesses", partial(_wide, 300.0), REFUSED


def _stack(contrast: float, poisson: float, wide: float) -> Findings:
    """Return bounds: between a half-space and what is bonded to rigid ground at once."""
    body = Stack((Layer(1.0, 80.0, poisson), Layer(4.0, 80.0 * contrast, poisson)))
    contact = paraboloid(body, 1e3, contact_radius=wide)
    pressure = contact.pressure(np.linspace(0, wide, 50))
    rigid = paraboloid(Stack((Layer(1.0, 80.0, poisson),)), 1e3, contact_radius=wide)
    soft, stiff = contact.force / contact.depth, rigid.force / rigid.depth
    bound = max(0.0, soft / stiff - 1) if contrast >= 1 else 0.0
    return {
        "finite": not_finite(pressure, contact.force, contact.depth),
        "depth above 0": (max(0.0, -contact.depth), 0.0),
        "softer than on rigid ground": (bound, 1e-6),
        "balance": off(_carried(contact), contact.force, 1e-6),
    }


def _carried(contact: Contact) -> float:
    """Return the force of the pressure by its own integral, in r = a sin t."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    t = np.pi / 4 * (nodes + 1)
    a = contact.contact_radius
    p = contact.pressure(a * np.sin(t))
    return float(2 * np.pi * a**2 * np.pi / 4 * weights @ (p * np.sin(t) * np.cos(t)))


def _wide(wide: float) -> Findings:
    body = Stack((Layer(1.0, 80.0, 0.3),))
    contact = paraboloid(body, 1e4, contact_radius=wide)
    large = Stack((Layer(1e3, 80.0, 0.3),))
    again = paraboloid(large, 1e7, contact_radius=1e3 * wide)
    findings = {"balance": off(_carried(contact), contact.force, 1e-6)}
    if wide < 1e-2:
        hertz = Hertz(1e4, contact.depth, 80.0, 0.3).force
        findings["half-space"] = off(contact.force, hertz, 2 * wide)
    return findings | {"scale": off(again.force / 1e6, contact.force, 1e-9)}


def _many() -> Iterator[Row]:
    yield "cycles", "1e5 cycles at 200 Hz of the lumped finger", _cycles, ANSWERED


def _cycles() -> Findings:
    """Return that the last cycle repeats the one before, as all do once the slow terms are over."""
    motion = Sinusoid(amplitude=0.3, frequency=200, cycles=100_000)
    _, response = answered_scene("lumped", {"motion": motion})
    per = (len(response.time) - 1) // 100_000
    force = response.force
    work = float(np.sum((force[1:] + force[:-1]) / 2 * np.diff(response.depth)))
    return {
        "finite": not_finite(force),
        "no pull": (max(0.0, -float(force.min())), 0.0),
        "the last cycle repeats": off(force[-per:], force[-2 * per : -per], 1e-6),
        "work": (max(0.0, -work), 0.0),
        "one ramp as ever": falling(answered_scene("lumped", {"motion": ramp(60, 0.6)})[1].force),
    }
