"""Axes of a scanned fingertip, found from its surface wherever the file has it.

A fingertip of closed form is fitted from 48 directions, which tells the tip from the cut and the
nail from the pad; those fits that are best after few steps are finished. The middle is then the
plane of the surface's own mirror symmetry, and the back is turned level: neither depends on where
the scan was cut, nor on how it was held.
"""

from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.scan_symmetry import OUTLIER, REACH, leveled, mirrored, symmetric
from fefinger.support.arrays import Array, Flags


if TYPE_CHECKING:
    from trimesh import Trimesh


FEW, MANY = 300, 4000
"""Points of a surface that the fits from all directions see, and those of the last fit, of the
symmetry and of the back."""

TRIED, FIRST, STEPS = 6, 4, 40
"""Number of directions that are fitted to the end, steps of the fits that choose them, and largest
number of steps of a fit."""

WORSE, SYMMETRY = 1.5, 4.0
"""Misfit over the least from which on a fit is out of question, and weight of the cost of asymmetry
over that of the misfit: fingertips are more alike in being symmetric than in their form."""

CLOSE, FINE = 1e-3, 1e-8
"""Relative change of a misfit at which a fit ends that is compared with others, to a tenth, and at
which the last one does."""


WHOLE = 0.85
"""Share of the length of a surface that is compared: the rest may be cut askew or rounded."""


FLATTER, SPREAD, TIPS, WEIGHT = 0.8, 0.15, 0.7, 0.1
"""Usual thickness over width, standard deviation of its logarithm and of that of the length of the
tip, and weight of both against the distances of all points."""

ROUND = 0.03
"""Standard deviation of the logarithm of thickness over width where that is above 1: a fingertip is
wider than thick, which alone tells the sides of a surface that has no cut and no flatter pad."""

SIDE, NEAR_TIP, ALONG = 0.6, 1.1, (3.0, 1.4)
"""Distance from the tip, over the width, where sides and palm of the fingertip of closed form stop
to widen, and exponents of both profiles: near those of the fingers of the thesis."""

PALM = 0.7
"""Part of the thickness below the widest level."""


@dataclass(frozen=True)
class Axes:
    """Axes of a fingertip in a file, and how like one it is.

    Attributes
    ----------
    place : (4, 4) transform from the file to x distal, y radial with 0 in the middle, z dorsal.
    misfit : root mean square distance from the fitted fingertip over its width, of what is near.
    apart : share of the surface up to REACH widths from the tip that is none of the fingertip.
    width, thickness : of the fitted fingertip, in units of the file.

    """

    place: Array
    misfit: float
    apart: float
    width: float
    thickness: float

    @property
    def turn(self) -> float:
        """Angle in degrees between the axes of the file and those found."""
        return float(np.degrees(np.arccos(np.clip((np.trace(self.place[:3, :3]) - 1) / 2, -1, 1))))


