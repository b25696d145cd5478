"""Reference press: a small flat press of a finger that converts strain to skin displacement."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.drives import DEFAULT_DRIVE, DRIVE_BY_NAME, driven_displacements
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice, number
from fefinger.support.vocabulary import DRIVES, TYPES


SMALLEST_DRIVE = 0.02
"""Smallest reference drive over the norm of the reference strain; below, the length is noise."""


@dataclass(frozen=True)
class Reference:
    """A small flat press of the same finger, the calibration of strain as skin displacement.

    depth mm; normals (n_types, 3) and strain (n_types, 3, 3) at the central site of each of
    `types`. A drive e corresponds to a skin displacement of depth * e / e_ref, with e_ref the drive
    at the central site in this press.
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

        Raises
        ------
        InputError
            Unknown types or drives, a type that is missing in this press or whose drive in it is
            not clearly above zero, or arrays of other shapes.
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
        if not value > SMALLEST_DRIVE * norm:
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

    x_in is the drive of each site's type times its length, so that a flat probe gives the
    one-dimensional case of the thesis.

    Parameters
    ----------
    strain, normals, types
        (n_t, n_sites, 3, 3); unit normals (n_sites, 3); afferent type of each site.
    reference
        A small flat press of the same finger.
    drives
        Drive per type, where it is not DEFAULT_DRIVE.

    Raises
    ------
    InputError
        As `driven_displacements` and `Reference.lengths`.
    """
    lengths = reference.lengths(types, drives)
    chosen = {**DEFAULT_DRIVE, **(drives or {})}
    return driven_displacements(strain, normals, types, chosen, lengths)
