"""What is drawn of a Result in space, before any renderer: surfaces, lines, end organs, colors."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fefinger import pieces, quantities, section
from fefinger.checks import choice
from fefinger.neural.trains import FEW
from fefinger.records import Array, Fields, Integers, Result


SOFT = ("skin", "subcutaneous tissue", pieces.PAD)
OFF_PLANE = 0.5  # mm: end organs before the cut by more are left out


@dataclass(frozen=True)
class Subject:
    """What is drawn of a result with fields.

    surfaces: the pieces of the finger; lines: the outlines of the cut, none if the finger is
    `whole`; organs: the end organs, `chosen` (n,) their numbers among the sites; on the whole
    finger those of a population, marked on the skin above them.
    """

    result: Result
    fields: Fields
    surfaces: tuple[pieces.Piece, ...]
    lines: pieces.Piece | None
    organs: pieces.Followed | None
    chosen: Integers
    whole: bool

    @property
    def fires(self) -> bool:
        """Return whether the end organs belong to units that were simulated."""
        return self.organs is not None and self.result.spikes is not None

    @property
    def types(self) -> list[str]:
        """Return the afferent type of each end organ."""
        sites = self.result.sites
        return [] if sites is None else [sites.types[i] for i in self.chosen]

    @property
    def units(self) -> Integers:
        """Return the number of the unit that each end organ belongs to."""
        sites = self.result.sites
        assert sites is not None
        return self.chosen if sites.unit is None else sites.unit[self.chosen]

    def rates(self, time: float) -> Array:
        """Return the rate in Hz of the unit of each end organ at a time in s."""
        trains = self.result.spikes
        assert trains is not None
        return np.array([float(trains.rate(int(unit), time)) for unit in self.units])

    def highest_rate(self) -> float:
        """Return the highest rate in Hz at any of the stored times."""
        if not self.fires:
            return 0.0
        return max(float(self.rates(time).max()) for time in self.fields.times)


def subject(result: Result, field: str) -> Subject:
    """Return what is drawn of a result; pressure is shown on the whole finger from below.

    Raises InputError if the field is unknown or there are no fields.
    """
    choice("field", field, quantities.FIELDS)
    fields, whole = quantities.fields_of(result), field == "pressure"
    if whole:
        fields = section.whole(fields)
        result = replace(result, response=replace(result.response, fields=fields))
    organs, chosen, sites = None, np.empty(0, np.int64), result.sites
    if sites is not None and (not whole or len(sites.types) > FEW):
        chosen = np.flatnonzero(whole | (sites.points[:, 1] >= -OFF_PLANE))
        above = sites.depths[:, None] * sites.normals if whole else 0.0
        organs = pieces.follow(fields, (sites.points + above)[chosen]) if len(chosen) else None
    return Subject(
        result=result,
        fields=fields,
        surfaces=pieces.entire(fields) if whole else pieces.cut_open(fields),
        lines=None if whole else pieces.outlines(fields),
        organs=organs,
        chosen=chosen,
        whole=whole,
    )


def colors(
    subjects: Sequence[Subject], field: str, limits: tuple[float, float] | None = None
) -> quantities.Span:
    """Return the colors that hold for all subjects at all of their times."""
    return quantities.span(
        (
            piece.at(quantities.values(each.result, field, frame))
            for each in subjects
            for frame in range(len(each.fields.times))
            for piece in each.surfaces
            if piece.name in SOFT
        ),
        field,
        limits,
    )
