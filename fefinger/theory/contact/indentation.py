"""Exact frictionless axisymmetric contact by a Hankel compliance: the surface and below.

The pressure is written as p(xi) = integral over 0..a of phi(t) cos(xi t) dt, which leaves the
Lebedev-Ufliand equation, Fredholm of the second kind with a smooth kernel, for phi:

    pi/2 phi(x) - integral over 0..a of phi(t) K(x, t) dt = g(x) / C,
    K(x, t) = integral over 0..inf of (1 - L(xi)) cos(xi x) cos(xi t) d xi,

C = 2 (1 - nu²) / E of the surface, g = depth - x²/R for a paraboloid, with phi(a) = 0, and
g = depth for a flat punch. phi is expanded in even Legendre polynomials, whose pressures have a
closed form. Source: Lebedev and Ufliand, J. Appl. Math. Mech. 22, 1958, 442.

Below the surface the kernels of `stack.py` decay as exp(-xi z), so that each component is one
smooth integral over the wavenumber. It is linear in the pressure: many contacts on one stack share
the kernels and the Bessel functions. Lengths in mm, moduli and stresses in kPa, forces in mN; z
points into the body.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Protocol

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike
from scipy.special import j0, j1

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array
from fefinger.theory.contact.stack import Layer, Stack


PHASE = 14.0
"""Largest phase of a cosine per panel in radians: its Legendre coefficient 32 is then 1e-19."""

_NODES, _WEIGHTS = legendre.leggauss(16)


class LayeredBody(Protocol):
    """Interface of a layered elastic body (hashable), as `stack.Stack`."""

    def __hash__(self) -> int:
        """Return a hash of the values."""

    @property
    def surface(self) -> tuple[float, float]:
        """Modulus in kPa and Poisson's ratio at the surface."""

    @property
    def scales(self) -> tuple[float, float]:
        """Smallest and largest length in mm of the body; infinite for a half-space."""

    def compliance(self, xi: ArrayLike) -> Array:
        """Return L (n,) at wavenumbers xi (n,) in 1/mm."""


