"""Shapes of rigid obstacles as height fields across their direction of travel.

A profile gives the distance h >= 0 in mm of the surface behind its foremost point, at positions
(u, v) in mm across the travel, with first and second derivatives. h is infinite, with derivatives
of zero, where there is no surface. Profiles that vary along u only extend along v.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Self, final

import numpy as np
from numpy.typing import ArrayLike

from fefinger.support.arrays import Array, Flags


if TYPE_CHECKING:
    from scipy.interpolate import RectBivariateSpline

    from fefinger.geometry.raster import Raster


Heights = tuple[Array, Array, Array]
"""h (...,) mm, its slope (..., 2) and its curvature (..., 2, 2) in 1/mm."""

FLANK = 75.0
"""Slope in degrees of the sides of a bar or ball: a height field cannot represent vertical ones."""

FLATTEST = 1e-12
"""Curvature in 1/mm below which a surface counts as curved by this much."""


class Profile(ABC):
    """Shape of an obstacle."""

    plane: ClassVar[bool] = False
    """Whether it is a plane."""

    level: ClassVar[bool] = False
    """Whether its crests reach h = 0 all over a plane."""

    @abstractmethod
    def height(self, across: Array) -> Heights:
        """Return h, its slope and its curvature at places `across` (..., 2) mm."""

    def rise(self, across: Array) -> Array:
        """Return h alone (...,) mm, which sliding needs at every step."""
        return self.height(across)[0]

    def incline(self, across: Array) -> Array:
        """Return the slope of h (..., 2) alone."""
        return self.height(across)[1]

    @property
    def half_axes(self) -> tuple[float, float, float] | None:
        """Half axes in mm of an ellipsoid or, with an infinite one, of a cylinder; else None."""
        return None

    @property
    def ends(self) -> tuple[float, float, float, float] | None:
        """Least and largest u, and v, in mm between which there is a surface; None without ends."""
        return None

    def beyond(self, across: Array) -> Flags:
        """Return whether places `across` (..., 2) mm are beyond the modeled shape."""
        return np.zeros(across.shape[:-1], dtype=bool)


@final
@dataclass(frozen=True)
class Plane(Profile):
    """A plane."""

    plane = True
    level = True

    def height(self, across: Array) -> Heights:
        """Height of a plane: h = 0."""
        return _lifted(*(np.zeros(across.shape[:-1]),) * 3)


@final
@dataclass(frozen=True)
class Ellipsoid(Profile):
    """An ellipsoid with half axes `radii` (3,) mm along u, v and the travel; inf is a cylinder.

    With s² = u²/a² + v²/b² its slope dh/ds is c tan(arcsin s); beyond tan(FLANK) it goes on as a
    cone of that slope, so that skin that folds around it meets no edge.
    """

    radii: tuple[float, float, float]

    def height(self, across: Array) -> Heights:
        """Return h = c (1 - sqrt(1 - s²)), and of a cone beyond FLANK."""
        flat, deep = np.array(self.radii[:2]), self.radii[2]
        s = self._s(across)
        over, root = self._slope_over_s(s)
        gradient = across / flat**2
        change = np.where(s > self._end, -over / np.where(s > 0, s**2, 1.0), 1 / root**3)
        bend = over[..., None, None] * np.diag(flat**-2.0)
        bend = bend + change[..., None, None] * gradient[..., :, None] * gradient[..., None, :]
        return self.rise(across), deep * over[..., None] * gradient, deep * bend

    def rise(self, across: Array) -> Array:
        """Return h alone (...,) mm."""
        s = self._s(across)
        on = np.minimum(s, self._end)
        root = np.sqrt(1.0 - on**2)
        return np.asarray(self.radii[2] * (1.0 - root + (s - on) * on / root))

    def incline(self, across: Array) -> Array:
        """Return the slope of h (..., 2) alone."""
        over, _ = self._slope_over_s(self._s(across))
        return np.asarray(self.radii[2] * over[..., None] * across / np.array(self.radii[:2]) ** 2)

    def _slope_over_s(self, s: Array) -> tuple[Array, Array]:
        """Return h' / s, which has a limit at s = 0, over c, and the root in it."""
        on = np.minimum(s, self._end)
        root = np.sqrt(1.0 - on**2)
        return np.where(s > self._end, on / np.where(s > 0, s, 1.0), 1.0) / root, root

    def beyond(self, across: Array) -> Flags:
        """Return whether places are on the cone."""
        return np.asarray(self._s(across) > self._end)

    @property
    def _end(self) -> float:
        return float(np.sin(np.radians(FLANK)))

    def _s(self, across: Array) -> Array:
        return np.hypot(across[..., 0] / self.radii[0], across[..., 1] / self.radii[1])

    @property
    def half_axes(self) -> tuple[float, float, float]:
        """Its half axes in mm."""
        return self.radii


