"""A body in contact at one depth, and what a step has to reach."""

from dataclasses import dataclass

from fefinger.fem.elements.spaces import Array
from fefinger.fem.hyperelastic.continuum import Memory
from fefinger.support.tolerances import SMALL_FORCE


@dataclass(frozen=True)
class State:
    """A body at one depth.

    values (n_unknowns,); pressure (n,) kPa the coefficients lambda of the candidates, with what
    holds their facets; depth mm.
    """

    values: Array
    pressure: Array
    depth: float

    def toward(self, other: "State", part: float) -> "State":
        """Return the state at `part` of the way to another."""
        return State(
            self.values + part * (other.values - self.values),
            self.pressure + part * (other.pressure - self.pressure),
            self.depth + part * (other.depth - self.depth),
        )


@dataclass(frozen=True)
class Asked:
    """What a step has to reach: a depth in mm or a force in mN, with what the past left.

    peak is the largest of them on the path.
    """

    control: str
    target: float
    memory: Memory
    peak: float = 0.0

    @property
    def small(self) -> float:
        """Force in mN below which errors are relative to one of this size; 0 for a depth."""
        return SMALL_FORCE * self.peak if self.control == "force" else 0.0

    @property
    def shallow(self) -> float:
        """Depth in mm below which errors are relative to one of this size; 0 for a force."""
        return SMALL_FORCE * self.peak if self.control == "depth" else 0.0
