"""Names and traits of the mechanics, and a candidate: a mechanics on one of its meshes."""

from dataclasses import dataclass
from typing import NamedTuple, Self


class Traits(NamedTuple):
    """Traits of a mechanics: whether it has a mesh, finite strain, and inertia."""

    meshed: bool
    finite: bool
    inertia: bool = False


MECHANICS = {
    "lumped": Traits(meshed=False, finite=False),
    "hertz": Traits(meshed=False, finite=False),
    "layered": Traits(meshed=False, finite=False),
    "condensed": Traits(meshed=True, finite=False),
    "pressed": Traits(meshed=True, finite=True),
    "modal": Traits(meshed=True, finite=False, inertia=True),
    "linear": Traits(meshed=True, finite=False),
    "solid": Traits(meshed=True, finite=True),
}
"""The mechanics, cheapest first, with their traits."""

MESHED = tuple(name for name, traits in MECHANICS.items() if traits.meshed)
"""Those with a mesh, whose resolution is the planner's to choose."""


@dataclass(frozen=True, order=True)
class Candidate:
    """A mechanics by name, and the resolution of its mesh; None without one."""

    mechanics: str
    resolution: str | None = None

    @classmethod
    def of(cls, label: str) -> Self:
        """Read the label of a report, such as "hertz" or "linear coarse"."""
        mechanics, _, resolution = label.partition(" ")
        return cls(mechanics, resolution or None)

    @property
    def on(self) -> str:
        """Mechanics and mesh in words, as in "pressed on the standard mesh"."""
        return (
            f"{self.mechanics} on the {self.resolution} mesh" if self.resolution else self.mechanics
        )

    @property
    def label(self) -> str:
        """Its name in reports and tables."""
        return f"{self.mechanics} {self.resolution or ''}".rstrip()

    @property
    def measured(self) -> Self:
        """The candidate whose measured errors and spikes hold for it: standard for fine."""
        resolution = "standard" if self.resolution == "fine" else self.resolution
        return type(self)(self.mechanics, resolution)
