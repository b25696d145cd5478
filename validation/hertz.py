"""Suite `hertz`: the finite elements and their contact against Hertz, where Hertz holds.

`theory/hertz.py` is the formula and `mechanics/hertz.py` will answer scenes with it; this is the
proof.
"""

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
from fefinger.validation.block import Block
from fefinger.validation.case import Case

from fefinger.theory.hertz import Hertz


RADIUS, CONTACT_RADIUS, MODULUS = 100.0, 1.0, 100.0
RATIOS = (0.3, 0.45, 0.49, 0.499, 0.5)
COARSE, QUICK, FINE = 3, 4, 6  # cells along the contact radius


@cache
def block(poisson: float, cells: int) -> Block:
    """Return the block of this suite, a = R / 100."""
    return Block(Hertz(RADIUS, CONTACT_RADIUS**2 / RADIUS, MODULUS, poisson), cells)


def force_error(poisson: float, cells: int) -> float:
    """Return the relative error of the contact force in %."""
    pressed = block(poisson, cells)
    return 100 * (pressed.force / pressed.hertz.force - 1)


def peak_error(poisson: float, cells: int) -> float:
    """Return the relative error of the largest pressure in %."""
    pressed = block(poisson, cells)
    return 100 * float(pressed.pressure.max() / pressed.hertz.peak_pressure - 1)


def area_error(poisson: float, cells: int) -> float:
    """Return the relative error of the contact area in %."""
    pressed = block(poisson, cells)
    return 100 * (pressed.area / (np.pi * pressed.hertz.contact_radius**2) - 1)


MEASURES = {"force": force_error, "peak pressure": peak_error, "contact area": area_error}

LIMITS = {
    COARSE: {"force": 3.0, "peak pressure": 20.0, "contact area": 2.5},
    QUICK: {"force": 1.0, "peak pressure": 6.0, "contact area": 2.5},
    FINE: {"force": 0.3, "peak pressure": 3.0, "contact area": 2.0},
}
"""Largest errors in %."""

SOURCE = (
    "Hertz 1881: P = 4/3 E* sqrt(R) depth^1.5, p0 = 2 E* / pi sqrt(depth / R), area = pi R depth"
)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield force, peak pressure and area for every Poisson ratio; finer meshes when not quick."""
    for nu in (0.3, 0.49) if quick else RATIOS:
        for cells in (QUICK,) if quick else LIMITS:
            for quantity, error in MEASURES.items():
                name = f"{quantity} error, nu {nu:g}, a / h = {cells}"
                limit = LIMITS[cells][quantity]
                yield Case("hertz", name, partial(error, nu, cells), 0.0, limit, "%", SOURCE)
