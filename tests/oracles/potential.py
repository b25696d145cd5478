"""Potential energy of a body at finite strain, independent of the derivatives that it checks."""

import numpy as np

from fefinger.fem.hyperelastic.continuum import Continuum, HistoryStress
from fefinger.fem.hyperelastic.material import PAIRS
from fefinger.support.arrays import Array


def energy(body: Continuum, values: Array, history: HistoryStress) -> float:
    """Return the potential in mN mm at the unknowns `values`: elastic, volumetric, of the past."""
    members = values[body.space.unknowns]
    moved, pressures = members[:, :30].reshape(-1, 10, 3), members[:, 30:]
    gradient = np.einsum("eni,qnk,ekj->eqij", moved, body.reference, body.jacobians)
    p = pressures @ body.shapes.T
    deformation = gradient + np.eye(3)
    c = np.swapaxes(deformation, -1, -2) @ deformation
    volume = np.linalg.det(deformation)
    trace, square = (np.trace(each, axis1=-2, axis2=-1) for each in (c, c @ c))
    one = trace * volume ** (-2 / 3) - 3
    two = (trace**2 - square) / 2 * volume ** (-4 / 3) - 3
    mu, compressibility = body.materials[:, :1], body.materials[:, 1:2]
    work = np.empty_like(one)
    for law, cells in body.laws:
        for e in cells:
            values = body.materials[e, 2 : 2 + len(law.parameters)]
            work[e] = history.gains[e, 0] * mu[e] * law.at(one[e], two[e], values).w
    work += history.gains[:, 1:] * (p * (volume - 1) - p * p * compressibility / 2)
    for row, (i, j) in enumerate(PAIRS):
        twice = 1.0 if i == j else 2.0
        work += twice * history.past[:, :, row] * (c[..., i, j] - float(i == j)) / 2
    return float((body.weights * work).sum())
