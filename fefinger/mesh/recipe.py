"""What a finger mesh is made from: the few numbers that decide shape and resolution."""

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from fefinger.support.checks import InputError, choice, number


RESOLUTIONS = ("coarse", "standard", "fine")

FORMAT = 1
"""Raised when the builder changes so that meshes cached from the same recipe must be made again."""

SURFACE_FORMAT = 2
"""The same of fingers from a surface file: since 2 it is checked how they lie in it."""


Touch = float | tuple[float, float] | None
"""Where a mesh is fine, as in `Recipe`."""


@dataclass(frozen=True)
class Recipe:
    """Dimensions of a fingertip in mm and the resolution of its mesh.

    `surface` is a file with the outer skin surface (STL, PLY, OBJ, ...) in mm; it replaces the
    parametric shape, whose width, thickness and pad radius then only scale the inside;
    `bone_surface` is one with the bone, in the same place.
    `touch` is where the facets are fine: the angle in degrees of the plate that touches there, or
    a place (x, y) in mm on the pad; None is around the touch of the 30 degree plate, which every
    mesh resolves.
    """

    width: float
    thickness: float
    pad_radius: float
    skin_thickness: float = 1.0
    resolution: str = "standard"
    surface: str | None = None
    touch: Touch = None
    bone_surface: str | None = None

    def __post_init__(self) -> None:
        for name, above, at_most in (
            ("width", 5.0, 40.0),
            ("thickness", 5.0, 40.0),
            ("pad_radius", 3.0, 60.0),
            ("skin_thickness", 0.3, 3.0),
        ):
            value = number(name, getattr(self, name), at_least=above, at_most=at_most, unit="mm")
            object.__setattr__(self, name, value)
        choice("resolution", self.resolution, RESOLUTIONS)

    @classmethod
    def of(cls, finger: Any, touch: Touch = None) -> "Recipe":
        """Return the recipe of a scene's finger (any record with the same fields)."""
        return cls(
            finger.width,
            finger.thickness,
            pad_radius=finger.pad_radius,
            skin_thickness=finger.skin.thickness,
            resolution=finger.mesh,
            surface=finger.surface,
            bone_surface=finger.bone_surface,
            touch=touch,
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the recipe as plain values, without `touch` and `bone_surface` where None."""
        values = asdict(self)
        for name in ("touch", "bone_surface"):
            if values[name] is None:
                del values[name]
        if isinstance(self.touch, tuple):
            values["touch"] = list(self.touch)
        return values

    def key(self) -> str:
        """Return a hash of all that decides the mesh, the content of a surface file included.

        Raises InputError where a surface file cannot be read.
        """
        made = FORMAT if self.surface is None else SURFACE_FORMAT
        parts = {**self.to_dict(), "format": made}
        for name in ("surface", "bone_surface"):
            file = getattr(self, name)
            if file is not None:
                parts[name] = _hash(name, file)
        text = json.dumps(parts, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()


def _hash(name: str, file: str) -> str:
    """Return the SHA-256 of the surface file of a finger; that of a stored result may be gone."""
    try:
        return hashlib.sha256(Path(file).read_bytes()).hexdigest()
    except OSError as error:
        message = (
            f"finger.{name}: expected a file with a surface, received {file!r} "
            f"({error.strerror or error}); work in the folder that the path is relative to, or "
            "name the file where it is"
        )
        raise InputError(message) from None
