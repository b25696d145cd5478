"""Fit of contact parameters to readings of the tactile array, by the procedure of Pawluk (1997).

A Hertz pressure is convolved with the response of the elements; a simplex search minimizes the
squared error over the whole press. Lengths in mm, pressures and moduli in kPa.
Source: Pawluk (1997), section 3.4.2.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.array.sensor import blurred
from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


TABLE = 120  # number of contact radii, and of distances, in the table of the blurred pressure


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
    """Return the function sqrt(a² - s²), zero beyond a."""
    return lambda s: np.sqrt(np.maximum(a**2 - s**2, 0.0))


def fit_fingerpad(depth: ArrayLike, pressure: ArrayLike, distance: ArrayLike) -> SensorFit:
    """Fit R mm, the relaxed b ("c0_b", kPa/mm) and m 1/mm to a slow press (Eq. 3.17, 3.18).

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
