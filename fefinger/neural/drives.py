"""Drives: scalar components of the strain at an end organ that excite it, and their calibration.

A drive takes strain (..., n_sites, 3, 3), positive in tension, and the unit normals (n_sites, 3) of
the skin above the sites, inward or outward, and returns a dimensionless array (..., n_sites).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice, number
from fefinger.support.vocabulary import DRIVES, TYPES


POISSON = 0.48
"""Poisson's ratio in the energy drive: subcutaneous tissue in the published sets."""


def compressive(strain: Array, normals: Array) -> Array:
    """Return max(0, -smallest principal strain).

    Default of SAI: the strain component that explains SAI rates best in Phillips & Johnson (1981),
    J Neurophysiol 46:1192 (as cited in thesis 4.1). Default of FAII: the corpuscle is compressed
    between indenter and bone (thesis 4.2.1), and its lamellae have no preferred tangent direction.
    """
    from fefinger.support.tensors import extremes  # compiled

    return np.maximum(0.0, -extremes(strain)[0])


def tensile(strain: Array, normals: Array) -> Array:
    """Return the largest principal strain (n_t, n_sites), negative where all are compressive."""
    from fefinger.support.tensors import extremes  # compiled

    return extremes(strain)[1]


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

    strain (n_t, n_sites, 3, 3); unit normals (n_sites, 3) and `types` (n_sites,) of the sites;
    `drives` and `lengths` (mm per unit of drive) by type. InputError for arrays that do not fit,
    or strain that is not finite.
    """
    strain, normals = np.asarray(strain), np.asarray(normals, float)
    n = len(types)
    if strain.ndim != 4 or strain.shape[1:] != (n, 3, 3) or normals.shape != (n, 3):
        raise InputError(
            f"strain, normals: expected (n_t, {n}, 3, 3) and ({n}, 3) for {n} sites, received "
            f"{strain.shape} and {normals.shape}"
        )
    if not np.isfinite(strain).all():
        raise InputError("strain: expected finite values")
    x_in = np.empty(strain.shape[:2])
    # End organs whose drive is computed together, so that a population needs little memory.
    block = 256
    for kind in dict.fromkeys(types):
        of_kind = np.flatnonzero([other == kind for other in types])
        for some in np.split(of_kind, range(block, len(of_kind), block)):
            drive = DRIVE_BY_NAME[drives[kind]](strain[:, some], normals[some])
            x_in[:, some] = lengths[kind] * drive
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


@dataclass(frozen=True)
class Reference:
    """A small flat press of the same finger, which calibrates strain as skin displacement.

    depth in mm; normals (n_types, 3) and strain (n_types, 3, 3) at the central site of each of
    `types`. A drive e corresponds to a skin displacement of depth * e / (drive in this press).
    """

    depth: float
    types: tuple[str, ...]
    normals: Array
    strain: Array

    def lengths(
        self, types: Sequence[str], drives: Mapping[str, str] | None = None
    ) -> dict[str, float]:
        """Skin displacement L in mm per unit of drive, by type: depth / drive in this press.

        `drives` names the drive of a type, where it is not DEFAULT_DRIVE.

        Raises InputError for unknown types or drives, a type that is missing in this press or whose
        drive in it is not clearly above zero, or arrays of other shapes.
        """
        for kind in types:
            choice("types", kind, TYPES)
        chosen = {**DEFAULT_DRIVE, **(drives or {})}
        for kind, name in chosen.items():
            choice("drives", kind, TYPES)
            choice(f"drives.{kind}", name, DRIVES)
        number("reference.depth", self.depth, above=0.0, unit="mm")
        n, strain, normals = len(self.types), np.shape(self.strain), np.shape(self.normals)
        if strain != (n, 3, 3) or normals != (n, 3):
            raise InputError(
                f"reference.strain, reference.normals: expected ({n}, 3, 3) and ({n}, 3) for {n} "
                f"types, received {strain} and {normals}"
            )
        return {kind: self._length(kind, chosen[kind]) for kind in types}

    def _length(self, kind: str, drive: str) -> float:
        """Skin displacement in mm per unit of drive of one type."""
        if kind not in self.types:
            raise InputError(f"reference.types: expected every type in use, {kind} is missing")
        i = self.types.index(kind)
        value = float(DRIVE_BY_NAME[drive](self.strain[i : i + 1], self.normals[i : i + 1])[0])
        norm = float(np.linalg.norm(self.strain[i]))
        # Smallest reference drive over the norm of the reference strain; below, the length is
        # noise.
        smallest_drive = 0.02
        if not value > smallest_drive * norm:
            raise InputError(
                f"drives.{kind}: the drive {drive!r} is {value:.3g} at the site of {kind} in the "
                f"reference press of {self.depth:g} mm, against a strain of {norm:.3g}; expected "
                "it clearly above zero; choose another drive or another depth of the site"
            )
        return self.depth / value


def equivalent_displacements(
    strain: ArrayLike,
    normals: ArrayLike,
    types: Sequence[str],
    reference: Reference,
    *,
    drives: Mapping[str, str] | None = None,
) -> Array:
    """Convert strain at end organs to equivalent skin displacement x_in (n_t, n_sites) in mm.

    As `driven_displacements`, with the lengths of a reference press, so that a flat probe gives the
    one-dimensional case of the thesis. `drives`: drive per type, where it is not DEFAULT_DRIVE.

    Raises InputError as `driven_displacements` and `Reference.lengths`.
    """
    lengths = reference.lengths(types, drives)
    chosen = {**DEFAULT_DRIVE, **(drives or {})}
    return driven_displacements(strain, normals, types, chosen, lengths)