@final
@dataclass(frozen=True)
class Bar(Profile):
    """A flat strip along v, `width` mm over all, with corners rounded to `corner` mm.

    Beyond a corner the side falls away at FLANK degrees. The slope is continuous; the curvature is
    1 / corner on the arc and zero elsewhere.
    """

    width: float
    corner: float

    def height(self, across: Array) -> Heights:
        """Return h of flat, arc and side."""
        u, radius = across[..., 0], self.corner
        past = np.maximum(np.abs(u) - (self.width / 2 - radius), 0.0)
        end = radius * np.sin(np.radians(FLANK))
        arc = np.minimum(past, end)
        root = np.sqrt(radius**2 - arc**2)
        h = radius - root + (past - arc) * np.tan(np.radians(FLANK))
        on_arc = (past > 0) & (past < end)
        return _lifted(h, np.sign(u) * arc / root, np.where(on_arc, radius**2 / root**3, 0.0))


@final
@dataclass(frozen=True)
class Pin(Profile):
    """Flat end of a round pin, `width` mm across over all, with its edge rounded to `corner` mm.

    The section through its axis is the section of a `Bar`.
    """

    width: float
    corner: float

    def height(self, across: Array) -> Heights:
        """Return h of flat, rounded edge and side."""
        r = np.sqrt(np.sum(across**2, axis=-1))
        section = np.stack([r, np.zeros_like(r)], -1)
        h, slope, curvature = Bar(self.width, self.corner).height(section)
        outward = across / np.where(r > 0, r, 1.0)[..., None]
        radial = outward[..., :, None] * outward[..., None, :]
        hoop = (slope[..., 0] / np.where(r > 0, r, 1.0))[..., None, None]
        bend = curvature[..., :1, :1] * radial + hoop * (np.eye(2) - radial)
        return h, slope[..., :1] * outward, bend


@final
@dataclass(frozen=True)
class Grating(Profile):
    """Rounded ridges along v, `period` mm apart, `ridge` mm wide at half height, `depth` mm high.

    h = depth S((|u| - f) / l) from the middle of a ridge to the middle of a groove, with the smooth
    step S(t) = t³ (10 - 15 t + 6 t²), l the smaller of ridge and groove and f half of what the
    ridge has beyond l: flat tops where ridges are wider than grooves, flat floors where they are
    narrower. The curvature is continuous. `shift` mm moves the ridges along u. `flank` mm: a
    smaller l; then ridges and grooves are both flat in their middle.
    """

    level = True

    period: float
    ridge: float
    depth: float
    shift: float = 0.0
    flank: float | None = None

    def height(self, across: Array) -> Heights:
        """Return h of the ridge or groove that each place is in."""
        u = across[..., 0] - self.shift
        u = u - self.period * np.round(u / self.period)
        length = self.flank or min(self.ridge, self.period - self.ridge)
        t = np.clip((np.abs(u) - (self.ridge - length) / 2) / length, 0.0, 1.0)
        h = smooth_step(t)
        slope = np.sign(u) * 30 * t**2 * (1 - t) ** 2 / length
        bend = 60 * t * (1 - t) * (1 - 2 * t) / length**2
        return _lifted(self.depth * h, self.depth * slope, self.depth * bend)


