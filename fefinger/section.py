"""What pictures of a finger need and no drawing library knows: mirror images, cuts, the indenter.

numpy only, so that a picture of the medial section exists where no renderer does.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fefinger.indenter import STANDARD, Flat, Grating, Relief, direction
from fefinger.profiles import Ellipsoid, Profile, frame
from fefinger.records import Array, Fields, Integers, Result


BONE = 3  # the region of rigid bone, which has no field of its own
SNAP = 1e-3  # of an edge
SAMPLES, STEPS = 1201, 8  # points of an indenter's outline; steps to the medial plane
_MIRROR = np.array([1.0, -1.0, 1.0])
_MIRROR_STRAIN = np.array([1.0, 1.0, 1.0, -1.0, -1.0, 1.0])


def nearest_frame(fields: Fields, time: float) -> int:
    """Return the index of the stored time next to `time` s."""
    return int(np.argmin(np.abs(fields.times - time)))


def peak_time(result: Result) -> float:
    """Return the time in s of the largest force."""
    return float(result.time[int(np.argmax(result.response.force))])


def is_half(points: Array) -> bool:
    """Return whether only y >= 0 is meshed."""
    return bool(points[:, 1].min() >= -1e-9 * np.ptp(points))


def whole(fields: Fields) -> Fields:
    """Return the fields of the whole finger, mirrored in the medial plane if they are half."""
    points = fields.points
    if not is_half(points):
        return fields
    off = np.flatnonzero(points[:, 1] > 1e-9 * np.ptp(points))
    image = np.arange(len(points))
    image[off] = len(points) + np.arange(len(off))
    return replace(
        fields,
        points=np.concatenate([points, points[off] * _MIRROR]),
        cells=np.concatenate([fields.cells, image[fields.cells][:, [0, 2, 1, 3]]]),
        region=np.concatenate([fields.region, fields.region]),
        displacement=np.concatenate(
            [fields.displacement, fields.displacement[:, off] * _MIRROR], axis=1
        ),
        strain=np.concatenate([fields.strain, fields.strain[:, off] * _MIRROR_STRAIN], axis=1),
        pressure=np.concatenate([fields.pressure, fields.pressure[:, off]], axis=1),
    )


@dataclass(frozen=True)
class Cut:
    """The medial section of a mesh: vertices lie on its edges, at `weight` from first to second.

    edges (n, 2) point numbers, weight (n,), triangles (k, 3) of section vertices, region (k,).
    """

    edges: Integers
    weight: Array
    triangles: Integers
    region: NDArray[np.int8]

    def at(self, nodal: Array) -> Array:
        """Return values given at the mesh points, (n_points, ...), at the section's vertices."""
        first, second = nodal[self.edges[:, 0]], nodal[self.edges[:, 1]]
        weight = self.weight.reshape(-1, *[1] * (nodal.ndim - 1))
        return np.asarray((1 - weight) * first + weight * second)

    def outlines(self) -> Integers:
        """Return the edges (m, 2) of section vertices that bound a region."""
        found = []
        for region in np.unique(self.region):
            corners = self.triangles[self.region == region]
            edges = np.sort(corners[:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2), axis=1)
            unique, count = np.unique(edges, axis=0, return_counts=True)
            found.append(unique[count == 1])
        return np.concatenate(found)


def cut(points: Array, cells: Integers, region: NDArray[np.int8]) -> Cut:
    """Cut tetrahedra with the medial plane, a hair above y = 0 so that half meshes are met."""
    level = 1e-6 * np.ptp(points)
    above = points[:, 1] > level
    count = above[cells].sum(axis=1)
    pairs, kinds = [], []
    for number in (1, 2, 3):
        hit = cells[count == number]
        order = np.argsort(~above[hit] if number < 3 else above[hit], axis=1, kind="stable")
        a, b, c, d = np.take_along_axis(hit, order, axis=1).T
        if number == 2:
            corners = [[(a, c), (a, d), (b, d)], [(a, c), (b, d), (b, c)]]
        else:
            corners = [[(a, b), (a, c), (a, d)]]
        for triangle in corners:
            pairs.append(np.array(triangle).transpose(2, 0, 1).reshape(-1, 3, 2))
            kinds.append(region[count == number])
    every = np.sort(np.concatenate(pairs).reshape(-1, 2), axis=1)
    y = points[every][:, :, 1]
    weight = (level - y[:, 0]) / (y[:, 1] - y[:, 0])
    # A vertex next to a mesh point becomes that point: slivers would show as scratches.
    every[weight < SNAP, 1] = every[weight < SNAP, 0]
    every[weight > 1 - SNAP, 0] = every[weight > 1 - SNAP, 1]
    edges, first, vertex = np.unique(every, axis=0, return_index=True, return_inverse=True)
    triangles = vertex.reshape(-1, 3)
    proper = (np.diff(np.sort(triangles, axis=1), axis=1) > 0).all(axis=1)
    kept = np.concatenate(kinds)[proper]
    return Cut(edges, np.clip(weight[first], 0.0, 1.0), triangles[proper], kept)


