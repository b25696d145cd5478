"""Meshes that come with the package: by recipe, or as templates for other fingers."""

import json
from functools import lru_cache
from importlib.resources import files as package_files
from pathlib import Path
from typing import Any

from fefinger.mesh.recipe import Recipe, Touch


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
    """Whether a shipped mesh can be morphed to a recipe, judged by its width."""
    return any(
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
