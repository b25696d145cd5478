"""A press as it is judged, and what a mesh leaves of an error of order 2."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from fefinger.mechanics.evidence.stated_errors import STATED
from fefinger.mechanics.linear import FACETS
from fefinger.results.pressure import peaks
from fefinger.results.records import Response
from fefinger.support.arrays import Array, Integers


ORDER = 2.0
"""Order in the cell length that the extrapolation assumes; contact limits it to about two."""

DEPTHS = 12
"""Evenly spaced depths of a press at which it is judged."""


@dataclass(frozen=True)
class Press:
    """A press on the way down: depth (n,) mm, force (n,) N, area (n,) mm², pressure (n,) kPa.

    pressure: the highest over 1 mm²; strain (n, 4, 3, 3) at the central end organs; at (m,): the
    numbers of the depths at which it is judged.
    """

    depth: Array
    force: Array
    area: Array
    pressure: Array
    strain: Array
    at: Integers

    @classmethod
    def of(cls, response: Response) -> Self:
        """Return the press that was answered by a ramp, without the time of first touch."""
        wanted = response.depth.max() * np.arange(1, DEPTHS + 1) / DEPTHS
        return cls(
            depth=response.depth[1:],
            **{what: curve(response, what)[1:] for what in STATED},
            at=np.searchsorted(response.depth, wanted * (1 - 1e-9)) - 1,
        )


def curve(response: Response, quantity: str) -> Array:
    """Return the "force", "pressure" (highest over 1 mm²), "area" or "strain" (n_t, ...)."""
    assert response.pad is not None
    assert response.pressure is not None
    assert response.contact_area is not None
    assert response.strain is not None
    if quantity == "pressure":
        return np.asarray(peaks(response.pad, response.pressure))
    values = {"force": response.force, "area": response.contact_area, "strain": response.strain}
    return values[quantity]


def left_on(coarser: str, finer: str) -> float:
    """Return the error of a mesh over what it changes of a coarser one, by the facets of the pad.

    Meshes are graded: facets shrink faster than the unknowns grow, and contact is on the facets.
    """
    return 1 / ((FACETS[coarser] / FACETS[finer]) ** ORDER - 1)


def norm(values: Array) -> Array:
    """Return the norms (n,) of values (n, ...), over all but the first axis."""
    return np.asarray(np.sqrt((values.reshape(len(values), -1) ** 2).sum(axis=1)))
