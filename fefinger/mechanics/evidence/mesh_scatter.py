"""By what answers differ on meshes of one finger, which the mesher draws at random."""

from functools import cache
from json import loads
from typing import Any

import numpy as np

from fefinger.support.package_data import report


REPORT = "mesh-scatter.json"

DRAWN = 2.0
"""Standard deviations of it in a stated error."""


@cache
def _read() -> dict[str, Any]:
    rows: dict[str, Any] = loads(report(REPORT))["rows"]
    return rows


def scatter(candidate: str, part: float, quantity: str) -> float:
    """Return the relative standard deviation of a quantity at a depth over the thickness.

    The larger of the presses that were measured; that of the fine mesh is taken for as large as
    that of the standard one. None without a mesh.
    """
    mesh = candidate.partition(" ")[2].replace("fine", "standard")
    rows = _read().get(mesh, {}).values()
    return max((float(np.interp(part, row["part"], row[quantity])) for row in rows), default=0.0)
