"""What of a result is shown: stored times, fields of whole fingers, and the medial section."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.finger_mesh import boundary_edges
from fefinger.geometry.mirror import Halves
from fefinger.results.records import Fields
from fefinger.results.result_record import ResultRecord
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
