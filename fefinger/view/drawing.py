"""Drawing of a Result in space, independent of the renderer: surfaces, lines, marks, colors.

PyVista (`plot3d`) and the page for a browser (`fefinger.pages.viewer`) draw the same record.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fefinger.results.records import Fields
from fefinger.results.result_record import ResultRecord
from fefinger.view import frames, markers, quantities, surfaces
from fefinger.view.surfaces import Piece


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
