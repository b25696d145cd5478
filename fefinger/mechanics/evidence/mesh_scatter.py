"""Scatter of results between meshes of the same finger: the mesher is not deterministic."""

import numpy as np

from fefinger.mechanics.evidence.table import SCATTER, table
from fefinger.results.candidate import Candidate


DRAWN = 2.0
"""Standard deviations that a stated error includes."""


def scatter(candidate: Candidate, part: float, quantity: str) -> float:
    """Return the relative standard deviation of a quantity at a relative depth.

    The largest of the presses, measured by `linear`; the fine mesh is assumed to have that of the
    standard one. 0 without a mesh.
    """
    drawn = Candidate("linear", candidate.measured.resolution)
    rows = table().all(SCATTER, f"scatter of {quantity}", drawn)
    return max((float(np.interp(part, row.part, row.values)) for row in rows), default=0.0)