def fingertip_axes(mesh: "Trimesh") -> Axes:
    """Find the axes of a surface (trimesh), open or closed."""
    points, normals = _sampled(mesh, MANY)
    center, size = points.mean(axis=0), float(np.linalg.norm(np.ptp(points, axis=0)))
    scaled = (points - center) / size
    few = scaled[:: len(scaled) // FEW]
    frames = [_fitted(few, frame, steps=FIRST) for frame in _directions(normals)]
    rim = (_rim(mesh) - center) / size
    # Size of the rim of an open end over the surface's diagonal, from which on it is the proximal
    # one.
    wide_rim = 0.25
    if len(rim) and np.ptp(rim, axis=0).max() > wide_rim:
        proximal = rim.mean(axis=0)
        frames = [each for each in frames if each.axes[0] @ proximal < 0.0] or frames
    frames = _different(frames)[:TRIED]
    frames = [_settled(few, each) for each in frames]
    best = min(frames, key=lambda each: each.misfit)
    frames = _different([*frames, *(_settled(few, _rolled(best, turns)) for turns in (1, 2, 3))])
    frames = [each for each in frames if each.misfit < WORSE * frames[0].misfit]
    costs = [each.misfit + SYMMETRY * _asymmetry(scaled, normals, each) for each in frames]
    # Least cost over that of other directions, which are then alike: the flattest count, and of
    # these the one nearest to the axes of the file.
    other_side = 0.9
    flat = 1.1  # ratio of thickness over width to that of the flattest
    alike = [frames[i] for i in range(len(frames)) if costs[i] <= min(costs) / other_side]
    flattest = min(each.flatness for each in alike)
    alike = [each for each in alike if each.flatness <= flat * flattest]
    chosen = max(alike, key=lambda each: float(np.trace(each.axes)))  # turned least
    chosen = _fitted(scaled, chosen.axes, chosen, tolerance=FINE)
    axes, origin = chosen.axes, chosen.origin
    normals = _outward(chosen, scaled, normals)
    rounds = 6  # repetitions of symmetry and level: each turn changes a little what is looked at
    for _ in range(rounds):
        axes, origin = symmetric(scaled, normals, axes, origin, chosen.width)
        axes = leveled(scaled, normals, axes, origin, chosen.width)
    place = np.eye(4)
    place[:3, :3] = axes
    place[:3, 3] = -axes @ (center + size * origin)
    seen = chosen.near(scaled, share=1.0)  # a ball is round at both ends
    # A fit that has grown beyond the surface is near it for its own width only.
    widest = 1.5 * _middle_size(scaled)
    away = np.abs(chosen.distance(scaled)[seen]) / min(chosen.width, widest)
    inside = away < OUTLIER
    return Axes(
        place,
        float(np.sqrt(np.mean(away[inside] ** 2))) if inside.any() else 1.0,
        float(1.0 - inside.mean()) if seen.any() else 1.0,
        size * chosen.width,
        size * chosen.thickness,
    )


@dataclass(frozen=True)
class Fit:
    """A fingertip of closed form: axes (3, 3) in rows, its tip at origin (3,), width, thickness."""

    axes: Array
    origin: Array
    width: float
    thickness: float
    blunt: float
    misfit: float

    @property
    def flatness(self) -> float:
        """Thickness over width."""
        return self.thickness / self.width

    def near(self, points: Array, share: float = WHOLE) -> Flags:
        """Whether points (n, 3) are up to REACH widths from the tip, in a share of the length."""
        behind = (self.origin - points) @ self.axes[0]
        return np.asarray(behind <= min(REACH * self.width, share * float(behind.max())))

    def distance(self, points: Array) -> Array:
        """Distances (n,) of points (n, 3), of the first order."""
        return _distance(points, self.axes, self.origin, self.width, self.thickness, self.blunt)


def _distance(
    points: Array,
    axes: Array,
    origin: Array,
    width: float | Array,
    thickness: float | Array,
    blunt: float | Array,
) -> Array:
    """Distance (..., n) of points (n, 3) from fingertips of closed form, see `Fit`.

    Sizes are numbers or (..., 1), axes (..., 3, 3), origins (..., 3).
    """
    x, y, z = np.moveaxis(axes @ points.T - axes @ origin[..., None], -2, 0)
    behind = np.maximum(-x / width, 1e-3)
    side, side_slope = _profile(behind, SIDE * blunt, ALONG[0])
    palm, palm_slope = _profile(behind, NEAR_TIP * blunt, ALONG[1])
    below = z < 0.0
    half_y = width / 2 * side
    half_z = thickness * np.where(below, PALM * palm, (1.0 - PALM) * side)
    slope = np.where(below, palm_slope / palm, side_slope / side)
    across, up = y / half_y**2, z / half_z**2
    one, other = y * across, z * up
    along = (one * side_slope / side + other * slope) / width
    steepness = np.sqrt(along**2 + across**2 + up**2)
    ahead = np.maximum(x + 1e-3 * width, 0.0)  # of the tip, where there are no sections
    return np.asarray((one + other - 1.0) / 2 / steepness.clip(1e-9) + ahead)


def _profile(behind: Array, reach: float | Array, exponent: float) -> tuple[Array, Array]:
    """Half size (n,) over the largest, and its slope, at distances from the tip."""
    left = np.maximum(1.0 - behind / reach, 0.0)
    power = left ** (exponent - 1.0)
    size = np.sqrt(1.0 - left * power)
    return size, exponent * power / (2.0 * reach * size)


def _sampled(mesh: "Trimesh", count: int) -> tuple[Array, Array]:
    """Points (n, 3) spread evenly over a surface, seeded, and its normals there (n, 3)."""
    random = np.random.default_rng(0)
    ends = np.cumsum(mesh.area_faces)
    at = np.searchsorted(ends, (np.arange(count) + random.random(count)) / count * ends[-1])
    at = random.permutation(np.minimum(at, len(ends) - 1))
    a, b = random.random((2, count, 1))
    a, b = np.where(a + b > 1.0, 1.0 - a, a), np.where(a + b > 1.0, 1.0 - b, b)
    first, second, third = np.moveaxis(np.asarray(mesh.triangles[at], dtype=float), 1, 0)
    return first + a * (second - first) + b * (third - first), np.asarray(mesh.face_normals[at])


def _directions(normals: Array) -> list[Array]:
    """Axes (3, 3) to start from: the axes of the file first, then all turns of the principal ones.

    The long axis is the one that the normals (n, 3) face least.
    """
    found = np.linalg.eigh(normals.T @ normals)[1].T
    frames = [np.eye(3)]
    for start in (np.eye(3), found):
        for long, sign, roll in product(range(3), (1.0, -1.0), range(4)):
            x, y = sign * start[long], start[(long + 1) % 3]
            z = np.cross(x, y)
            angle = np.pi / 2 * roll
            y, z = np.cos(angle) * y + np.sin(angle) * z, np.cos(angle) * z - np.sin(angle) * y
            frames.append(np.stack([x, y, z]))
    return frames


def _different(frames: list[Fit]) -> list[Fit]:
    """Return fits by their misfit, without those whose axes are the same as a better one's."""
    kept: list[Fit] = []
    same = 0.95  # least cosine between all axes of two fits that are the same
    for each in sorted(frames, key=lambda fit: fit.misfit):
        if all(np.einsum("ij,ij->i", each.axes, one.axes).min() < same for one in kept):
            kept.append(each)
    return kept


def _rolled(fit: Fit, turns: int) -> Fit:
    """Return a fit that is rolled about its long axis by turns of 90 degrees."""
    x, y, z = fit.axes
    axes = np.stack([x, *((y, z), (z, -y), (-y, -z), (-z, y))[turns]])
    width, thickness = (fit.width, fit.thickness)[:: -1 if turns % 2 else 1]
    return replace(fit, axes=axes, width=width, thickness=thickness)


def _middle_size(points: Array) -> float:
    """Middle one of the three principal sizes of points (n, 3), as the width of a cylinder's."""
    return float(np.sqrt(8.0 * np.sort(np.linalg.eigvalsh(np.cov(points.T)))[1]))


def _settled(points: Array, fit: Fit) -> Fit:
    """Fit twice to points (n, 3), as the first fit changes what is near its tip."""
    for _ in range(2):
        fit = _fitted(points, fit.axes, fit)
    return fit


def _start(points: Array, axes: Array) -> Fit:
    """Return a fingertip with axes (3, 3) and the size of the box of points (n, 3)."""
    local = points @ axes.T
    low, size = local.min(axis=0), np.ptp(local, axis=0)
    origin = axes.T @ (low + size * [1.0, 0.5, PALM])
    return Fit(axes, origin, float(size[1]), float(size[2]), 1.0, 0.0)


def _fitted(
    points: Array,
    start: Array,
    before: Fit | None = None,
    *,
    steps: int = STEPS,
    tolerance: float = CLOSE,
) -> Fit:
    """Fit the fingertip of closed form to points (n, 3), from axes (3, 3) or from a fit."""
    from scipy.optimize import least_squares
    from scipy.spatial.transform import Rotation

    first = before or _start(points, start)
    seen = first.near(points)
    unit = OUTLIER * _middle_size(points)
    held = np.sqrt(len(points)) * WEIGHT

    def parts(values: Array) -> tuple[Array, ...]:
        """Return axes (..., 3, 3), origin (..., 3) and sizes (..., 1) of values (..., 9)."""
        axes = Rotation.from_rotvec(values[..., :3]).as_matrix() @ first.axes
        sizes = np.exp(values[..., 6:]) * [first.width, first.thickness, first.blunt]
        origin = first.origin + values[..., 3:6] * first.width
        return axes, origin, sizes[..., :1], sizes[..., 1:2], sizes[..., 2:]

    def away(values: Array) -> Array:
        """Return distances of points, and of the sizes from usual ones, (..., n + 3)."""
        fit = parts(values)
        _, _, width, thickness, blunt = fit
        flat = np.log(thickness / width)
        usual = [(flat - np.log(FLATTER)) / SPREAD, np.maximum(flat, 0.0) / ROUND]
        usual.append(np.log(blunt) / TIPS)
        there = _distance(points[seen], *fit) / unit
        return np.concatenate([there, *(held * each for each in usual)], axis=-1)

    # Step of angles and of relative lengths in differences: rounding and curvature both add 1e-7.
    difference = 1e-7

    def slopes(values: Array) -> Array:
        """Return the derivatives (n + 3, 9) of `away`, by differences all at once."""
        here, *there = away(values + difference * np.eye(10, 9, -1))
        return (np.array(there) - here).T / difference

    bounds = np.full(9, np.inf)
    larger = 1.6  # largest ratio of width and thickness to those that a fit starts from
    sharper = 4.0  # largest ratio of the length of the tip to that of the fingers of the thesis
    bounds[6:8], bounds[8] = np.log(larger), np.log(sharper)
    found = least_squares(
        away,
        np.zeros(9),
        slopes,
        bounds=(-bounds, bounds),
        loss="soft_l1",
        max_nfev=steps,
        ftol=tolerance,
    )
    axes, origin, *sizes = parts(found.x)
    # Cost of a point farther than REACH from the tip: fits that look at few points are no better.
    unseen = 0.1
    misfit = (found.cost + unseen * np.sum(~seen)) / len(points)
    width, thickness, blunt = (float(size[0]) for size in sizes)
    return Fit(axes, origin, width, thickness, blunt, float(misfit))


def _rim(mesh: "Trimesh") -> Array:
    """Return the points (n, 3) of the edges of single triangles."""
    from trimesh.grouping import group_rows

    edges = mesh.edges[group_rows(mesh.edges_sorted, require_count=1)]
    return np.asarray(mesh.vertices[np.unique(edges)], dtype=float)


def _outward(fit: Fit, points: Array, normals: Array) -> Array:
    """Return normals (n, 3) at points of a surface as they face away from its long axis."""
    along = np.minimum((points - fit.origin) @ fit.axes[0], -fit.width / 2)
    away = points - fit.origin - along[:, None] * fit.axes[0]
    return normals * np.where(np.einsum("ni,ni->n", away, normals) < 0.0, -1.0, 1.0)[:, None]


def _asymmetry(points: Array, normals: Array, fit: Fit) -> float:
    """Cost of the distances of a surface from its mirror image in the middle of a fit.

    In the unit of the misfit; points (n, 3) of the surface and normals there.
    """
    some = slice(None, None, 2)  # of the points: every second one
    points, normals = points[some], _outward(fit, points[some], normals[some])
    axes, origin = fit.axes, fit.origin
    for _ in range(2):
        axes, origin = symmetric(points, normals, axes, origin, fit.width)
    off = mirrored(points, normals, axes, origin, fit.width)[2] / (OUTLIER * fit.width)
    return float(np.mean(np.sqrt(1.0 + off**2) - 1.0)) if len(off) else 1.0
