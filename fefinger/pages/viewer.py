"""Results as one interactive page that a browser draws with WebGL: `write(results, path)`.

Needs neither a renderer nor a network. Every field is in the page.
"""

import base64
import json
import zlib
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike

from fefinger.geometry.finger_mesh import boundary_edges
from fefinger.geometry.profiles import FLANK
from fefinger.neural.trains import FEW
from fefinger.pages import page
from fefinger.results.records import Fields
from fefinger.results.result_record import ResultRecord
from fefinger.support.arrays import Array, Integers
from fefinger.support.atomic_write import in_place
from fefinger.view import figures, frames, quantities, surfaces
from fefinger.view.drawing import (
    Drawing,
    Marks,
    colors,
    cut_open,
    highest_rate,
    marks_on_skin,
    titles,
)
from fefinger.view.quantities import Span


OUTER = ("skin", surfaces.PAD, surfaces.FRONT)
LEVELS = 65535  # steps from the lowest to the highest value of a field, in 16 bits
GRID = 61  # points along and across an indenter that is not plane
REACH = 7.0  # mm of an indenter to either side
PRESSED = "pressure on the pad"  # has colors of its own beside another field
RATED = Span(0.0, 1.0, quantities.RATES, "neither")

Json = dict[str, object]


class Blob(bytearray):
    """Buffer of concatenated arrays."""

    def add(self, array: ArrayLike, kind: str) -> Json:
        """Append an array as little-endian `kind` (f4, u4, u2); return its place as JSON."""
        data = np.ascontiguousarray(array, dtype=f"<{kind}")
        place = {"kind": kind, "at": len(self), "count": data.size}
        self.extend(data.tobytes() + bytes(-data.nbytes % 4))
        return place

    def text(self) -> str:
        """Return the compressed buffer as base64."""
        return base64.b64encode(zlib.compress(self, 9)).decode("ascii")


def write(
    results: ResultRecord | Sequence[ResultRecord],
    path: str | PathLike[str],
    field: str = quantities.DEFAULT,
    time: float | None = None,
    limits: tuple[float, float] | None = None,
    folders: Sequence[str] = (),
) -> None:
    """Write the page on one result, or several side by side, to the HTML file `path`.

    The page opens with `field` at the stored time next to `time` s, by default the time of the
    largest force of the first result; `limits` are the ends of that field's color bar. Several
    results are named by their `folders`. Raises InputError if a result has no fields, the field is
    unknown or the time is after the end.
    """
    shown = frames.requested(results, field, time)
    drawings = []
    for result, title in zip(shown, titles(shown, folders), strict=True):
        drawn = cut_open(frames.whole_result(result), title)
        # The page can show the skin in front of the cut.
        before = surfaces.other_half(drawn.fields)
        drawings.append(replace(drawn, surfaces=(*drawn.surfaces, *before)))
    blob = Blob()
    spans = {
        name: colors(drawings, name, limits if name == field else None)
        for name in quantities.FIELDS
    } | {PRESSED: colors(drawings, "pressure")}
    data = {
        "field": field,
        "time": frames.peak_time(shown[0]) if time is None else time,
        "scenes": [_scene(drawn, blob) for drawn in drawings],
        "fields": {name: bar(spans[name], name) for name in quantities.FIELDS},
        "pressure": bar(spans[PRESSED], "pressure"),
        "maps": {color_map(span): colors_of(span) for span in [*spans.values(), RATED]},
        "rate": quantities.round_up(max(map(highest_rate, shown)) or 1.0),
        "rates": quantities.RATES,
        "few": FEW,
    }  # fmt: skip
    html = page.render(
        "viewer.html",
        title=", ".join(result.scene.name for result in shown),
        fields=[(name, quantities.label(name), text) for name, text in quantities.ABOUT.items()],
        script=page.source("drawing.js") + page.source("viewer.js"),
        data=page.raw(json.dumps(data).replace("<", "\\u003c")),
        blob=blob.text(),
    )
    with in_place(path) as new:
        new.write_text(html, encoding="utf-8")


def bar(span: Span, name: str) -> Json:
    """Return the color bar of a field."""
    return span._asdict() | {"colors": color_map(span), "unit": quantities.unit(name)}


def color_map(span: Span) -> str:
    """Return the key of a color table: the name of the color map with its part in use."""
    low, high = span.part
    return span.colors if (low, high) == (0.0, 1.0) else f"{span.colors} {low:.6g} to {high:.6g}"


def colors_of(span: Span) -> list[int]:
    """Return the colors (3 n,) of a table from 0 to 255, red, green and blue by turns."""
    table = span.map()(np.arange(quantities.SHADES))[:, :3]
    return [int(value) for value in np.round(255 * table).astype(int).ravel()]


