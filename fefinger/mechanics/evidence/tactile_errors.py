"""Errors of the tactile finger beside `solid`, as measured."""

from functools import cache

import numpy as np

from fefinger.mechanics.evidence.presses import read
from fefinger.results.touch import TouchError
from fefinger.support.arrays import Array


REPORT = "tactile-error.json"
"""Report of errors beside `solid`."""


@cache
def measured_errors() -> tuple[Array, TouchError]:
    """Return ends of ranges of penetration in mm, and the errors in each.

    Those which 95 % of the presses of REPORT keep, on loading and after it, of the presses that the
    factor of finite strain was not fitted to.
    """
    measured = read(REPORT)
    rows = [row for row in measured["rows"] if not row["fitted"]]
    parts = np.array(
        [
            [(row[each]["loading"], row[each]["later"]) for row in rows]
            for each in TouchError._fields
        ],
        dtype=float,
    )
    worst = np.fmax.reduce(parts, axis=2)
    quantile = 0.95  # share of measured presses whose error is at most the stated one
    return np.array(measured["bands_mm"][1:]), TouchError(*np.nanquantile(worst, quantile, axis=1))
