"""Fingers against published vibrations, without tuning; and what needs modes of its own."""

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Case, Expected, Noted
from fefinger.validation.waves import loops, preload
from scipy import sparse

from fefinger.fem.contact.closed_contact import ClosedContact
from fefinger.fem.elements.mass import mass
from fefinger.fem.modes import modes_of
from fefinger.mechanics.evidence import vibration
from fefinger.mechanics.press.mode_store import PER_CUBIC_METER, finger_modes
from fefinger.mechanics.press.operator import operator
from fefinger.mechanics.realtime.modal import Modal
from fefinger.mechanics.situation import Situation
from fefinger.results.harmonic import Complex, Harmonic
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.motions import FrequencySweep
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array


MESH = "standard"
VISCOUS = "maeno1998_viscous"
MANY = 900  # modes of the reference
HELD_OUT_PART = 0.08
"""Preload over the thickness at which the stated errors of stiffening tissue are tried."""

BAND = np.linspace(50.0, 450.0, 17)
"""Hz in which stated errors are compared."""

FREE = 4.0, 9.0
"""mm from first touch between which the skin is free of a contact of 0.5 N, before the first node
of the displacement."""


def mirror_difference() -> float:
    """Return the largest relative difference of two fingers under balls that are mirror images."""
    balls = [Sphere(5, at=(0.0, side)) for side in (1.5, -1.5)]
    fingers = [Modal(loops.finger(), ball, deepest=0.8) for ball in balls]
    frequency = np.array([20.0, 100.0, 200.0, 300.0])
    one, other = (each.harmonic(frequency, depth=0.5).stiffness for each in fingers)
    worst = float(np.abs(one / other - 1).max())
    for k in range(1, 400):
        depth = 0.5 * min(1.0, k / 50) + 0.02 * np.sin(2 * np.pi * 200 * k * 1e-4)
        forces = [each.step(depth, 1e-4).force for each in fingers]
        worst = max(worst, abs(forces[0] / forces[1] - 1) if forces[1] else 0.0)
    return worst


def stated_errors_hold() -> float:
    """Return the share of frequencies at which the stated error of the modes holds."""
    loop, depth = loops.loop(), loops.DEPTH
    stated, exact = loop.harmonic(BAND, depth=depth), _with_many(loop, depth)
    errors = np.abs(stated.stiffness / (2e-3 * exact.stiffness(BAND)) - 1)
    return float((errors <= stated.error + 1e-9).mean())


def _with_many(loop: Modal, depth: float) -> ClosedContact:
    """Return the finger held at a depth, with three times the modes."""
    prepared = loop.vibrating
    finger, solid, static = loop.finger, prepared.solid, prepared.body.static
    light = finger.skin.density * PER_CUBIC_METER
    found = modes_of(solid.parts[0].compliance, mass(solid.space, {1: 1.0, 2: 1.0}), MANY)
    squares = found.squares * finger.skin.modulus / light
    loads = static.patch.loads[: solid.space.n_displacements]
    shares = np.asarray(sparse.csr_matrix(loads.T) @ found.shapes).T / np.sqrt(light)
    active = np.flatnonzero(prepared.preload(depth, None)[1] > 0)
    o, here = prepared.body.oscillators, prepared.body.shares
    # The second static term: that of the modes at hand, less that of the further ones.
    total = prepared.inertia + (here.T / o.squares**2) @ here
    rest = static.flexibility - (shares.T / squares) @ shares
    inertia = total - (shares.T / squares**2) @ shares
    block = np.ix_(active, active)
    return ClosedContact.of(
        *(squares, shares[:, active], rest[block], static.patch.projected[active]),
        *(o.weights, o.rates, inertia[block]),
    )


@cache
def preloaded(part: float) -> preload.Preloaded:
    """Return the coarse finger of d.s., calibrated, pressed by a part of its thickness.

    The stated errors were measured at other preloads.
    """
    held_out = Finger.subject("d.s.", resolution="coarse")
    return preload.Preloaded.of(held_out, part * held_out.thickness)


def preload_slope() -> float:
    """Return the relaxed stiffness about a preload over a secant of equilibria, less 1."""
    prepared = preloaded(HELD_OUT_PART)
    return sum(prepared.statics) / prepared.secant(1e-3) - 1


