"""Bodies with closed-form vibrations: a shear layer, an incompressible ball, a half-space."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from fefinger.validation.problems.grids import box, octant, quarter
from scipy import optimize, sparse, special

from fefinger.contact.oscillators import Complex, complex_modulus
from fefinger.fem.elements.assembly import Elastic, mass, stiffness
from fefinger.fem.elements.spaces import Space, trace
from fefinger.fem.linalg.system import System, factor
from fefinger.fem.modes import Modes, lowest
from fefinger.support.arrays import Array, Integers


DENSITY = 1.1e-6
"""kg/mm³."""

PULP = Elastic(34.0, 0.48)
INCOMPRESSIBLE = Elastic(34.0, 0.5)

WEIGHTS, RATES = np.array([1.5, 0.5, 0.4]), np.array([224.0, 14.0, 0.63])
"""Prony terms over the long-time modulus, as those of a fingertip."""


@dataclass(frozen=True)
class Vibrating:
    """A body with its factored stiffness, its mass, and its lowest modes on free displacements."""

    system: System
    mass: sparse.csr_matrix
    modes: Modes
    free: Integers

    def static(self, loads: Array) -> Array:
        """Displacements (n_free, k) under loads (n_free, k)."""
        full = np.zeros((self.system.space.n_unknowns, loads.shape[1]))
        full[self.free] = loads
        return np.asarray(self.system.solve(full)[self.free])

    def receptance(
        self, load: Array, frequency: Array, relaxation: tuple[Array, Array] | None = None
    ) -> Array:
        """Work (n_f,) of a load (n_free,) on the displacement that it causes at frequencies in Hz.

        Two static terms stand for the modes that are left out. relaxation: weights and rates of the
        Prony terms, WEIGHTS and RATES by default.
        """
        work, omega_squared = self.modes.shapes.T @ load, self.modes.omega_squared
        moved = self.static(load[:, None])[:, 0]
        first = load @ moved - work**2 @ (1 / omega_squared)
        second = moved @ (self.mass @ moved) - work**2 @ (1 / omega_squared**2)
        weights, rates = relaxation or (WEIGHTS, RATES)
        modulus = complex_modulus(weights, rates, frequency)
        omega = 2 * np.pi * frequency
        swing = 1 / (np.multiply.outer(modulus, omega_squared) - omega[:, None] ** 2)
        rest = first / modulus + second * omega**2 / modulus**2
        return np.asarray(swing @ work**2 + rest)


def vibrating(space: Space, tissue: Elastic, fixed: Integers, count: int) -> Vibrating:
    """Factor a body of one tissue, and compute its `count` lowest modes."""
    system = factor(space, stiffness(space, {1: tissue}), fixed)
    free = system.free[system.free < space.n_displacements]
    inner = mass(space, {1: DENSITY})[free][:, free].tocsr()

    def solve(loads: Array) -> Array:
        full = np.zeros((space.n_unknowns, loads.shape[1]))
        full[free] = loads
        return np.asarray(system.solve(full)[free])

    return Vibrating(system, inner, lowest(solve, inner, count), free)


HEIGHT = 4.0
"""mm of the shear layer."""


@cache
def shear_layer(cells: int, count: int = 12) -> Vibrating:
    """Return a layer that moves parallel to its base alone."""
    space = box(np.linspace(0, 1, 2), np.linspace(0, 1, 2), np.linspace(0, HEIGHT, cells + 1))
    nodes = np.arange(space.n_nodes)
    base = nodes[space.node_points[:, 2] < 1e-9]
    fixed = np.concatenate([3 * nodes + 1, 3 * nodes + 2, 3 * base])
    pressures = space.n_displacements + np.arange(space.n_unknowns - space.n_displacements)
    return vibrating(space, PULP, np.concatenate([np.unique(fixed), pressures]), count)


def shear_speed(tissue: Elastic) -> float:
    """Speed of shear waves in mm/s."""
    return float(np.sqrt(tissue.shear / DENSITY))


def on_moving_base(cells: int, frequency: Array, count: int = 12) -> Array:
    """Motion (n_f,) of the surface of a shear layer over the motion of its base, by modes."""
    body = shear_layer(cells, count)
    space, modulus = body.system.space, complex_modulus(WEIGHTS, RATES, frequency)
    along = np.zeros(space.n_displacements)
    along[::3] = 1.0
    heavy = mass(space, {1: DENSITY}) @ along
    load = heavy[body.free]
    where = space.node_points[body.free // 3, 2]
    top = (where > HEIGHT - 1e-9) / np.count_nonzero(where > HEIGHT - 1e-9)
    moved = body.static(load[:, None])[:, 0]
    shapes, omega_squared = body.modes.shapes, body.modes.omega_squared
    omega = 2 * np.pi * frequency
    parts = (top @ shapes) * (load @ shapes)
    swing = 1 / (np.multiply.outer(modulus, omega_squared) - omega[:, None] ** 2)
    rest = (top @ moved - parts @ (1 / omega_squared)) / modulus
    return np.asarray(1 + omega**2 * (swing @ parts + rest))


def exact_modulus(weights: Array, rates: Array, frequency: Array) -> Complex:
    """Complex modulus (n_f,) by the transform of the relaxation of a sudden strain.

    i w times the integral of (1 + sum g exp(-v t)) exp(-i w t): the glassy modulus, less what each
    term has lost. It shares nothing with `complex_modulus`.
    """
    lost = weights * rates / (rates + 2j * np.pi * np.asarray(frequency)[:, None])
    return np.asarray(1.0 + weights.sum() - lost.sum(axis=1))


def layer_exact(frequency: Array) -> Array:
    """Motion (n_f,) of the surface of a shear layer over the motion of its base: 1 / cos(k h)."""
    modulus = exact_modulus(WEIGHTS, RATES, frequency)
    k = 2 * np.pi * frequency / (shear_speed(PULP) * np.sqrt(modulus))
    return np.asarray(1 / np.cos(k * HEIGHT))


@cache
def ball(refinements: int, *, twisting: bool, count: int = 3) -> Vibrating:
    """Return an eighth of a free incompressible ball of 1 mm: modes of one parity in each plane.

    `twisting`: odd in every plane, so that the lowest mode is the torsional one of degree 2; else
    even, so that it is the spheroidal one of degree 2.
    """
    space = octant(refinements)
    flat = {axis: np.flatnonzero(space.node_points[:, axis] < 1e-9) for axis in range(3)}
    fixed = []
    for axis, nodes in flat.items():
        components = [c for c in range(3) if (c != axis) == twisting]
        fixed += [3 * nodes + c for c in components]
        if twisting:  # the mean stress is odd as well
            inside = np.isin(space.vertices, np.flatnonzero(space.points[:, axis] < 1e-9))
            fixed.append(space.n_displacements + np.unique(space.pressures[inside]))
    return vibrating(space, INCOMPRESSIBLE, np.unique(np.concatenate(fixed)), count)


def torsional_root() -> float:
    """Lowest w a / c of the torsional modes of degree 2 of a free ball: j2(x) = x j3(x)."""

    def equation(x: float) -> float:
        return float(special.spherical_jn(2, x) - x * special.spherical_jn(3, x))

    return float(optimize.brentq(equation, 2.0, 3.0))


def spheroidal_root() -> float:
    """Lowest w a / c of the spheroidal modes of degree 2 of a free incompressible ball.

    The displacement is the gradient of r² Y, with the pressure of its inertia, and the double curl
    of the vector r j2(k r) Y; the surface bears no traction.
    """
    degree = 2

    def equation(x: float) -> float:
        j, slope = special.spherical_jn(degree, x), special.spherical_jn(degree, x, True)
        bend = -(2 / x) * slope - (1 - degree * (degree + 1) / x**2) * j
        j1, j2 = x * slope, x**2 * bend
        normal = (-(x**2) + 2 * degree * (degree - 1), 2 * degree * (degree + 1) * (j1 - j))
        shear = (2 * (degree - 1), j2 + (degree * (degree + 1) - 2) * j)
        return float(normal[0] * shear[1] - normal[1] * shear[0])

    return float(optimize.brentq(equation, 2.0, 3.5))


DISC = 1.0
"""Radius in mm of the loaded disc on the half-space."""

SECTORS = 5
"""Prisms around the quarter."""

FAR = 24.0
"""Radius and depth in mm of the body that stands for the half-space, held at its far faces."""


LOSSY = np.array([20.0]), np.array([6283.0])
"""Relaxation of the half-space: waves of 1 kHz die out within a few mm."""


@cache
def half_space(edge: float, count: int = 150) -> tuple[Vibrating, Array]:
    """Return a quarter of a cylinder that stands for a half-space, and 1 kPa on its disc."""
    r = np.concatenate([np.linspace(0, DISC, 3), np.geomspace(1.5 * DISC, FAR, 8)])
    z = np.concatenate([np.linspace(0, DISC, 3), np.geomspace(1.5 * DISC, FAR, 8)])

    def size(radius: Array, depth: Array) -> Array:
        # Smallest at the edge of the disc, where the shear strain is singular.
        return np.maximum(edge, 0.5 * np.hypot(radius - DISC, depth))

    space = quarter(r, z, size, SECTORS)
    points = space.node_points
    away = (np.hypot(points[:, 0], points[:, 1]) > FAR * 0.985) | (points[:, 2] > FAR - 1e-6)
    held = np.flatnonzero(away)
    planes = [3 * np.flatnonzero(points[:, axis] < 1e-9) + axis for axis in (0, 1)]
    fixed = np.concatenate([(3 * held[:, None] + np.arange(3)).ravel(), *planes])
    body = vibrating(space, PULP, np.unique(fixed), count)
    return body, _disc_load(space)[body.free]


def _disc_load(space: Space) -> Array:
    """Nodal forces (n_displacements,) in mN along z of 1 kPa on the disc."""
    facets = np.sort(space.scalar.mesh.facets.T, axis=1)
    corners = space.points[facets]
    on_top = (np.abs(corners[:, :, 2]) < 1e-9).all(axis=1)
    inside = np.hypot(corners[:, :, 0], corners[:, :, 1]).max(axis=1) < DISC * 1.001
    surface = trace(space, facets[on_top & inside])
    load = np.zeros(space.n_displacements)
    shares = np.einsum("kq,tq->tk", surface.quadratic, surface.weights)
    np.add.at(load, 3 * surface.nodes + 2, shares)
    return load


def half_space_exact(frequency: float) -> complex:
    """Mean displacement in mm of a disc under 1 kPa on a viscoelastic half-space.

    Lamb's integral with the complex modulus (Miller and Pursey, Proc. R. Soc. A 223:521, 1954): no
    pole lies on the axis.
    """
    modulus = complex(exact_modulus(*LOSSY, np.array([frequency]))[0])
    shear = PULP.shear * modulus
    k2 = (2 * np.pi * frequency) ** 2 * DENSITY / shear
    ratio = (1 - 2 * PULP.poisson) / (2 - 2 * PULP.poisson)  # of the squared wave numbers

    edges = np.concatenate([[0.0], np.geomspace(0.02, 400.0, 200)])
    nodes, weights = np.polynomial.legendre.leggauss(16)
    half = np.diff(edges)[:, None] / 2
    x = (edges[:-1, None] + half * (1 + nodes)).ravel()
    shear_root, pressure_root = np.sqrt(x * x - k2 + 0j), np.sqrt(x * x - ratio * k2 + 0j)
    rayleigh = (2 * x * x - k2) ** 2 - 4 * x * x * pressure_root * shear_root
    kernel = -k2 * pressure_root / rayleigh * special.j1(x * DISC) ** 2 / x
    total = kernel @ (half * weights).ravel()
    # Beyond, the kernel is static, (1 - nu) / x, and j1² is 1 / (pi x) on the mean.
    tail = (1 - PULP.poisson) / (2 * np.pi * DISC * edges[-1] ** 2)
    return complex(2 / shear * (total + tail))
