"""Mesh of a finger: shipped with the package, else from the user's cache, else built and cached."""

import json
import os
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from fefinger.geometry.finger_mesh import FingerMesh, whole
from fefinger.mesh import mesh_record
from fefinger.mesh.extend import continuation_source, extended
from fefinger.mesh.recipe import Recipe, Touch, has_template, shipped_path
from fefinger.support import cache
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from fefinger.mesh.finger_shape import Shape
    from fefinger.scene.finger import Finger

FILE = "mesh.vtu"
"""File of a cached mesh, beside its sidecar."""


def load_or_build(
    finger: "Finger | Recipe",
    *,
    half: bool,
    touch: Touch = None,
    with_continuation: bool = False,
    progress: Callable[[str], None] | None = None,
) -> FingerMesh:
    """Load or build the mesh of a scene's finger (or a Recipe), half or whole.

    `touch` as in `Recipe`; `with_continuation`: longer behind the proximal cut. Looks among the
    shipped meshes, then in the user's cache; builds and caches it if neither has it, by a morph of
    a shipped one in seconds where one is near. The mesher is random, so that a second process that
    needs the mesh at the same time waits and gets the same one. `progress` receives short
    sentences.
    """
    recipe = finger if isinstance(finger, Recipe) else Recipe.of(finger, touch)
    path = shipped_path(recipe)
    mesh = mesh_record.read(path) if path else _cached(recipe) or _made(recipe, progress)
    mesh = extended(mesh) if with_continuation else mesh
    return mesh if half else whole(mesh)


def available(finger: "Finger", touch: Touch = None) -> bool:
    """Whether the mesh of a scene's finger is shipped or cached, so that it need not be built."""
    recipe = Recipe.of(finger, touch)
    return shipped_path(recipe) is not None or os.path.isdir(cached_path(recipe))


def morphed(finger: "Finger", touch: Touch = None) -> bool:
    """Whether the mesh of a finger is expected to be a morph of a shipped one, made in a second."""
    return has_template(Recipe.of(finger, touch))


def mesh_problem(
    finger: "Finger",
    touch: Touch = None,
    at: tuple[float, float] | None = None,
    reach: float = 0.0,
) -> str:
    """Reason why a finger cannot be meshed, as a sentence; empty if none is known.

    The shape is built, in some 50 ms (of a scan in a second), but not meshed. A place `at` (x, y)
    mm more than `reach` mm beside the pad is a reason too.
    """
    from fefinger.mesh.finger_shape import touch_within

    try:
        if at is None and available(finger, touch):
            return ""
        # Every mechanics asks on every mesh, and the shape is the same on all of them.
        recipe = replace(Recipe.of(finger, touch), resolution="standard")
        shape = _shape(recipe, recipe.key())
        if isinstance(shape, str):
            return shape
        if at is not None:
            touch_within(shape, at, reach)
    except InputError as error:
        return str(error)
    return ""


@lru_cache(maxsize=4)
def _shape(recipe: Recipe, _key: str) -> "Shape | str":
    """Return the shape of a recipe whose files have a hash, or the reason why it has none."""
    from fefinger.mesh.scan import shape_of

    try:
        return shape_of(recipe)
    except InputError as error:
        return str(error)


def sha256(finger: "Finger", touch: Touch = None, *, with_continuation: bool = False) -> str | None:
    """Source hash of the mesh of a scene's finger; None if it is neither shipped nor cached.

    That is the SHA-256 of its file, or follows from it for the continued finger.
    """
    recipe = Recipe.of(finger, touch)
    sidecar = mesh_record.sidecar_path(shipped_path(recipe) or cached_path(recipe) / FILE)
    try:
        source = str(json.loads(sidecar.read_text(encoding="utf-8"))["sha256"])
        return continuation_source(source) if with_continuation else source
    except (OSError, ValueError, KeyError, TypeError):  # no sidecar, or a damaged one
        return None


def cached_path(recipe: Recipe) -> Path:
    """Folder of the mesh of a recipe in the user's cache."""
    return cache.root() / "meshes" / recipe.key()[:16]


def keep(mesh: FingerMesh, recipe: Recipe) -> None:
    """Write a mesh into the user's cache; OSError or InputError where it cannot be written."""
    with cache.appearing(cached_path(recipe), f"mesh {mesh.name}") as new:
        mesh_record.write(mesh, new / FILE)


_in_memory: dict[Path, FingerMesh] = {}
"""Meshes that could not be cached, by cache path: built again, the random mesher would differ."""


def _cached(recipe: Recipe) -> FingerMesh | None:
    """Read the mesh of a recipe from the cache; None if it is missing or damaged."""
    place = cached_path(recipe)
    return cache.load(place, lambda folder: mesh_record.read(folder / FILE)) or _in_memory.get(
        place
    )


def _made(recipe: Recipe, progress: Callable[[str], None] | None) -> FingerMesh:
    """Build and cache the mesh of a recipe, or wait for the process that is building it."""
    say = progress or (lambda _: None)
    wait = "another process builds this mesh; waiting for it"
    with cache.alone(cached_path(recipe), lambda: say(wait)):
        return _cached(recipe) or _built(recipe, say)


def _built(recipe: Recipe, say: Callable[[str], None]) -> FingerMesh:
    """Build and cache the mesh of a recipe; return it as read back from the cache."""
    from fefinger.mesh.build import build

    name = f"{recipe.width:g}x{recipe.thickness:g}x{recipe.pad_radius:g}-{recipe.resolution}"
    mesh = build(recipe, name=name, progress=say)
    try:
        keep(mesh, recipe)
    except (InputError, OSError) as error:
        say(f"the mesh could not be cached: {error}")
    # Where file locks do not work, another process may have been faster: its mesh counts.
    return _cached(recipe) or _in_memory.setdefault(cached_path(recipe), mesh)
