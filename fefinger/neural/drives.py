"""Drives: scalar components of the strain at an end organ that excite it.

Each takes strain (..., n_sites, 3, 3), positive in tension, and the unit normals of the skin above
the sites (n_sites, 3), inward or outward, and returns a dimensionless drive (..., n_sites).
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import DRIVES


POISSON = 0.48
"""Poisson's ratio in the energy drive: that of subcutaneous tissue in the published sets."""


def compressive(strain: Array, normals: Array) -> Array:
    """Return max(0, -smallest principal strain).

    Default of SAI: the strain component that explains SAI rates best in Phillips & Johnson (1981),
    J Neurophysiol 46:1192 (as cited in thesis 4.1). Default of FAII: the corpuscle is compressed
    between indenter and bone (thesis 4.2.1), and its lamellae have no preferred tangent direction.
    """
    return np.maximum(0.0, -np.linalg.eigvalsh(strain)[..., 0])


def tensile(strain: Array, normals: Array) -> Array:
    """Return the largest principal strain (n_t, n_sites), negative where all are compressive."""
    return np.asarray(np.linalg.eigvalsh(strain)[..., 2])


def tangent(strain: Array, normals: Array) -> Array:
    """Return the largest strain in the tangent plane of the skin, with its sign.

    Default of FAI: the maximum horizontal strain of Phillips & Johnson (1981), as cited in thesis
    4.1. Default of SAII: stretch of the skin in its plane, which is what SAII units respond to
    (Edin 1992, J Neurophysiol 67:1105, hairy skin of the hand; by analogy for glabrous skin).
    """
    first, second = in_plane(normals)
    a = np.einsum("...sij,si,sj->...s", strain, first, first)
    b = np.einsum("...sij,si,sj->...s", strain, first, second)
    c = np.einsum("...sij,si,sj->...s", strain, second, second)
    return 0.5 * (a + c) + np.hypot(0.5 * (a - c), b)


def energy(strain: Array, normals: Array) -> Array:
    """Return sqrt(2 W / E), W the elastic strain-energy density at POISSON and modulus E.

    It is the strain itself in uniaxial stress. Elastic: relaxation does not lower it. Strain-energy
    density is what several finite-element studies of SAI and FAI units use, as Pham et al. (2017),
    doi:10.1371/journal.pone.0189293.
    """
    trace = np.trace(strain, axis1=-2, axis2=-1)
    squares = np.einsum("...ij,...ij->...", strain, strain)
    return np.sqrt((squares + POISSON / (1.0 - 2.0 * POISSON) * trace**2) / (1.0 + POISSON))


def von_mises(strain: Array, normals: Array) -> Array:
    """Return the equivalent strain sqrt(2/3 e:e) of the deviator e."""
    deviator = strain - np.trace(strain, axis1=-2, axis2=-1)[..., None, None] / 3.0 * np.eye(3)
    return np.sqrt(2.0 / 3.0 * np.einsum("...ij,...ij->...", deviator, deviator))


Drive = Callable[[Array, Array], Array]

DRIVE_BY_NAME: dict[str, Drive] = dict(
    zip(DRIVES, (compressive, tensile, tangent, energy, von_mises), strict=True)
)
"""What each of DRIVES computes."""

DEFAULT_DRIVE: dict[str, str] = {
    "SAI": "compressive",
    "SAII": "tangent",
    "FAI": "tangent",
    "FAII": "compressive",
}
"""Drive per afferent type; the docstring of each drive gives the source."""


def driven_displacements(
    strain: ArrayLike,
    normals: ArrayLike,
    types: Sequence[str],
    drives: Mapping[str, str],
    lengths: Mapping[str, float],
) -> Array:
    """Convert strain at end organs to x_in (n_t, n_sites) in mm: drive times length, by type.

    InputError for arrays that do not fit the types, or strain that is not finite.
    """
    strain, normals = np.asarray(strain, float), np.asarray(normals, float)
    n = len(types)
    if strain.ndim != 4 or strain.shape[1:] != (n, 3, 3) or normals.shape != (n, 3):
        raise InputError(
            f"strain, normals: expected (n_t, {n}, 3, 3) and ({n}, 3) for {n} sites, received "
            f"{strain.shape} and {normals.shape}"
        )
    if not np.isfinite(strain).all():
        raise InputError("strain: expected finite values")
    x_in = np.empty(strain.shape[:2])
    for kind in dict.fromkeys(types):
        of_kind = np.array([other == kind for other in types])
        x_in[:, of_kind] = lengths[kind] * DRIVE_BY_NAME[drives[kind]](
            strain[:, of_kind], normals[of_kind]
        )
    return x_in


def in_plane(normals: Array) -> tuple[Array, Array]:
    """Return two unit vectors (n_sites, 3) across each normal, at right angles to each other.

    InputError for normals that are not unit vectors.
    """
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    if not np.all(np.abs(length - 1.0) < 1e-6):
        msg = f"normals: expected unit vectors, received lengths {length.ravel().tolist()}"
        raise InputError(msg)
    axis = np.eye(3)[np.argmin(np.abs(normals), axis=-1)]
    across: Array = np.cross(normals, axis)
    across /= np.sqrt(np.sum(across**2, axis=-1, keepdims=True))
    return across, np.cross(normals, across)
