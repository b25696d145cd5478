"""Appendix A.3 of Pawluk (1997): the rubber ball, on a half-space and on a bonded cover."""

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.oracles.fingerpad import series_modulus
from fefinger.validation.oracles.layer import Faced, Sheet, paraboloid_at
from fefinger.validation.thesis.lumped import DIGITS
from fefinger.validation.thesis.pressure import BALL_DEPTH, BALLS, SENSOR, ball
from numpy.typing import ArrayLike

from fefinger.calibration.array_sensor import ArraySensor, BlurredCap, SensorFit, blurred, search
from fefinger.support.arrays import Array
from fefinger.theory.contact.hertz import Hertz
from fefinger.theory.contact.indentation import Contact


COVER = 2.0  # mm of RTV silicone on a rigid plane (A.1)
BONDED = {"nominal": (2.34, 4.49), "fitted": (2.53, 4.61)}
"""Force in N and contact radius in mm at 0.59 mm on the bonded cover (section A.3, recomputed)."""

PRINTED_FORCE = 1.8  # N at 0.59 mm (Figure A-5)
PRINTED_FIT = {"radius": 32.6, "modulus": 570.0}
NOMINAL = {"radius": 31.0, "modulus": 540.0}
PRESSES = 24  # depths of a press


@cache
def bonded(name: str, depth: float = BALL_DEPTH) -> Contact:
    """Return the contact of a ball with the cover as a layer bonded to a rigid plane."""
    radius, modulus, *_ = BALLS[name]
    return paraboloid_at(Faced(Sheet(COVER, SENSOR, 0.5), modulus, 0.5), radius, depth=depth)


@cache
def press(cover: str) -> tuple[Array, Array, Array]:
    """Return depth and pressure (n_t, 32) and distance (32,) of a press of the nominal ball.

    As the array reads it, with its noise; the cover is a "half-space" or "bonded".
    """
    depth = np.linspace(0.05, 0.7, PRESSES)
    places = ArraySensor().positions
    r = np.unique(np.hypot(*places.T).round(9))
    rows = []
    for each in depth.tolist():
        if cover == "bonded":
            contact = bonded("nominal", each)
            rows.append(blurred(contact.pressure, contact.contact_radius, r))
        else:
            plane, radius = ball("nominal")[0], NOMINAL["radius"]
            hertz = Hertz(radius, each, 0.75 * plane, 0.5)
            rows.append(blurred(hertz.pressure, hertz.contact_radius, r))
    noise = np.random.default_rng(5).normal(0.0, ArraySensor().noise, (len(depth), len(r)))
    return np.repeat(depth[:, None], len(r), axis=1), np.array(rows) + noise, r


@cache
def fitted(cover: str) -> dict[str, float]:
    """Apply the thesis's fit to the press of the nominal ball."""
    return fit_ball(*press(cover)).parameters


def fit_ball(depth: ArrayLike, pressure: ArrayLike, distance: ArrayLike) -> SensorFit:
    """Fit radius mm and modulus kPa of an incompressible ball on the array (A.2 to A.4).

    The array is an incompressible half-space of modulus SENSOR, as in the thesis; a 2 mm cover
    on a rigid plane is actually much stiffer. Arguments and errors as `fit_fingerpad`.
    """

    def predict(radius: float, modulus: float, reach: Array, cap: BlurredCap) -> Array:
        plane = series_modulus((modulus, 0.5), (SENSOR, 0.5))
        a = np.minimum(np.sqrt(radius * reach), cap.widest)
        return 2 * plane / (np.pi * radius) * cap(a, distance)

    return search(predict, {"radius": 31.0, "modulus": 540.0}, depth, pressure, distance)


def direct(name: str) -> float:
    """Fit the pressures on the bonded cover by least squares, without blur."""
    from scipy.optimize import curve_fit

    depth, _, r = press("bonded")
    apart = np.broadcast_to(r, depth.shape).ravel()
    pressure = np.concatenate([bonded("nominal", each).pressure(r) for each in depth[:, 0]])

    def model(depth: Array, radius: float, plane: float) -> Array:
        inside = np.sqrt(np.maximum(radius * depth - apart**2, 0.0))
        return 2 * plane / (np.pi * radius) * inside

    (radius, plane), _ = curve_fit(model, depth.ravel(), pressure, p0=(31.0, 700.0))
    return float(radius if name == "radius" else 1 / (1 / (0.75 * plane) - 1 / SENSOR))


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the ball on the bonded cover, and what the fit of the thesis makes of both."""
    for name, values in BONDED.items():
        for quantity, expected, unit in zip(
            ("force", "contact_radius"), values, ("N", "mm"), strict=True
        ):
            force = unit == "N"
            yield Case(
                f"A.3: {quantity.replace('_', ' ')} of the ball at 0.59 mm, {name}, bonded cover",
                partial(
                    lambda n, q, s: s * getattr(bonded(n), q),
                    name,
                    quantity,
                    1e-3 if force else 1.0,
                ),
                Expected(expected, 0.006, unit),
                "recomputed: integral equation, 1 - L weighted by the share of the cover",
                printed=PRINTED_FORCE if force else None,
                erratum=(
                    "A 2 mm cover on a rigid plane is no half-space: bonded to it, it makes the "
                    "contact half as stiff again. The printed 1.8 N lies between the two."
                    if force
                    else ""
                ),
                reason=DIGITS,
            )
    for name, expected in (("nominal", 1.144), ("fitted", 1.078)):
        title = f"A.3: printed force of the ball over that of Hertz, {name}"
        measure = partial(lambda n: PRINTED_FORCE / (1e-3 * float(ball(n)[1].force)), name)
        source = "section A.3, recomputed: 14 % above the nominal ball, 8 % above the fitted one"
        yield Case(title, measure, Expected(expected, 1e-3), source, reason=DIGITS)
    yield from _fits()


def _fits() -> Iterator[Case]:
    for name, nominal in NOMINAL.items():
        yield Case(
            f"A.3: {name} that the fit finds over the true one, cover a half-space",
            partial(lambda n: fitted("half-space")[n] / NOMINAL[n], name),
            Expected(1.0, 0.02),
            "readings made of the nominal ball, 0.5 kPa of noise",
            printed=PRINTED_FIT[name] / nominal,
            erratum=(
                "The thesis found 32.6 mm and 570 kPa, within 6 % (5.2 and 5.6 %), and took that "
                "for proof of the array. The noise alone leaves 1 %."
            ),
            reason="noise of one press",
        )
        expected = direct(name) / nominal
        yield Case(
            f"A.3: {name} that the fit finds over the true one, cover bonded",
            partial(lambda n: fitted("bonded")[n] / NOMINAL[n], name),
            Expected(expected, 0.03 * expected),
            "second method: least squares on the pressures without blur and noise",
            printed=PRINTED_FIT[name] / nominal,
            erratum=(
                "Were the cover bonded and incompressible, the thesis's fit would find nearly the "
                "radius that the thesis found, but a ball almost twice as stiff. So the cover was "
                "softer than that, or slid on its plane, or the gain of the elements was set by "
                "the ball: the text does not say. 1.8 N, between the two readings, fits any."
            ),
            reason="the blur weighs the rim of the contact differently",
        )
