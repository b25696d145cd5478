"""Gap between a pad with or without ridges and any object, over the points of a grid.

The pad is a paraboloid on flat layers; the object its heights, of which the skin meets those that
lie ahead of its undeformed points.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from scipy import fft

from fefinger.geometry.profiles import Profile, frame
from fefinger.mechanics.press import axisymmetric
from fefinger.mechanics.press.axisymmetric import Touch
from fefinger.mechanics.press.layer_grid import LayerGrid
from fefinger.results.records import Pad
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter, direction
from fefinger.scene.indenters import STANDARD
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Ridges
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import InputError
from fefinger.theory.contact.stack import Stack


PER_FEATURE = 10.0
"""Grid points in the narrowest part or gap of an object."""

PER_RADIUS = 1.5
"""Grid points in the radius of its sharpest crest."""

PER_RIDGE = 11.0
"""Grid points in a ridge of the skin: with 7.5 FAII fire 14 % more over dots, with 17 2 % more
(`reports/ridges.json`)."""

PER_DEPTH = 6.0
"""Grid points in the depth of the shallowest end organ."""

PER_CONTACT = 48
"""Grid points across the contact of a smooth object."""


@dataclass(frozen=True)
class LayerGap:
    """Gap between the pad and an object over the points of a grid.

    places (n, n, 2) mm; profile, turned by `turn` (2, 2); radius of the pad in mm.
    """

    places: Array
    profile: Profile
    turn: Array
    radius: float
    ridges: Ridges | None
    lift: float = 0.0

    @classmethod
    def of(cls, scene: Scene, axis: Array, grid: LayerGrid) -> Self:
        """Return the gap of a scene at first touch, at a depth of 0, before it moves."""
        indenter, finger = scene.indenter, scene.finger
        turn = frame(axis, indenter.turn)[:2] @ frame(axis)[:2].T
        gap = cls(grid.places, indenter.profile, turn, finger.pad_radius, finger.ridges)
        lowest = np.unravel_index(int(np.argmin(gap((0.0, 0.0)))), grid.places.shape[:2])
        seen = 20  # points to a side within a cell of the grid at which first touch is sought
        cell = np.linspace(-grid.spacing, grid.spacing, 2 * seen + 1)
        around = np.stack(np.meshgrid(cell, cell, indexing="ij"), axis=-1)
        near = replace(gap, places=grid.places[lowest] + around)
        return replace(gap, lift=float(near((0.0, 0.0)).min()))

    @cached_property
    def pad(self) -> Array:
        """Distance (n, n) mm of the skin from the plane of first touch."""
        bowl = np.sum(self.places**2, axis=-1) / (2 * self.radius) - self.lift
        return bowl if self.ridges is None else bowl + self.ridges.valleys(self.places)

    def __call__(self, shift: tuple[float, float]) -> Array:
        """Return the gap (n, n) mm at a depth of 0, with the object at a place (2,) mm."""
        if self.profile.plane:
            return self.pad
        return np.asarray(self.pad + self.profile.rise(self._on_object(self.places, shift)))

    def _on_object(self, places: Array, shift: tuple[float, float]) -> Array:
        return np.asarray((places - np.asarray(shift)) @ self.turn.T)

    def push(self, shift: tuple[float, float], pressure: Array) -> Array:
        """Return the force (2,) kPa of a pressure (n²,), summed, on inclined heights."""
        if self.profile.plane:
            return np.zeros(2)
        loaded = np.flatnonzero(pressure)
        places = self._on_object(self.places.reshape(-1, 2)[loaded], shift)
        return np.asarray(pressure[loaded] @ self.profile.incline(places) @ self.turn)


def first_touch(finger: Finger, indenter: Indenter) -> Touch | None:
    """Return the first touch on the spherical pad, or None if the place is not on it."""
    plate = indenter.plate
    if plate is None:
        return axisymmetric.touch(finger, indenter)
    axis = direction(plate)
    return Touch(finger.pad_radius * (direction(STANDARD) - axis), axis)


def spacing(finger: Finger, indenter: Indenter, reach: float, shallowest: float) -> float:
    """Return the distance in mm of the grid points for a contact of a radius of `reach` mm.

    shallowest: depth in mm of the end organ nearest to the skin.
    """
    ridges = finger.ridges
    widths = [2 * reach / PER_CONTACT, shallowest / PER_DEPTH]
    if indenter.hertzian is None:
        part = min(indenter.feature, indenter.narrowest)
        widths += [part / PER_FEATURE, indenter.least_radius / PER_RADIUS]
    if ridges is not None and ridges.height > 0:
        widths.append(ridges.pitch / PER_RIDGE)
    return min(widths)


def grid_of(layers: Stack, reach: float, step: float) -> LayerGrid:
    """Return the grid for a contact of a radius of `reach` mm, with points `step` mm apart.

    InputError if it would not fit into memory.
    """
    around = 1.0  # free skin about the contact, both sides together, in thicknesses of the layers
    most = 1024  # most grid points of a side: half a GB, and a second a step
    side = 2 * reach + around * layers.thickness
    points = math.ceil(side / step)
    if points <= most:
        points = fft.next_fast_len(points)
    while points <= most and points % 2:
        points = fft.next_fast_len(points + 1)
    if points > most:
        raise InputError(
            f"indenter: expected an object whose contact, {2 * reach:.3g} mm wide, a grid of "
            f"{most} points a side resolves, received one that needs points {step:.2g} mm apart, "
            f"{points:.4g} a side; take rounder edges, or larger parts or ridges, or press less"
        )
    return LayerGrid(layers, points, step, width=reach / 2)


def check_ridges(ridges: Ridges | None, reach: float) -> None:
    """Raise InputError for ridges of the skin that are coarser than the contact."""
    if ridges is not None and ridges.pitch > 2 * reach:
        raise InputError(
            f"finger.ridges.pitch: expected less than the width of the contact, {2 * reach:.3g} "
            f"mm, received {ridges.pitch:g} mm; press deeper, or leave the ridges out"
        )


def window(kept: Array) -> tuple[slice, slice]:
    """Return the part of blocks (n_t, m, m) that a pressure ever touches, and one block around."""
    touched: Flags = np.any(kept > 0.0, axis=0)
    part = []
    for axis in (1, 0):
        at = np.flatnonzero(touched.any(axis=axis))
        first, last = (at[0], at[-1]) if len(at) else (0, 1)
        part.append(slice(max(first - 1, 0), min(last + 2, len(touched))))
    return part[0], part[1]


def pad_of(
    first: Touch, grid: LayerGrid, gap: LayerGap, block: int, part: tuple[slice, slice]
) -> Pad:
    """Return the pad on which pressure is kept: a part of the middles of blocks of points.

    They lie on the paraboloid and its ridges.
    """
    step = grid.spacing * block
    count = math.ceil(grid.points / block)
    lines = grid.lines[0] + grid.spacing * (block - 1) / 2 + step * np.arange(count)
    places = np.stack(np.meshgrid(lines[part[0]], lines[part[1]], indexing="ij"), axis=-1)
    away = replace(gap, places=places).pad + gap.lift
    across = frame(first.axis)[:2]
    points = first.origin + places @ across + away[..., None] * first.axis
    normals = places @ across / gap.radius - first.axis
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    index = np.arange(places.size // 2).reshape(places.shape[:2])
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.concatenate([np.stack(x, -1).reshape(-1, 3) for x in ((a, c, b), (a, d, c))])
    areas = np.full(index.size, step**2)
    return Pad(points.reshape(-1, 3), areas, normals.reshape(-1, 3), triangles)
