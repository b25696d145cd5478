"""Contact of rigid patterns with the flat stack of `layered`, finer than a mesh of the finger.

Bars, pins and arrays of probes have edges that the elements of the finger (0.6 mm) do not resolve.
Here the pad is a paraboloid on the exact layers over bone, on the grid of the mechanics `layered`.
Elastic: under a prescribed depth strain does not relax, under a force it is that at once.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from fefinger.validation.afferents import experiments

from fefinger.contact.active_set import DONE
from fefinger.contact.gridded import GridContact, GridFriction, GridStepper
from fefinger.contact.stepper import Target
from fefinger.geometry.profiles import Profile
from fefinger.mechanics.layered import stack
from fefinger.mechanics.press.layer_grid import LayerGrid, StrainProbe
from fefinger.neural.drives import DRIVE_BY_NAME
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError
from fefinger.theory.contact.stack import Stack


Shape = Callable[[Array], Array]
"""Heights (...,) mm of an object above its lowest point, at places (..., 2) mm."""

POINTS, SPACING = 192, 0.08
"""Grid points on a side, and the distance in mm between them."""

ELASTIC = np.zeros(0), np.zeros(0)


@dataclass(frozen=True)
class Pad:
    """Paraboloid of `radius` mm on a stack of layers, on a periodic grid."""

    layers: Stack
    radius: float
    points: int = POINTS
    spacing: float = SPACING

    @cached_property
    def grid(self) -> LayerGrid:
        """The layers."""
        return LayerGrid(self.layers, self.points, self.spacing)

    def gap(self, shape: Shape) -> Array:
        """Distance (n, n) mm of a rigid object at first touch of its lowest point."""
        places = self.grid.places
        return np.asarray(np.sum(places**2, axis=-1) / (2 * self.radius) + shape(places))

    def contact(
        self, gap: Callable[[tuple[float, float]], Array], friction: float = 0.0
    ) -> GridStepper:
        """Return the elastic contact with an object, by its gap (n, n) mm at a place."""
        shape, rest = (self.points, self.points), (self.spacing, gap, ELASTIC)
        if not friction:
            return GridContact(self.grid.compliance, shape, *rest)
        return GridFriction(self.grid.flexibility, shape, (friction, friction), *rest)

    def pressure(self, shape: Shape, depth: float) -> Array:
        """Pressure (n, n) in kPa under a rigid object `depth` mm deep.

        ConvergenceError if the contact is not found.
        """
        gap = self.gap(shape)
        contact = self.contact(lambda shift: gap)
        solved(contact, Target(depth))
        return contact.pressure.reshape(gap.shape)

    def strain(self, pressure: Array, z: float, places: Array) -> Array:
        """Strain (n_places, 3, 3) at the depth z mm below places (n_places, 2) mm."""
        return StrainProbe(self.grid, places, np.full(len(places), z)).strain(pressure)


def solved(contact: GridStepper, target: Target) -> None:
    """Take a contact to a target; ConvergenceError if it is not found."""
    outcome = contact.advance(1.0, target)
    if outcome != DONE:
        raise ConvergenceError(contact.failures[outcome])


@cache
def pad() -> Pad:
    """Return the pad of the experiments."""
    return Pad(stack(experiments.MACAQUE), experiments.MACAQUE.pad_radius)


def driven(shape: Shape, depth: float, places: Array, *, drive: str, organ: float) -> Array:
    """Drives (n,) of end organs `organ` mm below places (n, 2) mm, `depth` mm under an object."""
    strain = pad().strain(pad().pressure(shape, depth), organ, np.asarray(places, float))
    return DRIVE_BY_NAME[drive](strain, np.tile([0.0, 0.0, 1.0], (len(strain), 1)))


def heights(profile: Profile) -> Shape:
    """Return the shape of the profile of an indenter."""
    return lambda places: profile.height(places)[0]
