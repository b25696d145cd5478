"""The mesh for a finger: shipped with the package, else from the user's cache, else built now."""

import json
import os
from collections.abc import Callable
from functools import lru_cache
from importlib.resources import files as package_files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.mesh import vtu
from fefinger.mesh.recipe import Recipe, Touch
from fefinger.mesh.symmetric import whole
from fefinger.support import cache
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from fefinger.scene.finger import Finger


def ready(
    finger: "Finger | Recipe",
    *,
    half: bool,
    touch: Touch = None,
    progress: Callable[[str], None] | None = None,
) -> FingerMesh:
    """Return the mesh for a scene's finger (or a Recipe), half or whole; `touch` as in `Recipe`.

    Looks among the shipped meshes, then in the user's cache; builds and caches it (about half a
    minute for the standard resolution) if neither has it. The mesher draws at random, so that
    whoever asks for it at the same time waits, and is given the same. `progress` receives short
    sentences.
    """
    recipe = finger if isinstance(finger, Recipe) else Recipe.of(finger, touch)
    path = shipped_path(recipe)
    mesh = vtu.read(path) if path else _cached(recipe) or _made(recipe, progress)
    return mesh if half else whole(mesh)


def at_hand(finger: "Finger", touch: Touch = None) -> bool:
    """Return whether the mesh for a scene's finger is shipped or cached, and need not be built."""
    recipe = Recipe.of(finger, touch)
    return shipped_path(recipe) is not None or os.path.isfile(cached_path(recipe))


def fault(finger: "Finger", touch: Touch = None, at: tuple[float, float] | None = None) -> str:
    """Return what keeps a scene's finger from having a mesh, in a sentence; empty if nothing known.

    Nor is there one of a finger without a pad at the place `at` (x, y) in mm. A shape is tried as
    far as it takes no mesher, some 50 ms.
    """
    from fefinger.mesh.build import touched
    from fefinger.mesh.parametric import parametric

    try:
        if finger.surface is not None or (at is None and at_hand(finger, touch)):
            return ""
        shape = parametric(Recipe.of(finger, touch))
        if at is not None:
            touched(shape, at)
    except InputError as error:
        said = str(error)
        return said if said.startswith(("finger.", "indenter.")) else f"finger.{said}"
    return ""


def sha256(finger: "Finger") -> str | None:
    """Return the hash of the file of a scene's finger's mesh; None if that is not at hand."""
    recipe = Recipe.of(finger)
    sidecar = vtu.sidecar_path(shipped_path(recipe) or cached_path(recipe))
    try:
        return str(json.loads(sidecar.read_text(encoding="utf-8"))["sha256"])
    except (OSError, ValueError, KeyError, TypeError):  # none, or a damaged one
        return None


def shipped_path(recipe: Recipe) -> Path | None:
    """Return the file of the shipped mesh of a recipe, or None."""
    wanted = recipe.to_dict()
    return next((path for known, path in _shipped(data_folder()) if known == wanted), None)


@lru_cache(maxsize=1)
def _shipped(folder: Path) -> tuple[tuple[dict[str, Any], Path], ...]:
    """Return the recipes of the meshes in a folder, with their files."""
    texts = {path: path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.json"))}
    found = ((json.loads(text).get("recipe"), path) for path, text in texts.items())
    return tuple((recipe, path.with_suffix(".vtu")) for recipe, path in found)


def data_folder() -> Path:
    """Return the folder of the shipped meshes, installed or in the checkout."""
    try:
        return Path(str(package_files("fefinger.meshes")))
    except ModuleNotFoundError:
        return Path(__file__).resolve().parents[2] / "meshes"


def cached_path(recipe: Recipe) -> Path:
    """Return where the user's cache keeps the mesh of a recipe."""
    return cache.root() / "meshes" / f"{recipe.key()[:16]}.vtu"


_unkept: dict[Path, FingerMesh] = {}
"""Meshes that the cache did not take, by their place in it: built again they would be others."""


def _cached(recipe: Recipe) -> FingerMesh | None:
    """Return the mesh of a recipe from the cache; one that is damaged counts as none."""
    place = cached_path(recipe)
    try:
        return vtu.read(place)
    except (InputError, OSError):
        return _unkept.get(place)


def _made(recipe: Recipe, progress: Callable[[str], None] | None) -> FingerMesh:
    """Return the mesh of a recipe, built here and put in the cache, or by whom it waited for."""
    say = progress or (lambda _: None)
    wait = "another process builds this mesh; waiting for it"
    with cache.alone(cached_path(recipe), lambda: say(wait)):
        return _cached(recipe) or _built(recipe, say)


def _built(recipe: Recipe, say: Callable[[str], None]) -> FingerMesh:
    """Return the mesh of a recipe as the cache has it, once it is built."""
    from fefinger.mesh.build import build

    name = f"{recipe.width:g}x{recipe.thickness:g}x{recipe.pad_radius:g}-{recipe.resolution}"
    mesh = build(recipe, name=name, progress=say)
    found = _cached(recipe)  # without locks, another may have been faster: then that is the one
    if found is not None:
        return found
    place = cached_path(recipe)
    try:
        return vtu.read(vtu.write(mesh, place))
    except (InputError, OSError) as error:
        say(f"the mesh could not be kept for the next time: {error}")
        return _unkept.setdefault(place, mesh)
