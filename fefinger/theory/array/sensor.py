"""The tactile array of the thesis: what it would have read of any pressure on a plane.

8 x 8 elements 2 mm apart, each a Gaussian of 0.96 mm, scanned one after the other at 200 Hz, with
noise of 0.5 kPa. Lengths in mm, pressures in kPa, times in s. Source: Pawluk (1997), section 3.2
and appendix A, Eq. 3.1 to 3.3, 3.18, A.1 and A.4.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


QUADRATURE = 80
"""Points of the radial convolution, at least; 40 give the same eight digits at 4 sigma."""

PER_SIGMA = 3.0
"""Points of it per sigma of its reach: they are then less than a sigma apart."""


COARSEST = 1.5
"""Spacing of points over sigma, up to which their sum is the integral of the Gaussian to
2 exp(-2 pi² sigma² / spacing²) = 3e-4."""


@dataclass(frozen=True)
class Reading:
    """What the array gave: frames one after the other, each scanned element by element.

    time (n_frames, n) s, when each element was read; pressure (n_frames, n) kPa.
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
        """Check the sizes."""
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
        """Return the matrix (n, n_points) from pressures at points to what the elements feel.

        points (n_points, 2) mm in the plane of the array, areas (n_points,) mm².

        Raises
        ------
        ValueError
            Areas whose side is longer than 1.5 sigma, which do not resolve the response.
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

    def read(
        self,
        time: ArrayLike,
        points: ArrayLike,
        areas: ArrayLike,
        pressure: ArrayLike,
        *,
        seed: int | None = None,
    ) -> Reading:
        """Return what the array reads of a pressure (n_t, n_points) in kPa at the times (n_t,).

        The pressure is joined by straight lines in time and read from `time[0]` on; only whole
        frames are returned. `seed` starts the noise; None leaves it out.

        Raises
        ------
        ValueError
            Shapes that do not match, times that do not increase, or less than one frame.
        """
        pressure = elastic.numbers("pressure", "pressures", pressure)
        return self.scan(time, pressure @ self.weights(points, areas).T, seed=seed)

    def scan(self, time: ArrayLike, felt: ArrayLike, *, seed: int | None = None) -> Reading:
        """Return what the array reads, element by element, of what these feel (n_t, n) in kPa.

        The rest as in `read`.
        """
        time = elastic.numbers("time", "times", time)
        felt = elastic.numbers("felt", "pressures", felt)
        if felt.shape[:1] != time.shape or not (np.diff(time) > 0).all():
            msg = f"time: expected {len(felt)} rising times, received {time.shape}"
            raise ValueError(msg)
        span = time[-1] - time[0] - self.delays[-1]
        if span < 0:
            msg = f"time: expected at least one frame of {1 / self.rate:g} s, received less"
            raise ValueError(msg)
        starts = time[0] + np.arange(int(span * self.rate + 1e-9) + 1) / self.rate
        at = starts[:, None] + self.delays
        columns = zip(at.T, felt.T, strict=True)
        read = np.stack([np.interp(when, time, value) for when, value in columns], axis=1)
        if seed is not None:
            read = read + np.random.default_rng(seed).normal(0.0, self.noise, read.shape)
        return Reading(at, read)


def centroid(positions: ArrayLike, pressure: ArrayLike) -> Array:
    """Return the center of pressure (..., 2) mm (Eq. 3.2 and 3.3) of pressures (..., n).

    Not a number where the pressures add up to nothing or less.
    """
    pressure = elastic.numbers("centroid", "pressures", pressure)
    total = pressure.sum(axis=-1)[..., None]
    moment = pressure @ np.asarray(positions, float)
    return np.divide(moment, total, out=np.full_like(moment, np.nan), where=total > 0)


def isobar(points: ArrayLike, triangles: ArrayLike, pressure: ArrayLike, level: float) -> Array:
    """Return the line of one pressure as segments (k, 2, 2) mm, from linear triangles.

    points (n, 2) mm, triangles (m, 3), pressure (n,) kPa. A place at exactly `level` is outside.
    """
    points = elastic.numbers("isobar", "places", points)
    pressure = elastic.numbers("isobar", "pressures", pressure)
    elastic.require_finite("isobar", level=level)
    corners = np.asarray(triangles)
    above = pressure[corners] > level
    crossed = corners[above.any(axis=1) & ~above.all(axis=1)]
    inside = pressure[crossed] > level
    lone = np.argmax(inside == (inside.sum(axis=1) == 1)[:, None], axis=1)
    rows = np.arange(len(crossed))
    one = crossed[rows, lone]
    ends = []
    for other in (crossed[rows, (lone + 1) % 3], crossed[rows, (lone + 2) % 3]):
        part = (level - pressure[one]) / (pressure[other] - pressure[one])
        ends.append(points[one] + part[:, None] * (points[other] - points[one]))
    return np.stack(ends, axis=1)


def radial_profile(
    positions: ArrayLike, pressure: ArrayLike, edges: ArrayLike, *, center: ArrayLike = (0.0, 0.0)
) -> tuple[Array, Array]:
    """Return mean distances and mean pressures (k,) in the bins between `edges` (k + 1,) mm.

    The distance from the center counts as negative on the side of smaller x (proximal), so that
    the two halves stay apart as in Figure 3-4. Empty bins are not numbers.
    """
    offset = np.asarray(positions, float) - np.asarray(center, float)
    distance = np.hypot(*offset.T) * np.where(offset[:, 0] < 0, -1.0, 1.0)
    edges = elastic.numbers("radial_profile", "edges", edges)
    if edges.ndim != 1 or len(edges) < 2 or (np.diff(edges) <= 0).any():
        msg = f"radial_profile: expected edges (k + 1,) that increase, received {edges}"
        raise ValueError(msg)
    elastic.numbers("radial_profile", "pressures", pressure)
    place = np.searchsorted(edges, distance, side="right") - 1
    kept = (place >= 0) & (place < len(edges) - 1)

    def total(values: Array | None) -> Array:
        chosen = None if values is None else values[kept]
        return np.bincount(place[kept], chosen, minlength=len(edges) - 1).astype(float)

    count = total(None)
    count[count == 0] = np.nan
    return total(distance) / count, total(np.asarray(pressure, float)) / count


def blurred(
    pressure: Callable[[Array], Array], reach: float, r: ArrayLike, sigma: float = 0.96
) -> Array:
    """Return the 2-D convolution (Eq. 3.18 and A.4) of a round pressure with the Gaussian, at r.

    `pressure` takes distances (k,) mm from the axis and gives kPa; it is zero beyond `reach` mm,
    where it may end as a square root. r in mm, of any shape.
    """
    from scipy.special import ive

    elastic.require_positive("blurred", reach=reach, sigma=sigma)
    r = elastic.numbers("blurred", "r", r)
    count = max(QUADRATURE, math.ceil(PER_SIGMA * reach / sigma))
    nodes, weights = np.polynomial.legendre.leggauss(count)
    angle = np.pi / 4 * (nodes + 1)
    s = reach * np.sin(angle)
    weights = np.pi / 4 * weights * reach * np.cos(angle)
    apart = np.exp(-((r[..., None] - s) ** 2) / (2 * sigma**2))
    kernel = s / sigma**2 * apart * ive(0, r[..., None] * s / sigma**2)
    return np.asarray(kernel @ (weights * pressure(s)))


@dataclass(frozen=True)
class Sharpened:
    """A pressure with the blur taken out: points (n, 2) mm, areas (n,) mm², pressure (n,) kPa.

    `residual` kPa is the root mean square that is left unexplained, the noise.
    """

    points: Array
    areas: Array
    pressure: Array
    residual: float


def sharpen(sensor: ArraySensor, pressure: ArrayLike, *, finer: int = 2) -> Sharpened:
    """Return the smoothest pressure whose blur explains one frame (n,) up to the noise.

    Deconvolution limited by noise: the roughness is the smallest for which the readings are met
    within the standard deviation of the noise (discrepancy principle). `finer` points per pitch.

    Raises
    ------
    ValueError
        A sensor without noise, for which this has no answer, or another number of readings.
    """
    pressure = elastic.numbers("sharpen", "pressures", pressure)
    if sensor.noise <= 0 or pressure.shape != (sensor.elements**2,):
        msg = f"pressure: expected {sensor.elements**2} readings and noise above 0 kPa"
        raise ValueError(msg)
    dense = ArraySensor(sensor.elements * finer, sensor.pitch / finer, sensor.sigma)
    points = dense.positions
    areas = np.full(len(points), dense.pitch**2)
    weights, rough = sensor.weights(points, areas), _roughness(dense.elements)

    def solve(smoothing: float) -> tuple[Array, float]:
        found = np.linalg.solve(weights.T @ weights + smoothing * rough, weights.T @ pressure)
        left = weights @ found - pressure
        return np.asarray(found, np.float64), float(np.sqrt(np.mean(left**2)))

    low, high = -10.0, 6.0
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if solve(10**middle)[1] < sensor.noise else (low, middle)
    found, residual = solve(10 ** ((low + high) / 2))
    return Sharpened(points, areas, found, residual)


def _roughness(side: int) -> Array:
    """Return the sum of squared steps to the neighbors and, at the rim, to zero, as a matrix."""
    step = np.diff(np.eye(side), axis=0, prepend=0.0, append=0.0)
    line = step.T @ step
    return np.kron(line, np.eye(side)) + np.kron(np.eye(side), line)


def two_pole(time: ArrayLike, signal: ArrayLike, corner: float = 1000.0) -> Array:
    """Return the signal (n_t,) behind a two-pole Butterworth low-pass of `corner` Hz.

    The filter of the force sensor (section 2.2). Exact for straight lines between the samples at
    rising times (n_t,) s; before the first one the signal rests at its first value.
    """
    elastic.require_positive("two_pole", corner=corner)
    time = elastic.numbers("two_pole", "times", time)
    signal = elastic.numbers("two_pole", "values", signal)
    if time.ndim != 1 or signal.shape != time.shape or (np.diff(time) <= 0).any():
        msg = "two_pole: expected a value at each of rising times, (n_t,) both"
        raise ValueError(msg)
    pole = 2 * np.pi * corner * np.exp(0.75j * np.pi)
    gain = 2 * (2 * np.pi * corner) ** 2 / (pole - pole.conjugate())
    state = -signal[0] / pole + 0j
    out = np.empty(len(time))
    out[0] = signal[0]
    for i, (step, change) in enumerate(zip(np.diff(time), np.diff(signal), strict=True)):
        x = pole * step
        first = np.expm1(x) / x
        state = np.exp(x) * state + step * (signal[i] * first + change * (first - 1) / x)
        out[i + 1] = (gain * state).real
    return out
