"""Units: of forces inside the package, and hints at wrong units of what users give.

All readers use these hints, so that a wrong unit is found with the same words everywhere.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fefinger.support.arrays import Array


NEWTON_PER_MILLINEWTON = 1e-3
"""Conversion of forces inside the package, kPa mm² = mN, to reported forces in N."""

SLOW = 0.5
"""Interval in s between samples of a recorder from which on their times may be in ms."""


@dataclass(frozen=True)
class Likely:
    """Usual range of a quantity, and the units that sizes outside of the range suggest.

    what: name of the quantity; low and high in `unit`; others: (unit, least, most), sizes in `unit`
    for which another unit is likely.
    """

    what: str
    unit: str
    low: float
    high: float
    others: tuple[tuple[str, float, float], ...]

    def hint(self, size: float) -> str:
        """Return words on the likely unit of a size outside of the range; "" inside."""
        if self.low <= size <= self.high:
            return ""
        units = [unit for unit, least, most in self.others if least <= size <= most]
        return f", as if it were in {units[0]}" if units else ""


TRAVEL = Likely("travel", "mm", 0.05, 50.0, (("m", 0.0, 0.05), ("um", 50.0, math.inf)))
FORCE = Likely(
    "largest force",
    "N",
    0.02,
    50.0,
    (("kN", 0.0, 0.02), ("mN or grams of force", 50.0, 1000.0), ("mN", 1000.0, math.inf)),
)
DURATION = Likely(
    "duration",
    "s",
    0.05,
    1000.0,
    (("minutes, or ended before a hold", 0.0, 0.05), ("ms", 1000.0, math.inf)),
)
MODULUS = Likely("modulus", "kPa", 0.5, 5000.0, (("MPa", 0.0, 0.5), ("Pa", 5000.0, math.inf)))
"""Of soft tissue: published ones are 2 to 500 kPa, relaxed."""

PRESS = Likely("depth", "mm", 0.01, 50.0, (("m", 0.0, 0.01),))
"""Of a press or a probe; vibrations alone are smaller."""

LOADED = Likely("force", "N", 1e-5, 50.0, (("kN", 0.0, 1e-5),))
"""The lightest filament of von Frey bends at 8e-5 N."""

SLOWEST = 0.05
"""Speed in mm/s, or rate in N/s, below which no one presses within a thousand samples."""

MESHED = 5.0, 40.0
"""Least and largest width and thickness in mm of a finger that a mesh is made for."""

FINGER = Likely("size", "mm", 1.0, 1e5, (("m", 0.0, 0.1), ("cm", 0.1, 1.0)))
"""A ball of rubber of 124 mm is a finger of the protocol p10, one of many meters a half-space."""


def in_milliseconds(time: Array) -> bool:
    """Return whether times (n,) are likely in ms, not s: many samples, too far apart."""
    # Number of samples from which on times are taken to be of a recorder, not written by hand.
    recorded = 64
    return len(time) >= recorded and float(np.median(np.diff(time))) >= SLOW


def seconds_or_milliseconds(
    time: Array, advice: str = "name the column time_ms, or time_s if they are in s"
) -> str:
    """Return a sentence on times that are likely in ms, with `advice` on what to do."""
    return (
        f"expected s, received {len(time)} samples {float(np.median(np.diff(time))):g} apart, as "
        f"if they were in ms; {advice}"
    )


def fitting(size: float, units: Mapping[str, float], low: float, high: float) -> str:
    """Return words on the first of `units`, by their sizes, in which a size is usual, or ""."""
    fits = [unit for unit, length in units.items() if low <= size * length <= high]
    return f", as if it were in {fits[0]}" if fits else ""