def two_part_statics() -> float:
    """Return the error of G* a + b, from two real factors, for a complex one without inertia."""
    prepared = preloaded(HELD_OUT_PART)
    factor = complex(preload.modulus(prepared.press.finger, np.array([60.0]))[0])
    material, geometric = prepared.statics
    exact = prepared.stiffness(factor, 0.0)
    return abs((factor * material + geometric) / exact - 1)


def preload_error(kind: str) -> Noted:
    """Return the largest error of the harmonic answer of stiffening tissue over what is stated."""
    prepared = preloaded(HELD_OUT_PART)
    pressed = prepared.press.finger
    other = pressed if kind == "published" else preload.viscous(pressed)
    frequency = np.array([60.0, 120.0, 200.0])
    share = vibration.geometric_share(HELD_OUT_PART)
    factors = prepared.factor * (1 + share * (1 - 1 / np.abs(preload.modulus(other, frequency))))
    answers = [
        prepared.linear(other, frequency[k : k + 1], factor)[0] for k, factor in enumerate(factors)
    ]
    still = np.abs(prepared.still(other, frequency))
    errors = np.abs(np.array(answers) - prepared.exact(other, frequency)) / still
    stated = np.array([_stated(other, prepared.depth, each) for each in frequency])
    text = ", ".join(
        f"{100 * error:.2g} % of {100 * limit:.2g} % at {each:g} Hz"
        for error, limit, each in zip(errors, stated, frequency, strict=True)
    )
    return Noted(float((errors / stated).max()), text)


def _stated(finger: Finger, depth: float, frequency: float) -> float:
    """Return the stated error of the harmonic answer at a frequency about a depth."""
    motion = FrequencySweep(depth, amplitude=0.01, start=0.5 * frequency, stop=frequency)
    return vibration.vibration_error(Situation.of(Scene(finger=finger, motion=motion)), "harmonic")


@cache
def finger(tissue: str) -> Modal:
    """Return the standard finger of a.h. under the plate at 30 degrees."""
    made = Finger.subject(loops.SUBJECT, tissue=tissue, resolution=MESH)
    return Modal(made, Flat(30), deepest=2.0)


@cache
def answer(tissue: str, force: float) -> Harmonic:
    """Return its harmonic answer from 5 to 400 Hz at a preload in N."""
    return finger(tissue).harmonic(np.geomspace(5.0, 400.0, 120), force=force)


def modes_below(frequency: float) -> float:
    """Return how many modes the whole free finger has below a frequency in Hz, relaxed."""
    whole = loops.finger(MESH)
    return float(np.sum(finger_modes(whole, operator(whole, half=False)).frequencies < frequency))


def stiffness_at(tissue: str, force: float, frequency: float) -> float:
    """Return the real dynamic stiffness in N/mm at a preload in N and a frequency in Hz."""
    found = answer(tissue, force)
    return float(np.interp(frequency, found.frequency, found.stiffness.real))


def damping_at(tissue: str, force: float, frequency: float) -> float:
    """Return the loss over the angular frequency in N s/m."""
    found = answer(tissue, force)
    loss = found.stiffness.imag / (2 * np.pi * found.frequency)
    return float(1e3 * np.interp(frequency, found.frequency, loss))


def impedance_phase(tissue: str, force: float, frequency: float) -> float:
    """Return the phase in degrees of the impedance, force over velocity."""
    found = answer(tissue, force)
    phase = np.degrees(np.angle(found.impedance))
    return float(np.interp(frequency, found.frequency, phase))


def along_skin(tissue: str, frequency: float) -> tuple[Array, Complex]:
    """Return distance in mm proximal of the contact, and complex displacement of the skin there."""
    found = finger(tissue).harmonic([frequency], force=0.5)
    x, moved = found.skin_points[:, 0], found.skin[0, :, 2]
    reach = (x < -FREE[0]) & (x > -FREE[1])
    order = np.argsort(-x[reach])
    return -x[reach][order], moved[reach][order]


def wave_speed(tissue: str, frequency: float) -> float:
    """Return the phase speed in m/s of the normal displacement along the skin."""
    distance, moved = along_skin(tissue, frequency)
    phase = np.unwrap(np.angle(moved))
    slope = np.polyfit(distance, phase, 1, w=np.abs(moved))[0]
    return float(1e-3 * 2 * np.pi * frequency / abs(slope))


def attenuation(tissue: str, frequency: float) -> float:
    """Return the decay in dB/mm of the normal displacement along the skin."""
    distance, moved = along_skin(tissue, frequency)
    slope = np.polyfit(distance, 20 * np.log10(np.abs(moved)), 1)[0]
    return float(-slope)


