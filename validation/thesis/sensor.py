"""Appendix A of Pawluk (1997): the tactile array, its blur and its rubber ball."""

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.thesis.array import GRAM_FORCE
from fefinger.validation.thesis.lumped import DIGITS
from fefinger.validation.thesis.pressure import BALL_DEPTH, BALLS, ball

from fefinger.calibration.array_sensor import ArraySensor, blurred
from fefinger.support.arrays import Array
from fefinger.theory.contact.hertz import Hertz


FILTERED = ((0, 39.4), (1, 38.1), (2, 34.0), (3, 25.7), (4, 13.8), (5, 4.1), (6, 0.57))
"""Distance in mm and blurred pressure in kPa of Figure A-5, fitted ball (recomputed)."""


def ball_pressure() -> Hertz:
    """Return the fitted ball of Figure A-5 as a Hertz contact of the same E*."""
    plane, _ = ball("fitted")
    return Hertz(BALLS["fitted"][0], BALL_DEPTH, 0.75 * plane, 0.5)


def array_pressure(r: Array) -> Array:
    """Simulate the readings of the array on the fitted ball at distances in mm, in kPa."""
    hertz = ball_pressure()
    return blurred(hertz.pressure, hertz.contact_radius, r)


def felt_force() -> float:
    """Return the integral of `array_pressure` in N."""
    r = np.linspace(0.0, 12.0, 2401)
    return float(np.trapezoid(2 * np.pi * r * array_pressure(r), r)) / 1e3


@cache
def coupling() -> Array:
    """Share of a load as large as one element that the elements read.

    The load is a pressure at the center of one element; the response of each is the Gaussian at
    its distance from there.
    """
    sensor = ArraySensor(elements=9)
    one = np.zeros((1, 2))
    response = sensor.weights(one, np.array([1.0]))[:, 0]
    return np.asarray((response / response.sum()).reshape(9, 9))


def neighbor(rows: int, columns: int) -> float:
    """Return the part of the total that the element so far away feels."""
    return float(coupling()[4 + rows, 4 + columns])


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the blur, the coupling and the noise."""
    for r, expected in FILTERED:
        yield Case(
            f"Figure A-5: filtered pressure of the fitted ball at {r} mm",
            partial(lambda r: float(array_pressure(np.array([float(r)]))[0]), r),
            Expected(expected, 0.006 if expected < 1 else 0.06, "kPa"),
            "section A.3, recomputed: Eq. A.4 on a grid",
            reason=DIGITS,
        )
    name = "Figure A-5: force under the filtered pressure, fitted ball"
    source = "section A.3, recomputed; the blur conserves force"
    yield Case(name, felt_force, Expected(1.670, 6e-4, "N"), source, reason=DIGITS)
    yield from _coupling()
    yield Case(
        "3.2: noise of 0.5 kPa on an element of 2 x 2 mm",
        lambda: ArraySensor().noise * ArraySensor().pitch ** 2 / GRAM_FORCE,
        Expected(0.204, 6e-4, "gf"),
        "section 3.2, recomputed",
        printed=1.2,
        erratum="The quoted 1.2 g fits neither the area of an element nor that of its Gaussian.",
        reason=DIGITS,
    )
    yield Case(
        "3.2: samples per second of 64 elements at 200 Hz",
        lambda: ArraySensor().elements ** 2 * ArraySensor().rate / 1e3,
        Expected(12.8, 0.05, "kHz"),
        "section 3.2, recomputed",
        erratum="The text has both 13 and 13.5 kHz; 12.8 is 13 in two digits.",
        reason=DIGITS,
    )


def _coupling() -> Iterator[Case]:
    for name, rows, columns, over_center, expected, printed in (
        ("a neighbor over the center", 0, 1, True, 0.1142, 0.11),
        ("the center in the total", 0, 0, False, 0.662, None),
        ("a neighbor in the total", 0, 1, False, 0.0756, 0.08),
        ("a diagonal neighbor in the total", 1, 1, False, 0.0086, 0.01),
    ):
        yield Case(
            f"3.2: coupling of the elements, {name}",
            partial(
                lambda i, j, c: neighbor(i, j) / (neighbor(0, 0) if c else 1.0),
                rows,
                columns,
                over_center,
            ),
            Expected(expected, 6e-4 if expected == 0.662 else 6e-5),
            "section 3.2, recomputed",
            printed=printed if over_center else None,
            erratum="Chapter 3 has less than 11 %; appendix A divides the same by the total."
            if over_center
            else "",
            reason=DIGITS,
        )
