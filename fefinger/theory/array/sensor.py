"""Tactile array sensor of Pawluk (1997): simulated readings, and the thesis's fit to readings.

8 x 8 elements 2 mm apart, each a Gaussian of 0.96 mm, scanned one after the other at 200 Hz, with
noise of 0.5 kPa. Lengths in mm, pressures in kPa, times in s. Source: Pawluk (1997), section 3.2,
3.4.2 and appendix A, Eq. 3.1 to 3.3, 3.17, 3.18, A.1 and A.4.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


QUADRATURE = 80
"""Smallest number of points of the radial convolution; 40 give the same eight digits at 4 sigma."""

PER_SIGMA = 3.0
"""Points of the radial convolution per sigma of its reach: they are less than a sigma apart."""


COARSEST = 1.5
"""Largest spacing of points over sigma: the error of their sum as an integral of the Gaussian is
then 2 exp(-2 pi² sigma² / spacing²) = 3e-4 (Poisson summation)."""

TABLE = 120  # number of contact radii, and of distances, in the table of the blurred pressure


@dataclass(frozen=True)
class Reading:
    """Readings of the array: consecutive frames, each scanned element by element.

    time (n_frames, n) s of each reading; pressure (n_frames, n) kPa.
    """

    time: Array
    pressure: Array


@dataclass(frozen=True)
class ArraySensor:
    """A square array of pressure elements on a rigid plane, centered on the origin.

    elements per side; pitch mm between centers; sigma mm of the spatial response; noise kPa,
    standard deviation; rate Hz of whole frames.

    Raises
    ------
    ValueError
        A size that is not above 0, or noise below 0.
    """

    elements: int = 8
    pitch: float = 2.0
    sigma: float = 0.96
    noise: float = 0.5
    rate: float = 200.0

    def __post_init__(self) -> None:
        sizes = {"pitch": self.pitch, "sigma": self.sigma, "rate": self.rate}
        elastic.require_positive("sensor", elements=self.elements, **sizes)
        elastic.require_not_negative("sensor", noise=self.noise)
        if self.elements != int(self.elements):
            msg = f"sensor: expected a whole number of elements, received {self.elements!r}"
            raise ValueError(msg)

    @property
    def positions(self) -> Array:
        """Centers (n, 2) mm, row by row in the order of the scan: y is the row, x the column."""
        line = (np.arange(self.elements) - (self.elements - 1) / 2) * self.pitch
        return np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)

    @property
    def triangles(self) -> NDArray[np.int64]:
        """Two triangles (m, 3) per square of four elements, for isobars."""
        corner = np.arange(self.elements**2).reshape(self.elements, self.elements)
        a, b = corner[:-1, :-1].ravel(), corner[:-1, 1:].ravel()
        c, d = corner[1:, :-1].ravel(), corner[1:, 1:].ravel()
        return np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])

    @property
    def delays(self) -> Array:
        """Time (n,) s after the start of a frame at which each element is read."""
        return np.arange(self.elements**2) / (self.elements**2 * self.rate)

    def weights(self, points: ArrayLike, areas: ArrayLike) -> Array:
        """Matrix (n, n_points) from pressures at points to the pressures that the elements average.

        points (n_points, 2) mm in the plane of the array, areas (n_points,) mm².

        Raises
        ------
        ValueError
            Areas with sides above 1.5 sigma, which do not resolve the response of an element.
        """
        points, areas = np.asarray(points, float), np.asarray(areas, float)
        if points.ndim != 2 or points.shape[1] != 2 or areas.shape != points.shape[:1]:
            msg = f"points: expected (n, 2) and areas (n,), received {points.shape}, {areas.shape}"
            raise ValueError(msg)
        elastic.numbers("points", "places", points)
        side = float(np.sqrt(elastic.numbers("points", "areas", areas, above=0.0).max()))
        if side > COARSEST * self.sigma:
            limit = COARSEST * self.sigma
            msg = f"areas: expected sides up to {limit:.3g} mm (sigma), received {side:.3g} mm"
            raise ValueError(msg)
        square = ((self.positions[:, None] - points) ** 2).sum(axis=-1)
        return np.exp(-square / (2 * self.sigma**2)) / (2 * np.pi * self.sigma**2) * areas

    def scan(
        self, time: ArrayLike, element_pressure: ArrayLike, *, seed: int | None = None
    ) -> Reading:
        """Simulate readings of the pressure (n_t, n) in kPa on the elements at times (n_t,) s.

        The pressure is linear between the times and read from `time[0]` on; only whole frames are
        returned. `seed` is that of the noise; None: without noise.

        Raises
        ------
        ValueError
            Shapes that do not match, times that do not increase, or less than one frame.
        """
        time = elastic.numbers("time", "times", time)
        element_pressure = elastic.numbers("element_pressure", "pressures", element_pressure)
        if element_pressure.shape[:1] != time.shape or not (np.diff(time) > 0).all():
            msg = f"time: expected {len(element_pressure)} rising times, received {time.shape}"
            raise ValueError(msg)
        span = time[-1] - time[0] - self.delays[-1]
        if span < 0:
            msg = f"time: expected at least one frame of {1 / self.rate:g} s, received less"
            raise ValueError(msg)
        starts = time[0] + np.arange(int(span * self.rate + 1e-9) + 1) / self.rate
        at = starts[:, None] + self.delays
        columns = zip(at.T, element_pressure.T, strict=True)
        read = np.stack([np.interp(when, time, value) for when, value in columns], axis=1)
        if seed is not None:
            read = read + np.random.default_rng(seed).normal(0.0, self.noise, read.shape)
        return Reading(at, read)


def isobar(points: ArrayLike, triangles: ArrayLike, pressure: ArrayLike, level: float) -> Array:
    """Line of constant pressure as segments (k, 2, 2) mm, from linear triangles.

    points (n, 2) mm, triangles (m, 3), pressure (n,) kPa. A vertex at exactly `level` is outside.
    """
    points = elastic.numbers("isobar", "places", points)
    pressure = elastic.numbers("isobar", "pressures", pressure)
    elastic.numbers("isobar", "level", level)
    corners = np.asarray(triangles)
    above = pressure[corners] > level
    crossed = corners[above.any(axis=1) & ~above.all(axis=1)]
    inside = pressure[crossed] > level
    # The corner that is alone on its side of the level: both cut edges meet there.
    lone = np.argmax(inside == (inside.sum(axis=1) == 1)[:, None], axis=1)
    rows = np.arange(len(crossed))
    one = crossed[rows, lone]
    ends = []
    for other in (crossed[rows, (lone + 1) % 3], crossed[rows, (lone + 2) % 3]):
        part = (level - pressure[one]) / (pressure[other] - pressure[one])
        ends.append(points[one] + part[:, None] * (points[other] - points[one]))
    return np.stack(ends, axis=1)


def blurred(
    pressure: Callable[[Array], Array], reach: float, r: ArrayLike, sigma: float = 0.96
) -> Array:
    """Convolution (Eq. 3.18 and A.4) of an axisymmetric pressure with the Gaussian, at r.

    `pressure` takes distances (k,) mm from the axis and gives kPa; it is zero beyond `reach` mm,
    where it may end as a square root. r in mm, of any shape.
    """
    from scipy.special import ive

    elastic.require_positive("blurred", reach=reach, sigma=sigma)
    r = elastic.numbers("blurred", "r", r)
    count = max(QUADRATURE, math.ceil(PER_SIGMA * reach / sigma))
    nodes, weights = np.polynomial.legendre.leggauss(count)
    # s = reach sin(angle) removes the square root in which the pressure ends.
    angle = np.pi / 4 * (nodes + 1)
    s = reach * np.sin(angle)
    weights = np.pi / 4 * weights * reach * np.cos(angle)
    apart = np.exp(-((r[..., None] - s) ** 2) / (2 * sigma**2))
    # ive is I0 without its growth exp(r s / sigma²), which is in `apart`: no overflow.
    kernel = s / sigma**2 * apart * ive(0, r[..., None] * s / sigma**2)
    return np.asarray(kernel @ (weights * pressure(s)))


@dataclass(frozen=True)
class SensorFit:
    """Fitted parameters by name, and the error of Eq. 2.5 as a fraction."""

    parameters: dict[str, float]
    error: float


class BlurredCap:
    """Table of the blurred sqrt(a² - r²) in mm for contact radii a and distances r (mm)."""

    def __init__(self, widest: float, farthest: float) -> None:
        from scipy.interpolate import RectBivariateSpline

        radii = np.linspace(0.0, widest, TABLE)
        distances = np.linspace(0.0, farthest, TABLE)
        rows = [np.zeros_like(distances)]
        rows += [blurred(_cap(a), a, distances) for a in radii[1:].tolist()]
        self.widest = widest
        self._spline = RectBivariateSpline(radii, distances, np.array(rows))

    def __call__(self, radius: ArrayLike, r: ArrayLike) -> Array:
        """Interpolate the blurred cap at contact radii and distances, of their broadcast shape."""
        return np.asarray(self._spline(radius, r, grid=False))


def _cap(a: float) -> Callable[[Array], Array]:
    return lambda s: np.sqrt(np.maximum(a**2 - s**2, 0.0))


def fit_fingerpad(depth: ArrayLike, pressure: ArrayLike, distance: ArrayLike) -> SensorFit:
    """Fit R mm, the relaxed b ("c0_b", kPa/mm) and m 1/mm to a slow press (Eq. 3.17, 3.18).

    A Hertz pressure is convolved with the response of the elements; a simplex search minimizes the
    squared error over the whole press.

    Parameters
    ----------
    depth, pressure
        (n_t, n) mm, at the time of the reading of each element, and kPa.
    distance
        (n,) mm of the elements from the center of contact.

    Raises
    ------
    ValueError
        If the search does not converge, or shapes do not match.
    """

    def predict(radius: float, b: float, m: float, reach: Array, cap: BlurredCap) -> Array:
        a = np.minimum(np.sqrt(radius * reach), cap.widest)
        return 4 * b / (np.pi * radius * m) * np.expm1(m * reach) * cap(a, distance)

    return search(predict, {"radius": 14.0, "c0_b": 3.0, "m": 1.5}, depth, pressure, distance)


def search(
    predict: Callable[..., Array],
    guess: dict[str, float],
    depth: ArrayLike,
    pressure: ArrayLike,
    distance: ArrayLike,
) -> SensorFit:
    """Minimize the squared error of `predict` over the logarithms of the parameters (simplex).

    guess: by name, that of the radius in mm first; other arguments and errors as `fit_fingerpad`.
    """
    from scipy.optimize import minimize

    depth = elastic.numbers("fit", "depth", depth)
    pressure = elastic.numbers("fit", "pressure", pressure)
    distance = elastic.numbers("fit", "distance", distance, least=0.0)
    start = np.array(list(guess.values()))
    if pressure.shape != depth.shape or depth.shape[1:] != np.shape(distance):
        msg = f"depth: expected the shape of the pressure {pressure.shape}, received {depth.shape}"
        raise ValueError(msg)
    reach = np.maximum(depth, 0.0)
    if not reach.max() > 0:
        raise ValueError("depth: expected a contact, received no depth above 0 mm")
    widest = float(np.sqrt(4 * start[0] * reach.max()))  # contact radius at R = 4 times the guess
    cap = BlurredCap(widest, float(distance.max()))

    def squares(logarithms: Array) -> float:
        return float(np.sum((predict(*np.exp(logarithms), reach, cap) - pressure) ** 2))

    options = {"xatol": 1e-7, "fatol": 1e-10, "maxiter": 4000, "maxfev": 4000}
    minimum = minimize(squares, np.log(start), method="Nelder-Mead", options=options)
    values = np.exp(minimum.x)
    if not minimum.success or values[0] * reach.max() > widest**2:
        msg = f"fit: expected a minimum, the search ended at {values.round(4).tolist()} without one"
        raise ValueError(msg)
    spread = float(np.sum((pressure - pressure.mean()) ** 2))
    return SensorFit(dict(zip(guess, values.tolist(), strict=True)), float(minimum.fun) / spread)
