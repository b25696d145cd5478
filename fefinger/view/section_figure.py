"""The medial section of the finger as a figure: a field, the regions, indenter and end organs.

matplotlib draws it, without a renderer.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fefinger.geometry.finger_mesh import BONE
from fefinger.neural.trains import FEW
from fefinger.results.result_record import ResultRecord
from fefinger.support.arrays import Array, Integers
from fefinger.view import figures, frames, quantities
from fefinger.view.drawing import OFF_PLANE, leader_order


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CLOSE = 3.5  # mm: half the width of the close view
LEADER = {"arrowstyle": "-", "color": figures.INK, "linewidth": 0.8, "relpos": (0.0, 0.5),
          "shrinkA": 0.0}  # fmt: skip


def draw(
    result: ResultRecord, *, field: str = quantities.DEFAULT, time: float | None = None
) -> "Figure":
    """Draw the deformed medial section, colored by a field, and a close view of the end organs.

    At the stored time next to `time` s, by default that of the largest force, or of the largest
    depth where the force is prescribed. Raises InputError if the result has no fields or the field
    is unknown.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    fields = quantities.fields_of(result)
    moment = frames.peak_time(result) if time is None else time
    cut = medial(result, field, frames.nearest_frame(fields, moment))
    with figures.style():
        drawn = figures.figure(figures.WIDE, 4.4)
        whole, close = drawn.subplots(1, 2, width_ratios=[1.35, 1.0])
        margin = 1.2  # mm about the section
        low, high = cut.places.min(axis=0) - margin, cut.places.max(axis=0) + margin
        for axis in (whole, close):
            _draw_section(axis, cut)
            axis.set(aspect="equal", xlabel="x (distal) / mm", ylabel="z (dorsal) / mm")
        whole.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), title=cut.title)
        center = cut.indenter.mean(axis=0)
        if cut.organs:
            seen = cut.organs if len(cut.organs) > FEW else cut.organs[:1]
            center = np.mean([organ.place for organ in seen], axis=0)
        close.set(
            xlim=(center[0] - CLOSE, center[0] + CLOSE),
            ylim=(center[1] - 0.45 * CLOSE, center[1] + 1.55 * CLOSE),
            title="close view of the end organs",
        )
        _draw_organs(whole, close, cut)
        scale, label = Normalize(cut.span.low, cut.span.high), quantities.label(field)
        bar = ScalarMappable(scale, cut.span.colors)
        drawn.colorbar(bar, ax=close, label=label, shrink=0.85, extend=cut.span.extend)
        return drawn


class Organ(NamedTuple):
    """An end organ in the section: place (2,) x and z mm, type, label, color; near the plane."""

    place: Array
    kind: str
    label: str
    color: str
    near: bool


@dataclass(frozen=True)
class Medial:
    """The deformed medial section at one frame.

    places (n, 2) x and z in mm, triangles (n_soft, 3) of the soft tissues and bone (n_bone, 3),
    values (n,) of the field, outlines (n_edges, 2) between regions, span of the colors, indenter
    (n_outline, 2) mm, end organs, title of the picture.
    """

    places: Array
    triangles: Integers
    bone: Integers
    values: Array
    outlines: Integers
    span: quantities.Span
    indenter: Array
    organs: Sequence[Organ]
    title: str


def medial(result: ResultRecord, field: str, frame: int) -> Medial:
    """Cut the finger of a result at a stored frame; InputError if the field is unknown."""
    fields = quantities.fields_of(result)
    cut = frames.cut(fields.points, fields.cells, fields.region)
    values = cut.at(quantities.values(result, field, frame))
    rest, moved = cut.at(fields.points), cut.at(fields.displacement[frame])
    places = (rest + moved)[:, [0, 2]]
    time = float(fields.times[frame])
    depth = float(np.interp(time, result.time, result.depth))
    pose = frames.pose(result, depth, time)
    soft = cut.region != BONE
    return Medial(
        places=places,
        triangles=cut.triangles[soft],
        bone=cut.triangles[~soft],
        values=values,
        outlines=cut.outlines(),
        span=quantities.span([values[np.unique(cut.triangles[soft])]], field),
        # The indenter may be seen far from its foremost point.
        # 30 mm of the indenter on both sides of the finger.
        indenter=pose.outline(30.0 + float(np.linalg.norm(pose.origin))),
        organs=_organs(result, rest, moved),
        title=f"medial section, t = {time:.4g} s, depth {depth:.3g} mm",
    )


