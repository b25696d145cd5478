"""Result of one step of a real-time finger."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fefinger.support.arrays import Array


@dataclass(slots=True)
class Step:
    """Result of a step; the arrays are those of the finger, and change with its next step.

    depth mm, force N, x and y mm of the center of pressure (nan without contact); pressure (n,) kPa
    at the candidate vertices, strain (n_sites, 6), positive in tension, with the components xx yy
    zz xy yz xz of the tensor. contact_area mm²: of `Condensed` the summed area of the vertices
    under pressure, which jumps with each of them, where `Response.contact_area` follows the rim
    within an element.
    """

    depth: float
    force: float
    contact_area: float
    x: float
    y: float
    pressure: Array
    strain: NDArray[np.floating]

    def __repr__(self) -> str:
        """Show the numbers with their units, not the arrays."""
        x, y = (round(each, 4) + 0.0 for each in (self.x, self.y))
        name, force = type(self).__name__, f"{self.force:.4g} N at {self.depth:.4g} mm"
        return f"<{name}: {force}, {self.contact_area:.4g} mm² about x {x:g}, y {y:g} mm>"