def _scene(drawn: Drawing, blob: Blob) -> Json:
    result, fields, every, lines = drawn.result, drawn.fields, drawn.surfaces, drawn.lines
    assert lines is not None
    moved = [fields.points + shift for shift in fields.displacement]
    depth, force = np.interp(fields.times, result.time, result.depth), result.force
    return {
        "title": drawn.title,
        "words": f"{result.plan.mechanics} ({quantities.measure(result)})",
        "times": fields.times.tolist(),
        "depth": depth.tolist(),
        "force": None if force is None else np.interp(fields.times, result.time, force).tolist(),
        **shape(every, lines, blob),
        "points": blob.add([at(every, each) for each in moved], "f4"),
        "values": {name: _values(drawn, name, blob) for name in quantities.FIELDS},
        "linePoints": blob.add([lines.at(each) for each in moved], "f4"),
        "organs": _organs(drawn.marks, fields, blob),
        "units": _organs(marks_on_skin(result), fields, blob),
        "indenter": surface(frames.pose(result, 0.0), blob),
    }


def shape(every: Sequence[surfaces.Piece], lines: surfaces.Piece, blob: Blob) -> Json:
    """Return the connectivity of surfaces and lines, which is the same in all frames."""
    starts = np.cumsum([0, *(len(piece.edges) for piece in every)])
    triangles = [piece.triangles + start for piece, start in zip(every, starts, strict=False)]
    counts = np.cumsum([0, *(len(each) for each in triangles)])
    return {
        "vertices": int(starts[-1]),
        "triangles": blob.add(np.concatenate(triangles), "u4"),
        "same": blob.add(_same(every), "u4"),
        "pieces": [
            {"name": piece.name, "flat": piece.flat, "from": int(a), "to": int(b)}
            for piece, a, b in zip(every, counts[:-1], counts[1:], strict=True)
        ],
        "lines": blob.add(lines.triangles, "u4"),
    }


def at(every: Sequence[surfaces.Piece], nodal: Array) -> Array:
    """Return values at the mesh points (n_points, ...) at the vertices of surfaces."""
    return np.concatenate([piece.at(nodal) for piece in every])


def _same(every: Sequence[surfaces.Piece]) -> Integers:
    """Return for each vertex (n,) the first vertex at its place, with which it shares a normal."""
    keys = []
    for number, piece in enumerate(every):
        kind = -1 if piece.name in OUTER and not piece.flat else number
        kinds = np.full(len(piece.weight), kind)
        keys.append(np.column_stack([piece.edges, np.round(1e6 * piece.weight), kinds]))
    _, first, inverse = np.unique(
        np.concatenate(keys), axis=0, return_index=True, return_inverse=True
    )
    return np.asarray(first[inverse.ravel()])


def _values(drawn: Drawing, name: str, blob: Blob) -> Json:
    """Return a field on all vertices at all times, rounded to LEVELS of its range."""
    steps = range(len(drawn.fields.times))
    nodal = (quantities.values(drawn.result, name, step) for step in steps)
    values = np.stack([at(drawn.surfaces, each) for each in nodal])
    low, high = float(values.min()), float(values.max())
    step = (high - low) / LEVELS or 1.0
    return blob.add(np.round((values - low) / step), "u2") | {"low": low, "step": step}


def _organs(shown: Marks | None, fields: Fields, blob: Blob) -> Json | None:
    """Return places, labels and colors of marks, and the rates of their units."""
    if shown is None:
        return None
    rates = None
    if shown.trains is not None:
        rates = blob.add([shown.rates(float(time)) for time in fields.times], "f4")
    return {
        "points": blob.add([shown.followed.moved(u) for u in fields.displacement], "f4"),
        "labels": shown.labels,
        "colors": [figures.COLORS.get(kind, figures.INK) for kind in shown.types],
        "rates": rates,
    }


def surface(pose: frames.Pose, blob: Blob) -> Json:
    """Return the surface of an indenter at first touch, and its direction of travel."""
    count = 2 if pose.profile.plane else GRID
    line = np.linspace(-1, 1, count)
    across = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1)
    reach = np.full(2, REACH)
    rimmed = pose.profile.plane or pose.profile.half_axes is not None
    if pose.profile.half_axes is not None:  # the square becomes a disk, whose rim is round
        across = across * np.sqrt(1 - across[..., ::-1] ** 2 / 2) * (1 - 1e-9)
        reach = np.minimum(REACH, np.sin(np.radians(FLANK)) * np.array(pose.profile.half_axes[:2]))
    places = pose.places(reach * across).reshape(-1, 3)
    seen = np.asarray(np.isfinite(places).all(axis=1))
    places = np.where(seen[:, None], places, 0.0)
    seen &= (places - pose.origin) @ pose.axis > -REACH
    corner = np.arange(count * count).reshape(count, count)
    a, b, c, d = (corner[i : count - 1 + i, j : count - 1 + j].ravel() for i in (0, 1)
                  for j in (0, 1))  # fmt: skip
    triangles = np.concatenate([np.column_stack([a, b, d]), np.column_stack([a, d, c])])
    triangles = triangles[seen[triangles].all(axis=1)]
    return {
        "points": blob.add(places, "f4"),
        "triangles": blob.add(triangles, "u4"),
        "rim": blob.add(boundary_edges(triangles) if rimmed else [], "u4"),
        "axis": pose.axis.tolist(),
    }
