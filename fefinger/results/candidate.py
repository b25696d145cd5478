"""Names and traits of the mechanics, and a candidate: a mechanics on one of its meshes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple, Self

from fefinger.support import registry
from fefinger.support.checks import InputError


class Traits(NamedTuple):
    """Traits of a mechanics: whether it has a mesh, finite strain, inertia, ridges of the skin.

    local: whether it gives pressure and strain, besides the force.
    """

    meshed: bool
    finite: bool
    inertia: bool = False
    ridges: bool = False
    local: bool = True

    @property
    def outputs(self) -> tuple[str, ...]:
        """What it gives of `Ask.pressure`, `strain` and `fields`."""
        return ("pressure", "strain") * self.local + ("fields",) * self.meshed


class _TraitsByName(Mapping[str, Traits]):
    """Traits of the mechanics of the package, cheapest first, then of the user's own.

    An unknown mechanics, which a saved result may name, has the traits SIMPLEST.
    """

    def __getitem__(self, name: str) -> Traits:
        if name not in registry.MECHANICS:
            return SIMPLEST
        found = registry.MECHANICS[name].traits
        if not isinstance(found, Traits):
            raise InputError(
                f"mechanics {name!r}: expected traits, a fefinger.Traits, received {found!r}"
            )
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(registry.MECHANICS)

    def __len__(self) -> int:
        return len(registry.MECHANICS)


SIMPLEST = Traits(meshed=False, finite=False)

MECHANICS: Mapping[str, Traits] = _TraitsByName()


def meshed() -> tuple[str, ...]:
    """Return the names of the mechanics with a mesh."""
    return tuple(name for name, traits in MECHANICS.items() if traits.meshed)


@dataclass(frozen=True, order=True)
class Candidate:
    """A mechanics by name, and the resolution of its mesh, None where it has none."""

    mechanics: str
    resolution: str | None = None

    @classmethod
    def of(cls, label: str) -> Self:
        """Make a candidate from its label, such as "hertz" or "linear coarse"."""
        mechanics, _, resolution = label.partition(" ")
        return cls(mechanics, resolution or None)

    @property
    def on(self) -> str:
        """Mechanics and mesh in words, as in "pressed on the standard mesh"."""
        return self.mechanics + (f" on the {self.resolution} mesh" if self.resolution else "")

    @property
    def label(self) -> str:
        """Its name in reports and tables."""
        return f"{self.mechanics} {self.resolution or ''}".rstrip()

    @property
    def measured(self) -> Self:
        """The candidate that was measured in its place: a fine mesh counts as a standard one."""
        resolution = "standard" if self.resolution == "fine" else self.resolution
        return type(self)(self.mechanics, resolution)
