"""A rigid plate with raised dots, which a finger scans."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from fefinger.geometry import profiles
from fefinger.scene.raised import SAMPLES, FlankLimit, Raised
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice, integer


ARRANGEMENTS = ("grid", "random")

TILE = 12
"""Spacings along a side of the square of random dots, which repeats."""

THROWS = 400
"""Places tried for each random dot."""


@final
@dataclass(frozen=True)
class Dots(Raised):
    """A plate with dots `spacing` mm apart, on a square grid or at random, without an end.

    `diameter` mm is that at half of the `height` mm; `edge` is 0.1 mm where that fits. Random dots
    (`seed`) have the density of the grid and do not overlap; their pattern repeats after 12
    spacings. On a grid a dot lies at the point that the smooth plate would touch first.
    """

    kind = "dots"
    lengths = ("diameter", "spacing", "height")
    usual_edge = 0.1

    spacing: float
    height: float = 0.4
    diameter: float = 0.7
    edge: float | None = None
    arrangement: str = "grid"
    seed: int = 0
    angle: float = 30.0
    tilt: float = 0.0
    roll: float = 0.0

    def __post_init__(self) -> None:
        """Check the number of samples besides, and that dots do not overlap."""
        super().__post_init__()
        self._check_samples("spacing", self.spacing, (self.tile, self.tile))
        choice("indenter.arrangement", self.arrangement, ARRANGEMENTS)
        integer("indenter.seed", self.seed)
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
        raise InputError(
            f"indenter.spacing: expected room for {TILE**2} dots {self.base:.3g} mm wide at random "
            f"at {self.spacing:g} mm, found it for {len(placed)}; take a larger spacing"
        )

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
