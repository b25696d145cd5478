"""The tactile array of Pawluk (1997) on the plate, and the thesis's fit to its readings.

8 x 8 elements 2 mm apart, each a Gaussian of 0.96 mm, scanned one after the other at 200 Hz, with
noise of 0.5 kPa. Lengths in mm, pressures in kPa, times in s. Source: Pawluk (1997), section 3.2,
3.4.2 and appendix A, Eq. 3.1 to 3.3, 3.17, 3.18, A.1 and A.4.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from fefinger.geometry.profiles import directions
from fefinger.results.pressure import cuts, net
from fefinger.results.records import Pad
from fefinger.scene.indenter import Indenter, direction
from fefinger.support import recording_files
from fefinger.support.checks import InputError
from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


PRESSURE = (1.0, 500.0)
"""Range in kPa of the largest reading of an array on a finger."""


@dataclass(frozen=True)
class ArraySensor:
    """A square array of pressure elements on a rigid plane, centered on the origin.

    elements per side; pitch mm between centers; sigma mm of the spatial response; noise kPa,
    standard deviation; rate Hz of whole frames.

    Raises ValueError for a size that is not above 0, or noise below 0.
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
    def delays(self) -> Array:
        """Time (n,) s after the start of a frame at which each element is read."""
        return np.arange(self.elements**2) / (self.elements**2 * self.rate)

    def weights(self, points: ArrayLike, areas: ArrayLike) -> Array:
        """Matrix (n, n_points) from pressures at points to the pressures that the elements average.

        points (n_points, 2) mm in the plane of the array, areas (n_points,) mm².

        Raises ValueError for areas with sides above 1.5 sigma, which do not resolve the response of
        an element.
        """
        points, areas = np.asarray(points, float), np.asarray(areas, float)
        if points.ndim != 2 or points.shape[1] != 2 or areas.shape != points.shape[:1]:
            msg = f"points: expected (n, 2) and areas (n,), received {points.shape}, {areas.shape}"
            raise ValueError(msg)
        elastic.numbers("points", "places", points)
        side = float(np.sqrt(elastic.numbers("points", "areas", areas, above=0.0).max()))
        # Largest spacing of points over sigma: the error of their sum as an integral of the
        # Gaussian is then 2 exp(-2 pi² sigma² / spacing²) = 3e-4 (Poisson summation).
        coarsest = 1.5
        if side > coarsest * self.sigma:
            limit = coarsest * self.sigma
            msg = f"areas: expected sides up to {limit:.3g} mm (sigma), received {side:.3g} mm"
            raise ValueError(msg)
        square = ((self.positions[:, None] - points) ** 2).sum(axis=-1)
        return np.exp(-square / (2 * self.sigma**2)) / (2 * np.pi * self.sigma**2) * areas


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
    # Smallest number of points of the radial convolution; 40 give the same eight digits at 4 sigma.
    quadrature = 80
    # Points of the radial convolution per sigma of its reach: they are less than a sigma apart.
    per_sigma = 3.0
    count = max(quadrature, math.ceil(per_sigma * reach / sigma))
    nodes, weights = _rule(count)
    # s = reach sin(angle) removes the square root in which the pressure ends.
    angle = np.pi / 4 * (nodes + 1)
    s = reach * np.sin(angle)
    weights = np.pi / 4 * weights * reach * np.cos(angle)
    apart = np.exp(-((r[..., None] - s) ** 2) / (2 * sigma**2))
    # ive is I0 without its growth exp(r s / sigma²), which is in `apart`: no overflow.
    kernel = s / sigma**2 * apart * ive(0, r[..., None] * s / sigma**2)
    return np.asarray(kernel @ (weights * pressure(s)))


@cache
def _rule(count: int) -> tuple[Array, Array]:
    """Return Gauss's nodes and weights (count,), for which a table of caps asks 119 times."""
    return np.polynomial.legendre.leggauss(count)


