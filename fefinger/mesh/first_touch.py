"""First touch of a plate with the smooth skin of a finger, and the curvature of the skin there.

Frame: x distal, y radial, z dorsal; lengths in mm.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from fefinger.geometry.profiles import directions
from fefinger.mesh import extend
from fefinger.mesh.finger_shape import FOREMOST, SmoothSurface, foremost, palm
from fefinger.mesh.frame import FIT_RADIUS, curvature
from fefinger.mesh.recipe import Recipe
from fefinger.mesh.scan import shape_of
from fefinger.support.arrays import Array


COUNT, ZOOM, ROUNDS = 21, 0.25, 8
"""Points per side of a search patch, factor of its refinement, and number of refinements."""


@dataclass(frozen=True)
class FirstTouch:
    """First touch: point (3,) mm, curvature (2, 2) 1/mm along `directions(axis)`, convex positive.

    The curvature belongs to a quadric fitted within 2 mm.
    """

    point: Array
    curvature: Array


def first_touch(recipe: Recipe, axis: ArrayLike) -> FirstTouch:
    """Find where a plate that moves along `axis` (3,) first touches the smooth skin of a finger."""
    shape, axis = _shape(recipe), np.asarray(axis, float)
    across = directions(axis)
    x = np.linspace(shape.cut, FOREMOST, 200)[1:]
    y = np.linspace(-recipe.width / 3, recipe.width / 3, 41)
    point = foremost(shape.skin, palm(shape.skin, *map(np.ravel, np.meshgrid(x, y))), axis)
    reach = 1.0
    for _ in range(ROUNDS):
        point = foremost(shape.skin, _patch(shape.skin, point, across, reach), axis)
        reach *= ZOOM
    around = _patch(shape.skin, point, across, 1.5 * FIT_RADIUS) - point
    return FirstTouch(point, curvature(around, across, axis))


@lru_cache(maxsize=64)
def at_cut(
    recipe: Recipe, axis: tuple[float, float, float], *, with_continuation: bool = False
) -> float:
    """Distance in mm of the skin at the proximal cut from a plate at its first touch.

    `with_continuation`: at the end of the finger that `mesh.extend` continues behind the cut.
    """
    shape, travel = _shape(recipe), np.array(axis)
    y = np.linspace(-recipe.width / 3, recipe.width / 3, 41)
    skin = palm(shape.skin, shape.cut, y)
    if with_continuation:
        slope = extend.palmar_slope(shape.skin.normals(skin[len(y) // 2 :][:1])[0])
        skin += np.array([-extend.LENGTH, 0.0, float(extend.rise(slope, extend.LENGTH))])
    return float((skin @ travel).min() - first_touch(recipe, axis).point @ travel)


_shape = lru_cache(maxsize=8)(shape_of)


def _patch(skin: SmoothSurface, point: Array, across: Array, reach: float) -> Array:
    """Return points (n, 3) of the skin about a point of it."""
    line = np.linspace(-reach, reach, COUNT)
    places = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    return skin.project(point + places @ across)
