"""Errors of the tactile finger beside `solid`, as measured."""

from functools import cache

import numpy as np

from fefinger.mechanics.evidence.presses import read
from fefinger.support.arrays import Array


REPORT = "tactile-error.json"
"""Report of errors beside `solid`."""

QUANTILE = 0.95
"""Share of measured presses whose error is at most the stated one."""


@cache
def measured_errors() -> tuple[Array, Array]:
    """Return ends of ranges of penetration in mm, and the error of the force in each.

    That which 95 % of the presses of REPORT keep, on loading and after it.
    """
    measured = read(REPORT)
    rows = np.array([[row["loading"], row["later"]] for row in measured["rows"]])
    return np.array(measured["bands_mm"][1:]), np.quantile(rows.max(axis=1), QUANTILE, axis=0)
