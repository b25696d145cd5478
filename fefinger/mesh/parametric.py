"""Parametric fingertip: skin from width, thickness and pad radius; inner surfaces from the skin."""

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import brentq

from fefinger.mesh import finger_shape
from fefinger.mesh import shell as surface
from fefinger.mesh.finger_shape import (
    ALONG,
    PLATE,
    SAMPLES,
    Nail,
    Shape,
    fitted_radii,
    rounding,
    smooth,
)
from fefinger.mesh.recipe import Recipe
from fefinger.mesh.shell import Shell, Table, Triangles, offset
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


TIP_HEIGHT = 0.65
"""Wanted height of the foremost point above the lowest one, over the thickness."""

TIP_RADIUS = 0.2
"""Smallest radius of the palmar profile at the tip, over the thickness; it has priority over
TIP_HEIGHT."""

SHARPENING = (np.radians(34.0), np.radians(48.0))
"""Slopes between which the profile turns from the pad's curvature to the tip's."""

ROUNDING = (np.radians(36.0), np.radians(70.0))
"""The same where the recipe has a radius of the tip: a wider turn keeps the pad round longer."""


def radii(recipe: Recipe) -> tuple[float, float]:
    """Return the wanted radii (R', R'') mm: R'' = (w/2)^2/(t/2), R' = R^2/R''."""
    across = (recipe.width / 2.0) ** 2 / (recipe.thickness / 2.0)
    return recipe.pad_radius**2 / across, across


def parametric(recipe: Recipe) -> Shape:
    """Return the fingertip of width w, thickness t and pad radius R.

    The curvatures at P30 are set so that a quadric fitted within 2 mm has the wanted radii; they
    differ from the fitted ones by a few percent, because the pad gets sharper toward the tip.
    """
    wanted = radii(recipe)
    if recipe.tip_radius is not None and recipe.tip_radius > wanted[0]:
        raise InputError(
            f"finger.tip_radius: expected at most {wanted[0]:.3g} mm, the radius of the pad along "
            f"a finger {recipe.width:g} mm wide and {recipe.thickness:g} mm thick with pad radius "
            f"{recipe.pad_radius:g} mm, received {recipe.tip_radius:g} mm"
        )
    if recipe.tip_radius is not None and recipe.tip_radius < recipe.skin_thickness:
        raise _thick(recipe)  # before a profile of that radius is sampled
    if wanted[0] < 0.6 * recipe.thickness:
        least = np.sqrt(0.6 * recipe.thickness * wanted[1])
        raise InputError(
            f"finger.pad_radius: expected at least {least:.1f} mm on a "
            f"finger {recipe.width:g} mm wide and {recipe.thickness:g} mm thick, received "
            f"{recipe.pad_radius:g} mm; the pad would be sharper along the finger than its tip"
        )
    point = np.array(wanted)
    for _ in range(4):
        middle, tables = _skin(recipe, along=point[0], across=point[1])
        cut = float(tables["palmar"][0][0])
        skin = Shell.of(middle, cut=cut, **tables)
        point *= np.array(wanted) / fitted_radii(patch_points(skin))
    return _with_inside(recipe, skin, tables, wanted)


def _or_tip(recipe: Recipe) -> str:
    """Remedy of a tip that takes too much room, where its radius was given."""
    return "" if recipe.tip_radius is None else ", or a smaller finger.tip_radius"


def patch_points(skin: finger_shape.SmoothSurface) -> Array:
    """Return points of a symmetric skin around the origin, for fitting, (n, 3) mm."""
    grid = np.stack(np.meshgrid(np.linspace(-3, 3, 31), np.linspace(-3, 3, 31)), axis=-1)
    u, v = grid.reshape(-1, 2).T
    return skin.project(u[:, None] * ALONG + v[:, None] * [0.0, 1.0, 0.0])


