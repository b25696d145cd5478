"""Table of contacts of a sphere with a layered body, interpolated by splines to any depth.

The interpolated quantity is the logarithm of the departure from Hertz, which starts at 0, so the
table is valid from first touch on. It is smooth in the contact radius, not in the depth: under a
stiff skin the depth grows a thousandfold while the contact doubles. Lengths in mm, moduli and
stresses in kPa, forces in mN.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array
from fefinger.theory.contact.indentation import Contact, over_edge, paraboloid, subsurface_field
from fefinger.theory.contact.stack import Stack


LEVELS = 48
"""Number of contacts per table; force of a finger over bone within 1e-6, strain within 1e-4."""

STEP = 2**0.25
"""Ratio of the largest contact radii of tables, so that presses of one body share tables."""


class TooWideError(ValueError):
    """Error for a contact that is wider than the radius of the paraboloid."""


@dataclass(frozen=True, eq=False)
class ContactTable:
    """Contacts (n,) of a rigid paraboloid of `radius` mm with `stack`, of growing contact radius.

    Made by `tabulate`.
    """

    stack: Stack
    radius: float
    contacts: tuple[Contact, ...]

    @property
    def deepest(self) -> float:
        """Largest depth in mm of the table."""
        return self.contacts[-1].depth

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return a (...,) in mm at the approach `depth` (...,) mm, 0 to `deepest`."""
        depth = self._within(depth)
        return np.sqrt(self.radius * depth) * np.exp(self._departure(self._rank(depth, 0))[..., 0])

    def force(self, depth: ArrayLike) -> Array:
        """Return P (...,) in mN at the approach `depth` (...,) mm, 0 to `deepest`."""
        depth = self._within(depth)
        return self._hertz * depth**1.5 * np.exp(self._departure(self._rank(depth, 0))[..., 1])

    def depth(self, force: ArrayLike) -> Array:
        """Return the approach (...,) in mm that carries `force` (...,) mN.

        ValueError for a force below zero, or larger than at the deepest contact.
        """
        force = np.asarray(force, np.float64)
        most = self.contacts[-1].force
        if not np.all((force >= 0) & (force <= most * (1 + 1e-12))):
            msg = f"Table: expected a force in 0 to {most:.6g} mN, received {force.max():.6g} mN"
            raise ValueError(msg)
        departure = np.exp(self._departure(self._rank(force, 1))[..., 1])
        return np.asarray(np.cbrt(force / (self._hertz * departure)) ** 2)

    def load(self, depth: ArrayLike, r: ArrayLike) -> Array:
        """Return the force (n_d, n_r) in mN within r (n_r,) mm of the axis at depths (n_d,) mm.

        The fractions of the interpolated pressure times the force of the table.
        """
        depth, r = np.atleast_1d(self._within(depth)), np.atleast_1d(np.asarray(r, np.float64))
        a = self.contact_radius(depth)
        x = r / np.where(a > 0, a, 1.0)[:, None]
        y = np.sqrt(np.maximum(1 - x**2, 0.0))
        inner = legendre.legint(over_edge(self._shape(a).T), lbnd=0)
        outside = legendre.legval(y, inner[:, :, None], tensor=False)
        return np.asarray(self.force(depth)[:, None] * (1 - outside / inner.sum(axis=0)[:, None]))

    def strain(self, depth: ArrayLike, r: ArrayLike, z: ArrayLike) -> Array:
        """Return the elastic strain (n_d, 4, n_p) below the contacts at `depth` (n_d,) mm.

        r (n_p,), z (n_p,) in mm; components r, theta, z and rz (tensor). ValueError for
        points that `subsurface_field` rejects under the widest contact. The last fields are cached.
        """
        depth = np.atleast_1d(self._within(depth))
        r, z = (np.atleast_1d(np.asarray(place, np.float64)) for place in (r, z))
        per_force = _strain_per_force(self, tuple(r.tolist()), tuple(z.tolist()))
        here = np.maximum(self.contact_radius(depth), self.contacts[0].contact_radius)
        return np.asarray(per_force(here) * self.force(depth)[:, None, None])

    @property
    def _hertz(self) -> float:
        """P_Hertz over depth^(3/2), in mN / mm^(3/2)."""
        return 4 / 3 * elastic.plane_modulus(*self.stack.surface) * math.sqrt(self.radius)

    @property
    def _widest(self) -> float:
        """Largest contact radius in mm."""
        return self.contacts[-1].contact_radius

    def _rank(self, wanted: Array, which: int) -> Array:
        """Return sqrt(a / widest) where the depth (0) or force (1) is `wanted`, by bisection."""
        low, high = np.zeros_like(wanted), np.ones_like(wanted)
        # 60 halvings reach rounding for any curve.
        for _ in range(60):
            middle = (low + high) / 2
            wide, load = np.moveaxis(np.exp(self._departure(middle)), -1, 0)
            depth = (self._widest * middle**2 / wide) ** 2 / self.radius
            over = (depth, self._hertz * depth**1.5 * load)[which] > wanted
            low, high = np.where(over, low, middle), np.where(over, middle, high)
        return (low + high) / 2

    @cached_property
    def _departure(self) -> CubicSpline:
        """Spline of the logarithms of a / sqrt(R depth) and P / P_Hertz over sqrt(a / widest)."""
        depth = np.array([contact.depth for contact in self.contacts])
        wide = np.array([contact.contact_radius for contact in self.contacts])
        force = np.array([contact.force for contact in self.contacts])
        ratios = np.stack([wide / np.sqrt(self.radius * depth), force / self._hertz / depth**1.5])
        rows = np.concatenate([np.zeros((1, 2)), np.log(ratios.T)])
        rank = np.sqrt(np.append(0.0, wide) / self._widest)
        return CubicSpline(rank, rows)

    @cached_property
    def _shape(self) -> CubicSpline:
        """Spline of the coefficients of phi / a² over a; at a = 0 Hertz's coefficients."""
        count = max(len(contact.phi) for contact in self.contacts)
        rows = np.zeros((len(self.contacts) + 1, count))
        flat = elastic.plane_modulus(*self.stack.surface) / (math.pi * self.radius)
        rows[0, :2] = 2 / 3 * flat, -2 / 3 * flat
        for row, contact in zip(rows[1:], self.contacts, strict=True):
            row[: len(contact.phi)] = contact.phi / contact.contact_radius**2
        wide = [0.0, *(contact.contact_radius for contact in self.contacts)]
        return CubicSpline(wide, rows)

    def _within(self, depth: ArrayLike) -> Array:
        """Check that depths are in the range of the table."""
        depth = np.asarray(depth, np.float64)
        if not np.all((depth >= 0) & (depth <= self.deepest * (1 + 1e-12))):
            raise ValueError(f"Table: expected depths in 0 to {self.deepest:.6g} mm")
        return depth


