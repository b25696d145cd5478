"""Shape of a fingertip, parametric or scanned: nested smooth surfaces, nail and bone.

Frame: x distal, y radial, z dorsal; the origin is the point P30 that a plate at 30 degrees touches
first; the pad's radii are those there. Lengths in mm.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.profiles import smooth_step
from fefinger.mesh.recipe import Recipe
from fefinger.mesh.shell import Shell, Triangles
from fefinger.scene.finger import BONE
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import InputError


PLATE = np.radians(30.0)
PLATE_NORMAL = np.array([np.sin(PLATE), 0.0, -np.cos(PLATE)])
"""Outward pad normal at P30."""

ALONG = np.array([np.cos(PLATE), 0.0, np.sin(PLATE)])
"""Direction along the pad at P30, toward the tip."""

PATCH_CENTER = np.array([-1.8, 0.0, -0.7])
PATCH_RADIUS = 5.0
"""Ball in mm that contains the contact with the plate: it extends toward the flatter pad."""

FIT_RADIUS = 2.0
"""Radius in mm around P30 within which the quadric is fitted."""


def fitted_radii(points: Array) -> tuple[float, float]:
    """Return the normal curvature radii (R', R'') mm of a surface through points at the origin.

    The surface must touch the 30-degree plate there; points farther than 2 mm are left out.
    Least squares of height = c0 + c1 u + c2 v + u^2/(2 R') + v^2/(2 R'') + c5 u v along the
    inward normal, with u along the finger and v across it.
    """
    along, across = np.diag(curvature(points, np.stack([ALONG, [0.0, 1.0, 0.0]]), -PLATE_NORMAL))
    return float(1.0 / along), float(1.0 / across)


def curvature(points: Array, across: Array, inward: Array) -> Array:
    """Return the second derivatives (2, 2) 1/mm of the quadric fitted within 2 mm of the origin.

    points (n, 3) mm of a surface, whose height along `inward` (3,) is a function of u and v along
    the rows of `across` (2, 3). NaN where there are fewer than 6 points.
    """
    near = points[np.linalg.norm(points, axis=1) < FIT_RADIUS]
    if len(near) < 6:
        return np.full((2, 2), np.nan)
    u, v = across @ near.T
    terms = [u**2 / 2, v**2 / 2, u * v, u, v, np.ones(len(u))]
    fit = np.linalg.lstsq(np.stack(terms, axis=1), near @ inward, rcond=None)[0]
    return np.array([[fit[0], fit[2]], [fit[2], fit[1]]])


FINE = 0.2
"""Facet size in mm that gives the volume inside a smooth surface to about 0.1 %."""

ROOM = 0.2
"""Least thickness in mm of subcutaneous tissue around the bone: thinner would need flat cells."""


RIDGE, FOREMOST = 400, 12.0
"""Number of points along the finger at which the touch of a plate is sought; largest x in mm."""

BONE_AHEAD, BONE_ROUNDED = 0.42, 0.3
"""Tissue ahead of a bone, over the thickness, and length of the rounding of its end, over the width
of the finger, where the recipe gives no other."""

BASE = 0.6
"""Length of the base of a bone at the cut, over the width of the finger."""

SAMPLES = 4001
"""Points in a profile table; the error of the trapezoidal rule is below 1e-6 mm."""


class SmoothSurface(Protocol):
    """Interface of a smooth closed surface, implemented by `Shell` and `scan.Cloud`."""

    def level(self, points: Array) -> Array:
        """Return a signed distance, negative inside, (n,) mm."""

    def normals(self, points: Array) -> Array:
        """Return the unit outward normals (n, 3) at points of the surface."""

    def project(self, points: Array, *, free: Flags | None = None) -> Array:
        """Return points (n, 3) moved onto the surface; free (n, 3) or (3,): what may change."""


@dataclass(frozen=True)
class Nail:
    """Patch of dorsal skin under the nail: a rounded rectangle in the projection along z, mm.

    Attributes
    ----------
    start, end : x of its proximal and distal end.
    half_width : half its width where the finger is wide.
    middle : lower bound of z.
    side : half width of the finger at x, which limits the nail's where the finger narrows.

    """

    start: float
    end: float
    half_width: float
    middle: float
    side: Callable[[Array], Array]

    def covers(self, points: Array) -> Flags:
        """Whether points of the skin are under the nail, (n,)."""
        x, y, z = points.T
        along = (2.0 * x - self.start - self.end) / (self.end - self.start)
        reach = self._reach(x) * np.maximum(1.0 - along**6, 0.0) ** (1.0 / 6.0)
        return np.asarray((np.abs(y) < reach) & (z > self.middle))

    def edge(self, count: int) -> tuple[Array, Array]:
        """Compute points along the outline with y >= 0: x and y, each (count,) mm."""
        angle = np.linspace(0.0, np.pi, count)
        along, aside = (
            np.sign(part) * np.abs(part) ** (1.0 / 3.0) for part in (np.cos(angle), np.sin(angle))
        )
        x = (self.start + self.end + along * (self.end - self.start)) / 2.0
        y = self._reach(x) * aside
        y[[0, -1]] = 0.0
        return x, y

    def _reach(self, x: Array) -> Array:
        """Return half the nail's width at x, (n,)."""
        return np.asarray(np.minimum(self.half_width, 0.8 * self.side(x)))


@dataclass(frozen=True)
class Shape:
    """The nested surfaces of one fingertip, origin at P30.

    Attributes
    ----------
    skin, subcutaneous, bone : outer surfaces of regions 1, 2 and 3.
    cut : x of the proximal cut, mm.
    radii : wanted normal curvature radii at P30, along (R') and across (R'') the finger, mm.
    nail : the patch under the nail.
    triangles : facet size in mm -> surfaces for the mesher that bound the regions of half a finger.
    sections : shells of half ellipses with the profiles of the three surfaces: these themselves
        for a parametric finger, near them for a scan.
    volumes : volume of half of each region inside the smooth surfaces, by name, mm^3.
    notes : remarks on the surface files used and their repairs.

    """

    skin: SmoothSurface
    subcutaneous: SmoothSurface
    bone: SmoothSurface
    cut: float
    radii: tuple[float, float]
    nail: Nail
    triangles: Callable[[float], list[Triangles]]
    sections: tuple[Shell, Shell, Shell]
    volumes: dict[str, float]
    notes: tuple[str, ...] = ()

    @property
    def shells(self) -> tuple[SmoothSurface, SmoothSurface, SmoothSurface]:
        """Outer surfaces of the skin (1), the subcutaneous tissue (2) and the bone (3)."""
        return self.skin, self.subcutaneous, self.bone

    def region(self, points: Array) -> NDArray[np.int8]:
        """Region of points (n,): 0 outside, 1 skin, 2 subcutaneous tissue, 3 bone."""
        return np.sum([shell.level(points) < 0.0 for shell in self.shells], axis=0, dtype=np.int8)


def touch_point(shape: Shape, touch: float | tuple[float, float]) -> Array:
    """Point (3,) of the palmar skin at a place (x, y), or first touch of a plate at an angle.

    Raises InputError for a place that is not on the pad.
    """
    if isinstance(touch, tuple):
        place = palm(shape.skin, np.array(touch[:1]), abs(touch[1]))
        if _off(shape.skin, place)[0]:
            message = f"indenter.at: expected a place (x, y) mm on the pad, received {touch}"
            raise InputError(message)
        return np.asarray(place[0])
    ridge = palm(shape.skin, np.linspace(shape.cut, FOREMOST, RIDGE)[1:], 0.0)
    angle = np.radians(touch)
    return foremost(shape.skin, ridge, np.array([-np.sin(angle), 0.0, np.cos(angle)]))


def touch_within(shape: Shape, touch: float | tuple[float, float], reach: float) -> Array:
    """As `touch_point`, but of a place up to `reach` mm beside the pad the next one on it.

    That lies toward the origin. InputError for a place farther away.
    """
    if not isinstance(touch, tuple) or touch == (0.0, 0.0):
        return touch_point(shape, touch)
    far = float(np.hypot(*touch))
    backward = 0.1  # steps in mm by which the edge of the pad is looked for
    widest = 60.0  # mm from the origin to the farthest place of any pad
    back = backward * np.arange(int(max(far - widest, 0.0) / backward), np.ceil(far / backward))
    x, y = (np.asarray(each * (1 - back / far), dtype=float) for each in touch)
    on = np.flatnonzero(~_off(shape.skin, palm(shape.skin, x, y)))
    if not on.size:
        return touch_point(shape, touch)
    nearest = int(on[0])
    if back[nearest] < reach + backward:
        return touch_point(shape, (float(x[nearest]), float(y[nearest])))
    raise InputError(
        f"indenter.at: expected a place (x, y) mm on the pad, or so near that the object covers a "
        f"part of it, in that direction within {far - back[nearest] + reach:.3g} mm of (0, 0), "
        f"received {touch}"
    )


def palm(skin: SmoothSurface, x: Array | float, y: Array | float) -> Array:
    """Points (n, 3) of the palmar skin at places x, y mm, (n,) each or one for all."""
    # From z = -1 mm on, below the touch of the 30 degree plate.
    below = np.column_stack(np.broadcast_arrays(x, y, -1.0))
    return skin.project(below, free=np.arange(3) == 2)


def foremost(skin: SmoothSurface, points: Array, axis: Array) -> Array:
    """First of the points (n, 3) on the skin that a plate moving along `axis` touches, (3,)."""
    return np.asarray(points[np.argmin(np.where(_off(skin, points), np.inf, points @ axis))])


def _off(skin: SmoothSurface, points: Array) -> Flags:
    """Whether a projection ended off the skin, (n,)."""
    return np.asarray(np.abs(skin.level(points)) > 1e-3)


def nail_of(recipe: Recipe, *, tip: float, middle: float, side: Callable[[Array], Array]) -> Nail:
    """Return the nail of a finger with the given tip: 0.86 w long and 0.75 w wide."""
    end = tip - 0.12 * recipe.width
    return Nail(end - 0.86 * recipe.width, end, 0.375 * recipe.width, middle, side)


def region_volumes(skin: float, subcutaneous: float, bone: float) -> dict[str, float]:
    """Return the volume of each region from those inside the three surfaces, mm^3."""
    return {"skin": skin - subcutaneous, "subcutaneous": subcutaneous - bone, "bone": bone}


def check_room(under: SmoothSurface, bone: Array, recipe: Recipe) -> None:
    """Raise InputError unless the points (n, 3) of the bone are ROOM below the surface `under`."""
    level = under.level(bone)
    least, place = -float(level.max()), float(bone[np.argmax(level), 0])
    if least < ROOM:
        field, remedy = "thickness", "a thinner skin"
        distal = place > 0.5 * (bone[:, 0].min() + bone[:, 0].max())
        if recipe.tip_tissue is not None and distal:
            field, remedy = "tip_tissue", f"a larger one than {recipe.tip_tissue:.3g} mm"
        raise InputError(
            f"finger.{field}: expected at least {ROOM:g} mm of subcutaneous tissue around the "
            f"bone of a finger {recipe.width:g} mm wide and {recipe.thickness:g} mm thick, "
            f"received {least:.2f} mm; use {remedy} or other dimensions, or turn a scan so that x "
            "points to the tip and z to the nail"
        )


def distal_phalanx(
    recipe: Recipe, *, cut: float, tip: float, top: float, slim: float = 1.0
) -> Shell:
    """Build the distal phalanx: a base at the cut, a narrow shaft and a flat wide tuft.

    slim: its width and height over the sizes of other fingers. Raises InputError where it would end
    behind the cut.
    """
    width, thickness = recipe.width, recipe.thickness
    pulp = BONE * thickness
    middle = top - recipe.skin_thickness - 0.14 * thickness
    depth = np.clip(middle - pulp * np.cos(PLATE), 0.07 * thickness, 0.18 * thickness)
    # A pad that rises steeply comes close to the nail: there the bone ends short of the pulp.
    end = min(tip - BONE_AHEAD * thickness, -np.sqrt(max(pulp**2 - middle**2, 0.0)))
    if recipe.tip_tissue is not None:
        end = tip - recipe.tip_tissue
        if end < cut + BASE * width and recipe.surface is None:
            raise InputError(
                f"finger.tip_tissue: expected at most {tip - cut - BASE * width:.1f} mm, so that "
                "the finger has the base of a bone at its cut, received "
                f"{recipe.tip_tissue:.3g} mm"
            )
    if recipe.surface is not None:
        end = max(end, cut + BASE * width)
    x = end - (end - cut) * np.linspace(1.0, 0.0, SAMPLES) ** 2
    base = smooth(1.0 - (x - cut) / (BASE * width))
    tuft = np.exp(-(((x - end + 0.16 * width) / (0.2 * width)) ** 2))
    tip_factor = rounding(x, end, BONE_ROUNDED * width)
    side = slim * width * (0.16 + 0.10 * base + 0.05 * tuft) * tip_factor
    low = slim * (depth + 0.16 * thickness * base) * tip_factor
    high = slim * 0.09 * thickness * tip_factor
    return Shell.of(middle, cut=cut, palmar=(x, low), dorsal=(x, high), side=(x, side))


def length_needed(recipe: Recipe) -> float:
    """Least length in mm of a scan: the base of a bone, the tissue ahead of it, and a margin."""
    ahead = BONE_AHEAD * recipe.thickness if recipe.tip_tissue is None else recipe.tip_tissue
    return max(1.1 * recipe.width, ahead + BASE * recipe.width + 1.0)


def rounding(x: Array, tip: float, reach: float) -> Array:
    """Profile factor sqrt(1 - u^3) of a rounded tip; u rises to 1 over the last `reach` mm."""
    return np.asarray(np.sqrt(1.0 - np.clip((x - tip) / reach + 1.0, 0.0, 1.0) ** 3))


def smooth(u: Array) -> Array:
    """Smooth step from 0 to 1 over 0 < u < 1, with two continuous derivatives."""
    return smooth_step(np.clip(u, 0.0, 1.0))
