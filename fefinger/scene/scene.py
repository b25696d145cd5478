"""A scene: finger, indenter, motion and requested outputs, with conversion to and from TOML."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np

from fefinger.laws import LAWS
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat
from fefinger.scene.motion import Motion
from fefinger.scene.toml import parse, parts, read, tables
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, names, number
from fefinger.support.registry import AFFERENTS
from fefinger.support.units import TRAVEL
from fefinger.support.vocabulary import LONGEST_RUN


PACKAGE, SCRIPT = "fefinger.", "__main__"
"""Of modules: the start of those of this package, and a script or notebook, which has no name that
another process could load."""


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Complete description of a touch: finger, indenter, motion and requested outputs.

    `plugins` are modules with objects and models of one's own that the scene uses; the modules of
    its indenter's class, of its laws and of its afferents are added. Equal scenes are equal;
    `Scene.from_toml(scene.to_toml()) == scene` holds exactly.
    """

    name: str = "scene"
    plugins: tuple[str, ...] = ()
    finger: Finger
    indenter: Indenter = field(default_factory=Flat)
    motion: Motion
    ask: Ask = field(default_factory=Ask)

    def __post_init__(self) -> None:
        """Check the parts and their combination."""
        if not isinstance(self.name, str) or not self.name.strip() or not self.name.isprintable():
            msg = f"name: expected a name for the scene that can be printed, received {self.name!r}"
            raise InputError(msg)
        kinds = {"finger": Finger, "indenter": Indenter, "motion": Motion, "ask": Ask}
        for name, kind in kinds.items():
            value = getattr(self, name)
            if not isinstance(value, kind):
                received = type(value).__name__
                if isinstance(value, type):
                    received = f"the class {value.__name__} itself; give it its values"
                article = "an" if kind.__name__[0] in "AI" else "a"
                raise InputError(f"{name}: expected {article} {kind.__name__}, received {received}")
        self._name_plugins()
        self._check_places()
        self._check_path()
        if self.ask.spikes and self.motion.duration > LONGEST_RUN:
            raise InputError(
                f"motion: expected at most {LONGEST_RUN:g} s where ask.spikes asks for spikes, "
                f"received {self.motion.duration:g} s; shorten the motion or ask for no spikes"
            )

    def _name_plugins(self) -> None:
        """Add the modules of object, laws and afferents, where they are not of the package."""
        laws = (LAWS[layer.law] for layer in (self.finger.skin, self.finger.subcutaneous))
        homes = [type(self.indenter).__module__, *(LAWS.origin(law)[0] for law in laws)]
        if self.ask.afferents not in AFFERENTS.shipped:
            homes.append(AFFERENTS.origin(AFFERENTS[self.ask.afferents])[0])
        own = [each for each in homes if each != SCRIPT and not each.startswith(PACKAGE)]
        plugins = dict.fromkeys((*names("plugins", self.plugins), *own))
        object.__setattr__(self, "plugins", tuple(plugins))

    @property
    def mirrored(self) -> bool:
        """Whether it is its own mirror image in the medial plane, so that half a finger does."""
        return self.indenter.mirrored and self.motion.mirrored

    def _check_places(self) -> None:
        """Check that motion and end organs stay within the tissue, and the object over the pad."""
        pulp = self.finger.pulp
        deepest = self.motion.deepest
        if deepest is not None and deepest >= pulp:
            raise InputError(
                f"motion.depth: expected less than {pulp:g} mm, the tissue under the pad (half the "
                f"finger's thickness), received a largest depth of {deepest:g} mm"
                f"{TRAVEL.hint(deepest)}"
            )
        for name, depth in self.ask.depths.items():
            number(f"ask.depths.{name}", depth, below=pulp, unit="mm")
        self._check_object()

    def _check_object(self) -> None:
        """Check that the object covers a part of the pad."""
        indenter, finger = self.indenter, self.finger
        if indenter.place is not None:
            # Where it goes on for ever the mesh tells whether it covers the pad.
            c, s = np.cos(np.radians(indenter.turn)), np.sin(np.radians(indenter.turn))
            turns, own = np.round(np.abs([[c, s], [s, c]]), 9), np.array(indenter.half_sides)
            parts = np.multiply(turns, own, out=np.zeros((2, 2)), where=turns > 0)
            limits = np.array([2 * finger.width, finger.width / 2]) + parts.sum(axis=1)
            if (np.abs(indenter.place) >= limits).any():
                raise InputError(
                    f"indenter.at: expected a place from which the object covers a part of the "
                    f"pad, x within {limits[0]:g} and y within {limits[1]:g} mm, received "
                    f"{list(indenter.place)}"
                )
        extent = None if self.motion.slides else indenter.extent  # else its path says it
        if extent is not None and any(low >= 0 or high <= 0 for low, high in extent):
            (left, right), (low, high) = extent
            raise InputError(
                f"indenter: expected an object that covers the place (0, 0) of first touch, "
                f"received one from x = {left:.4g} to {right:.4g} and y = {low:.4g} to {high:.4g} "
                "mm; shift it, or set indenter.center = true for a relief from a file, whose "
                "middle is put there"
            )

    def _check_path(self) -> None:
        """Check that the path stays on the object, as far as the point of first touch goes."""
        extent = self.indenter.extent
        if extent is None or not self.motion.slides:
            return
        roll = np.radians(self.indenter.turn)
        x, y = -self.motion.shift(np.array(self.motion.breakpoints)).T
        places = (np.cos(roll) * x + np.sin(roll) * y, np.cos(roll) * y - np.sin(roll) * x)
        shorter = _shortened(extent, places) if self.motion.along_line else 0.0
        distance = getattr(self.motion, "distance", 0.0) * shorter
        # Rounded down, so that what the message names is accepted.
        at_most = f" (motion.distance at most {np.floor(100 * distance + 1e-6) / 100:g})"
        short = 0.1  # distance in mm of a slide below which a shorter one is not suggested
        path = "a shorter path" + (at_most if distance >= short else "")
        for name, range_, place in zip("xy", extent, places, strict=True):
            low, high = float(place.min()), float(place.max())
            if low < range_[0] or high > range_[1]:
                raise InputError(
                    f"motion: expected a path on the object, which reaches from {range_[0]:.4g} to "
                    f"{range_[1]:.4g} mm along its {name}, received one from {low:.4g} to "
                    f"{high:.4g} mm; take {path}, another direction or a larger object, or "
                    "for a relief from a file indenter.center = true"
                )

    def to_dict(self) -> dict[str, Any]:
        """Convert to nested tables of plain values, as in a TOML file."""
        plugins = {"plugins": list(self.plugins)} if self.plugins else {}
        return {
            "name": self.name,
            **plugins,
            **tables(self.finger, self.indenter, self.motion, self.ask),
        }

    def to_toml(self) -> str:
        """Convert to TOML text, with every value written out."""
        import tomli_w

        return tomli_w.dumps(self.to_dict())

    @classmethod
    def from_dict(cls, table: Mapping[str, object], *, folder: str | Path = ".") -> Self:
        """Read a scene from nested tables; files in it are looked up relative to `folder`."""
        return cls(**parts(table, Path(folder)))

    @classmethod
    def from_toml(cls, source: str | Path) -> Self:
        """Read a scene from a file, or from TOML text (a string with a line break or a "=").

        A scene without a name is named after its file, without the ending.
        """
        if isinstance(source, str) and ("\n" in source or "=" in source or not source.strip()):
            return cls.from_dict(parse(source))
        path = Path(source)
        return cls.from_dict({"name": path.stem, **read(path)}, folder=path.parent)

    @classmethod
    def from_stored(cls, text: str) -> Self:
        """Read a scene that `to_toml` wrote, without the files that it names."""
        return cls(**parts(parse(text), None))


def _shortened(extent: Iterable[tuple[float, float]], places: Iterable[Array]) -> float:
    """Return the part of a straight path from (0, 0) that stays on an object; 1: all of it.

    extent: range (2,) of x and of y; places: coordinates (n,) of the path, x and y.
    """
    share = 1.0
    for (least, most), place in zip(extent, places, strict=True):
        for past, limit in ((-float(place.min()), -least), (float(place.max()), most)):
            if past > limit:
                share = min(share, limit / past if past else 0.0)
    return max(share, 0.0)
