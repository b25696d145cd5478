"""What is drawn of a Result in space, before any renderer: surfaces, lines, end organs, colors."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fefinger.results.records import Fields, ResultRecord
from fefinger.view import frames, quantities
from fefinger.view import markers as marks
from fefinger.view import surfaces as pieces


SOFT = ("skin", "subcutaneous tissue", pieces.PAD)


@dataclass(frozen=True)
class Subject:
    """What is drawn of a result with fields.

    surfaces: the pieces of the finger; lines: the outlines of the cut, none if the finger is
    `whole`; marks: of end organs in the cut, or of units on the skin of the whole finger; title:
    what is written above.
    """

    result: ResultRecord
    fields: Fields
    surfaces: tuple[pieces.Piece, ...]
    lines: pieces.Piece | None
    marks: marks.Marks | None
    whole: bool
    title: str


def subject(result: ResultRecord, field: str, title: str = "") -> Subject:
    """Return what is drawn of a result; pressure is shown on the whole finger from below.

    It is called `title`, or as its scene.

    Raises InputError if the field is unknown or there are no fields.
    """
    quantities.named("field", field)
    fields, whole = quantities.fields_of(result), field == "pressure"
    if whole:
        fields = frames.whole(fields)
        result = replace(result, response=replace(result.response, fields=fields))
    return Subject(
        result=result,
        fields=fields,
        surfaces=pieces.entire(fields) if whole else pieces.cut_open(fields),
        lines=None if whole else pieces.outlines(fields),
        marks=marks.on_skin(result) if whole else marks.in_section(result),
        whole=whole,
        title=title or result.scene.name,
    )


def colors(
    subjects: Sequence[Subject], field: str, limits: tuple[float, float] | None = None
) -> quantities.Span:
    """Return the colors that hold for all subjects at all of their times."""
    return quantities.span(
        (
            np.concatenate([piece.at(nodal) for piece in each.surfaces if piece.name in SOFT])
            for each in subjects
            for frame in range(len(each.fields.times))
            for nodal in [quantities.values(each.result, field, frame)]
        ),
        field,
        limits,
    )