def _organs(result: ResultRecord, rest: Array, moved: Array) -> list[Organ]:
    """Return the end organs, displaced as the nearest vertex of the section is."""
    if result.sites is None:
        return []
    organs = []
    for point, depth, kind in zip(
        result.sites.points, result.sites.depths, result.sites.types, strict=True
    ):
        nearest = int(np.argmin(np.sum((rest - point) ** 2, axis=1)))
        place = (point + moved[nearest])[[0, 2]]
        label = f"{kind}  {depth:g} mm"
        color = figures.COLORS.get(kind, figures.INK)
        organs.append(Organ(place, kind, label, color, bool(abs(point[1]) <= OFF_PLANE)))
    return organs


def _draw_section(axis: "Axes", cut: Medial) -> None:
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.patches import Polygon
    from matplotlib.tri import Triangulation

    axis.add_collection(PolyCollection(list(cut.places[cut.bone]), color=figures.BONE))
    corners, triangles = np.column_stack([cut.places, cut.values]), cut.triangles
    # Inside triangles matplotlib mixes colors, not values: their edges are halved twice.
    for _ in range(2):
        corners, triangles = _halved(corners, triangles)
    x, y, values = corners.T
    axis.tripcolor(
        Triangulation(x, y, triangles), values, shading="gouraud", rasterized=True,
        cmap=cut.span.map(), vmin=cut.span.low, vmax=cut.span.high,
    )  # fmt: skip
    lines = list(cut.places[cut.outlines])
    axis.add_collection(LineCollection(lines, colors="white", linewidths=0.9, alpha=0.9))
    if len(cut.indenter):
        slab = Polygon(cut.indenter, facecolor="#b8c2cc", edgecolor=figures.INK, linewidth=0.9)
        axis.add_patch(slab)
    axis.grid(visible=False)


def _halved(corners: Array, triangles: Integers) -> tuple[Array, Integers]:
    """Divide each of the triangles (n, 3) into four; return all corners, and triangles (4 n, 3)."""
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, side = np.unique(sides, axis=0, return_inverse=True)
    (a, b, c), (ab, bc, ca) = triangles.T, len(corners) + side.reshape(-1, 3).T
    quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return (
        np.concatenate([corners, corners[edges].mean(axis=1)]),
        np.concatenate([np.column_stack(quarter) for quarter in quarters]),
    )


def _draw_organs(whole: "Axes", close: "Axes", cut: Medial) -> None:
    """Mark the end organs, hollow where far from the plane, with a column of labels if few."""
    if len(cut.organs) > FEW:
        return _draw_population(whole, close, cut)
    column = [(0.69, 0.36 - 0.088 * row) for row in range(len(cut.organs))]
    ends = close.transData.inverted().transform(close.transAxes.transform(column))
    places = np.reshape([organ.place for organ in cut.organs], (-1, 2))
    for at, i in zip(column, leader_order(places, np.reshape(ends, (-1, 2))), strict=True):
        place, _, label, color, near = cut.organs[i]
        face = color if near else "none"
        for axis, size, rim in ((whole, 2.5, 0.4), (close, 6.5, 0.8)):
            axis.plot(*place, "o", ms=size, mfc=face, mec="white", mew=rim, zorder=5)
        box = {"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": color}
        close.annotate(
            label, (place[0], place[1]), xytext=at, textcoords="axes fraction",
            va="center", color=color, fontweight="bold", zorder=6, bbox=box, arrowprops=LEADER,
        )  # fmt: skip


def _draw_population(whole: "Axes", close: "Axes", cut: Medial) -> None:
    """Mark the end organs near the plane, and name the types in a legend."""
    for kind, color in figures.COLORS.items():
        places = [organ.place for organ in cut.organs if organ.near and organ.kind == kind]
        for axis, size in ((whole, 3), (close, 5)):
            axis.plot(*np.reshape(places, (-1, 2)).T, "o", ms=size, mfc=color, mec="white",
                      mew=0.6, ls="", zorder=5, label=kind if places else "_")  # fmt: skip
    close.legend(loc="lower right", framealpha=0.9, frameon=True)
