"""A layered finger over rigid bone as an elastic contact, from the exact table of its stack."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fefinger.theory.indentation import paraboloid_at, paraboloid_under
from fefinger.theory.stack import Stack
from fefinger.theory.table import LEVELS, Table, tabulate


Array = NDArray[np.float64]

MARGIN = 1.001
"""Contact radius of the table over the largest one asked for, so that rounding stays inside."""


@dataclass(frozen=True, eq=False)
class Layered:
    """Contacts of a rigid paraboloid with a stack, up to the deepest of the scene."""

    table: Table

    @classmethod
    def to_depth(cls, stack: Stack, radius: float, depth: float, *, levels: int = LEVELS) -> Self:
        """Return the contacts down to `depth` mm; ValueError where they are wider than `radius`."""
        widest = paraboloid_at(stack, radius, depth=depth).contact_radius
        return cls(tabulate(stack, radius, widest=min(MARGIN * widest, radius), levels=levels))

    @classmethod
    def to_force(cls, stack: Stack, radius: float, force: float) -> Self:
        """Return the contacts up to `force` mN; ValueError where they are wider than `radius`."""
        widest = paraboloid_under(stack, radius, force=force).contact_radius
        return cls(tabulate(stack, radius, widest=min(MARGIN * widest, radius)))

    def force(self, depth: Array) -> Array:
        """Return the force (n,) in mN."""
        return self.table.force(depth)

    def depth(self, force: float) -> float:
        """Return the depth in mm under a force in mN."""
        return float(self.table.depth(force))

    def radius(self, depth: Array) -> Array:
        """Return the contact radius (n,) in mm."""
        return self.table.contact_radius(depth)

    def load(self, depth: Array, r: Array) -> Array:
        """Return the force (n, m) in mN within the distances r (m,) mm of the axis."""
        out = np.zeros((len(depth), len(r)))
        force = self.force(depth)
        for row, reached, whole in zip(out, depth, force, strict=True):
            if reached > 0:
                contact = self.table.at(float(reached))
                # The shares of the interpolated pressure, of the force that the table states.
                row[:] = contact.load(r) * whole / contact.force
        return out

    def strain(self, depth: Array, r: Array, z: Array) -> Array:
        """Return e_r, e_t, e_z, e_rz (n, m, 4) at r, z (m,) mm, z > 0 below the surface."""
        return np.moveaxis(self.table.strain(depth, r, z=z), 1, 2)
