"""By what answers differ on meshes of one finger, which the mesher draws at random."""

from functools import cache
from json import loads
from typing import Any

import numpy as np

from fefinger.results.candidate import Candidate
from fefinger.support.package_data import report


REPORT = "mesh-scatter.json"

DRAWN = 2.0
"""Standard deviations of it in a stated error."""


@cache
def _read() -> dict[str, Any]:
    rows: dict[str, Any] = loads(report(REPORT))["rows"]
    return rows


def scatter(candidate: Candidate, part: float, quantity: str) -> float:
    """Return the relative standard deviation of a quantity at a depth over the thickness.

    The larger of the presses that were measured; that of the fine mesh is taken for as large as
    that of the standard one. 0 without a mesh.
    """
    rows = _read().get(candidate.measured.resolution or "", {}).values()
    return max((float(np.interp(part, row["part"], row[quantity])) for row in rows), default=0.0)
