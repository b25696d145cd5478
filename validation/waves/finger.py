"""Fingers against published vibrations, without tuning; and what needs modes of its own."""

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Case, Expected, Noted
from fefinger.validation.waves import lateral, loops, preload
from scipy import sparse

from fefinger.contact.oscillators import ClosedContact
from fefinger.fem.elements.assembly import mass
from fefinger.fem.modes import modes_of
from fefinger.mechanics import modal, pressed, solid
from fefinger.mechanics.evidence import vibration
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.press.modal_body import PER_CUBIC_METER, finger_modes
from fefinger.mechanics.press.operator import operator
from fefinger.mechanics.situation import Situation
from fefinger.mechanics.vibrations import Vibrations
from fefinger.results.records import Complex, Harmonic
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.motions import FrequencySweep, RampSinusoid
from fefinger.scene.scene import Scene
from fefinger.studies.tables import dynamic_stiffness
from fefinger.support.arrays import Array


MESH = "standard"
VISCOUS = "maeno1998_viscous"
MANY = 900  # modes of the reference
HELD_OUT_PART = 0.08
"""Preload over the thickness at which the stated errors of stiffening tissue are tried."""

LONG = 100.0
"""s of rest in which the tissue relaxes at the preload."""

SLOW = 20.0
"""Hz at which inertia changes nothing."""

BAND = np.linspace(50.0, 450.0, 17)
"""Hz in which stated errors are compared."""

FREE = 4.0, 9.0
"""mm from first touch between which the skin is free of a contact of 0.5 N, before the first node
of the displacement."""


def mirror_difference() -> float:
    """Return the largest relative difference of two fingers under balls that are mirror images."""
    balls = [Sphere(5, at=(0.0, side)) for side in (1.5, -1.5)]
    fingers = [Loop(loops.finger(), ball, mechanics="modal", deepest=0.8) for ball in balls]
    frequency = np.array([20.0, 100.0, 200.0, 300.0])
    one, other = (
        Vibrations.of(each.prepared, 0.8).harmonic(frequency, depth=0.5).stiffness
        for each in fingers
    )
    worst = float(np.abs(one / other - 1).max())
    for k in range(1, 400):
        depth = 0.5 * min(1.0, k / 50) + 0.02 * np.sin(2 * np.pi * 200 * k * 1e-4)
        forces = [each.step(1e-4, depth=depth).force for each in fingers]
        worst = max(worst, abs(forces[0] / forces[1] - 1) if forces[1] else 0.0)
    return worst


def stated_errors_hold() -> float:
    """Return the share of frequencies at which the stated error of the modes holds."""
    loop, depth = loops.vibrations(), loops.DEPTH
    stated, exact = loop.harmonic(BAND, depth=depth), _with_many(loop, depth)
    errors = np.abs(stated.stiffness / (2e-3 * exact.stiffness(BAND)) - 1)
    return float((errors <= stated.error + 1e-9).mean())


