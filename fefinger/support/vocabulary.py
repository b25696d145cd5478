"""Names that a scene can choose from: afferent types, drives, generators and rules.

The implementations are in `neural/endorgans.py` (with generators), `neural/drives.py` and
`neural/afferent_units.py`.
"""

from enum import StrEnum
from typing import TypeVar


Value = TypeVar("Value")


class Control(StrEnum):
    """What a motion prescribes: the depth of the object or the force on it."""

    DEPTH = "depth"
    FORCE = "force"

    @property
    def unit(self) -> str:
        """Unit of the prescribed quantity."""
        return self.of("mm", "N")

    @property
    def pace(self) -> str:
        """Key of a scene for its rate."""
        return self.of("speed", "loading_rate")

    @property
    def other(self) -> "Control":
        """The quantity that results: the force of a given depth, the depth of a given force."""
        return self.of(Control.FORCE, Control.DEPTH)

    def of(self, depth: Value, force: Value) -> Value:
        """Return the first value if the depth is prescribed, the second if the force is."""
        return force if self is Control.FORCE else depth

    def __repr__(self) -> str:
        """Return the text that a motion takes."""
        return repr(str(self))

    @classmethod
    def of_kind(cls, kind: str) -> "Control":
        """Control of a motion by its kind in a scene, as "ramp" or "force-ramp"."""
        return cls.FORCE if kind.startswith("force-") else cls.DEPTH


TYPES = ("SAI", "SAII", "FAI", "FAII")
"""Afferent types: slowly (SA) and fast (FA) adapting, with small (I) and large (II) fields."""

TYPE_SYNONYMS = {
    "sa1": "SAI",
    "sa2": "SAII",
    "ra": "FAI",
    "ra1": "FAI",
    "rai": "FAI",
    "fa1": "FAI",
    "pc": "FAII",
    "ra2": "FAII",
    "raii": "FAII",
    "fa2": "FAII",
}
"""Other names of the types in the literature, in lower case: not accepted, but understood."""

FAMILIES = ("recorded", "thesis")
"""Families of afferents, the default first: `recorded`, fitted to recorded responses
(`neural/recorded.py`), and `thesis`, the chain of Pawluk (1997) with its squid membrane."""

DRIVES = ("compressive", "tensile", "tangent", "energy", "von_mises")
"""Components of the strain at an end organ that can drive it."""

GENERATORS = ("saturating", "linear")
"""Laws from the output of an end organ to the generator current, the default first."""

RULES = ("mean", "max", "first")
"""Combination of the generator currents of a unit's end organs.

"mean": the mean current on one membrane, the spatial summation of generator current. "max": at
every time the largest one on one membrane. "first": a membrane for each branch; the first to fire
fires the unit and its impulse invades the others, which take over its state (that branches of SAI
units reset each other: Lesniak et al. 2014, doi:10.7554/eLife.01488, and PMC4332704). It costs one
integration per branch, the others one per unit. With one input to all branches the three agree.
"""

RECORDED_RULES = ("max", "mean")
"""The same for units of the family `recorded`, whose inputs are combined before one filter: the
largest of the end organs at every time, or their mean."""

LONGEST_RUN = 3600.0
"""Longest run with spikes in s: an hour is 72 million steps of every membrane."""
