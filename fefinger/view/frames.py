"""What of a result is shown: stored times, fields, the medial section, and the indenter."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.finger_mesh import Halves, boundary_edges
from fefinger.geometry.profiles import Plane, Profile, frame
from fefinger.results.records import Fields
from fefinger.results.result_record import ResultRecord
from fefinger.scene.indenter import direction
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError, number
from fefinger.view import quantities


def is_half(points: Array) -> bool:
    """Whether only y >= 0 is meshed."""
    return bool(points[:, 1].min() >= -1e-9 * np.ptp(points))


@dataclass(frozen=True)
class EdgePoints:
    """Points on edges of a mesh, which follow the mesh through all of its frames.

    edges (n, 2) mesh points, weight (n,): 0 at the first point of an edge, 1 at the second.
    """

    edges: Integers
    weight: Array

    def at(self, nodal: Array) -> Array:
        """Interpolate values at the mesh points, (n_points, ...), to these points."""
        first, second = nodal[self.edges[:, 0]], nodal[self.edges[:, 1]]
        weight = self.weight.reshape(-1, *[1] * (nodal.ndim - 1))
        return np.asarray((1 - weight) * first + weight * second)


@dataclass(frozen=True)
class Cut(EdgePoints):
    """The medial section of a mesh: triangles (k, 3) of its points, and region (k,) of each."""

    triangles: Integers
    region: NDArray[np.int8]

    def outlines(self) -> Integers:
        """Edges (m, 2), in section vertices, that bound a region."""
        regions = np.unique(self.region)
        return np.concatenate([boundary_edges(self.triangles[self.region == k]) for k in regions])


def cut(points: Array, cells: Integers, region: NDArray[np.int8]) -> Cut:
    """Cut tetrahedra with the medial plane.

    The plane is at 1e-6 of the size above y = 0, so that it intersects the cells of half meshes.
    """
    level = 1e-6 * np.ptp(points)
    above = points[:, 1] > level
    count = above[cells].sum(axis=1)
    pairs, kinds = [], []
    for corner_count in (1, 2, 3):
        hit = cells[count == corner_count]
        order = np.argsort(~above[hit] if corner_count < 3 else above[hit], axis=1, kind="stable")
        a, b, c, d = np.take_along_axis(hit, order, axis=1).T
        if corner_count == 2:
            corners = [[(a, c), (a, d), (b, d)], [(a, c), (b, d), (b, c)]]
        else:
            corners = [[(a, b), (a, c), (a, d)]]
        for triangle in corners:
            pairs.append(np.array(triangle).transpose(2, 0, 1).reshape(-1, 3, 2))
            kinds.append(region[count == corner_count])
    every = np.sort(np.concatenate(pairs).reshape(-1, 2), axis=1)
    y = points[every][:, :, 1]
    weight = (level - y[:, 0]) / (y[:, 1] - y[:, 0])
    # A vertex next to a mesh point becomes that point: slivers would show as scratches.
    snap = 1e-3  # distance over edge length below which a section vertex is moved to a mesh point
    every[weight < snap, 1] = every[weight < snap, 0]
    every[weight > 1 - snap, 0] = every[weight > 1 - snap, 1]
    edges, first, vertex = np.unique(every, axis=0, return_index=True, return_inverse=True)
    triangles = vertex.reshape(-1, 3)
    proper = (np.diff(np.sort(triangles, axis=1), axis=1) > 0).all(axis=1)
    regions = np.concatenate(kinds)[proper]
    return Cut(edges, np.clip(weight[first], 0.0, 1.0), triangles[proper], regions)


def requested(
    results: ResultRecord | Sequence[ResultRecord], field: str, time: float | None = None
) -> list[ResultRecord]:
    """Return one result or several as a list, if their `field` can be shown at a `time` in s.

    Raises InputError for a result without fields, an unknown field, or a time as in `check`.
    """
    every = [results] if isinstance(results, ResultRecord) else list(results)
    for result in every:
        quantities.fields_of(result)
    quantities.named("field", field)
    check("time", every, time)
    return every


def check(name: str, results: Sequence[ResultRecord], time: float | None) -> None:
    """Raise InputError for a `time` in s before the runs, or more than a step after all of them.

    Messages call the time `name`. None, the time of the peak, is always right.
    """
    if time is None:
        return
    number(name, time, at_least=0, unit="s")
    last = max(float(result.time[-1]) for result in results)
    step = max(float(result.time[-1] - result.time[-2]) for result in results)
    if time > last + step:
        raise InputError(
            f"{name}: expected a time within the run, from 0 to {last:.4g} s, "
            f"received {time:.6g} s; leave it out for the time of {results[0].peak_name}"
        )


def deviations(results: Sequence[ResultRecord], names: Sequence[str], time: float) -> list[str]:
    """Return a sentence for each result whose nearest stored time differs from `time`."""
    sentences = []
    for result, name in zip(results, names, strict=True):
        fields = quantities.fields_of(result)
        shown = float(fields.times[nearest_frame(fields, time)])
        if abs(shown - time) > 1e-6 * float(fields.times[-1]):
            which = "last" if time > fields.times[-1] else f"nearest to {time:.6g} s"
            of = f"the {which} of its {len(fields.times)} stored times"
            sentences.append(f"{name}: shown at {shown:.6g} s, {of}")
    return sentences


def nearest_frame(fields: Fields, time: float) -> int:
    """Return the index of the stored time next to `time` s."""
    return int(np.argmin(np.abs(fields.times - time)))


def peak_time(result: ResultRecord) -> float:
    """Return the time in s of the largest force, or of the largest depth under a given force."""
    return float(result.time[result.peak])


def whole(fields: Fields) -> Fields:
    """Return the fields of the whole finger, mirrored in the medial plane if they are half."""
    points = fields.points
    if not is_half(points):
        return fields
    halves = Halves.of(points, tolerance=1e-9 * float(np.ptp(points)))
    return replace(
        fields,
        points=halves.vectors(points),
        cells=halves.cells(fields.cells),
        region=np.concatenate([fields.region, fields.region]),
        displacement=halves.vectors(fields.displacement),
        strain=halves.voigt(fields.strain),
        pressure=halves.values(fields.pressure, axis=1),
        energy=None if fields.energy is None else halves.values(fields.energy, axis=1),
    )


def whole_result(result: ResultRecord) -> ResultRecord:
    """Return the result with its fields on the whole finger."""
    fields = whole(quantities.fields_of(result))
    return replace(result, response=replace(result.response, fields=fields))


SAMPLES, STEPS = 1201, 8  # points of an outline; iterations of its places in the medial plane


class Pose(NamedTuple):
    """An indenter in space: foremost point (3,) mm, direction of travel (3,), shape, and roll."""

    origin: Array
    axis: Array
    profile: Profile
    roll: float = 0.0

    @property
    def frame(self) -> Array:
        """Rows (3, 3) of unit vectors: the two directions of the shape, and the axis."""
        return frame(self.axis, self.roll)

    def places(self, across: Array) -> Array:
        """Return points (..., 3) of the surface from places (..., 2) mm across; inf beyond it."""
        height = self.profile.height(across)[0]
        frame = self.frame
        there = (np.isfinite(height) & ~self.profile.beyond(across))[..., None]
        back = np.where(there, height[..., None], 0.0) * frame[2]
        return np.where(there, self.origin + across @ frame[:2] - back, np.inf)

    def outline(self, reach: float) -> Array:
        """Return the outline (n, 2) in the medial plane, x and z in mm; n is 0 where it misses it.

        The outline goes `reach` mm to either side.
        """
        ahead = self.axis[[0, 2]] / np.hypot(self.axis[0], self.axis[2])
        if self.profile.half_axes is not None and self.roll == 0:
            return self._ring(ahead, self.profile.half_axes)
        front = self._front(reach)
        if not len(front):
            return front
        low = float((front @ ahead).min()) - 0.06 * reach
        back = front + np.outer(low - front @ ahead, ahead)
        return np.concatenate([front, back[[-1, 0]]])

    def _ring(self, ahead: Array, radii: tuple[float, float, float]) -> Array:
        """Return the ellipse (n, 2) in which the medial plane cuts an ellipsoid; `radii` in mm."""
        center = self.origin - radii[2] * self.axis
        inside = 1 - (center[1] / radii[1]) ** 2
        if inside <= 0:
            return np.empty((0, 2))
        turn = np.linspace(0, 2 * np.pi, 181)[:, None]
        along = np.array([ahead[1], -ahead[0]])
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


def pose(result: ResultRecord, depth: float, time: float | None = None) -> Pose:
    """Return the pose of the indenter after `depth` mm of travel, at a time in s if it slides.

    Without a time, for pictures of an indenter of constant shape, a sliding texture is the plane
    through its crests.
    """
    first = _first(result, depth)
    if result.lateral is None or not result.scene.motion.slides:
        return first
    if time is None:
        return first._replace(profile=Plane()) if first.profile.level else first
    shift = result.lateral.shift
    moved = np.array([np.interp(time, result.time, shift[:, k]) for k in (0, 1)])
    across, motion = frame(first.axis)[:2], result.scene.motion
    here, plate = first._replace(origin=first.origin + moved @ across), result.scene.indenter.flat
    if plate is None or not motion.turns_plate:
        return here
    normal = first.axis + motion.inclines(time, plate) @ across
    return here._replace(axis=normal / np.linalg.norm(normal))


@dataclass(frozen=True)
class Texture:
    """A sliding plate with a texture, drawn as heights that change over fixed places.

    first: its pose before it moves; shift(t) (2,) mm: how far it has moved along its plane.
    """

    first: Pose
    shift: Callable[[float], Array]

    def rise(self, time: float, points: Array) -> Array:
        """Distances (n,) mm of drawn points (n, 3) from the surface at a time in s.

        Along the direction of travel; 0 where the surface has no height.
        """
        local = (points - self.first.origin) @ self.first.frame.T
        turn = self.first.frame[:2] @ frame(self.first.axis)[:2].T
        height = self.first.profile.rise(local[:, :2] - turn @ self.shift(time))
        return np.where(np.isfinite(height), -height - local[:, 2], 0.0)


def texture(result: ResultRecord) -> Texture | None:
    """Return the texture of an indenter that slides; None where it has none."""
    first = _first(result, 0.0)
    if result.lateral is None or not result.scene.motion.slides:
        return None
    if first.profile.plane or not first.profile.level:
        return None
    return Texture(first, result.scene.motion.shift)


def _first(result: ResultRecord, depth: float) -> Pose:
    """Return the pose of the indenter before it slides."""
    indenter = result.scene.indenter
    plate, at, pad = indenter.plate, indenter.place, result.pad
    origin, axis = np.zeros(3), direction(STANDARD if plate is None else plate)
    if plate is not None:
        if plate != STANDARD.plate and result.fields is not None:
            points = whole(result.fields).points
            origin = points[int(np.argmin(points @ axis))]
    elif at is not None and pad is not None:
        palmar = np.where(pad.normals[:, 2] < 0, 0.0, np.inf)
        away = np.sum((pad.points[:, :2] - at) ** 2, axis=1) + palmar
        here = int(np.argmin(away))
        origin, axis = pad.points[here], -pad.normals[here]
        # Distance in mm from the next vertex of the pad from which on a place is beside it.
        next_to = 1.0
        if away[here] > next_to**2:  # beside the pad: it moves along z
            axis = np.array([0.0, 0.0, 1.0])
            across = (pad.points - [*at, 0.0]) @ frame(axis, indenter.turn)[:2].T
            origin = np.array([*at, (pad.points[:, 2] + indenter.profile.rise(across)).min()])
    return Pose(origin + depth * axis, axis, indenter.profile, indenter.turn)
