"""Part of the suite `fem`: Hertz contact where Hertz holds, at every Poisson ratio.

`theory/contact/hertz.py` is the formula and `mechanics/hertz.py` answers scenes with it; this is
the proof.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.problems.grids import Size, quarter
from fefinger.validation.problems.quarter import (
    Exact,
    Indenter,
    Pressed,
    Quarter,
    half_space,
    turned,
)

from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.elements.spaces import Space
from fefinger.support.arrays import Array
from fefinger.theory.contact.hertz import Hertz


RADIUS, CONTACT_RADIUS, MODULUS = 100.0, 1.0, 100.0
RATIOS = (0.3, 0.45, 0.49, 0.499, 0.5)
WIDE, DEEP = 1.1, 1.3  # contact radii to which the mesh is as fine as its core
GROWTH = 5.0  # of the edges beyond

DEPTHS = (0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.5)  # contact radii
OFFSETS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25)  # contact radii from the axis
AZIMUTH = 0.61  # of the points, in radians: in no plane of the mesh


@dataclass(frozen=True)
class Grading:
    """How a quarter is meshed, lengths in contact radii.

    lines: the grid before refinement; core: longest edge under the contact, to WIDE and DEEP; rim:
    at the edge of the contact, growing by `slope` away from it; sectors around the quarter. No
    point is put on the edge of the contact.
    """

    lines: tuple[float, ...]
    core: float
    rim: float
    slope: float
    sectors: int

    def size(self, a: float) -> Size:
        """Return the longest edge in mm at a place, for a contact radius of `a` mm."""

        def size(r: Array, z: Array) -> Array:
            r, z = r / a, z / a
            beyond = np.hypot(np.maximum(r - WIDE, 0), np.maximum(z - DEEP, 0))
            rim = self.rim + self.slope * np.hypot(r - 1, z)
            return a * np.minimum(self.core + GROWTH * beyond, rim)

        return size

    def space(self, a: float) -> Space:
        """Return the mesh of a half-space for a contact radius of `a` mm."""
        lines = a * np.array(self.lines)
        return quarter(lines, lines, self.size(a), self.sectors)


LINES = (0.0, 0.71, 1.42, 2.84)
LEVELS = (
    Grading(LINES, core=0.8, rim=0.24, slope=1.24, sectors=3),
    Grading(LINES, core=0.4, rim=0.12, slope=0.62, sectors=4),
    Grading(LINES, core=0.2, rim=0.06, slope=0.31, sectors=6),
)
BUDGETS = (1_000, 4_000, 20_000)  # most displacement nodes of the levels
COARSER = 4.0  # times the limits, one level below the finest
FINEST = len(LEVELS) - 1


TARGETS = {
    "force": (0.1, "relative error of the force"),
    "peak pressure": (0.7, "relative error of the largest pressure"),
    "pressure within 0.9 a": (1.0, "L2 error of the pressure over the inner disk"),
    "pressure": (2.5, "L2 error of the pressure over the true disk"),
    "contact area": (5.0, "area of the hats in contact, whole ones, so a fraction of a cell"),
    "strain": (1.0, "RMS error of the strain tensor 0.15 a to 1.5 a deep, over the largest"),
    "strain anywhere": (1.25, "the same at the worst of those points"),
    "recovered strain": (0.5, "the same by recovery from the displacements around, RMS"),
    "recovered strain anywhere": (1.0, "by recovery, at the worst of those points"),
}
"""Largest errors in % on the finest mesh, and what they are of."""

ORDERS = {
    "force": (2.5, 0.5, "between that of the displacement, 3, and that of the edge"),
    "pressure": (
        1.25,
        0.4,
        "limited by the square root in which the pressure ends",
    ),
    "strain": (2.0, 0.4, "gradient of quadratic elements"),
}
"""Expected order in the cell length, its tolerance, and why."""

SOURCE = "Hertz 1881: P = 4/3 E* sqrt(R) depth^1.5, p0 = 2 E* / pi sqrt(depth / R); Huber 1904"


def hertz(poisson: float) -> Hertz:
    """Return the contact of this part, a = R / 100."""
    return Hertz(RADIUS, CONTACT_RADIUS**2 / RADIUS, MODULUS, poisson)


def exact(one: Hertz) -> Exact:
    """Return a Hertz contact as a quarter is compared with it."""
    a = one.contact_radius
    return Exact(one.depth, one.force, (a, a), lambda x, y: one.pressure(np.hypot(x, y)))


def bowl(radius: float) -> Indenter:
    """Return the paraboloid r² / 2R."""
    return Indenter(lambda x, y: (x**2 + y**2) / (2 * radius))


def body(poisson: float, level: int) -> Quarter:
    """Return the quarter under the paraboloid on one of LEVELS."""
    return body_on(LEVELS[level].space(CONTACT_RADIUS), poisson)


def body_on(space: Space, poisson: float) -> Quarter:
    """Return the quarter under the paraboloid, with the half-space's displacement around it."""
    elastic = Elastic(MODULUS, poisson)
    return half_space(space, elastic, bowl(RADIUS), exact(hertz(poisson)), spread=1.3)


