"""Rigid plates with raised dots, Braille or letters, which a finger scans.

Sides rise as the smooth step S (`profiles.smooth_step`), whose length follows from the stated
radius of the crest. Sizes across are those at half of the height.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from fefinger.geometry import profiles
from fefinger.scene.indenter import PlateLike
from fefinger.scene.textured import check_flank
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice


Extent = tuple[tuple[float, float], tuple[float, float]]

SAMPLES = 10
"""Samples of a flank."""

FINEST = 0.02
"""Least distance in mm of samples: 10 million of them cover 60 x 60 mm."""

ARRANGEMENTS = ("grid", "random")

TILE = 12
"""Spacings along a side of the square of random dots, which repeats."""

THROWS = 400
"""Places tried for each random dot."""

MARGIN = 15.0
"""mm of bare plate around a text: a pad is no wider."""

LARGEST_TEXT = 60
"""Largest number of characters of a text."""

ROUNDING, TAIL = 0.3, 3.0
"""Standard deviation, over the flank, of the mean that rounds the corners of outlines, and where
it is cut off."""

FONT, CAPITAL, STROKE = "DejaVu Sans", 0.729, 0.135
"""Font of letters, which Matplotlib ships; height of its capitals over its size, and width of its
strokes over that height."""


class Raised(PlateLike):
    """A plate with raised parts of one height, `edge` mm the radius of their crests."""

    sharp = True

    height: float
    edge: float
    roll: float

    @property
    def raised(self) -> bool:
        """True."""
        return True

    @property
    def flank(self) -> float:
        """Length in mm of their sides, seen from above."""
        return profiles.flank_of(self.edge, self.height)

    @property
    def pitch(self) -> float:
        """Distance in mm of the samples of the surface."""
        return max(self.flank / SAMPLES, FINEST)

    @property
    def least_radius(self) -> float:
        """The radius of the crests in mm."""
        return self.edge

    def rising(self, inside: Array) -> Array:
        """Return the height in mm at places `inside` mm within the outline at half height."""
        t = np.clip(0.5 + inside / self.flank, 0.0, 1.0)
        return self.height * profiles.smooth_step(t)

    def _set_raised(self, width: float) -> None:
        """Check height and edge of parts `width` mm wide, and the angles."""
        self._set("height", above=0, unit="mm")
        self._set("edge", above=0, unit="mm")
        check_flank(self.edge, self.height, width)
        self._set_angles()


@final
@dataclass(frozen=True)
class Dots(Raised):
    """A plate with dots `spacing` mm apart, on a square grid or at random, without an end.

    `diameter` mm is that at half of the `height` mm. Random dots (`seed`) have the density of the
    grid and do not overlap; their pattern repeats after 12 spacings. On a grid a dot lies at the
    point that the smooth plate would touch first.
    """

    kind = "dots"

    spacing: float
    height: float = 0.4
    diameter: float = 0.7
    edge: float = 0.1
    arrangement: str = "grid"
    seed: int = 0
    angle: float = 30.0
    tilt: float = 0.0
    roll: float = 0.0

    def __post_init__(self) -> None:
        """Check the sizes, and that dots do not overlap."""
        self._set("diameter", above=0, unit="mm")
        self._set_raised(self.diameter)
        self._set("spacing", at_least=self.base, unit="mm")
        choice("indenter.arrangement", self.arrangement, ARRANGEMENTS)
        if isinstance(self.seed, bool) or not isinstance(self.seed, int) or self.seed < 0:
            msg = f"indenter.seed: expected a whole number of 0 or more, received {self.seed!r}"
            raise InputError(msg)
        if self.arrangement == "random":
            _ = self.centers

    @property
    def base(self) -> float:
        """Diameter of a dot in mm where it rises from the plate."""
        return self.diameter + self.flank

    @property
    def feature(self) -> float:
        """The diameter in mm, or the narrowest gap between dots of a grid."""
        return min(self.diameter, self.spacing - self.diameter)

    @property
    def tile(self) -> float:
        """Side in mm of the square that repeats."""
        return self.spacing * (1 if self.arrangement == "grid" else TILE)

    @cached_property
    def centers(self) -> Array:
        """Places (n, 2) mm of the dots in the square from (0, 0) that repeats."""
        if self.arrangement == "grid":
            return np.zeros((1, 2))
        rng, placed = np.random.default_rng(self.seed), np.empty((0, 2))
        for place in rng.uniform(0.0, self.tile, (THROWS * TILE**2, 2)):
            apart = np.abs(placed - place)
            apart = np.minimum(apart, self.tile - apart)
            if (np.hypot(*apart.T) >= self.base).all():
                placed = np.vstack([placed, place])
            if len(placed) == TILE**2:
                return placed
        msg = (
            f"indenter.spacing: expected room for {TILE**2} dots {self.base:.3g} mm wide at random "
            f"at {self.spacing:g} mm, found it for {len(placed)}; take a larger spacing"
        )
        raise InputError(msg)

    @cached_property
    def profile(self) -> profiles.Tiled:
        """The square of dots, repeated."""
        from scipy.spatial import cKDTree

        count = max(int(np.ceil(self.tile / self.pitch)), 2 * SAMPLES)
        step, beyond = self.tile / count, 2 * SAMPLES
        lines = step * np.arange(-beyond, count + beyond + 1, dtype=np.float64)
        places = np.stack(np.meshgrid(lines, lines, indexing="ij"), axis=-1)
        away, _ = cKDTree(self.centers, boxsize=self.tile).query(places % self.tile)
        heights = self.rising(self.diameter / 2 - away)
        return profiles.Tiled(profiles.Relief(lines, lines, heights), self.tile)

    def describe(self) -> str:
        """Return "a rigid plate of dots", with their sizes."""
        order = "every" if self.arrangement == "grid" else "at random, one on a square of"
        size = f"{self.diameter:g} mm wide, {self.height:g} high, {order} {self.spacing:g} mm"
        return f"a rigid plate of dots {size}"

    @property
    def mirrored(self) -> bool:
        """Whether it is its own mirror image: a grid along or across the finger."""
        return super().mirrored and self.arrangement == "grid"


class Text(Raised):
    """A raised text along x, which begins `start` mm before the point of first touch.

    It reads from x = 0 to the right, seen from the finger with y up; around it is bare plate.
    """

    text: str
    start: float

    @property
    def box(self) -> tuple[float, float]:
        """Length in mm of the text, and its height about y = 0."""
        raise NotImplementedError

    def inside(self, x: Array, y: Array) -> Array:
        """Compute the signed distance (n_x, n_y) mm of grid nodes from the outline, inside > 0."""
        raise NotImplementedError

    @property
    def extent(self) -> Extent:
        """Ranges in mm of x and y on which there is plate."""
        length, height = self.box
        across = height / 2 + MARGIN
        return (self.start - MARGIN, self.start + length + MARGIN), (-across, across)

    @cached_property
    def profile(self) -> profiles.Relief:
        """The surface of text and plate."""
        x, y = (self._lines(low, high) for low, high in self.extent)
        return profiles.Relief(x, y, self.rising(self.inside(x - self.start, y)))

    @property
    def mirrored(self) -> bool:
        """False: a text is not symmetric."""
        return False

    def _lines(self, low: float, high: float) -> Array:
        """Return grid lines (n,) mm of the surface."""
        count = int(np.ceil((high - low) / self.pitch)) + 1
        return np.linspace(low, high, count, dtype=np.float64)

    def _set_text(self) -> None:
        self._set("start", unit="mm")
        if not isinstance(self.text, str) or not self.text.strip() or len(self.text) > LARGEST_TEXT:
            msg = (
                f"indenter.text: expected 1 to {LARGEST_TEXT} characters that are not all blank, "
                f"received {self.text!r}"
            )
            raise InputError(msg)


@final
@dataclass(frozen=True)
class Braille(Text):
    """A text in Braille, letter by letter (grade 1): letters, figures, blanks, some signs.

    Dots of `diameter` mm at half of their `height` mm, `spacing` mm apart in a cell, and a cell
    every `cell` mm: by default those of printed books.
    """

    kind = "braille"

    text: str
    height: float = 0.48
    diameter: float = 1.1
    spacing: float = 2.34
    cell: float = 6.2
    edge: float = 0.25
    start: float = 0.0
    angle: float = 30.0
    tilt: float = 0.0
    roll: float = 0.0

    def __post_init__(self) -> None:
        """Check the text and the sizes."""
        self._set("diameter", above=0, unit="mm")
        self._set_raised(self.diameter)
        self._set("spacing", at_least=self.diameter + self.flank, unit="mm")
        self._set("cell", at_least=self.spacing + self.diameter + self.flank, unit="mm")
        self._set_text()
        _ = self.centers

    @property
    def feature(self) -> float:
        """The diameter in mm."""
        return self.diameter

    @cached_property
    def centers(self) -> Array:
        """Places (n, 2) mm of the dots, from the middle of the first column of the first cell."""
        from fefinger.scene.braille import cells

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

    Their strokes are 0.135 of that wide.
    """

    kind = "letters"

    text: str
    size: float = 6.0
    height: float = 0.5
    edge: float = 0.05
    start: float = 0.0
    angle: float = 30.0
    tilt: float = 0.0
    roll: float = 0.0

    def __post_init__(self) -> None:
        """Check the text and the sizes."""
        self._set("size", above=0, unit="mm")
        self._set_raised(self.feature)
        self._set_text()

    @property
    def feature(self) -> float:
        """Width in mm of a stroke."""
        return STROKE * self.size

    @cached_property
    def outlines(self) -> tuple[Array, ...]:
        """Closed outlines (n, 2) mm of the letters, the middle of the capitals at y = 0."""
        from matplotlib.font_manager import FontProperties
        from matplotlib.textpath import TextPath

        scale = self.size / (CAPITAL * 100.0)  # outlines of 100 points are smooth
        drawn = TextPath((0.0, 0.0), self.text, size=100.0, prop=FontProperties(family=FONT))
        outlines = [np.asarray(each) * scale for each in drawn.to_polygons()]
        if not outlines:
            msg = f"indenter.text: expected characters that {FONT} draws, received {self.text!r}"
            raise InputError(msg)
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
