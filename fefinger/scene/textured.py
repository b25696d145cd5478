"""Rigid plates with ridges, dots or a relief, which a finger scans."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Self, final

import numpy as np

from fefinger.geometry import profiles
from fefinger.geometry.height_map import MOST
from fefinger.scene.indenter import Indenter, turned
from fefinger.scene.key import Key
from fefinger.scene.raised import FLANK_SAMPLES, Crest, FlankLimit, Raised, check_edge
from fefinger.scene.relief_file import read_relief
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, boolean, number, set_number


SAMPLES = 4
"""Least number of samples of a relief in x and in y: as many as a cubic needs."""

TILE = 12
"""Spacings along a side of the square of random dots, which repeats."""


@final
@dataclass(frozen=True)
class Grating(Indenter):
    """A rigid plate with rounded ridges, `period` mm apart and `depth` mm high.

    `ridge` mm is the width of a ridge at half its height. The middle of a ridge passes through the
    point that the smooth plate would touch first, `shift` mm moves it. `angle` and `tilt` are those
    of the plate, `roll` turns the ridges in it. `edge` is the radius in mm of the crests; by
    default ridges are as round as their width, or that of the grooves, allows.
    """

    sharp = True

    period: Annotated[float, Key("Spacing of the ridges", unit="mm", above=0)]
    ridge: Annotated[float, Key("Width of a ridge at half its height", unit="mm", above=0)]
    depth: Annotated[float, Key("Height of the ridges over the grooves", unit="mm", above=0)]
    shift: Annotated[float, Key("Shift of the pattern along the plate", unit="mm")] = 0.0
    angle: float = 30.0
    tilt: float = 0.0
    roll: float = 0.0
    edge: Crest = None

    def __post_init__(self) -> None:
        """Check that ridge and edge fit."""
        super().__post_init__()
        set_number(self, "indenter.ridge", above=0, below=self.period, unit="mm")
        if self.edge is not None:
            sizes = f"period = {self.period:g}, ridge = {self.ridge:g}"
            limit = FlankLimit("ridge", sizes, self.feature)
            check_edge(self.edge, self.depth, limit, least=0.0)

    @property
    def profile(self) -> profiles.Grating:
        """Rounded ridges."""
        flank = None if self.edge is None else profiles.flank_of(self.edge, self.depth)
        return profiles.Grating(self.period, self.ridge, self.depth, self.shift, flank)

    @property
    def raised(self) -> bool:
        """Whether the radius of its crests is stated."""
        return self.edge is not None

    @property
    def feature(self) -> float:
        """Width in mm of a ridge or of a groove, whichever is less."""
        return min(self.ridge, self.period - self.ridge)

    @property
    def repeats(self) -> tuple[float, float]:
        """The period in mm across the ridges."""
        return self.period, float("inf")

    @property
    def narrowest(self) -> float:
        """The width in mm of its ridges or of the grooves between them."""
        return self.feature

    @property
    def least_radius(self) -> float:
        """The radius in mm of its ridges where they are sharpest, within 1 %."""
        across = np.column_stack([np.linspace(0, self.period, 401), np.zeros(401)])
        return profiles.sharpest_radius(self.profile, across)

    def describe(self) -> str:
        """Return "a rigid grating", with the sizes of its ridges and how they lie."""
        size = f"{self.ridge:g} mm wide every {self.period:g} mm, {self.depth:g} high"
        return f"a rigid grating of ridges {size}{turned(self.roll)}"

    @property
    def mirrored(self) -> bool:
        """Whether it is its own mirror image: ridges along the finger must not be shifted."""
        return super().mirrored and (self.shift == 0 or self.roll % 180 == 0)


@final
@dataclass(frozen=True)
class Dots(Raised):
    """A plate with dots `spacing` mm apart, on a square grid or at random, without an end.

    `diameter` mm is that at half of the `height` mm; `edge` is 0.1 mm where that fits. Random dots
    (`seed`) have the density of the grid and do not overlap; their pattern repeats after 12
    spacings. On a grid a dot lies at the point that the smooth plate would touch first.
    """

    usual_edge = 0.1

    spacing: Annotated[float, Key("Spacing of the dots", unit="mm", above=0)]
    height: Annotated[float, Key("Height of the dots", unit="mm", above=0)] = 0.4
    diameter: Annotated[float, Key("Diameter of a dot at half its height", unit="mm", above=0)] = (
        0.7
    )
    edge: Crest = None
    arrangement: Annotated[str, Key("Order of the dots", words=("grid", "random"))] = "grid"
    seed: Annotated[int, Key("Seed of random places", at_least=0)] = 0
    angle: float = 30.0
    tilt: float = 0.0
    roll: float = 0.0

    def __post_init__(self) -> None:
        """Check the number of samples besides, and that dots do not overlap."""
        super().__post_init__()
        self._check_samples("spacing", self.spacing, (self.tile, self.tile))
        if self.arrangement == "random":
            _ = self.centers

    @property
    def flank_limits(self) -> tuple[FlankLimit, ...]:
        """The diameter, and the gap between dots of a grid."""
        sizes = f"spacing = {self.spacing:g}, diameter = {self.diameter:g}"
        return (
            FlankLimit("diameter", f"diameter = {self.diameter:g}", self.diameter),
            FlankLimit("spacing", sizes, self.spacing - self.diameter),
        )

    @property
    def base(self) -> float:
        """Diameter of a dot in mm where it rises from the plate."""
        return self.diameter + self.flank

    @property
    def tile(self) -> float:
        """Side in mm of the square that repeats."""
        return self.spacing * (1 if self.arrangement == "grid" else TILE)

    @property
    def repeats(self) -> tuple[float, float]:
        """The spacing in mm of a grid; random dots have none."""
        return (self.spacing if self.arrangement == "grid" else float("inf"),) * 2

    @cached_property
    def centers(self) -> Array:
        """Places (n, 2) mm of the dots in the square from (0, 0) that repeats."""
        if self.arrangement == "grid":
            return np.zeros((1, 2))
        rng, placed = np.random.default_rng(self.seed), np.empty((0, 2))
        # 400 places are tried for each random dot.
        for place in rng.uniform(0.0, self.tile, (400 * TILE**2, 2)):
            apart = np.abs(placed - place)
            apart = np.minimum(apart, self.tile - apart)
            if (np.hypot(*apart.T) >= self.base).all():
                placed = np.vstack([placed, place])
            if len(placed) == TILE**2:
                return placed
        raise InputError(
            f"indenter.spacing: expected room for {TILE**2} dots {self.base:.3g} mm wide at random "
            f"at {self.spacing:g} mm, found it for {len(placed)}; take a larger spacing"
        )

    @cached_property
    def profile(self) -> profiles.Tiled:
        """The square of dots, repeated."""
        from scipy.spatial import cKDTree

        count = max(int(np.ceil(self.tile / self.pitch)), 2 * FLANK_SAMPLES)
        step, beyond = self.tile / count, 2 * FLANK_SAMPLES
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


@final
@dataclass(frozen=True)
class Relief(Indenter):
    """A rigid plate with a relief of your own: `heights` mm toward the finger at x, y in mm.

    x (n_x,) and y (n_y,) are the grid lines on the plate, x toward the tip before `roll`, with the
    point that the smooth plate would touch first at (0, 0); heights (n_x, n_y). A bicubic spline
    runs through the samples, and beyond the outermost ones the plate ends.
    """

    sharp = True
    mirrored = False  # whether the samples are symmetric is not looked at

    x: Annotated[tuple[float, ...], Key("Grid lines along x", unit="mm")]
    y: Annotated[tuple[float, ...], Key("Grid lines along y", unit="mm")]
    heights: Annotated[
        tuple[tuple[float, ...], ...],
        Key("Heights toward the finger, one row for each x", unit="mm"),
    ]
    angle: float = 30.0
    tilt: float = 0.0
    roll: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, lines in (("x", self.x), ("y", self.y)):
            if len(lines) < SAMPLES or any(after <= before for before, after in pairwise(lines)):
                raise InputError(
                    f"indenter.{name}: expected at least {SAMPLES} rising numbers, "
                    f"received {len(lines)}: {list(lines[:5])} ..."
                )
        if len(self.x) * len(self.y) > MOST:
            raise InputError(
                f"indenter.heights: expected at most {MOST} heights, received {len(self.x)} x "
                f"{len(self.y)}; take a coarser grid, or the part that the finger meets"
            )
        if len(self.heights) != len(self.x):
            raise InputError(
                f"indenter.heights: expected one row for each of the {len(self.x)} values of x, "
                f"received {len(self.heights)} rows"
            )
        for i, row in enumerate(self.heights):
            if len(row) != len(self.y):
                raise InputError(
                    f"indenter.heights[{i}]: expected a list of {len(self.y)} numbers, received "
                    f"{len(row)}"
                )

    @property
    def profile(self) -> profiles.Relief:
        """The spline through the samples."""
        return profiles.Relief(*map(np.array, (self.x, self.y, self.heights)))

    @property
    def least_radius(self) -> float:
        """The radius in mm of its sharpest crest, of places a fifth of the samples apart."""
        u, v = (
            np.interp(np.arange(0, len(x) - 1, 0.2), np.arange(len(x)), x) for x in (self.x, self.y)
        )
        return self.profile.sharpest_radius(u, v)

    def describe(self) -> str:
        """Return "a rigid relief", with the number of its heights."""
        return f"a rigid relief of {len(self.x)} by {len(self.y)} heights"

    @cached_property
    def feature(self) -> float:
        """Width in mm of its ridges, if it were a sine with the mean squares of height and slope.

        Infinite for a plane, level or not.
        """
        lines = [np.asarray(each) for each in (self.x, self.y)]
        heights = np.asarray(self.heights, dtype=np.float64)
        places = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
        basis = np.column_stack([places, np.ones(len(places))])
        plane = np.linalg.lstsq(basis, heights.ravel(), rcond=None)[0]
        rough = heights - (basis @ plane).reshape(heights.shape)
        slopes = np.hypot(*np.gradient(rough, *lines))
        # Heights of less over the length are rounding of a plane.
        if float(np.abs(rough).max()) <= 1e-9 * float(np.ptp(lines[0])):
            return float("inf")
        return float(np.pi * rough.std() / np.sqrt(np.mean(slopes**2)))

    @property
    def extent(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Ranges in mm of x and y on which there are samples."""
        return (self.x[0], self.x[-1]), (self.y[0], self.y[-1])

    @classmethod
    def of(cls, function: Callable[[Any, Any], Any], x: Any, y: Any, **placing: float) -> Self:
        """Return the relief of a function of arrays x and y in mm, sampled at the grid lines."""
        if (count := len(x) * len(y)) > MOST:
            raise InputError(
                f"indenter.heights: expected at most {MOST} heights, received {count}; take fewer "
                "grid lines"
            )
        with np.errstate(all="ignore"):
            surface = np.asarray(function(*np.meshgrid(x, y, indexing="ij")), dtype=float)
        if surface.shape != (len(x), len(y)):
            raise InputError(
                f"indenter.heights: expected a function that returns one height for each of "
                f"{len(x)} x {len(y)} places, received an array of shape {surface.shape}"
            )
        return cls(x, y, surface.tolist(), **placing)

    @classmethod
    def from_array(cls, heights: object, pitch: float, **placing: float) -> Self:
        """Return the relief of heights (n_x, n_y) mm, `pitch` mm apart, with its middle at 0, 0."""
        pitch = number("indenter.pitch", pitch, above=0, unit="mm")
        try:
            values = np.asarray(heights, dtype=float)
        except (TypeError, ValueError) as error:
            msg = f"indenter.heights: expected an array (n_x, n_y) of numbers in mm: {error}"
            raise InputError(msg) from None
        if values.ndim != 2:
            msg = f"indenter.heights: expected an array (n_x, n_y), received shape {values.shape}"
            raise InputError(msg)
        _check_heights("indenter.heights", values)
        x, y = (pitch * (np.arange(n) - (n - 1) / 2) for n in values.shape)
        return cls(x.tolist(), y.tolist(), values.tolist(), **placing)

    @classmethod
    def from_file(
        cls,
        file: str | Path,
        *,
        pitch: float | None = None,
        height: float | None = None,
        center: bool = False,
        **placing: float,
    ) -> Self:
        """Read x, y and height in mm from CSV, NPZ, PNG or STL, see `read_relief`.

        `center` puts the middle of the file at (0, 0), where the smooth plate would touch first.
        """
        center = boolean("indenter.center", center)
        x, y, heights = read_relief(Path(file), pitch, height, center=center)
        _check_heights("indenter.file", np.asarray(heights, float), f" in {str(file)!r}")
        return cls(x, y, heights, **placing)


def _check_heights(field: str, values: Array, where: str = "") -> None:
    """Raise InputError for too few heights, or such that differ by more than a finger follows."""
    if values.size > MOST:
        raise InputError(
            f"{field}: expected at most {MOST} heights{where}, received {values.shape[0]} x "
            f"{values.shape[1]}; take a coarser grid, or the part that the finger meets"
        )
    if min(values.shape) < SAMPLES:
        raise InputError(
            f"{field}: expected at least {SAMPLES} by {SAMPLES} heights{where}, received "
            f"{values.shape[0]} by {values.shape[1]}"
        )
    # Largest difference in mm of the heights of a relief: no finger bends around more.
    tallest = 20.0
    if float(np.ptp(values)) > tallest:
        raise InputError(
            f"{field}: expected heights in mm that differ by at most {tallest:g} mm, received "
            f"{values.min():g} to {values.max():g}; convert them if they are in um, or cut off "
            "what lies deeper than the finger reaches"
        )
