"""Parametric distal fingertip: skin, subcutaneous tissue, bone and nail from a few dimensions.

Frame: x distal, y radial, z dorsal; the origin is the point P30 that a plate at 30 degrees touches
first. Lengths in mm.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import brentq

from fefinger.checks import InputError
from fefinger.mesh.recipe import Recipe
from fefinger.mesh.shell import Array, Shell, Table, offset


PLATE = np.radians(30.0)
PLATE_NORMAL = np.array([np.sin(PLATE), 0.0, -np.cos(PLATE)])
"""Outward pad normal at the point that the 30-degree plate touches."""

PATCH_CENTER = np.array([-1.8, 0.0, -0.7])
PATCH_RADIUS = 5.0
"""Ball, mm, in which the pad meets a 30-degree plate: it reaches farther towards the flat pad."""

TIP_HEIGHT = 0.65
"""Wanted height of the foremost point above the lowest one, over the thickness."""

TIP_RADIUS = 0.2
"""Smallest radius of the palmar profile at the tip, over the thickness; it may lift the tip."""

SHARPENING = (np.radians(34.0), np.radians(48.0))
"""Slopes between which the profile turns from the pad's curvature to the tip's."""

PULP = 0.47
"""Wanted soft tissue between P30 and the bone, over the thickness: 4.7 mm on a 10 mm finger."""

SAMPLES = 4001
"""Points in a profile table: their trapezoid error is below 1e-6 mm."""


@dataclass(frozen=True)
class Shape:
    """The nested shells of one fingertip and the patch under its nail; origin at P30.

    Attributes
    ----------
    skin, subcutaneous, bone : outer surfaces of regions 1, 2 and 3.
    radii : wanted normal curvature radii at P30, along (R') and across (R'') the finger, mm.
    nail : x of the nail's proximal and distal end and its half width, mm.

    """

    skin: Shell
    subcutaneous: Shell
    bone: Shell
    radii: tuple[float, float]
    nail: tuple[float, float, float]

    @property
    def shells(self) -> tuple[Shell, Shell, Shell]:
        """Outer surfaces of the skin (1), the subcutaneous tissue (2) and the bone (3)."""
        return self.skin, self.subcutaneous, self.bone

    def region(self, points: Array) -> NDArray[np.int8]:
        """Return 0 outside, 1 in skin, 2 in subcutaneous tissue, 3 in bone, (n,)."""
        return np.sum([shell.level(points) < 0.0 for shell in self.shells], axis=0, dtype=np.int8)

    def on_nail(self, points: Array) -> NDArray[np.bool_]:
        """Return which points of the skin are under the nail, a rounded rectangle, (n,)."""
        x, y, z = points.T
        along = (2.0 * x - self.nail[0] - self.nail[1]) / (self.nail[1] - self.nail[0])
        inside = along**6 + (y / self._nail_half_width(x)) ** 6 < 1.0
        return np.asarray(inside & (z > self.skin.middle))

    def nail_edge(self, count: int) -> Array:
        """Return points of the nail's outline with y >= 0 on the skin, (count, 3) mm."""
        angle = np.linspace(0.0, np.pi, count)
        along, aside = (
            np.sign(part) * np.abs(part) ** (1.0 / 3.0) for part in (np.cos(angle), np.sin(angle))
        )
        x = (self.nail[0] + self.nail[1] + along * (self.nail[1] - self.nail[0])) / 2.0
        y = self._nail_half_width(x) * aside
        y[[0, -1]] = 0.0
        wide, _, high = self.skin.heights(x)
        return np.column_stack([x, y, self.skin.middle + high * np.sqrt(1.0 - (y / wide) ** 2)])

    def _nail_half_width(self, x: Array) -> Array:
        """Return half the nail's width at x: it follows the finger where that narrows, (n,) mm."""
        return np.asarray(np.minimum(self.nail[2], 0.8 * self.skin.heights(x)[0]))


def radii(recipe: Recipe) -> tuple[float, float]:
    """Return the wanted radii (R', R'') mm: R'' = (w/2)^2/(t/2), R' = R^2/R''."""
    across = (recipe.width / 2.0) ** 2 / (recipe.thickness / 2.0)
    return recipe.pad_radius**2 / across, across


def parametric(recipe: Recipe) -> Shape:
    """Return the fingertip of width w, thickness t and pad radius R.

    The palmar profile has curvature 1/R' at P30. There the section x = const leans by 30 degrees
    against the normal, so (Meusnier) its own curvature b/a^2 must be 1/(R'' cos 30): this gives the
    half width a at P30, and the outline narrows from w/2 through it to the tip.
    """
    along, across = radii(recipe)
    if along < 0.6 * recipe.thickness:
        message = (
            f"pad_radius: expected at least {np.sqrt(0.6 * recipe.thickness * across):.1f} mm on a "
            f"finger {recipe.width:g} mm wide and {recipe.thickness:g} mm thick, received "
            f"{recipe.pad_radius:g} mm; the pad would be sharper along the finger than its tip"
        )
        raise InputError(message)
    palmar, middle = _palmar(recipe, along)
    cut, tip = float(palmar[0][0]), float(palmar[0][-1])
    half = recipe.width / 2.0
    share = middle * np.cos(PLATE) * across / half**2
    if share > 0.98:
        message = (
            f"pad_radius: expected a fingertip that narrows towards its tip, received width "
            f"{recipe.width:g}, thickness {recipe.thickness:g} and pad radius "
            f"{recipe.pad_radius:g} mm, which would need {2 * half * np.sqrt(share):.1f} mm of "
            "width at the contact point; use a smaller thickness or a larger pad radius"
        )
        raise InputError(message)
    reach = tip / (1.0 - np.cbrt(1.0 - share))
    x = tip - (tip - cut) * np.linspace(1.0, 0.0, SAMPLES) ** 2
    side = (x, half * _rounding(x, tip, reach))
    top = recipe.thickness - palmar[1].max()
    # The back's radius at the tip is 1.5 top^2 / reach: the skin must fit inside it.
    blunt = min(0.7 * recipe.width, 1.5 * top**2 / (1.3 * recipe.skin_thickness))
    dorsal = (x, top * _rounding(x, tip, blunt))
    outer = {"palmar": palmar, "dorsal": dorsal, "side": side}
    inner = {name: offset(table, recipe.skin_thickness) for name, table in outer.items()}
    nail = tip - 0.12 * recipe.width
    return Shape(
        skin=Shell.of(middle, cut=cut, **outer),
        subcutaneous=Shell.of(middle, cut=cut, **inner),
        bone=_bone(recipe, cut=cut, tip=tip, top=middle + top),
        radii=(along, across),
        nail=(nail - 0.86 * recipe.width, nail, 0.375 * recipe.width),
    )


def _palmar(recipe: Recipe, along: float) -> tuple[Table, float]:
    """Return the palmar profile (x, depth below the widest level) and the z of that level.

    The curvature is 1/R' over the pad, grows without a jump to the tip's between the slopes of
    SHARPENING, and fades to zero behind the lowest point.
    """
    thickness = recipe.thickness
    slope = np.linspace(0.0, np.pi / 2, SAMPLES)
    start, end = SHARPENING
    ramp = _smooth((slope - start) / (end - start))

    def distal(sharpness: float) -> Table:
        radius = along / (1.0 + sharpness * ramp)
        steps = (np.cos(slope) * radius, np.sin(slope) * radius)
        x, z = (cumulative_trapezoid(step, slope, initial=0.0) for step in steps)
        return x, z

    sharpest = max(along / (TIP_RADIUS * thickness) - 1.0, 0.0)
    wanted = TIP_HEIGHT * thickness
    sharpness = sharpest
    if distal(0.0)[1][-1] > wanted > distal(sharpest)[1][-1]:
        sharpness = brentq(lambda c: distal(c)[1][-1] - wanted, 0.0, sharpest)
    x, z = distal(sharpness)
    if z[-1] > 0.9 * thickness:
        message = (
            f"pad_radius: expected a pad that rises at most {0.9 * thickness:.1f} mm to its tip, "
            f"received {recipe.pad_radius:g} mm, which rises {z[-1]:.1f} mm on a finger of "
            f"thickness {thickness:g} mm; use a smaller pad radius or a larger thickness"
        )
        raise InputError(message)
    length = min(max(1.7 * recipe.width, x[-1] + 5.0), max(25.0, x[-1] + 5.0)) - x[-1]
    arc = np.linspace(-length, 0.0, SAMPLES)
    back = cumulative_trapezoid(1.0 - _smooth(-arc / (0.5 * recipe.width)), arc, initial=0.0)
    rise = cumulative_trapezoid((back - back[-1]) / along, arc, initial=0.0)
    x_all = np.append(arc[:-1], x)
    z_all = np.append((rise - rise[-1])[:-1], z)
    at = np.array([np.interp(PLATE, slope, part) for part in (x, z)])
    return (x_all - at[0], z[-1] - z_all), float(z[-1] - at[1])


def _bone(recipe: Recipe, *, cut: float, tip: float, top: float) -> Shell:
    """Return the distal phalanx: a base at the cut, a narrow shaft and a flat wide tuft."""
    width, thickness = recipe.width, recipe.thickness
    pulp = PULP * thickness
    middle = top - recipe.skin_thickness - 0.14 * thickness
    depth = np.clip(middle - pulp * np.cos(PLATE), 0.07 * thickness, 0.18 * thickness)
    # A pad that rises steeply comes close to the nail: there the bone ends short of the pulp.
    end = min(tip - 0.42 * thickness, -np.sqrt(max(pulp**2 - middle**2, 0.0)))
    x = end - (end - cut) * np.linspace(1.0, 0.0, SAMPLES) ** 2
    base = _smooth(1.0 - (x - cut) / (0.6 * width))
    tuft = np.exp(-(((x - end + 0.16 * width) / (0.2 * width)) ** 2))
    rounding = _rounding(x, end, 0.3 * width)
    side = width * (0.16 + 0.10 * base + 0.05 * tuft) * rounding
    low = (depth + 0.16 * thickness * base) * rounding
    high = 0.09 * thickness * rounding
    return Shell.of(middle, cut=cut, palmar=(x, low), dorsal=(x, high), side=(x, side))


def _rounding(x: Array, tip: float, reach: float) -> Array:
    """Return sqrt(1 - u^3) with u the share of the last `reach` mm: from one to zero at the tip."""
    return np.asarray(np.sqrt(1.0 - np.clip((x - tip) / reach + 1.0, 0.0, 1.0) ** 3))


def _smooth(u: Array) -> Array:
    """Return the step from 0 to 1 over 0 < u < 1 with two continuous derivatives."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u**3 * (10.0 + u * (6.0 * u - 15.0)))
