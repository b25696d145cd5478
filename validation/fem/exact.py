"""Part of the suite `fem`: cone, sphere, punch, ellipse, layers and stack against exact contacts.

Half-spaces have their own far field around the mesh; layers end where nothing moves any more.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.fem.hertz import LINES, Grading, bowl
from fefinger.validation.oracles.layer import Sheet
from fefinger.validation.oracles.punch import Cone, FlatPunch
from fefinger.validation.oracles.sphere import Sphere
from fefinger.validation.problems.grids import quarter
from fefinger.validation.problems.quarter import Exact, Indenter, Quarter, half_space, outer

from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.elements.spaces import Space
from fefinger.support.arrays import Array
from fefinger.theory.contact import indentation
from fefinger.theory.contact.elliptic import Elliptic
from fefinger.theory.contact.stack import Base, Layer, Stack


MODULUS, NU = 100.0, 0.49
EVERYDAY = Grading(LINES, core=0.3, rim=0.08, slope=0.5, sectors=5)
EDGE = Grading(LINES, core=0.4, rim=0.006, slope=0.5, sectors=5)  # for an infinite pressure
TIP = 0.02  # edge in contact radii at the tip of a cone
FINE = Grading(LINES, core=0.2, rim=0.04, slope=0.4, sectors=6)  # for a stiff skin
HALF_ANGLE = 80.0  # degrees
SPREAD = 1.3
LAYERS = (Layer(1.0, 100.0, 0.49), Layer(4.0, 34.0, 0.48))


@dataclass(frozen=True)
class Comparison:
    """A body under an indenter, and the exact contact."""

    body: Quarter
    exact: Exact


def sphere() -> Comparison:
    """Return a true sphere at a / R = 0.3, which the paraboloid is 1 % off."""
    truth = Sphere(1 / 0.3, 1.0, MODULUS, NU)
    ball = Indenter(lambda x, y: truth.radius - np.sqrt(truth.radius**2 - x**2 - y**2))
    return _half_space(EVERYDAY.space(1.0), ball, _round(truth))


def cone() -> Comparison:
    """Return a cone, whose pressure is infinite at the tip."""
    slope = 1 / np.tan(np.radians(HALF_ANGLE))
    truth = Cone(HALF_ANGLE, np.pi / 2 * slope, MODULUS, NU)
    size, lines = EVERYDAY.size(1.0), np.array(LINES)
    space = quarter(
        lines,
        lines,
        lambda r, z: np.minimum(size(r, z), TIP + 0.5 * np.hypot(r, z)),
        EVERYDAY.sectors,
    )
    tip = Indenter(lambda x, y: slope * np.hypot(x, y))
    return _half_space(space, tip, _round(truth))


def punch() -> Comparison:
    """Return a flat punch, whose pressure is infinite at the edge, which lies on the mesh.

    The circle is a polygon of the same area.
    """
    sides = 4 * EDGE.sectors
    half = np.pi / sides
    corner = float(np.sqrt(half / (np.sin(half) * np.cos(half))))
    truth = FlatPunch(1.0, 0.01, MODULUS, NU)

    def face(x: Array, y: Array) -> Array:
        turn = np.arctan2(y, x) / (2 * half)
        middle = 2 * half * (np.clip(np.floor(turn), 0, EDGE.sectors - 1) + 0.5)
        inside = x * np.cos(middle) + y * np.sin(middle) <= corner * np.cos(half) * (1 + 1e-9)
        return np.where(inside, 0.0, np.inf)

    lines = corner * np.array([0.0, 0.5, 1.0, 2.0, 3.0])
    space = quarter(lines, lines, EDGE.size(corner), EDGE.sectors)
    return _half_space(space, Indenter(face), _round(truth))


def ellipse() -> Comparison:
    """Return a contact of two curvatures, 100 and 30 mm, on a mesh stretched to its axes."""
    truth = Elliptic(100.0, 30.0, 0.01, MODULUS, NU)
    a, b = truth.semi_axes
    even = EVERYDAY.space(1.0)
    space = Space(even.points * [a, b, np.sqrt(a * b)], even.cells, even.tissue)
    saddle = Indenter(lambda x, y: x**2 / (2 * 100.0) + y**2 / (2 * 30.0))
    exact = Exact(truth.depth, truth.force, (a, b), truth.pressure)
    return _half_space(space, saddle, exact)


def layer(base: Base, poisson: float) -> Comparison:
    """Return a layer as thick as the contact is wide, bonded to a rigid base or sliding on it."""
    truth = indentation.paraboloid(Sheet(1.0, MODULUS, poisson, base), 100.0, contact_radius=1.0)
    ends = (3.6, 4.4, 5.5, 7.0) if base == "bonded" else (3.6, 4.4, 6.0, 9.0, 14.0, 25.0)
    r, z = np.array([*LINES[:3], 2.1, 2.84, *ends]), np.array([0.0, 0.5, 1.0])
    space = quarter(r, z, EVERYDAY.size(1.0), EVERYDAY.sectors)
    tissues = {1: Elastic(MODULUS, poisson)}
    return _layered(space, tissues, truth, base=base)


def on_bone() -> Comparison:
    """Return the bonded layer on bone that is meshed, and 1e9 times stiffer than it."""
    truth = indentation.paraboloid(Sheet(1.0, MODULUS, NU), 100.0, contact_radius=1.0)
    r = np.array([*LINES[:3], 2.1, 2.84, 3.6, 4.4, 5.5, 7.0])
    z = np.array([0.0, 0.5, 1.0, 1.5])
    space = quarter(r, z, EVERYDAY.size(1.0), EVERYDAY.sectors, interfaces=(1.0,))
    tissues = {1: Elastic(MODULUS, NU), 2: Elastic(1e9 * MODULUS, 0.3)}
    return _layered(space, tissues, truth, base="bonded")


def stack_contact() -> indentation.Contact:
    """Return a contact 2 mm wide on skin, softer tissue and bone."""
    return indentation.paraboloid(Stack(LAYERS), 10.0, contact_radius=2.0)


def stack(grading: Grading) -> Comparison:
    """Return 1 mm of skin on 4 mm of softer tissue, bonded to each other and to bone."""
    truth = stack_contact()
    r = np.array([0.0, 1.42, 2.84, 4.2, 5.7, 7.5, 10.0, 13.0, 18.0, 26.0])
    z = np.array([0.0, 0.5, 1.0, 2.0, 3.5, 5.0])
    space = quarter(r, z, grading.size(2.0), grading.sectors, interfaces=(1.0,))
    tissues = {k: Elastic(one.modulus, one.poisson) for k, one in enumerate(LAYERS, start=1)}
    return _layered(space, tissues, truth, base="bonded")


BODIES: dict[str, Callable[[], Comparison]] = {
    "sphere, a / R = 0.3": sphere,
    "cone": cone,
    "flat punch": punch,
    "ellipse": ellipse,
    "bonded layer, a = h": lambda: layer("bonded", NU),
    "bonded layer, a = h, nu 0.5": lambda: layer("bonded", 0.5),
    "bonded layer on bone 1e9 times stiffer": on_bone,
    "sliding layer, a = h": lambda: layer("sliding", NU),
    "skin, subcutaneous tissue, bone, a = 2 mm": lambda: stack(FINE),
}
SMOOTH = {"force": 0.2, "peak pressure": 0.7, "pressure within 0.9 a": 1.0, "pressure": 2.5}
LAYER = "Lebedev and Ufliand 1958"
LIMITS: dict[str, tuple[dict[str, float], str]] = {
    "sphere, a / R = 0.3": (SMOOTH, "Sneddon 1965; the paraboloid is 1 % off"),
    "cone": ({"force": 0.2, "pressure within 0.9 a": 1.0, "pressure": 2.5}, "Love 1939"),
    "flat punch": ({"force": 0.5, "pressure within 0.9 a": 1.0}, "Boussinesq; Sneddon 1965"),
    "ellipse": (SMOOTH, "Hertz 1881; Johnson 1985, 4.2"),
    "bonded layer, a = h": (SMOOTH, LAYER),
    "bonded layer, a = h, nu 0.5": (SMOOTH, LAYER),
    "bonded layer on bone 1e9 times stiffer": (SMOOTH, f"{LAYER}, on a rigid base"),
    "sliding layer, a = h": (SMOOTH, LAYER),
    "skin, subcutaneous tissue, bone, a = 2 mm": (SMOOTH, f"{LAYER}; Haskell 1953"),
}
"""Largest errors in %, and where the exact contact is from."""

QUICK = ("sphere, a / R = 0.3", "bonded layer, a = h")


@dataclass(frozen=True, eq=False)
class Solved:
    """What is kept of a solved body: errors in %, places (n, 2) mm, pressure and exact kPa."""

    errors: dict[str, float]
    places: Array
    pressure: Array
    exact: Array


@cache
def solved(name: str) -> Solved:
    """Return the contact of one of BODIES beside the exact one."""
    problem = BODIES[name]()
    pressed, truth = problem.body.pressed(problem.exact.depth), problem.exact
    space, vertices = problem.body.space, problem.body.patch.vertices
    measured = {
        "nodes": float(space.n_nodes),
        "force": 100 * float(pressed.force / truth.force - 1),
        "pressure within 0.9 a": 100 * pressed.pressure_error(truth, 0.9),
    }
    if "pressure" in LIMITS[name][0]:
        measured["pressure"] = 100 * pressed.pressure_error(truth, 1.0)
    if "peak pressure" in LIMITS[name][0]:
        peak = float(truth.pressure(np.array(0.0), np.array(0.0)))
        measured["peak pressure"] = 100 * (float(pressed.pressure.max()) / peak - 1)
    places = space.points[vertices, :2]
    return Solved(measured, places, pressed.pressure, truth.pressure(*places.T))


def _round(truth: Sphere | Cone | FlatPunch | indentation.Contact) -> Exact:
    a = truth.contact_radius
    return Exact(truth.depth, truth.force, (a, a), lambda x, y: truth.pressure(np.hypot(x, y)))


def _half_space(space: Space, indenter: Indenter, exact: Exact) -> Comparison:
    body = half_space(space, Elastic(MODULUS, NU), indenter, exact, spread=SPREAD)
    return Comparison(body, exact)


def _layered(
    space: Space,
    tissues: dict[int, Elastic],
    truth: indentation.Contact,
    *,
    base: str,
) -> Comparison:
    bottom, side = outer(space)
    held = np.zeros((space.n_nodes, 3), dtype=bool)
    held[bottom, 2] = True
    if base == "bonded":
        held[bottom | side] = True
    reach = (SPREAD * truth.contact_radius) ** 2 / (2 * truth.radius)
    still = np.zeros((space.n_nodes, 3))
    body = Quarter(space, tissues, held, still, bowl(truth.radius), reach)
    return Comparison(body, _round(truth))


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the errors of every body, of QUICK ones when quick."""
    for name in QUICK if quick else BODIES:
        limits, source = LIMITS[name]
        for quantity, limit in limits.items():
            title = f"{name}: {quantity}"
            measure = partial(lambda n, q: solved(n).errors[q], name, quantity)
            expectation = Expected(0.0, limit, "%")
            yield Case(title, measure, expectation, source, reason="what the mesh leaves")
