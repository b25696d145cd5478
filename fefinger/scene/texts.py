"""Rigid plates with a text in Braille or in embossed letters, which a finger reads."""

import re
from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, final

import numpy as np

from fefinger.geometry import profiles
from fefinger.scene.key import Key
from fefinger.scene.raised import Crest, FlankLimit, Raised
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


Extent = tuple[tuple[float, float], tuple[float, float]]

ROUNDING, TAIL = 0.3, 3.0
"""Standard deviation, over the flank, of the mean that rounds the corners of outlines, and where
it is cut off."""

FONT, CAPITAL, STROKE = "DejaVu Sans", 0.729, 0.135
"""Font of letters, which Matplotlib ships; height of its capitals over its size, and width of its
strokes over that height."""


FIRST = "1 12 14 145 15 124 1245 125 24 245".split()
"""Dots of a to j, which are also the figures 1 to 9 and 0."""

LETTERS = {
    **dict(zip("abcdefghij", FIRST, strict=True)),
    **dict(zip("klmnopqrst", (f"{dots}3" for dots in FIRST), strict=True)),
    **dict(zip("uvxyz", (f"{dots}36" for dots in FIRST[:5]), strict=True)),
    "w": "2456",
}
SIGNS = {" ": "", ",": "2", ".": "256", "?": "236", "!": "235", "-": "36"}
NUMBER, LETTER, CAPITAL_SIGN = "3456", "56", "6"
WORD = re.compile(r"[A-Z]{2,}(?![a-z])")
FIGURES = dict(zip("1234567890", FIRST, strict=True))
"""Dots of signs in Braille, counted down the left column of a cell, then down the right one.

The letters are those of Louis Braille, shared by the languages with Latin letters; figures follow
the number sign. Signs, capitals and numbers are those of Unified English Braille, grade 1. A word
of capitals is one of two or more."""


Words = Annotated[str, Key("The text, along x")]
Start = Annotated[
    float, Key("Distance from the point of first touch to the beginning of the text", unit="mm")
]
Height = Annotated[float, Key("Height of the dots or letters", unit="mm", above=0)]


class Text(Raised):
    """A raised text along x, which begins `start` mm before the point of first touch.

    It reads from x = 0 to the right, seen from the finger with y up; around it is bare plate.
    """

    mirrored = False

    text: Words
    start: Start

    def __post_init__(self) -> None:
        """Check the length of the text."""
        super().__post_init__()
        largest_text = 60  # largest number of characters of a text
        if not self.text.strip() or len(self.text) > largest_text:
            raise InputError(
                f"indenter.text: expected 1 to {largest_text} characters that are not all blank, "
                f"received {self.text!r}"
            )

    @property
    @abstractmethod
    def box(self) -> tuple[float, float]:
        """Length in mm of the text, and its height about y = 0."""

    @abstractmethod
    def inside(self, x: Array, y: Array) -> Array:
        """Compute the signed distance (n_x, n_y) mm of grid nodes from the outline, inside > 0."""

    @property
    def extent(self) -> Extent:
        """Ranges in mm of x and y that the plate under the text covers."""
        length, height = self.box
        margin = 15.0  # mm of bare plate around a text: a pad is no wider
        across = height / 2 + margin
        return (self.start - margin, self.start + length + margin), (-across, across)

    @cached_property
    def profile(self) -> profiles.Relief:
        """The surface of text and plate."""
        (left, right), (low, high) = self.extent
        self._check_samples("text", self.text, (right - left, high - low))
        x, y = (
            np.linspace(low, high, int(np.ceil((high - low) / self.pitch)) + 1)
            for low, high in self.extent
        )
        return profiles.Relief(x, y, self.rising(self.inside(x - self.start, y)))


