"""Strain-energy density of soft tissue, for pictures.

The stored energy lies between two limits, both functions of the present strain: relaxed, with the
long-time moduli, as after a long hold; and elastic, with the instantaneous moduli.

Fields hold the density of the finite elements, whose integral over the mesh is the work of the
indenter on elastic tissue. Fields of earlier versions hold only the strain at the points; the
density from it is some 20 % too large on a coarse mesh, as energy grows with the square of strain.
"""

import numpy as np

from fefinger.geometry.finger_mesh import SKIN, SUBCUTANEOUS, volumes
from fefinger.geometry.voigt import tensor_from_voigt
from fefinger.laws import LAWS
from fefinger.results.records import Fields
from fefinger.scene.finger import Finger
from fefinger.scene.tissue import Tissue
from fefinger.support.arrays import Array


INCOMPRESSIBLE = 0.49
"""Poisson's ratio above which the energy of a change of volume is left out: it is small, and the
error of the elements' volume strain, times the bulk modulus, is not."""


def density(fields: Fields, frame: int, finger: Finger, *, elastic: bool, finite: bool) -> Array:
    """Return the strain-energy density (n_points,) in kJ/m³ (which is kPa) at the mesh points.

    `elastic`: with the instantaneous moduli, otherwise the relaxed ones. `finite`: the strain is
    logarithmic, with the energy of the tissue's law; otherwise it is small, with Hooke's law. A
    point in two tissues gets the mean, weighted by the volumes of its cells; bone has none.
    """
    if fields.energy is not None:
        return np.asarray(fields.energy[frame, :, int(elastic)])
    of_skin, soft = shares(fields)
    total = np.zeros(len(fields.points))
    for tissue, part in ((finger.skin, of_skin), (finger.subcutaneous, soft - of_skin)):
        distortion, volume = split(fields.strain[frame], tissue, finite=finite)
        if elastic:
            long_time = (tissue.prony or finger.prony).long_time
            distortion = distortion / long_time
            volume = volume / long_time if finger.relaxation == "whole" else volume
        total += part * (distortion + volume)
    return total


def split(strain: Array, tissue: Tissue, *, finite: bool) -> tuple[Array, Array]:
    """Return the relaxed energy densities (n,) kPa of distortion and of the change of volume.

    Small strain e (n, 6): mu e' : e' and K / 2 (tr e)². Finite: mu W of the tissue's law at the
    principal stretches exp(e), and K / 2 (J - 1)². The second is 0 above INCOMPRESSIBLE.
    """
    shear = tissue.modulus / (2 * (1 + tissue.poisson))
    bulk = 0.0
    if tissue.poisson <= INCOMPRESSIBLE:
        bulk = tissue.modulus / (3 * (1 - 2 * tissue.poisson))
    trace = strain[:, :3].sum(axis=1)
    deviator = strain - np.where(np.arange(6) < 3, trace[:, None] / 3, 0.0)
    if not finite:
        squares = (deviator**2) @ np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
        return shear * squares, bulk / 2 * trace**2
    logs = np.linalg.eigvalsh(tensor_from_voigt(deviator))
    first, second = (np.expm1(sign * 2 * logs).sum(axis=1) for sign in (1, -1))
    distortion = shear * LAWS[tissue.law].at(first, second, tissue.law_values).w
    return distortion, bulk / 2 * np.expm1(trace) ** 2


def shares(fields: Fields) -> tuple[Array, Array]:
    """Return the skin's share (n_points,) of the soft volume at a point, and 1 where it has any."""
    volume = np.repeat(np.abs(volumes(fields.points, fields.cells))[:, None], 4, axis=1)
    skin, subcutaneous = (
        np.bincount(fields.cells[part].ravel(), volume[part].ravel(), len(fields.points))
        for part in (fields.region == SKIN, fields.region == SUBCUTANEOUS)
    )
    total = skin + subcutaneous
    return skin / np.where(total > 0, total, 1.0), (total > 0).astype(float)