@dataclass(frozen=True, eq=False)
class Contact:
    """A solved contact: contact radius a and depth in mm, `radius` R in mm (inf: a flat punch).

    `phi` (n,) kPa mm are the coefficients of P_0, P_2, P_4, ... of t / a.
    """

    body: LayeredBody
    contact_radius: float
    radius: float
    depth: float
    phi: Array

    @property
    def force(self) -> float:
        """P = 2 pi times the integral of phi, in mN."""
        return 2 * math.pi * self.contact_radius * float(self.phi[0])

    def pressure(self, r: ArrayLike) -> Array:
        """Contact pressure in kPa at r (...,) mm, zero outside; a punch's edge is infinite."""
        x = elastic.numbers("Contact", "r", r, least=0.0) / self.contact_radius
        y = np.sqrt(np.maximum(1 - x**2, 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            value = legendre.legval(y, over_edge(self.phi)) / (self.contact_radius * y)
        edge = 0.0 if math.isfinite(self.radius) else math.inf
        return np.where(x < 1, value, np.where(x > 1, 0.0, edge))

    def transform(self, xi: ArrayLike) -> Array:
        """Hankel transform of the pressure (...,) in mN at wavenumbers xi (...,).

        It is the integral of p r J0(xi r) dr; at xi = 0 the force over 2 pi.
        """
        xi = elastic.numbers("Contact.transform", "wavenumbers", xi, least=0.0)
        a = self.contact_radius
        # phi oscillates at most as a wave of its degree; its last coefficients are rounding.
        t, weights = panels(a / 2, a, reach=float(xi.max()) + len(self.phi) / a)
        density = weights * legendre.legval(t / a, _even(self.phi))
        return np.asarray(np.cos(np.multiply.outer(xi, t)) @ density)


def paraboloid(body: LayeredBody, radius: float, *, contact_radius: float) -> Contact:
    """Solve the contact of a rigid paraboloid r² / 2R (R = `radius` mm) with this contact radius.

    ValueError for a value at or below zero, or a contact wider than R (small strain) or than 200
    thicknesses of the top layer.
    """
    elastic.require_positive("paraboloid", radius=radius, contact_radius=contact_radius)
    elastic.require_small(
        "paraboloid", "a contact radius", contact_radius, limit=radius, of="the radius"
    )
    lift, bowl = _solve(body, contact_radius)
    depth = float(bowl.sum() / lift.sum()) / radius
    return _contact(body, contact_radius, radius, depth=depth, phi=depth * lift - bowl / radius)


def flat_punch(body: LayeredBody, contact_radius: float, *, depth: float) -> Contact:
    """Solve the contact of a flat rigid punch of `contact_radius` mm pressed by `depth` mm."""
    elastic.require_positive("flat_punch", contact_radius=contact_radius, depth=depth)
    lift, _ = _solve(body, contact_radius)
    return _contact(body, contact_radius, math.inf, depth=depth, phi=depth * lift)


def spectrum(body: LayeredBody, reach: float) -> tuple[Array, Array]:
    """Nodes xi (n,) and weights times 1 - L(xi) (n,) of integrals with cos(xi y), y <= reach.

    Gauss-Legendre panels graded from far below the inverse thickness of the body to where 1 - L is
    negligible. The reach is rounded up and the result cached: contacts of one body share it.
    """
    fine = body.scales[0]
    if fine == math.inf:
        return np.zeros(0), np.zeros(0)
    return _spectrum(body, math.ceil(2 * math.log2(max(reach, fine) / fine)))


@lru_cache(maxsize=64)
def _spectrum(body: LayeredBody, half_octave: int) -> tuple[Array, Array]:
    """Compute the `spectrum` for a reach of 2^(half_octave / 2) times the smallest scale."""
    fine, coarse = body.scales
    reach = fine * 2 ** (half_octave / 2)
    # The departure 1 - L falls as exp(-2 xi h): at xi h = 20 it is under 1e-14.
    xi, weights = panels(1e-4 / coarse, 20.0 / fine, reach=reach)
    departure = weights * (1 - body.compliance(xi))
    for cached in (xi, departure):
        cached.flags.writeable = False
    return xi, departure


def over_edge(phi: Array) -> Array:
    """Legendre series (2 n - 1, ...) of a y p in y = sqrt(1 - r² / a²), from phi (n, ...).

    P_2k(sqrt(1 - y²)) integrates over the edge to P_2k(y) / P_2k(0).
    """
    half = np.arange(1, len(phi))
    at_zero = np.cumprod([1.0, *((1 - 2 * half) / (2 * half))])
    return _even((phi.T / at_zero).T)


def _even(coefficients: Array) -> Array:
    """Legendre series (2 n - 1, ...) with these even coefficients (n, ...)."""
    series = np.zeros((2 * len(coefficients) - 1, *coefficients.shape[1:]))
    series[::2] = coefficients
    return series


def _contact(body: LayeredBody, a: float, radius: float, *, depth: float, phi: Array) -> Contact:
    """Build a contact without the trailing coefficients of phi that are rounding."""
    rounding = 1e-14  # coefficients of phi below this fraction of the largest are rounding
    count = int(np.flatnonzero(np.abs(phi) > rounding * np.abs(phi).max())[-1]) + 1
    return Contact(body, a, radius, depth, phi[:count])


def _solve(body: LayeredBody, a: float) -> tuple[Array, Array]:
    """Solve the equation for g = 1 and for g = x²: phi (n,) in even Legendre coefficients."""
    wide = a / body.scales[0]
    # Largest contact radius over thickness of the top layer; the number of unknowns grows with it.
    widest = 200.0
    if wide > widest:
        raise ValueError(
            f"indentation: expected a contact radius of at most {widest:g} thicknesses of the top "
            f"layer, received {wide:.3g}"
        )
    # phi varies over the thickness of the top layer, so the number of unknowns grows with `wide`.
    # In steps of 8, so that contacts of similar width share the cached rules.
    count = 24 + 8 * math.ceil(6 * wide / 8)
    nodes, weights = even_rule(count)
    x, weight = a * nodes, a * weights
    xi, departure = spectrum(body, 2 * a)
    wave = np.cos(x[:, None] * xi)
    matrix = np.pi / 2 * np.eye(count) - (wave * departure) @ wave.T * weight
    compliance = 2 / elastic.plane_modulus(*body.surface)
    right = np.stack([np.ones(count), x**2], axis=1) / compliance
    values = np.linalg.solve(matrix, right)
    norm = 4.0 * np.arange(count) + 1
    phi = norm[:, None] * (even_basis(count).T * weights) @ values
    return phi[:, 0], phi[:, 1]


@cache
def even_rule(count: int) -> tuple[Array, Array]:
    """Nodes and weights (count,) on 0..1, exact for even polynomials of degree < 4 count."""
    nodes, weights = legendre.leggauss(2 * count)
    return nodes[count:], weights[count:]


@cache
def even_basis(count: int) -> Array:
    """Legendre P_0, P_2, ... (count, count) at the nodes of `even_rule`, one row per node."""
    nodes, _ = even_rule(count)
    basis = np.array(legendre.legvander(nodes, 2 * count - 1)[:, ::2], np.float64)
    basis.flags.writeable = False
    return basis


def panels(low: float, high: float, *, reach: float) -> tuple[Array, Array]:
    """Composite Gauss-Legendre nodes and weights (n,) on 0..high: one panel to `low`, then octaves.

    No panel is wider than PHASE / reach.
    """
    octaves = max(1, math.ceil(math.log2(high / low)))
    edges = [0.0, *np.geomspace(low, high, octaves + 1)]
    cuts = [np.zeros(1)]
    for start, end in itertools.pairwise(edges):
        pieces = max(1, math.ceil((end - start) * reach / PHASE))
        cuts.append(np.linspace(start, end, pieces + 1)[1:])
    cut = np.concatenate(cuts)
    half = np.diff(cut)[:, None] / 2
    return (cut[:-1, None] + half * (_NODES + 1)).ravel(), (half * _WEIGHTS).ravel()


def panels_up_to(nodes: Array, high: float) -> int:
    """Count the first `nodes` of `panels` that cover 0..high, in whole panels."""
    points = len(_NODES)
    return min(len(nodes), points * math.ceil(int(np.searchsorted(nodes, high)) / points))


@dataclass(frozen=True, eq=False)
class Field:
    """Displacement, strain and stress of n_c contacts at n_p points.

    displacement (n_c, 2, n_p) u_r and u_z in mm; strain (n_c, 4, n_p) and stress (n_c, 4, n_p) in
    kPa with the components r, theta, z and rz (tensor), positive in tension.
    """

    displacement: Array
    strain: Array
    stress: Array


def subsurface_field(
    stack: Stack, contacts: Sequence[Contact], r: ArrayLike, *, z: ArrayLike
) -> Field:
    """Compute the field below `contacts` on one `stack` at points r (n_p,), z (n_p,) in mm.

    ValueError for a contact on another body, r < 0, or z outside 0.02 a to the base.
    """
    r, z = elastic.points("subsurface_field", r, z)
    r, z = np.atleast_1d(r), np.atleast_1d(z)
    if not contacts or any(contact.body != stack for contact in contacts):
        msg = "subsurface_field: expected at least one contact, and only contacts with this stack"
        raise ValueError(msg)
    widest = max(contact.contact_radius for contact in contacts)
    # Smallest depth over the largest contact radius; the integral grows as its inverse.
    shallowest = 0.02
    if np.any(z < shallowest * widest):
        raise ValueError(
            f"subsurface_field: expected points at least {shallowest} contact radii = "
            f"{shallowest * widest:.3g} mm deep, received {z.min():.3g} mm; on the surface use the "
            f"pressure of the contact"
        )
    displacement = np.empty((len(contacts), 2, len(z)))
    strain = np.empty((len(contacts), 4, len(z)))
    stress = np.empty((len(contacts), 4, len(z)))
    shallow = float(z.min())
    decay = 28.0  # exponent at which the integrals are truncated: exp(-28) is 1e-12
    xi, weights = panels(
        1e-4 / min(stack.scales[1], shallow),
        decay / shallow,
        reach=float(r.max()) + widest,
    )
    loads = weights * np.array([contact.transform(xi) for contact in contacts])
    octave = np.floor(np.log2(z))
    for level in np.unique(octave):
        members = np.flatnonzero(octave == level)
        # Deeper points need fewer of the same wavenumbers, in whole panels.
        last = panels_up_to(xi, decay / float(z[members].min()))
        depths, place = np.unique(z[members], return_inverse=True)
        kernels = stack.depths(xi[:last], depths)
        for index, depth in enumerate(depths):
            here = members[place == index]
            layer = stack.layers[stack.locate(float(depth))[0]]
            parts = _integrate(loads[:, :last], layer, kernels[index], xi=xi[:last], r=r[here])
            displacement[:, :, here], strain[:, :, here], stress[:, :, here] = parts
    return Field(displacement, strain, stress)


def _integrate(
    loads: Array, layer: Layer, kernels: Array, *, xi: Array, r: Array
) -> tuple[Array, Array, Array]:
    """Integrate displacement, strain and stress (n_c, 2 or 4, n_p) at one depth.

    loads (n_c, n): transforms of the pressures times the weights; kernels (4, n) of the stack.
    """
    wave = np.multiply.outer(xi, r)
    even, odd = j0(wave), j1(wave)
    slide, sink, axial, shear = kernels
    nu, twice = layer.poisson, 2 * layer.shear
    stretch = ((1 - 2 * nu) * axial / twice - nu * slide) / (1 - nu)
    u_z, spread, strain_z, stress_z = (
        (loads * part) @ even for part in (sink, xi * slide, xi * stretch, xi * axial)
    )
    u_r, stress_rz = ((loads * part) @ odd for part in (slide, xi * shear))
    hoop = np.where(r > 0, u_r / np.where(r > 0, r, 1.0), spread / 2)
    strain = np.stack([spread - hoop, hoop, strain_z, stress_rz / twice], axis=1)
    # From sigma_z and strain differences, which stay finite in an incompressible layer.
    across = [stress_z + twice * (strain[:, i] - strain_z) for i in (0, 1)]
    stress = np.stack([*across, stress_z, stress_rz], axis=1)
    return np.stack([u_r, u_z], axis=1), strain, stress
