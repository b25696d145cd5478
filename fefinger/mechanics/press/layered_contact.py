"""A layered finger over rigid bone as an elastic contact, from the exact table of its stack."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.theory.contact.contact_table import LEVELS, Table, tabulate_to
from fefinger.theory.contact.stack import Stack


@dataclass(frozen=True, eq=False)
class Layered:
    """Contacts of a rigid paraboloid with a stack, up to the deepest of the scene."""

    table: Table

    @classmethod
    def to_depth(cls, stack: Stack, radius: float, depth: float, *, levels: int = LEVELS) -> Self:
        """Return the contacts down to `depth` mm; ValueError where they are wider than `radius`."""
        return cls(tabulate_to(stack, radius, depth=depth, levels=levels))

    @classmethod
    def to_force(cls, stack: Stack, radius: float, force: float) -> Self:
        """Return the contacts up to `force` mN; ValueError where they are wider than `radius`."""
        return cls(tabulate_to(stack, radius, force=force))

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
        return self.table.load(depth, r)

    def strain(self, depth: Array, r: Array, z: Array) -> Array:
        """Return e_r, e_t, e_z, e_rz (n, m, 4) at r, z (m,) mm, z > 0 below the surface."""
        try:
            return np.moveaxis(self.table.strain(depth, r, z=z), 1, 2)
        except ValueError as error:
            msg = f"ask.depths: {error}; ask for other depths or for no strain, or press less"
            raise InputError(msg) from error
