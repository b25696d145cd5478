"""What is drawn of a Result in space: surfaces, lines and marks of end organs or units.

PyVista (`plot3d`) and the page for a browser (`fefinger.pages.viewer`) draw the same record.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from fefinger.neural.trains import FEW, SpikeTrains
from fefinger.results.records import Fields, Sites
from fefinger.results.result_record import ResultRecord
from fefinger.scene.schema import column, split
from fefinger.support.arrays import Array, Integers
from fefinger.support.text import flat
from fefinger.view import frames, quantities, surfaces
from fefinger.view.surfaces import Piece


MOST = 3  # differences in a title
SHOWN = ("indenter.", "motion.", "finger.")  # the outputs of a scene do not change its picture
SUBJECT = "finger.subject"
SIZES = ("finger.width", "finger.thickness", "finger.pad_radius")  # set by the subject
OFF_PLANE = 0.5  # mm from the cut within which end organs of a population are marked


@dataclass(frozen=True)
class Marks:
    """Marks (n,) that follow the mesh: their types, labels, and the units that they belong to.

    Of marks with the same label all but the most distal one have an empty label. `trains` of the
    units are None where the scene asks for no spikes.
    """

    followed: surfaces.Followed
    types: tuple[str, ...]
    labels: tuple[str, ...]
    units: Integers
    trains: SpikeTrains | None

    def rates(self, time: float) -> Array:
        """Return the rate in Hz of the unit of each mark at a time in s; needs `trains`."""
        assert self.trains is not None
        return np.array([float(self.trains.rate(int(unit), time)) for unit in self.units])


def marks_in_section(result: ResultRecord) -> Marks | None:
    """Return a mark per end organ; of a population only of those within OFF_PLANE of the cut."""
    sites = result.sites
    if sites is None:
        return None
    chosen = np.arange(len(sites.types))
    if len(chosen) > FEW:
        chosen = np.flatnonzero(np.abs(sites.points[:, 1]) <= OFF_PLANE)
    return _marks(result, sites, sites.points[chosen], chosen, _units(sites)[chosen])


def marks_on_skin(result: ResultRecord) -> Marks | None:
    """Return a mark per unit of a population, on the skin above the middle of its end organs."""
    sites = result.sites
    if sites is None or len(sites.types) <= FEW:
        return None
    above = sites.points + sites.depths[:, None] * sites.normals
    units, first, unit, count = np.unique(
        _units(sites), return_index=True, return_inverse=True, return_counts=True
    )
    places = np.stack([np.bincount(unit, above[:, k]) / count for k in range(3)], axis=1)
    return _marks(result, sites, places, first, units)


def _units(sites: Sites) -> Integers:
    """Return the unit of each site (n_sites,); one each where they are not of a population."""
    return np.arange(len(sites.types)) if sites.unit is None else sites.unit


def _marks(
    result: ResultRecord, sites: Sites, points: Array, chosen: Integers, units: Integers
) -> Marks | None:
    """Return marks at points (n, 3) with types and depths of chosen sites (n,); None if n is 0."""
    if not len(points):
        return None
    types = tuple(sites.types[i] for i in chosen)
    labels = [f"{kind} {sites.depths[i]:g} mm" for kind, i in zip(types, chosen, strict=True)]
    shown = {labels[i]: i for i in np.argsort(points[:, 0], kind="stable").tolist()}
    first = tuple(label if shown[label] == i else "" for i, label in enumerate(labels))
    followed = surfaces.follow(quantities.fields_of(result), points)
    return Marks(followed, types, first, units, result.spikes)


def leader_order(marks: Array, ends: Array) -> list[int]:
    """Assign a mark (n, 2) to each end (n, 2) of a leader line, so that no lines cross.

    The leaders are the shortest in all: two that cross would be shorter with their ends swapped.
    """
    from scipy.optimize import linear_sum_assignment
    from scipy.spatial.distance import cdist

    return [int(mark) for mark in linear_sum_assignment(cdist(ends, marks))[1]]


def highest_rate(result: ResultRecord) -> float:
    """Return the highest rate in Hz of any unit at any stored time; 0 without spikes."""
    if result.spikes is None:
        return 0.0
    times = quantities.fields_of(result).times
    return max(float(result.spikes.rate(unit, times).max()) for unit in range(len(result.spikes)))


@dataclass(frozen=True)
class Drawing:
    """The surfaces, lines and marks of a result with fields, and the title above it.

    lines: outlines of the cut, None if the finger is whole; marks: of end organs in the cut, or of
    units on the skin of a whole finger.
    """

    result: ResultRecord
    surfaces: tuple[Piece, ...]
    lines: Piece | None
    marks: Marks | None
    title: str

    @property
    def fields(self) -> Fields:
        """The fields of the result."""
        return quantities.fields_of(self.result)

    @property
    def whole(self) -> bool:
        """Whether the finger is drawn whole."""
        return self.lines is None


def drawing(result: ResultRecord, field: str, title: str) -> Drawing:
    """Return the drawing that shows a field: the whole finger for pressure, else the cut one.

    Raises InputError if the field is unknown or there are no fields.
    """
    if quantities.named("field", field) != "pressure":
        return cut_open(result, title)
    result = frames.whole_result(result)
    pieces = surfaces.entire(quantities.fields_of(result))
    return Drawing(result, pieces, None, marks_on_skin(result), title)


def cut_open(result: ResultRecord, title: str) -> Drawing:
    """Return the drawing of the half finger behind the medial plane, and of its end organs."""
    fields = quantities.fields_of(result)
    pieces, lines = surfaces.cut_open(fields), surfaces.outlines(fields)
    return Drawing(result, pieces, lines, marks_in_section(result), title)


def colors(
    drawings: Sequence[Drawing], field: str, limits: tuple[float, float] | None = None
) -> quantities.Span:
    """Return the range of colors of a field in the soft tissue of all drawings at all times."""

    def values(drawn: Drawing, frame: int) -> Array:
        nodal = quantities.values(drawn.result, field, frame)
        soft = [piece for piece in drawn.surfaces if piece.name in surfaces.SOFT]
        return np.concatenate([piece.at(nodal) for piece in soft])

    every = (values(each, frame) for each in drawings for frame in range(len(each.fields.times)))
    return quantities.span(every, field, limits)


def titles(
    results: Sequence[ResultRecord], folders: Sequence[str | PathLike[str]] = ()
) -> tuple[str, ...]:
    """Return a title for each result: the name of its scene, and of its folder if they are several.

    The first MOST values follow in which the scenes differ.
    """
    names = [result.scene.name for result in results]
    if len(results) == 1:
        return tuple(names)
    if folders:
        ours = [Path(folder).resolve() for folder in folders]
        folder_names = [path.parent.name if path.suffix == ".nc" else path.name for path in ours]
        names = [folder if folder == name else f"{folder}: {name}"
                 for folder, name in zip(folder_names, names, strict=True)]  # fmt: skip
    tables = [dict(flat(result.scene.to_dict())) for result in results]
    every = dict.fromkeys(key for table in tables for key in table if key.startswith(SHOWN))
    varied = [key for key in every if len({repr(table.get(key)) for table in tables}) > 1]
    kinds = {key.removesuffix("kind") for key in varied if key.endswith(".kind")}
    # Other values of parts of different kinds are not comparable.
    varied = [key for key in varied if key.endswith(".kind") or not key.startswith(tuple(kinds))]
    if SUBJECT in varied:
        varied = [key for key in varied if key not in SIZES]
    varied.sort(key=lambda key: (not key.endswith(".kind"), SHOWN.index(key.split(".")[0] + ".")))
    return tuple(
        ", ".join([name, *_differences(table, varied)])
        for name, table in zip(names, tables, strict=True)
    )


def _differences(table: Mapping[str, object], varied: Sequence[str]) -> Iterator[str]:
    long = 24  # letters of a value in a title
    for key in varied[:MOST]:
        value = table.get(key, "none")
        text = f"{value:g}" if isinstance(value, float) else str(value)
        if not isinstance(value, str):
            text = f"{text} {split(column(key, str(table['motion.kind'])))[1]}".strip()
        yield f"{key} {text}" if len(text) <= long else f"another {key}"
    if len(varied) > MOST:
        yield f"{len(varied) - MOST} more"