class Pose(NamedTuple):
    """An indenter in space: foremost point and direction of travel (3,), shape, turn in degrees."""

    origin: Array
    axis: Array
    profile: Profile
    roll: float = 0.0

    @property
    def frame(self) -> Array:
        """Rows (3, 3): the shape's two unit vectors across the travel, then the axis."""
        return frame(self.axis, self.roll)

    def places(self, across: Array) -> Array:
        """Return the points (..., 3) of the surface at places across the travel, inf beyond it."""
        height = self.profile.height(across)[0]
        frame, there = self.frame, np.isfinite(height)[..., None]
        back = np.where(there, height[..., None], 0.0) * frame[2]
        return np.where(there, self.origin + across @ frame[:2] - back, np.inf)

    def outline(self, reach: float) -> Array:
        """Return the indenter's outline (n, 2) in the medial plane, x and z in mm.

        It goes `reach` mm to either side; no rows where the plane misses the indenter.
        """
        ahead = self.axis[[0, 2]] / np.hypot(self.axis[0], self.axis[2])
        if isinstance(self.profile, Ellipsoid) and self.roll == 0:
            return self._ring(np.array([ahead[1], -ahead[0]]), ahead, self.profile.radii)
        front = self._front(reach)
        if not len(front):
            return front
        low = float((front @ ahead).min()) - 0.06 * reach
        back = front + np.outer(low - front @ ahead, ahead)
        return np.concatenate([front, back[[-1, 0]]])

    def _ring(self, along: Array, ahead: Array, radii: tuple[float, float, float]) -> Array:
        """Return the ellipse in which the medial plane cuts an ellipsoid that travels along it."""
        center = self.origin - radii[2] * self.axis
        inside = 1 - (center[1] / radii[1]) ** 2
        if inside <= 0:
            return np.empty((0, 2))
        turn = np.linspace(0, 2 * np.pi, 181)[:, None]
        ring = radii[0] * np.cos(turn) * along + radii[2] * np.sin(turn) * ahead
        return np.asarray(center[[0, 2]] + np.sqrt(inside) * ring)

    def _front(self, reach: float) -> Array:
        """Return the line (n, 2) in which the surface meets the medial plane y = 0."""
        unrolled = self._replace(roll=0.0).frame
        along = np.linspace(-reach, reach, SAMPLES)
        aside = np.full(SAMPLES, -self.origin[1] / unrolled[1, 1])
        turn = (self.frame @ unrolled.T)[:2, :2].T
        for _ in range(STEPS):
            across = np.column_stack([along, aside]) @ turn
            height = self.profile.height(across)[0]
            height = np.where(np.isfinite(height), height, 0.0)
            aside = (height * self.axis[1] - self.origin[1]) / unrolled[1, 1]
        places = self.places(across)
        return places[np.isfinite(places).all(axis=1)][:, [0, 2]]


def pose(result: Result, depth: float) -> Pose:
    """Return where the indenter is after `depth` mm of travel."""
    indenter = result.scene.indenter
    roll = getattr(indenter, "roll", 0.0)
    if isinstance(indenter, Flat | Grating | Relief):
        axis, origin = direction(indenter), np.zeros(3)
        if Flat(indenter.angle, indenter.tilt) != STANDARD and result.fields is not None:
            points = whole(result.fields).points
            origin = points[int(np.argmin(points @ axis))]
        return Pose(origin + depth * axis, axis, indenter.profile, roll)
    origin, axis = np.zeros(3), direction(STANDARD)
    at, pad = getattr(indenter, "at", None), result.pad
    if at is not None and pad is not None:
        palmar = np.where(pad.normals[:, 2] < 0, 0.0, np.inf)
        here = int(np.argmin(np.sum((pad.points[:, :2] - at) ** 2, axis=1) + palmar))
        origin, axis = pad.points[here], -pad.normals[here]
    return Pose(origin + depth * axis, axis, indenter.profile, roll)
