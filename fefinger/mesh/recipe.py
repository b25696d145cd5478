"""Recipe of a finger mesh: the dimensions and the resolution that determine it."""

import hashlib
import json
from dataclasses import asdict, dataclass
from functools import lru_cache
from importlib.resources import files as package_files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fefinger.support.checks import InputError, choice, number
from fefinger.support.units import MESHED


if TYPE_CHECKING:
    from fefinger.scene.finger import Finger


RESOLUTIONS = ("coarse", "standard", "fine")

FORMAT = 2
"""Version of the builder in the cache key; increased when a recipe gives another mesh. Version 2
morphs shipped meshes."""

SURFACE_FORMAT = 8
"""The same for fingers from a surface file; version 3 morphs too, and averages their two halves;
version 4 has the nail above the tip, not above half of the thickness; version 5 has curved skin in
holes;
version 6 finds the axes of the scan and morphs the finest mesh; version 7 has a skin as smooth as
the noise of the scan asks; version 8 has other axes where it has no cut or nail, and cuts a rounded
end farther behind."""


Touch = float | tuple[float, float] | None
"""Center of the fine mesh, as in `Recipe`."""


@dataclass(frozen=True)
class Recipe:
    """Dimensions of a fingertip in mm and the resolution of its mesh.

    `surface` is a file with the outer skin surface (STL, PLY, OBJ, ...) in mm; it replaces the
    parametric shape, whose width, thickness and pad radius then only scale the inside;
    `axes` says where its axes come from, as in `read_surface`. `bone_surface` is one with the bone,
    in the same place. `tip_tissue` is the soft tissue ahead of
    a parametric bone, along x from its end to the tip, and `tip_radius` the radius of the palmar
    profile at the tip; None leaves both to the shape.
    `touch` is the center of the fine facets: the angle in degrees of a plate, for its first touch,
    or a place (x, y) in mm on the pad; None is the touch of the 30 degree plate, which every mesh
    resolves.
    """

    width: float
    thickness: float
    pad_radius: float
    skin_thickness: float = 1.0
    resolution: str = "standard"
    surface: str | None = None
    touch: Touch = None
    bone_surface: str | None = None
    tip_tissue: float | None = None
    tip_radius: float | None = None
    axes: str | None = None

    def __post_init__(self) -> None:
        for name, above, at_most in (
            ("width", *MESHED),
            ("thickness", *MESHED),
            ("pad_radius", 3.0, 60.0),
            ("skin_thickness", 0.3, 3.0),
        ):
            field = f"finger.{name.replace('skin_', 'skin.')}"
            value = number(field, getattr(self, name), at_least=above, at_most=at_most, unit="mm")
            object.__setattr__(self, name, value)
        choice("finger.resolution", self.resolution, RESOLUTIONS)

    @classmethod
    def of(cls, finger: "Finger", touch: Touch = None) -> "Recipe":
        """Return the recipe of a scene's finger."""
        skin = finger.skin.thickness
        assert skin is not None  # a finger has been checked to have one
        return cls(
            finger.width,
            finger.thickness,
            pad_radius=finger.pad_radius,
            skin_thickness=skin,
            resolution=finger.mesh,
            surface=finger.surface,
            bone_surface=finger.bone_surface,
            tip_tissue=finger.tip_tissue,
            tip_radius=finger.tip_radius,
            touch=touch,
            axes=None if finger.surface is None else finger.axes,
        )

    def to_dict(self) -> dict[str, object]:
        """Return the recipe as plain values, without the optional ones that are None."""
        values = asdict(self)
        for name in ("touch", "bone_surface", "tip_tissue", "tip_radius", "axes"):
            if values[name] is None:
                del values[name]
        if isinstance(self.touch, tuple):
            values["touch"] = list(self.touch)
        return values

    def key(self) -> str:
        """Hash of all inputs of the mesh, the content of surface files included.

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
    """SHA-256 of a surface file; raises InputError if it is gone, as for a stored result."""
    try:
        return hashlib.sha256(Path(file).read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(
            f"finger.{name}: expected a file with a surface, received {file!r} "
            f"({error.strerror or error}); give its absolute path, or work in the folder that the "
            "path is relative to"
        ) from None


STRETCH = 1.15
"""Largest ratio of facet sizes to the template's, in the fine half of the pad: a mesh beyond it is
coarser than its resolution says."""


def shipped_path(recipe: Recipe) -> Path | None:
    """Return the file of the shipped mesh of a recipe, or None."""
    wanted = recipe.to_dict()
    return next((path for shipped, path in _shipped(data_folder()) if shipped == wanted), None)


def templates(resolution: str, touch: Touch) -> list[Path]:
    """Return the shipped meshes of a resolution that are fine at `touch`."""
    return [
        path
        for recipe, path in _shipped(data_folder())
        if recipe["resolution"] == resolution and recipe.get("touch") == touch
    ]


def has_template(recipe: Recipe) -> bool:
    """Whether a shipped mesh can be morphed to a recipe, judged by its width and thickness.

    Fingers thicker than wide come out stretched or with poor cells: on coarse meshes 10 and 14 mm
    wide, at ratios of 1.25 and more, and at none up to 1.1.
    """
    return recipe.thickness <= STRETCH * recipe.width and any(
        shipped["resolution"] == recipe.resolution
        and shipped.get("touch") == recipe.touch
        and recipe.width <= STRETCH * shipped["width"]
        for shipped, _ in _shipped(data_folder())
    )


def data_folder() -> Path:
    """Return the folder of the shipped meshes, installed or in the checkout."""
    try:
        return Path(str(package_files("fefinger.meshes")))
    except ModuleNotFoundError:
        return Path(__file__).resolve().parents[2] / "meshes"


@lru_cache(maxsize=1)
def _shipped(folder: Path) -> tuple[tuple[dict[str, Any], Path], ...]:
    """Return the recipes of the meshes in a folder, with their files."""
    texts = {path: path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.json"))}
    recipes = ((json.loads(text).get("recipe"), path) for path, text in texts.items())
    return tuple((recipe, path.with_suffix(".vtu")) for recipe, path in recipes)
