"""The tactile array of the thesis under a plate: what it would read of any response."""

from typing import TYPE_CHECKING

import numpy as np

from fefinger.checks import InputError
from fefinger.scene import Flat, Indenter


if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

    from fefinger.records import Array, Pad, Result
    from fefinger.theory.sensor import ArraySensor, Reading


FINEST = 16
"""Pieces along the edge of a triangle of the pad that the array is read from, at most."""


def read(
    result: "Result", sensor: "ArraySensor | None" = None, *, seed: int | None = None
) -> "Reading":
    """Return the readings of an array on the plate, with its middle under the center of pressure.

    The array is aligned when the force is largest, as in section 3.2.1 of the thesis; its x points
    distally along the plate, its y sideways. `seed` starts the noise; None leaves it out.

    Raises
    ------
    InputError
        Without a plate or a pressure, or on a pad too coarse for the elements.
    """
    from fefinger.theory.sensor import ArraySensor

    pad, pressure = result.pad, result.pressure
    if pad is None or pressure is None:
        msg = "ask.pressure: expected true, because the array reads the pressure on the pad"
        raise InputError(msg)
    points = on_plate(result)
    heaviest = pressure[int(np.argmax(pressure @ pad.areas))] * pad.areas
    if heaviest.sum() <= 0:
        msg = "motion: expected contact, but there is no pressure to align the array by"
        raise InputError(msg)
    points = points - heaviest @ points / heaviest.sum()
    sensor = sensor or ArraySensor()
    places, areas, hats = finer(points, pad, sensor.sigma / 2)
    try:
        return sensor.read(result.time, places, areas, (hats @ pressure.T).T, seed=seed)
    except ValueError as error:
        msg = f"sensor: {error}"
        raise InputError(msg) from None


def finer(points: "Array", pad: "Pad", side: float) -> "tuple[Array, Array, csr_matrix]":
    """Return places (k, 2), areas (k,) mm² and hats (k, n): the pad cut into pieces for a sum.

    points (n, 2) mm are those of the pad in a plane; the pressure at the places is `hats` times
    that at the points, linear in each triangle, and no piece is longer than `side` mm unless that
    takes more than FINEST of them along an edge. The force is kept: each point has its own area.
    """
    from scipy.sparse import coo_matrix, diags

    corners = points[pad.triangles]
    edges = corners - np.roll(corners, 1, axis=1)
    parts = int(np.ceil(np.linalg.norm(edges, axis=2).max(initial=0.0) / side))
    parts = min(max(parts, 1), FINEST)
    local = _pieces(parts)
    places = np.einsum("qa,tad->tqd", local, corners).reshape(-1, 2)
    size = np.abs(edges[:, 1, 0] * edges[:, 2, 1] - edges[:, 1, 1] * edges[:, 2, 0]) / 2
    areas = np.repeat(size / len(local), len(local))
    rows = np.repeat(np.arange(len(places)), 3)
    columns = np.repeat(pad.triangles, len(local), axis=0).ravel()
    values = np.tile(local, (len(corners), 1)).ravel()
    hats = coo_matrix((values, (rows, columns)), shape=(len(places), len(points))).tocsr()
    owned = areas @ hats
    share = np.divide(pad.areas, owned, out=np.zeros_like(owned), where=owned > 0)
    kept = areas > 0
    return places[kept], areas[kept], (hats @ diags(share))[kept]


def _pieces(parts: int) -> "Array":
    """Return the middles (parts², 3) of the pieces of a triangle, in its three coordinates."""
    i, j = np.meshgrid(np.arange(parts), np.arange(parts), indexing="ij")
    up, down = i + j < parts, i + j < parts - 1
    one = np.concatenate([i[up] + 1 / 3, i[down] + 2 / 3]) / parts
    two = np.concatenate([j[up] + 1 / 3, j[down] + 2 / 3]) / parts
    return np.column_stack([one, two, 1 - one - two])


def on_plate(result: "Result") -> "Array":
    """Return the points of the pad (n, 2) mm as the plate sees them: distal, sideways."""
    assert result.pad is not None
    return plane(result.scene.indenter, result.pad.points)


def plane(indenter: Indenter, points: "Array") -> "Array":
    """Return points (n, 3) mm as the plate sees them, (n, 2) mm: distal, sideways.

    Raises
    ------
    InputError
        For an indenter that is no plate.
    """
    from fefinger.mechanics._touch import direction

    if not isinstance(indenter, Flat):
        msg = f"indenter: expected a plate to put the array on, received a {indenter.kind}"
        raise InputError(msg)
    axis = direction(indenter)
    distal = np.array([1.0, 0.0, 0.0]) - axis[0] * axis
    distal /= np.linalg.norm(distal)
    return np.asarray(points @ np.stack([distal, np.cross(axis, distal)], axis=1))
