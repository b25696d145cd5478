"""Lateral vibration of the pad of a finger that sticks to a plate, and what was measured of it.

Wiertlewski and Hayward (J. Biomech. 45:1869, 2012) pressed fingertips of seven people on a plate
that vibrates along itself, and found the impedance of a spring, a damper and a mass: at 0.5 N 0.6
to 2.1 N/mm, 0.75 to 2.38 N s/m and 110 to 230 mg, and with the preload P in N 1.48 P^0.35 N/mm and
1.78 P^0.35 N s/m (numbers as two later works quote them).
"""

from dataclasses import replace
from functools import cache

import numpy as np
from fefinger.validation.case import Noted
from fefinger.validation.waves import loops
from scipy import sparse

from fefinger.contact.oscillators import ClosedContact
from fefinger.fem.condensation import displaced, reduce
from fefinger.mechanics.press import placement
from fefinger.mechanics.press.frequency_response import RimError
from fefinger.mechanics.press.modal_body import body_of_modes, residual_inertia
from fefinger.mechanics.press.moving_contact import with_tractions
from fefinger.mechanics.vibrations import Vibrations
from fefinger.results.records import PER_METER, Complex
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.support.arrays import Array
from fefinger.support.units import NEWTON_PER_MILLINEWTON


STIFFNESS, DAMPING, POWER = 1.48, 1.78, 0.35
"""N/mm and N s/m at 1 N, and the power of the preload with which both grow."""

MASSES = 110e-6, 230e-6
"""kg at 0.5 N, of the least and the most of all people."""

MASS = sum(MASSES) / 2

SHOWN = 0.5
"""Preload in N of the figure."""

RANGE = 0.52, 1.8
"""Of the least and the largest of the springs and dampers at 0.5 N over the fit."""

BAND = np.geomspace(20.0, 400.0, 80)
"""Hz."""

NOTED = 50.0, 100.0, 200.0, 400.0
"""Hz."""


def measured(preload: float, frequency: Array, mass: float = MASS) -> Complex:
    """Return the published fit (n_f,) in N s/m at a preload in N and frequencies in Hz."""
    omega, growth = 2 * np.pi * frequency, preload**POWER
    spring = PER_METER * STIFFNESS * growth
    return np.asarray(DAMPING * growth + 1j * (mass * omega - spring / omega))


@cache
def impedance(tissue: str, preload: float) -> Complex:
    """Impedance (n_f,) in N s/m over BAND of a finger that sticks to a plate, along its axis.

    The plate vibrates along the finger. Its contact is that of the relaxed finger at the preload.
    """
    finger = Finger.subject(loops.SUBJECT, tissue=tissue, resolution="coarse")
    loop = Vibrations(finger, Flat(30), deepest=2.0)
    prepared = loop.vibrating
    solid, on = prepared.solid, prepared.body.static.patch
    pressed = prepared.preload(None, preload)[1] > 0
    if pressed[on.border].any():
        raise RimError(loops.SUBJECT)
    three = with_tractions(solid, on, placement.obstacle(Flat(30), solid).axis)
    loaded = np.tile(pressed, 3) & (np.asarray(abs(three.loads).sum(axis=0)).ravel() > 0)
    loads = three.loads[:, loaded]
    nothing = sparse.csr_matrix((0, solid.space.n_unknowns))
    static = reduce(solid, replace(three, loads=loads, vertices=three.vertices[loaded]), nothing)
    body = body_of_modes(finger, loop.modes, static, lambda: nothing)
    along: Array = np.concatenate([np.zeros_like(on.areas), on.areas, np.zeros_like(on.areas)])
    o = body.oscillators
    held = ClosedContact.of(
        *(o.omega_squared, body.participation, body.residual_flexibility),
        *(along[loaded], o.weights, o.rates),
        residual_inertia(
            finger, solid, displaced(solid, loads), body.participation / o.omega_squared[:, None]
        ),
    )
    stiffness = solid.sides * NEWTON_PER_MILLINEWTON * held.stiffness(BAND)
    return np.asarray(PER_METER * stiffness / (2j * np.pi * BAND))


def magnitude(tissue: str, preload: float) -> Noted:
    """Return the magnitude at 200 Hz over the published one."""
    ratios = np.abs(_over_published(tissue, preload))
    text = ", ".join(f"{each:.2f} at {f:g} Hz" for f, each in zip(NOTED, ratios, strict=True))
    return Noted(float(ratios[NOTED.index(200.0)]), text)


def phase(tissue: str, preload: float) -> Noted:
    """Return the phase in degrees at 200 Hz less the published one."""
    turned = np.degrees(np.angle(_over_published(tissue, preload)))
    text = ", ".join(f"{each:.0f} at {f:g} Hz" for f, each in zip(NOTED, turned, strict=True))
    return Noted(float(turned[NOTED.index(200.0)]), text)


def _over_published(tissue: str, preload: float) -> Complex:
    """Impedance (n,) over the published one at the frequencies NOTED."""
    frequency = np.array(NOTED)
    computed = impedance(tissue, preload)
    parts = (np.interp(frequency, BAND, each) for each in (computed.real, computed.imag))
    real, imaginary = parts
    return np.asarray((real + 1j * imaginary) / measured(preload, frequency))