@final
@dataclass(frozen=True)
class Braille(Text):
    """A text in Braille, letter by letter (grade 1): letters, figures, blanks, some signs.

    Dots of `diameter` mm at half of their `height` mm, `spacing` mm apart in a cell, and a cell
    every `cell` mm: by default as in printed books. `edge` is 0.25 mm where that fits.
    """

    usual_edge = 0.25

    text: Words
    height: Height = 0.48
    diameter: Annotated[float, Key("Diameter of a dot at half its height", unit="mm", above=0)] = (
        1.1
    )
    spacing: Annotated[float, Key("Spacing of the dots in a cell", unit="mm", above=0)] = 2.34
    cell: Annotated[float, Key("Spacing of the cells", unit="mm", above=0)] = 6.2
    edge: Crest = None
    start: Start = 0.0
    angle: float = 30.0
    tilt: float = 0.0
    roll: float = 0.0

    def __post_init__(self) -> None:
        """Check the signs of the text besides."""
        super().__post_init__()
        _ = self.centers

    @property
    def flank_limits(self) -> tuple[FlankLimit, ...]:
        """The diameter, and the gaps between dots within a cell and between cells."""
        dot = f"diameter = {self.diameter:g}"
        within = f"spacing = {self.spacing:g}, {dot}"
        between = f"cell = {self.cell:g}, {within}"
        return (
            FlankLimit("diameter", dot, self.diameter),
            FlankLimit("spacing", within, self.spacing - self.diameter),
            FlankLimit("cell", between, self.cell - self.spacing - self.diameter),
        )

    @cached_property
    def centers(self) -> Array:
        """Places (n, 2) mm of the dots, from the middle of the first column of the first cell."""
        column = [(0, 1), (0, 0), (0, -1), (1, 1), (1, 0), (1, -1)]
        dots = [
            (self.cell * number + self.spacing * column[dot][0], self.spacing * column[dot][1])
            for number, cell in enumerate(cells(self.text))
            for dot in cell
        ]
        return np.array(dots, dtype=float)

    @property
    def box(self) -> tuple[float, float]:
        """Length in mm of the text, and its height about y = 0."""
        return float(self.centers[:, 0].max()), 2 * self.spacing

    def inside(self, x: Array, y: Array) -> Array:
        """Compute the signed distance (n_x, n_y) mm of grid nodes from a dot, inside > 0."""
        from scipy.spatial import cKDTree

        places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        return np.asarray(self.diameter / 2 - cKDTree(self.centers).query(places)[0])

    def describe(self) -> str:
        """Return "a rigid plate of braille", with its text."""
        return f"a rigid plate of braille, {self.text!r}, {self.height:g} mm high"