def _with_inside(
    recipe: Recipe, skin: Shell, tables: dict[str, Table], wanted: tuple[float, float]
) -> Shape:
    """Complete the shape: subcutaneous tissue, bone and nail inside the skin."""
    cut, tip = skin.cut, skin.tip
    inner = {name: offset(table, recipe.skin_thickness) for name, table in tables.items()}
    under = Shell.of(skin.middle, cut=cut, **inner)
    _check_round(under, recipe)
    top = skin.middle + float(tables["dorsal"][1].max())
    bone = finger_shape.distal_phalanx(recipe, cut=cut, tip=tip, top=top)
    finger_shape.check_room(under, surface.without_caps(surface.half(bone, 0.5))[0], recipe)
    nail = finger_shape.nail_of(
        recipe, tip=tip, middle=skin.middle, side=lambda x: skin.heights(x)[0]
    )
    shells = (skin, under, bone)
    inside = (surface.volume(surface.half(shell, finger_shape.FINE)) for shell in shells)
    return Shape(
        skin=skin,
        subcutaneous=under,
        bone=bone,
        cut=cut,
        radii=wanted,
        nail=nail,
        triangles=lambda step: _triangles(shells, nail, step),
        sections=shells,
        volumes=finger_shape.region_volumes(*inside),
    )


def _check_round(under: Shell, recipe: Recipe) -> None:
    """Raise InputError where the skin is thicker than its tip is round: it has no inner surface."""
    x = under.tip - (under.tip - under.cut) * np.linspace(1.0, 0.0, SAMPLES) ** 2
    # Below this squared ratio of height and width a section of the inner skin is flat.
    if min(under.palmar_ratio(x).min(), under.dorsal_ratio(x).min()) < 1e-4:
        raise _thick(recipe)


def _thick(recipe: Recipe) -> InputError:
    """Return the error of a skin that is too thick for its tip."""
    tip = recipe.tip_radius or TIP_RADIUS * recipe.thickness
    # Skin over the radius of the tip that has an inner surface in all fingers of the shape of the
    # means: up to 0.73 in one 8 mm wide and 6 mm thick, 0.78 in one of 22 and 16 mm.
    thick_skin = 0.7
    return InputError(
        f"finger.skin.thickness: expected less than some {thick_skin * tip:.2g} mm, "
        f"{thick_skin:g} of the radius of the tip of a finger {recipe.thickness:g} mm thick, "
        f"received {recipe.skin_thickness:g} mm; use a thinner skin or a thicker finger"
    )


def _skin(recipe: Recipe, *, along: float, across: float) -> tuple[float, dict[str, Table]]:
    """Return the widest level and the three profiles with radii `along` and `across` at P30.

    The palmar profile has curvature 1/R' at P30. There the section x = const leans by 30 degrees
    against the normal, so (Meusnier) its own curvature b/a^2 must be 1/(R'' cos 30): this gives the
    half width a at P30, and the outline narrows from w/2 through it to the tip.
    """
    palmar, middle = _palmar(recipe, along)
    cut, tip = float(palmar[0][0]), float(palmar[0][-1])
    half = recipe.width / 2.0
    share = middle * np.cos(PLATE) * across / half**2
    if share > 0.98:
        raise InputError(
            f"finger.pad_radius: expected a fingertip that narrows toward its tip, received width "
            f"{recipe.width:g}, thickness {recipe.thickness:g} and pad radius "
            f"{recipe.pad_radius:g} mm, which would need {2 * half * np.sqrt(share):.1f} mm of "
            "width at the contact point; use a smaller thickness or a larger pad radius"
            f"{_or_tip(recipe)}"
        )
    reach = tip / (1.0 - np.cbrt(1.0 - share))
    x = tip - (tip - cut) * np.linspace(1.0, 0.0, SAMPLES) ** 2
    top = recipe.thickness - palmar[1].max()
    # The back's radius at the tip is 1.5 top^2 / reach: the skin must fit inside it.
    blunt = min(0.7 * recipe.width, 1.5 * top**2 / (1.3 * recipe.skin_thickness))
    dorsal = (x, top * rounding(x, tip, blunt))
    side = (x, half * rounding(x, tip, reach))
    return middle, {"palmar": palmar, "dorsal": dorsal, "side": side}