@lru_cache(maxsize=8)
def _strain_per_force(
    table: ContactTable, r: tuple[float, ...], z: tuple[float, ...]
) -> CubicSpline:
    """Spline of the strain (4, n_p) at points r, z mm per unit force, over the contact radius a.

    It tends to the strain of a point force, with zero slope in a.
    """
    solved = subsurface_field(table.stack, table.contacts, r, z=z).strain
    wide = np.array([contact.contact_radius for contact in table.contacts])
    force = np.array([contact.force for contact in table.contacts])
    return CubicSpline(wide, solved / force[:, None, None], bc_type=("clamped", "not-a-knot"))


@lru_cache(maxsize=16)
def tabulate(stack: Stack, radius: float, *, widest: float, levels: int = LEVELS) -> ContactTable:
    """Tabulate contacts of a paraboloid of `radius` mm up to a contact radius of `widest` mm.

    The last tables are cached: scenes of one finger share them. ValueError as in
    `indentation.paraboloid` at `widest`.
    """
    elastic.require_positive("tabulate", radius=radius, widest=widest)
    fewest = 4  # smallest number of contacts that a cubic spline needs
    if levels < fewest:
        raise ValueError(f"tabulate: expected at least {fewest} levels, received {levels!r}")
    # Quadratic spacing: the departure from Hertz begins at the thickness of the top layer, however
    # thin.
    wide = widest * (np.arange(1, levels + 1) / levels) ** 2
    solved = [paraboloid(stack, radius, contact_radius=float(a)) for a in wide]
    return ContactTable(stack, radius, tuple(solved))


def tabulate_to(
    stack: Stack,
    radius: float,
    *,
    depth: float | None = None,
    force: float | None = None,
    levels: int = LEVELS,
) -> ContactTable:
    """Tabulate contacts up to `depth` mm, or else up to `force` mN.

    The widest contact is the smallest power of STEP mm that suffices, or `radius`.

    TooWideError for a contact wider than `radius`.
    """
    quantity, wanted = ("force", force or 0.0) if depth is None else ("depth", depth)
    elastic.require_positive("tabulate_to", radius=radius, **{quantity: wanted})
    stiff = elastic.plane_modulus(*stack.surface)
    guess = {
        "depth": (radius * wanted) ** 0.5,
        "force": (0.75 * wanted * radius / stiff) ** (1 / 3),
    }

    def reaches(power: int) -> bool:
        wide = min(STEP**power, radius)
        return bool(getattr(paraboloid(stack, radius, contact_radius=wide), quantity) >= wanted)

    most = math.ceil(math.log(radius, STEP))
    power = min(math.ceil(math.log(guess[quantity], STEP)), most)
    while power < most and not reaches(power):
        power += 1
    while reaches(power - 1):
        power -= 1
    if power == most and not reaches(most):
        unit = {"depth": "mm", "force": "mN"}[quantity]
        raise TooWideError(
            f"tabulate_to: expected a {quantity} whose contact is at most as wide as the radius "
            f"{radius:g} mm (small strain), received {wanted:g} {unit}"
        )
    return tabulate(stack, radius, widest=min(STEP**power, radius), levels=levels)
