"""What a step of a loop in real time gives, and the state between two steps."""

from dataclasses import dataclass
from typing import Any

from fefinger.support.arrays import Array, Floats


@dataclass(slots=True, repr=False)
class Step:
    """Result of a step; the loop owns the arrays, which change with its next step.

    depth mm, force N; touching: whether there is contact; x and y mm: center of pressure, without
    contact the last one (the first touch at the start); pressure (n,) kPa at the candidate
    vertices; strain (n_sites, 6), positive in tension, with the components xx yy zz xy yz xz of the
    tensor. contact_area mm²: at small strain the summed area of the vertices under pressure, which
    jumps with each of them, where `Result.contact_area` follows the rim within an element.

    Of an object that moves sideways: shift (2,) mm, and lateral_force (2,) N on the finger, both
    distal and radial; with friction torque N mm on the finger about the normal through the center
    of pressure, stick_area mm² of the vertices that do not slip, and work mJ lost so far.
    """

    pressure: Array
    strain: Floats
    shift: Array
    lateral_force: Array
    depth: float = 0.0
    force: float = 0.0
    contact_area: float = 0.0
    x: float = 0.0
    y: float = 0.0
    touching: bool = False
    torque: float = 0.0
    stick_area: float = 0.0
    work: float = 0.0

    def __repr__(self) -> str:
        """Show the numbers with their units, not the arrays."""
        x, y = (round(each, 4) + 0.0 for each in (self.x, self.y))
        where = f"about x {x:g}, y {y:g} mm" if self.touching else "no contact"
        force = f"{self.force:.4g} N at {self.depth:.4g} mm"
        return f"<{type(self).__name__}: {force}, {self.contact_area:.4g} mm², {where}>"


@dataclass(frozen=True)
class LoopState:
    """State of a loop: its contact's state, the center of pressure in mm, the angles in degrees."""

    contact: tuple[Any, ...]
    center: tuple[float, float]
    angles: tuple[float, float]
