"""Drawing of a Result in space, independent of the renderer, and titles of several.

PyVista (`plot3d`) and the page for a browser (`fefinger.pages.viewer`) draw the same record.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from fefinger.results.records import Fields
from fefinger.results.result_record import ResultRecord
from fefinger.scene.field_units import column, split
from fefinger.support.text import flat
from fefinger.view import frames, markers, quantities, surfaces
from fefinger.view.surfaces import Piece


MOST = 3  # differences in a title
LONG = 24  # letters of a value in a title
SHOWN = ("indenter.", "motion.", "finger.")  # the outputs of a scene do not change its picture
SUBJECT = "finger.subject"
SIZES = ("finger.width", "finger.thickness", "finger.pad_radius")  # set by the subject


@dataclass(frozen=True)
class Drawing:
    """The surfaces, lines and marks of a result with fields.

    surfaces: of the finger; lines: the outlines of the cut, None if the finger is whole; marks: of
    end organs in the cut, or of units on the skin of the whole finger; title: the line above.
    """

    result: ResultRecord
    surfaces: tuple[Piece, ...]
    lines: Piece | None
    marks: markers.Marks | None
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

    On the skin of a whole finger the units of a population are marked. Raises InputError if the
    field is unknown or there are no fields.
    """
    if quantities.named("field", field) != "pressure":
        return cut_open(result, title)
    result = frames.whole_result(result)
    pieces = surfaces.entire(quantities.fields_of(result))
    return Drawing(result, pieces, None, markers.on_skin(result), title)


def cut_open(result: ResultRecord, title: str) -> Drawing:
    """Return the drawing of the half finger behind the medial plane, and of its end organs."""
    fields = quantities.fields_of(result)
    pieces, lines = surfaces.cut_open(fields), surfaces.outlines(fields)
    return Drawing(result, pieces, lines, markers.in_section(result), title)


def colors(
    drawings: Sequence[Drawing], field: str, limits: tuple[float, float] | None = None
) -> quantities.Span:
    """Return the colors that hold for all drawings at all of their times."""
    return quantities.span(
        (
            np.concatenate(
                [piece.at(nodal) for piece in each.surfaces if piece.name in surfaces.SOFT]
            )
            for each in drawings
            for frame in range(len(each.fields.times))
            for nodal in [quantities.values(each.result, field, frame)]
        ),
        field,
        limits,
    )


def titles(
    results: Sequence[ResultRecord], folders: Sequence[str | PathLike[str]] = ()
) -> tuple[str, ...]:
    """Return a title for each result: name of its scene, its folder's where there are several.

    With the values in which the scenes differ, as many as there is room for.
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


def _differences(table: Mapping[str, Any], varied: Sequence[str]) -> Iterator[str]:
    for key in varied[:MOST]:
        value = table.get(key, "none")
        text = f"{value:g}" if isinstance(value, float) else str(value)
        if not isinstance(value, str):
            text = f"{text} {split(column(key, table['motion.kind']))[1]}".strip()
        yield f"{key} {text}" if len(text) <= LONG else f"another {key}"
    if len(varied) > MOST:
        yield f"{len(varied) - MOST} more"