def _palmar(recipe: Recipe, along: float) -> tuple[Table, float]:
    """Return the palmar profile (x, depth below the widest level) and the z of that level.

    The curvature is 1/R' over the pad, grows without a jump to the tip's between the slopes of
    SHARPENING, and fades to zero behind the lowest point.
    """
    slope = np.linspace(0.0, np.pi / 2, SAMPLES)
    x, z = _distal(recipe, along, slope)
    if z[-1] > 0.9 * recipe.thickness:
        raise InputError(
            "finger.pad_radius: expected a pad that rises at most "
            f"{0.9 * recipe.thickness:.1f} mm to its tip, received "
            f"{recipe.pad_radius:g} mm, which rises {z[-1]:.1f} mm on a finger of "
            f"thickness {recipe.thickness:g} mm; use a smaller pad radius or a larger thickness"
            f"{_or_tip(recipe)}"
        )
    length = min(max(1.7 * recipe.width, x[-1] + 5.0), max(25.0, x[-1] + 5.0)) - x[-1]
    arc = np.linspace(-length, 0.0, SAMPLES)
    # The palm behind the pad slopes by at most 0.21 radians toward the crease.
    fading = min(0.5 * recipe.width, 2.0 * 0.21 * along)
    back = cumulative_trapezoid(1.0 - smooth(-arc / fading), arc, initial=0.0)
    rise = cumulative_trapezoid((back - back[-1]) / along, arc, initial=0.0)
    x_all = np.append(arc[:-1], x)
    z_all = np.append((rise - rise[-1])[:-1], z)
    at = np.array([np.interp(PLATE, slope, part) for part in (x, z)])
    return (x_all - at[0], z[-1] - z_all), float(z[-1] - at[1])


def _distal(recipe: Recipe, along: float, slope: Array) -> Table:
    """Compute x and z of the palmar profile at slopes from the lowest point to the tip.

    The tip has the radius of the recipe or, without one, the height TIP_HEIGHT t, unless that needs
    a radius below TIP_RADIUS t.
    """
    start, end = SHARPENING if recipe.tip_radius is None else ROUNDING
    ramp = smooth((slope - start) / (end - start))

    def profile(sharpness: float) -> Table:
        radius = along / (1.0 + sharpness * ramp)
        steps = (np.cos(slope) * radius, np.sin(slope) * radius)
        x, z = (cumulative_trapezoid(step, slope, initial=0.0) for step in steps)
        return x, z

    def excess(sharpness: float) -> float:
        return float(profile(sharpness)[1][-1] - TIP_HEIGHT * recipe.thickness)

    if recipe.tip_radius is not None:
        return profile(along / recipe.tip_radius - 1.0)
    sharpest = max(along / (TIP_RADIUS * recipe.thickness) - 1.0, 0.0)
    if excess(0.0) <= 0.0:
        return profile(0.0)
    if excess(sharpest) >= 0.0:
        return profile(sharpest)
    return profile(brentq(excess, 0.0, sharpest))


def _triangles(shells: tuple[Shell, ...], nail: Nail, step: float) -> list[Triangles]:
    """Return the closed skin, the open inner surfaces and a wall under the nail's outline.

    The inner surfaces extend beyond the cut, so that their open edges lie outside the finger; the
    wall makes facets end at the nail's outline.
    """
    skin = shells[0]
    inner = [surface.without_caps(surface.half(s, step, overhang=1.0)) for s in shells[1:]]
    x, y = nail.edge(40)
    wide, _, high = skin.heights(x)
    edge = np.column_stack([x, y, skin.middle + high * np.sqrt(1.0 - (y / wide) ** 2)])
    reach = 0.5 * skin.normals(edge)
    return [
        surface.half(skin, step),
        *inner,
        surface.ribbon(np.stack([edge + reach, edge - reach])),
    ]
