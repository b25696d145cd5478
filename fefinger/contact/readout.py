"""What is read of a contact after a step in real time: force, area, center of pressure, strain."""

from typing import NamedTuple

import numpy as np

from fefinger.contact.active_set import combine
from fefinger.support.arrays import Array, Floats, Integers
from fefinger.support.compiled import njit


FORCE, AREA, X, Y = 0, 1, 2, 3
"""Indices of `Readout.summary`: mN, mm² of pressed vertices, center of pressure in mm."""


class Readout(NamedTuple):
    """Maps from pressure and elastic stress to what is read, and the values last read.

    areas and projected (n,) mm², moments (2, n) mm³: integrals of the hat of each vertex,
    `projected` across the axis and of the meshed part; rows (k, n_strains): strains under unit
    elastic stresses, in single or double precision; chosen and factor (k,): work; strain
    (n_strains,); summary (4,): the center stays where it was while nothing touches.
    """

    areas: Array
    projected: Array
    moments: Array
    rows: Floats
    chosen: Integers
    factor: Floats
    strain: Floats
    summary: Array


def readout(
    areas: Array, projected: Array, moments: Array, rows: Array, kind: type[np.floating]
) -> Readout:
    """Allocate a readout; rows (k, n_strains), read in the precision `kind`."""
    return Readout(
        areas=np.array(areas, dtype=np.float64),
        projected=np.array(projected, dtype=np.float64),
        moments=np.array(moments, dtype=np.float64, order="C"),
        rows=np.ascontiguousarray(rows, dtype=kind),
        chosen=np.zeros(len(rows), dtype=np.int64),
        factor=np.zeros(len(rows), dtype=kind),
        strain=np.zeros(rows.shape[1], dtype=kind),
        summary=np.zeros(4),
    )


@njit(cache=True)
def read(out: Readout, pressure: Array, elastic: Array, share: float) -> None:
    """Update all of a readout; `share`: the strain over the strain under the elastic stress."""
    read_contact(out, pressure)
    combine(out.strain, out.rows, elastic, out.chosen, out.factor)
    if share != 1.0:
        for j in range(len(out.strain)):
            out.strain[j] *= share


@njit(cache=True)
def read_contact(out: Readout, pressure: Array) -> None:
    """Update force, area and center of pressure alone."""
    force = area = weight = x = y = 0.0
    for j in range(len(pressure)):
        if pressure[j] > 0.0:
            force += out.projected[j] * pressure[j]
            area += out.areas[j]
            weight += out.areas[j] * pressure[j]
            x += out.moments[0, j] * pressure[j]
            y += out.moments[1, j] * pressure[j]
    summary = out.summary
    summary[FORCE], summary[AREA] = force, area
    if weight > 0.0:
        summary[X], summary[Y] = x / weight, y / weight