@cache
def errors(poisson: float, level: int) -> dict[str, float]:
    """Errors of `measured` on one of LEVELS."""
    truth = hertz(poisson)
    return measured(body(poisson, level).pressed(truth.depth), truth)


def measured(pressed: Pressed, truth: Hertz) -> dict[str, float]:
    """Return the errors in % by the names of TARGETS, with the displacement `nodes`."""
    below = strain_errors(pressed.strain, truth)
    recovered = strain_errors(pressed.recovered_strain, truth)
    return {
        "nodes": float(pressed.body.space.n_nodes),
        "force": 100 * (pressed.force / truth.force - 1),
        "peak pressure": 100 * float(pressed.pressure.max() / truth.peak_pressure - 1),
        "pressure within 0.9 a": 100 * pressed.pressure_error(exact(truth), 0.9),
        "pressure": 100 * pressed.pressure_error(exact(truth), 1.0),
        "contact area": 100 * (pressed.area / (np.pi * truth.contact_radius**2) - 1),
        "imbalance": pressed.imbalance,
        "strain": 100 * float(np.sqrt(np.mean(below**2))),
        "strain anywhere": 100 * float(below.max()),
        "recovered strain": 100 * float(np.sqrt(np.mean(recovered**2))),
        "recovered strain anywhere": 100 * float(recovered.max()),
    }


def strain_errors(strain: Callable[[Array], Array], truth: Hertz) -> Array:
    """Return the errors (n,) of a strain at OFFSETS and DEPTHS over the largest strain."""
    a = truth.contact_radius
    r, z = (a * axis.ravel() for axis in np.meshgrid(OFFSETS, DEPTHS))
    turn = np.array([np.cos(AZIMUTH), np.sin(AZIMUTH)])
    computed = strain(np.column_stack([np.multiply.outer(r, turn), z]))
    expected = turned(truth.strain(r, z), turn)
    size = np.linalg.norm(expected, axis=(1, 2)).max()
    return np.asarray(np.linalg.norm(computed - expected, axis=(1, 2)) / size)


def order(name: str, poisson: float) -> float:
    """Return the fitted order of an error in the cell length, nodes^(-1/3)."""
    values = [errors(poisson, level) for level in range(len(LEVELS))]
    length = [-np.log(one["nodes"]) / 3 for one in values]
    return float(np.polyfit(length, [np.log(abs(one[name])) for one in values], 1)[0])


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the errors on the finest mesh at every Poisson ratio and their observed orders."""
    for nu in (0.49,) if quick else RATIOS:
        level = FINEST - 1 if quick else FINEST
        yield from _errors(nu, level)
        yield from _balance(nu, level)
        if not quick:
            yield from _orders(nu)


def _errors(nu: float, level: int) -> Iterator[Case]:
    for name, (limit, meaning) in TARGETS.items():
        title = f"Hertz, nu {nu:g}, {BUDGETS[level]} nodes: {name}"
        measure = partial(lambda n: errors(nu, level)[n], name)
        limits = Expected(0.0, limit if level == FINEST else COARSER * limit, "%")
        yield Case(title, measure, limits, SOURCE, reason=meaning)
    yield Case(
        f"Hertz, nu {nu:g}: displacement nodes of that mesh",
        lambda: errors(nu, level)["nodes"],
        Expected(0.0, BUDGETS[level], "nodes"),
        "the budget of the mesh",
        reason="no more than the budget",
    )


def _balance(nu: float, level: int) -> Iterator[Case]:
    yield Case(
        f"Hertz, nu {nu:g}, {BUDGETS[level]} nodes: force and reactions, over the force",
        lambda: errors(nu, level)["imbalance"],
        Expected(0.0, 1e-8),
        "equilibrium of the body",
        reason="the residual of the linear solution, 1e-10, with a margin",
    )


def _orders(nu: float) -> Iterator[Case]:
    for name, (expected, spread, reason) in ORDERS.items():
        title = f"Hertz, nu {nu:g}: order of {name}"
        measure = partial(order, name, nu)
        limits = Expected(expected, spread)
        yield Case(title, measure, limits, "regularity of the exact solution", reason=reason)