@final
@dataclass(frozen=True, eq=False)
class Relief(Profile):
    """A surface through `heights` (n_u, n_v) mm toward the finger at grid lines u, v mm.

    Between the samples it is the interpolating bicubic spline, whose derivatives are exact. There
    is no surface beyond the outermost samples. h counts from the highest sample, so it is a little
    negative where the spline rises above it.
    """

    level = True

    u: Array
    v: Array
    heights: Array

    @classmethod
    def sampled(cls, function: Callable[[Array, Array], Array], u: Array, v: Array) -> Self:
        """Return the relief of a function of u and v mm, sampled at the grid lines."""
        heights = function(*np.meshgrid(u, v, indexing="ij"))
        return cls(u, v, np.asarray(heights, dtype=np.float64))

    @property
    def ends(self) -> tuple[float, float, float, float]:
        """The outermost samples."""
        (left, right), (low, high) = self.u[[0, -1]].tolist(), self.v[[0, -1]].tolist()
        return left, right, low, high

    @cached_property
    def _spline(self) -> "RectBivariateSpline":
        from scipy.interpolate import RectBivariateSpline

        return RectBivariateSpline(self.u, self.v, self.heights.max() - self.heights)

    @cached_property
    def _raster(self) -> "Raster | None":
        from fefinger.geometry.raster import Raster

        return Raster.through(self.u, self.v, self.heights.max() - self.heights)

    def rise(self, across: Array) -> Array:
        """Return h of the spline, compiled where the samples are evenly spaced."""
        if self._raster is None:
            return super().rise(across)
        return np.asarray(self._raster.heights(across))

    def incline(self, across: Array) -> Array:
        """Return the slope of h, likewise."""
        if self._raster is None:
            return super().incline(across)
        return np.asarray(self._raster.slopes(across))

    def height(self, across: Array) -> Heights:
        """Return h of the spline."""
        u, v = np.moveaxis(across, -1, 0)
        ahead = (u >= self.u[0]) & (u <= self.u[-1]) & (v >= self.v[0]) & (v <= self.v[-1])

        def part(du: int, dv: int) -> Array:
            return np.where(ahead, self._spline.ev(u, v, dx=du, dy=dv), 0.0)

        mixed = part(1, 1)
        bend = np.stack([np.stack([part(2, 0), mixed], -1), np.stack([mixed, part(0, 2)], -1)], -2)
        return np.where(ahead, part(0, 0), np.inf), np.stack([part(1, 0), part(0, 1)], -1), bend

    def sharpest_radius(self, u: Array, v: Array) -> float:
        """Return the smallest radius in mm to which it bulges where rising lines u and v mm cross.

        As the function of that name, 30 times faster: a spline is evaluated line by line.
        """
        sharpest, at_once = 0.0, 2**20  # crossings at once, of some 50 MB
        for rows in np.array_split(u, min(math.ceil(len(u) * len(v) / at_once), len(u))):
            bend_u, mixed, bend_v = (self._spline(rows, v, dx=k, dy=2 - k) for k in (2, 1, 0))
            bulge = (bend_u + bend_v) / 2 + np.hypot((bend_u - bend_v) / 2, mixed)
            sharpest = max(sharpest, float(bulge.max()))
        return 1 / max(sharpest, FLATTEST)


@final
@dataclass(frozen=True, eq=False)
class Tiled(Profile):
    """A relief that repeats every `period` mm along u and v.

    Its samples cover [0, period] and a margin, which repeats the samples of the neighbors.
    """

    level = True

    relief: Relief
    period: float

    def height(self, across: Array) -> Heights:
        """Return h of the tile that each place is in."""
        return self.relief.height(across % self.period)

    def rise(self, across: Array) -> Array:
        """Return h alone."""
        return self.relief.rise(across % self.period)

    def incline(self, across: Array) -> Array:
        """Return the slope of h alone."""
        return self.relief.incline(across % self.period)


def smooth_step(t: Array) -> Array:
    """Return S(t) = t³ (10 - 15 t + 6 t²), from 0 at t = 0 to 1 at t = 1 without a kink."""
    return np.asarray(t**3 * (10.0 + t * (6.0 * t - 15.0)))


def flank_of(edge: float, height: float) -> float:
    """Length in mm of a step S of `height` mm whose sharpest crest has the radius `edge` mm."""
    # The largest second derivative of S, at t = 1/2 - 1 / sqrt(12), is 10 / sqrt(3).
    return float(np.sqrt(10 / 3**0.5 * edge * height))


def sharpest_radius(profile: Profile, across: Array) -> float:
    """Return the smallest radius in mm to which a profile bulges at places `across` (n, 2) mm."""
    _, _, curvature = profile.height(across)
    return float(1 / max(np.linalg.eigvalsh(curvature).max(), FLATTEST))


def frame(axis: Array, roll: float = 0.0) -> Array:
    """Return the rows u, v and axis (3, 3) of an object that travels along the unit vector axis.

    Without roll u lies in the x-z plane; `roll` degrees turn u and v about the axis.
    """
    across = np.cross([0.0, 1.0, 0.0], axis)
    first = across / np.linalg.norm(across)
    second = np.cross(axis, first)
    c, s = np.cos(np.radians(roll)), np.sin(np.radians(roll))
    return np.array([c * first + s * second, c * second - s * first, axis])


def directions(axis: ArrayLike) -> Array:
    """Return the unit vectors (2, 3) across a travel (3,): toward the tip, and sideways.

    The first is the one nearest to x; the first of `frame` lies in the x-z plane instead.
    """
    axis = np.asarray(axis, float)
    distal = np.array([1.0, 0.0, 0.0]) - axis[0] * axis
    distal /= np.linalg.norm(distal)
    return np.stack([distal, np.cross(axis, distal)])


def _lifted(h: Array, slope: Array, bend: Array) -> Heights:
    """Return the heights of a profile that changes along u alone."""
    zero = np.zeros_like(h)
    curvature = np.stack([np.stack([bend, zero], -1), np.stack([zero, zero], -1)], -2)
    return h, np.stack([slope, zero], -1), curvature