@final
@dataclass(frozen=True)
class Letters(Text):
    """An embossed text in DejaVu Sans, capitals `size` mm high, raised by `height` mm.

    Their strokes are 0.135 of that wide. `edge` is 0.05 mm where that fits.
    """

    usual_edge = 0.05

    text: Words
    size: Annotated[float, Key("Height of the capitals", unit="mm", above=0)] = 6.0
    height: Height = 0.5
    edge: Crest = None
    start: Start = 0.0
    angle: float = 30.0
    tilt: float = 0.0
    roll: float = 0.0

    @property
    def flank_limits(self) -> tuple[FlankLimit, ...]:
        """The width of a stroke."""
        return (FlankLimit("size", f"size = {self.size:g}", STROKE * self.size),)

    @cached_property
    def outlines(self) -> tuple[Array, ...]:
        """Closed outlines (n, 2) mm of the letters, the middle of the capitals at y = 0."""
        from matplotlib.font_manager import FontProperties, findfont, get_font
        from matplotlib.path import Path
        from matplotlib.textpath import text_to_path

        # Matplotlib draws a box for characters that a font lacks, and dollars as mathematics.
        font = FontProperties(family=FONT)
        has = get_font(findfont(font)).get_charmap()
        lacking = "".join(dict.fromkeys(each for each in self.text if ord(each) not in has))
        points, codes = text_to_path.get_text_path(font, self.text, ismath=False)
        scale = self.size / (CAPITAL * text_to_path.FONT_SCALE)
        outlines = [np.asarray(each) * scale for each in Path(points, codes).to_polygons()]
        if lacking or not outlines:
            msg = f"indenter.text: expected characters that {FONT} draws, received "
            raise InputError(msg + repr(lacking or self.text))
        left = min(float(each[:, 0].min()) for each in outlines)
        return tuple(each - (left, self.size / 2) for each in outlines)

    @property
    def box(self) -> tuple[float, float]:
        """Length in mm of the text, and its height about y = 0."""
        every = np.vstack(self.outlines)
        return float(every[:, 0].max()), 2 * float(np.abs(every[:, 1]).max())

    def inside(self, x: Array, y: Array) -> Array:
        """Compute the signed distance (n_x, n_y) mm of grid nodes from the letters, inside > 0."""
        from matplotlib.path import Path
        from scipy.ndimage import gaussian_filter
        from scipy.spatial import cKDTree

        places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        filled = np.zeros(places.shape[:2], bool)
        for outline in self.outlines:  # what an even number of outlines encloses is a hole
            ranges = [np.searchsorted(lines, outline[:, k]) for k, lines in enumerate((x, y))]
            part = tuple(slice(each.min(), each.max() + 1) for each in ranges)
            shape = filled[part].shape
            filled[part] ^= (
                Path(outline).contains_points(places[part].reshape(-1, 2)).reshape(shape)
            )
        fine = np.vstack([_dense(outline, self.pitch / 4) for outline in self.outlines])
        far = (0.5 + ROUNDING * TAIL) * self.flank
        away, _ = cKDTree(fine).query(places, distance_upper_bound=far)
        signed = np.where(filled, 1.0, -1.0) * np.minimum(away, far)
        # A mean over the neighborhood keeps straight edges in place, and rounds corners.
        spread = [ROUNDING * self.flank / (lines[1] - lines[0]) for lines in (x, y)]
        return np.asarray(gaussian_filter(signed, spread, truncate=TAIL, mode="nearest"))

    def describe(self) -> str:
        """Return "a rigid plate with embossed letters", with the text."""
        size = f"{self.size:g} mm tall, {self.height:g} high"
        return f"a rigid plate with the embossed letters {self.text!r}, {size}"


def _dense(outline: Array, step: float) -> Array:
    """Return points (n, 2) on a closed outline, at most `step` mm apart."""
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(outline, axis=0), axis=1)))
    at = np.linspace(0.0, length[-1], int(length[-1] / step) + 2)
    return np.column_stack([np.interp(at, length, outline[:, k]) for k in (0, 1)])


def cells(text: str) -> Iterator[tuple[int, ...]]:
    """Yield the dots of every cell of a text, from 0.

    A number goes on through points and commas that a figure follows. Two signs stand before a word
    of capitals, one before each other capital.

    Raises InputError for a character that the table lacks.
    """
    in_number, word_ends = False, 0
    for place, character in enumerate(text):
        before, after = text[:place][-1:], text[place + 1 :][:1]
        if character in FIGURES:
            if not in_number:
                yield _dots(NUMBER)
            in_number = True
            yield _dots(FIGURES[character])
            continue
        small = character.lower()
        if small not in LETTERS and small not in SIGNS:
            signs = " ".join(sign for sign in SIGNS if sign.strip())
            raise InputError(
                f"indenter.text: expected letters a to z, figures, blanks and {signs}, received "
                f"{character!r}"
            )
        if in_number and character in "abcdefghij":
            yield _dots(LETTER)
        in_number = in_number and character in ".," and after.isdigit()
        if small != character and place >= word_ends:
            word = WORD.match(text, place)
            whole = word is not None and not before.isalpha()
            word_ends = word.end() if word is not None and whole else place + 1
            yield from [_dots(CAPITAL_SIGN)] * (2 if whole else 1)
        yield _dots(LETTERS.get(small, SIGNS.get(small, "")))


def _dots(digits: str) -> tuple[int, ...]:
    return tuple(sorted(int(digit) - 1 for digit in digits))
