"""Scatter of the answers between meshes of the same finger, as the mesher is random."""

import numpy as np

from fefinger.mechanics.evidence.table import SCATTER, table
from fefinger.results.candidate import Candidate


DRAWN = 2.0
"""Standard deviations of it in a stated error."""


def scatter(candidate: Candidate, part: float, quantity: str) -> float:
    """Return the relative standard deviation of a quantity at a depth over the thickness.

    The larger of the presses that were measured, by `linear`; that of the fine mesh is taken for as
    large as that of the standard one. 0 without a mesh.
    """
    drawn = Candidate("linear", candidate.measured.resolution)
    rows = table().all(SCATTER, f"scatter of {quantity}", drawn)
    return max((float(np.interp(part, row.part, row.values)) for row in rows), default=0.0)