@dataclass(frozen=True)
class SensorFit:
    """Fitted parameters by name, and the error of Eq. 2.5 as a fraction."""

    parameters: dict[str, float]
    error: float


class BlurredCap:
    """Table of the blurred sqrt(a² - r²) in mm for contact radii a and distances r (mm)."""

    def __init__(self, widest: float, farthest: float) -> None:
        from scipy.interpolate import RectBivariateSpline

        # Number of contact radii, and of distances, in the table of the blurred pressure.
        table = 120
        radii = np.linspace(0.0, widest, table)
        distances = np.linspace(0.0, farthest, table)
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

    guess: by name, the radius in mm first; other arguments and errors as `fit_fingerpad`.
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


def reading_matrix(sensor: ArraySensor, pad: Pad, places: Array) -> Array:
    """Matrix (n_elements, n_pad) from pressures on the pad to pressures on the array's elements.

    places (n_pad, 2) mm: points of the pad in the plane of the array, between which the pressure
    varies linearly.

    Raises ValueError if the triangles of the pad are too large for the elements.
    """
    between, loads = net(pad, cuts(pad, sensor.sigma))
    areas = np.asarray(loads.sum(axis=1)).ravel()
    loaded = areas > 0
    weights = sensor.weights((between @ places)[loaded], areas[loaded]) / areas[loaded]
    return np.asarray(weights @ loads[loaded])


def plane(indenter: Indenter, points: Array) -> Array:
    """Project points (n, 3) mm onto the plane of the plate: (n, 2) mm, distal and sideways.

    Raises InputError for another indenter.
    """
    if indenter.flat is None:
        msg = f"indenter: expected a plate to put the array on, received a {indenter.kind}"
        raise InputError(msg)
    return np.asarray(points @ directions(direction(indenter.flat)).T)


@dataclass(frozen=True)
class Frames:
    """Readings of an array in a slow press.

    depth (n_t, n) mm, pressure (n_t, n) kPa of elements at distance (n,) mm from the center of
    contact.
    """

    depth: Array
    pressure: Array
    distance: Array


def frames(file: str | Path) -> Frames:
    """Read the frames of the array from a CSV file: time, position (mm from touch), p1 ... p64.

    One frame per row, in kPa, read element by element in the row order of the array, so that the
    depth is that at the time of every element. The array is aligned by the frame with the largest
    sum, as in section 3.2.1 of the thesis.

    Raises InputError for missing columns, times that do not rise, another unit, or no contact.
    """
    sensor = ArraySensor()
    count = len(sensor.positions)
    wanted = ("time", "position", *(f"p{i} in kPa" for i in range(1, count + 1)))
    table = recording_files.read(str(file), file).pick(wanted, slow=True)
    time, depth, pressure = table[:, 0], table[:, 1], table[:, 2:]
    fewest = 4  # fewest frames of a press, for three fitted parameters
    if len(table) < fewest:
        msg = f"{file}: expected {fewest} frames or more of a slow press, received {len(table)}"
        raise InputError(msg)
    (low, high), largest = PRESSURE, float(pressure.max())
    if largest <= 0:
        raise InputError(f"{file}: p1 ... : expected pressures above 0 in contact, received none")
    if not low <= largest <= high:
        raise InputError(
            f"{file}: p1 ... : expected kPa, with a largest pressure of {low:g} to {high:g}, "
            f"received {largest:.3g}, as if it were in {'MPa' if largest < low else 'Pa'}; convert "
            "the columns"
        )
    reached = np.interp(time[:, None] + sensor.delays, time, depth)
    return aligned(reached, pressure, sensor)


def aligned(depth: Array, pressure: Array, sensor: ArraySensor) -> Frames:
    """Center frames (n_t, n) mm and kPa on the center of pressure of the one of largest sum."""
    heaviest = np.maximum(pressure[int(np.argmax(pressure.sum(axis=1)))], 0.0)
    center = heaviest @ sensor.positions / heaviest.sum()
    distance = np.hypot(*(sensor.positions - center).T)
    return Frames(depth, pressure, distance)