def speed_noted(tissue: str) -> Noted:
    """Return the phase speed in m/s along the pad at 300 Hz, with the decay beside it."""
    speeds = [f"{wave_speed(tissue, f):.3g} m/s at {f:g} Hz" for f in (100.0, 200.0, 400.0)]
    decays = [f"{attenuation(tissue, f):.2g} dB/mm at {f:g} Hz" for f in (100.0, 200.0, 400.0)]
    return Noted(wave_speed(tissue, 300.0), f"{', '.join(speeds)}; decay {', '.join(decays)}")


def phase_rise(tissue: str) -> Noted:
    """Return by how many degrees the phase of the impedance rises from 30 to 200 Hz at 0.5 N."""
    at = {f: impedance_phase(tissue, 0.5, f) for f in (10.0, 30.0, 100.0, 200.0, 300.0)}
    text = ", ".join(f"{phase:.0f} degrees at {f:g} Hz" for f, phase in at.items())
    return Noted(at[200.0] - at[30.0], text)


LATERAL = "the published one is of lateral motion, and its digits are quoted from memory"

SPEED = (
    "a pad of 5 mm over bone carries no wave below some 300 Hz (wave speed over four thicknesses): "
    "beyond the contact the skin moves in phase and dies out within mm, so that the phase speed is "
    "that of no wave; shear waves in this tissue run at 6 m/s in the pulp and 10 m/s in the skin"
)


def verdicts() -> Iterator[Case]:
    """Yield the comparisons with published fingers; none is tuned to pass."""
    yield Case(
        "modes of the free finger below 250 Hz, relaxed tissue",
        partial(modes_below, 250.0),
        Expected(7.0, 0.0, "1"),
        "Serhat and Kuchenbecker (2021), Appl. Sci. 11:5709: seven, finite elements",
    )
    for force, found in ((0.2, 1.27), (0.5, 1.85), (1.0, 2.50)):
        yield Case(
            f"stiffness at 20 Hz, preload {force:g} N, maeno1998",
            partial(stiffness_at, loops.TISSUE, force, 20.0),
            Expected(found, 0.03 * found, "N/mm"),
            WIERTLEWSKI,
            wanted=1.0,
            shortfall=f"published moduli are taken as relaxed ones; {LATERAL}",
        )
    for tissue, found, why in (
        (loops.TISSUE, 0.2, "its relaxation ends at 36 Hz: nothing is lost at 200 Hz"),
        (
            VISCOUS,
            2.78,
            "its branch has the published ratio of loss to stiffness, and this finger "
            "has 2.7 times the published stiffness",
        ),
    ):
        yield Case(
            f"loss over angular frequency at 200 Hz, preload 0.5 N, {tissue}",
            partial(damping_at, tissue, 0.5, 200.0),
            Expected(found, 0.05 * found, "N s/m"),
            WIERTLEWSKI,
            wanted=1.0,
            shortfall=f"{why}; {LATERAL}",
        )
    source = "the source thesis, section 2.3: measured phases rise above 30 Hz (its Fig. 2-9)"
    yield Case(
        f"rise of the phase of the impedance from 30 to 200 Hz, {loops.TISSUE}",
        partial(phase_rise, loops.TISSUE),
        Expected(-12.7, 0.6, "degrees"),
        source,
        wanted=5.0,
        shortfall=(
            "inertia alone does not explain it: the phase falls as in the model without mass (-12 "
            "degrees) up to 200 Hz, and rises beyond, where the finger resonates"
        ),
    )
    yield Case(
        f"rise of the phase of the impedance from 30 to 200 Hz, {VISCOUS}",
        partial(phase_rise, VISCOUS),
        Expected.between(5.0, 60.0, "degrees"),
        source,
        reason="that it rises; how far was not read",
    )
    for tissue, found in ((loops.TISSUE, 30.1), (VISCOUS, 18.7)):
        yield Case(
            f"phase speed along the pad at 300 Hz, {tissue}",
            partial(speed_noted, tissue),
            Expected(found, 0.05 * found, "m/s"),
            MANFREDI,
            wanted=7.0,
            shortfall=SPEED,
        )


WIERTLEWSKI = "Wiertlewski and Hayward (2012), quoted from memory: about 1 N/mm and 1 N s/m"
MANFREDI = "Manfredi et al. (2012): plateau of some 7 m/s"
