"""Suite `hertz`: the finite elements and their contact against Hertz, where Hertz holds.

`theory/hertz.py` is the formula and `mechanics/hertz.py` will answer scenes with it; this is the
proof.
"""

from collections.abc import Iterator
from functools import cache

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


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield force and peak pressure for every Poisson ratio; finer meshes when not quick."""
    source = (
        "Hertz 1881 (REFERENCE B1): P = 4/3 E* sqrt(R) depth^1.5, p0 = 2 E* / pi sqrt(depth / R)"
    )
    levels = (QUICK,) if quick else (COARSE, QUICK, FINE)
    ratios = (0.3, 0.49) if quick else RATIOS
    limits = {COARSE: (3.0, 20.0), QUICK: (1.0, 6.0), FINE: (0.3, 3.0)}
    for nu in ratios:
        for cells in levels:
            force, peak = limits[cells]
            where = f"nu {nu:g}, a / h = {cells}"
            yield Case(
                "hertz",
                f"force error, {where}",
                lambda n=nu, c=cells: force_error(n, c),
                0.0,
                force,
                "%",
                source,
            )
            yield Case(
                "hertz",
                f"peak pressure error, {where}",
                lambda n=nu, c=cells: peak_error(n, c),
                0.0,
                peak,
                "%",
                source,
            )
