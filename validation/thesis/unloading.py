"""Eq. 3.13 of Pawluk (1997) on the way back: what it pulls, and what a contact does."""

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.oracles.fingerpad import Fingerpad
from fefinger.validation.thesis.pressure import pad

from fefinger.support.arrays import Array
from fefinger.theory.relaxation import hereditary_integral


UNLOADED = {0.0: 0.08, 2.0: -0.02, 3.7: -0.75, 4.0: -0.69, 4.5: -0.40}
"""Pressure kPa by Eq. 3.13 after a partial retraction, by distance mm (section 3.3, recomputed)."""

PLACES = tuple(UNLOADED)  # mm from the center


def pressure_as_printed(finger: Fingerpad, time: Array, depth: Array, r: Array) -> Array:
    """Return the pressure (n_t, m) kPa at r (m,) mm by Eq. 3.13 as printed.

    Valid only while the contact grows: on unloading it keeps the history of places that have
    left the contact, where the pressure becomes negative.
    """
    return hereditary_integral(finger.prony, time, finger.pressure(r, depth[:, None]))


@cache
def retracted() -> tuple[Array, Array]:
    """Return the pressures kPa at PLACES after 2 mm at 10 mm/s and back to 1 mm, means.

    First by Eq. 3.13 as printed, then right; b as printed.
    """
    means = pad("means", "instantaneous")
    parts = np.linspace(0.0, 2.0, 401), np.linspace(2.0, 1.0, 201)[1:]
    depth: Array = np.concatenate(parts, dtype=np.float64)
    time: Array = np.arange(len(depth), dtype=np.float64) * 5e-4
    r = np.array(PLACES)
    history = means.press(time, depth)
    right = history.stress(means.pressure(r, history.nodes[:, None]))
    return pressure_as_printed(means, time, depth, r)[-1], right[-1]


@cache
def printed_by_parts(r: float) -> float:
    """Return Eq. 3.13 after that motion by its integral by parts, p(t) + integral of G' p."""
    means = pad("means", "instantaneous")
    time = np.linspace(0.0, 0.3, 60_001)
    pressure = means.pressure(r, np.minimum(10 * time, 4 - 10 * time))
    weights, rates = means.prony.weights[1:], means.prony.v
    slope = sum(w * v * np.exp(-v * (0.3 - time)) for w, v in zip(weights, rates, strict=True))
    return float(pressure[-1] - np.trapezoid(slope * pressure, time))


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the pressures after a partial retraction."""
    for r, expected in UNLOADED.items():
        yield Case(
            f"3.3: pressure {r:g} mm from the center by Eq. 3.13, back from 2 to 1 mm",
            partial(lambda r: float(retracted()[0][PLACES.index(r)]), r),
            Expected(printed_by_parts(r), 1e-3, "kPa"),
            f"second method: Eq. 3.13 by parts; section 3.3, recomputed: {expected:g} kPa",
            reason="steps of 0.5 ms, where a place leaves the contact with the slope of a root",
        )
    yield Case(
        "3.3: lowest of these pressures, contact resolved",
        lambda: float(retracted()[1].min()),
        Expected(0.0, 1e-9, "kPa"),
        "skin cannot pull on a dry plate; Ting 1966",
        printed=-0.75,
        erratum=(
            "Eq. 3.13 keeps the memory of places that have left the contact, so it pulls, and "
            "outside of the contact. fefinger follows Ting and Graham."
        ),
        reason="rounding of the arithmetic",
    )