def _with_many(loop: Vibrations, depth: float) -> ClosedContact:
    """Return the finger held at a depth, with three times the modes."""
    prepared = loop.vibrating
    finger, solid, static = loop.finger, prepared.solid, prepared.body.static
    light = finger.skin.density * PER_CUBIC_METER
    found = modes_of(solid.parts[0].compliance, mass(solid.space, {1: 1.0, 2: 1.0}), MANY)
    omega_squared = found.omega_squared * finger.skin.modulus / light
    loads = static.patch.loads[: solid.space.n_displacements]
    participation = np.asarray(sparse.csr_matrix(loads.T) @ found.shapes).T / np.sqrt(light)
    active = np.flatnonzero(prepared.preload(depth, None)[1] > 0)
    o, here = prepared.body.oscillators, prepared.body.participation
    # The second static term: that of the modes at hand, less that of the further ones.
    total = prepared.static(np.arange(here.shape[1])).inertia + (here.T / o.omega_squared**2) @ here
    residual = static.flexibility - (participation.T / omega_squared) @ participation
    inertia = total - (participation.T / omega_squared**2) @ participation
    block = np.ix_(active, active)
    return ClosedContact.of(
        *(omega_squared, participation[:, active], residual[block], static.patch.projected[active]),
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
    answer = prepared.linear(other, frequency, vibration.geometric_share(HELD_OUT_PART))
    still = np.abs(prepared.still(other, frequency))
    errors = np.abs(answer - prepared.exact(other, frequency)) / still
    stated = np.array([_stated(other, prepared.depth, each) for each in frequency])
    text = ", ".join(
        f"{100 * error:.2g} % of {100 * limit:.2g} % at {each:g} Hz"
        for error, limit, each in zip(errors, stated, frequency, strict=True)
    )
    return Noted(float((errors / stated).max()), text)


def through_time() -> Noted:
    """Return the error of a slow vibration through time, peak to peak, over what is stated."""
    held_out = Finger.subject("d.s.", resolution="coarse")
    depth = HELD_OUT_PART * held_out.thickness
    motion = RampSinusoid(20.0, depth, amplitude=0.02, frequency=SLOW, cycles=3, settle=1.0)
    ask = Ask(pressure=False, strain=False, fields=False)
    scene = Scene(finger=held_out, motion=motion, ask=ask)
    swings = []
    for mechanics in (solid, modal, pressed):
        answer = mechanics.respond(scene)
        last = answer.time > motion.duration - 1 / SLOW
        swings.append(float(np.ptp(answer.force[last])))
    stated = vibration.vibration_error(Situation.of(scene))
    with_share, without = (swing / swings[0] - 1 for swing in swings[1:])
    text = (
        f"{100 * with_share:.2g} % of {100 * stated:.2g} %; `pressed` alone {100 * without:.2g} %"
    )
    return Noted(abs(with_share) / stated, text)


def vibration_through_time() -> Noted:
    """Return the error of vibrations through time over what is stated, with viscous relaxation."""
    prepared = preloaded(HELD_OUT_PART)
    finger = preload.viscous(prepared.press.finger)
    ask = Ask(pressure=False, strain=False, fields=False)
    shares, parts = [], []
    for frequency in (100.0, 200.0, 300.0):
        motion = RampSinusoid(
            *(20.0, prepared.depth), amplitude=0.005, frequency=frequency, cycles=12, settle=LONG
        )
        scene, at = Scene(finger=finger, motion=motion, ask=ask), np.array([frequency])
        exact, still = prepared.exact(finger, at)[0], prepared.still(finger, at)[0]
        stated, errors = vibration.vibration_error(Situation.of(scene)), []
        for mechanics in (modal, pressed):
            answer = mechanics.respond(scene)
            stiffness = dynamic_stiffness(motion, answer.time, answer.depth, answer.force)
            errors.append(np.inf if stiffness is None else float(abs((stiffness - exact) / still)))
        shares.append(errors[0] / stated)
        parts.append(
            f"{100 * errors[0]:.2g} % of {100 * stated:.2g} % at {frequency:g} Hz "
            f"(`pressed` {100 * errors[1]:.2g} %)"
        )
    return Noted(max(shares), ", ".join(parts))


def _stated(finger: Finger, depth: float, frequency: float) -> float:
    """Return the stated error of the harmonic answer at a frequency about a depth."""
    motion = FrequencySweep(depth, amplitude=0.01, start=0.5 * frequency, stop=frequency)
    return vibration.vibration_error(Situation.of(Scene(finger=finger, motion=motion)))


@cache
def finger(tissue: str) -> Vibrations:
    """Return the standard finger of a.h. under the plate at 30 degrees."""
    made = Finger.subject(loops.SUBJECT, tissue=tissue, resolution=MESH)
    return Vibrations(made, Flat(30), deepest=2.0)


@cache
def answer(tissue: str, force: float) -> Harmonic:
    """Return its harmonic answer from 5 to 400 Hz at a preload in N."""
    return finger(tissue).harmonic(np.geomspace(5.0, 400.0, 120), force=force)


def modes_below(frequency: float) -> float:
    """Count the modes of the whole free finger below a frequency in Hz, relaxed."""
    whole = loops.finger(MESH)
    return float(np.sum(finger_modes(whole, operator(whole, half=False)).frequencies < frequency))


def slope(tissue: str, force: float) -> Noted:
    """Return the slope in dB per decade of the impedance along the normal from 30 to 200 Hz."""
    harmonic = answer(tissue, force)
    chosen = (harmonic.frequency >= 30) & (harmonic.frequency <= 200)
    decibel = 20 * np.log10(np.abs(harmonic.impedance[chosen]))
    fall = float(np.polyfit(np.log10(harmonic.frequency[chosen]), decibel, 1)[0])
    at = {
        f: np.interp(f, harmonic.frequency, np.abs(harmonic.impedance))
        for f in (30.0, 100.0, 200.0)
    }
    return Noted(fall, ", ".join(f"{value:.3g} N s/m at {f:g} Hz" for f, value in at.items()))


def impedance_phase(tissue: str, force: float, frequency: float) -> float:
    """Return the phase in degrees of the impedance, force over velocity."""
    harmonic = answer(tissue, force)
    phase = np.degrees(np.angle(harmonic.impedance))
    return float(np.interp(frequency, harmonic.frequency, phase))


def along_skin(tissue: str, frequency: float) -> tuple[Array, Complex]:
    """Return distance in mm proximal of the contact, and complex displacement of the skin there."""
    harmonic = finger(tissue).harmonic([frequency], force=0.5)
    x, moved = harmonic.skin_points[:, 0], harmonic.skin[0, :, 2]
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
    still = massless_phase(tissue, np.array(list(at)))
    each = zip(at.items(), still, strict=True)
    text = ", ".join(f"{f:g} Hz: {phase:.0f} ({other:.0f})" for (f, phase), other in each)
    return Noted(at[200.0] - at[30.0], f"phase in degrees (without mass): {text}")


def massless_phase(tissue: str, frequency: Array) -> Array:
    """Return the phase (n_f,) in degrees of the impedance of a finger without mass."""
    made = finger(tissue).finger
    return np.degrees(np.angle(preload.modulus(made, frequency))) - 90.0


SPEED = (
    "a pad of 5 mm over bone carries no wave below some 300 Hz (wave speed over four thicknesses): "
    "beyond the contact the skin moves in phase and dies out within mm, so that the phase speed is "
    "that of no wave; shear waves in this tissue run at 6 m/s in the pulp and 10 m/s in the skin"
)


def _along_the_skin() -> Iterator[Case]:
    for force in (0.2, 0.5, 1.0):
        yield Case(
            f"impedance along the skin at 200 Hz over the published one, preload {force:g} N, "
            f"{VISCOUS}",
            partial(lateral.magnitude, VISCOUS, force),
            Expected.between(*lateral.RANGE),
            WIERTLEWSKI,
            reason="the range of the people at 0.5 N over the fit",
        )
        yield Case(
            f"phase of the impedance along the skin at 200 Hz less the published one, preload "
            f"{force:g} N, {VISCOUS}",
            partial(lateral.phase, VISCOUS, force),
            Expected(0.0, 15.0, "degrees"),
            WIERTLEWSKI,
            reason="110 to 230 mg turn it by 5 degrees, people by 2, slow relaxation by 8",
        )
    yield Case(
        f"phase of the impedance along the skin at 200 Hz less the published one, preload 0.5 N, "
        f"{loops.TISSUE}",
        partial(lateral.phase, loops.TISSUE, 0.5),
        Expected(-56.0, 3.0, "degrees"),
        WIERTLEWSKI,
        wanted=0.0,
        shortfall="published relaxation ends at 36 Hz: at 200 Hz nothing is lost",
    )


def verdicts() -> Iterator[Case]:
    """Yield the comparisons with published fingers; none is tuned to pass."""
    name = "modes of the free finger below 250 Hz, relaxed tissue"
    origin = "Serhat and Kuchenbecker (2021), Appl. Sci. 11:5709: seven, finite elements"
    yield Case(name, partial(modes_below, 250.0), Expected(7.0, 0.0), origin)
    yield from _along_the_skin()
    for tissue, found, shortfall in (
        (loops.TISSUE, -19.0, ""),
        (VISCOUS, -12.0, "the branch was identified along the skin, where the stiffness rises"),
    ):
        yield Case(
            f"slope of the impedance along the normal from 30 to 200 Hz, preload 1 N, {tissue}",
            partial(slope, tissue, 1.0),
            Expected(found, 2.0, "dB/decade"),
            "the source thesis, section 2.3: Thompson et al., 16 subjects, 0.5 to 5.6 N (Fig. 2-7)",
            wanted=-20.0 if shortfall else None,
            shortfall=shortfall,
        )
    source = "the source thesis, section 2.3: measured phases rise above 30 Hz (its Fig. 2-9)"
    yield Case(
        f"rise of the phase of the impedance from 30 to 200 Hz without mass, {loops.TISSUE}",
        lambda: float(np.diff(massless_phase(loops.TISSUE, np.array([30.0, 200.0])))[0]),
        Expected(-13.6, 0.1, "degrees"),
        source,
        wanted=5.0,
        shortfall="the model of the source: the discrepancy between its Figs 2-8 and 2-9",
    )
    yield Case(
        f"rise of the phase of the impedance from 30 to 200 Hz, {loops.TISSUE}",
        partial(phase_rise, loops.TISSUE),
        Expected(-12.7, 0.6, "degrees"),
        source,
        wanted=5.0,
        shortfall=(
            "inertia alone does not explain it: the phase falls as in the model without mass (-14 "
            "degrees) up to 200 Hz, and rises beyond, where the finger resonates"
        ),
    )
    name = f"rise of the phase of the impedance from 30 to 200 Hz, {VISCOUS}"
    measure = partial(phase_rise, VISCOUS)
    limits = Expected.between(5.0, 60.0, "degrees")
    yield Case(name, measure, limits, source, reason="that it rises; how far was not read")
    for tissue, found in ((loops.TISSUE, 30.1), (VISCOUS, 20.9)):
        name = f"phase speed along the pad at 300 Hz, {tissue}"
        measure = partial(speed_noted, tissue)
        limits = Expected(found, 0.05 * found, "m/s")
        yield Case(name, measure, limits, MANFREDI, wanted=7.0, shortfall=SPEED)


WIERTLEWSKI = (
    "Wiertlewski and Hayward (2012): 1.48 P^0.35 N/mm, 1.78 P^0.35 N s/m, 110 to 230 mg at P in N; "
    "seven people"
)
MANFREDI = "Manfredi et al. (2012): plateau of some 7 m/s"
