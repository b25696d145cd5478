"""A rigid plate with the relief of a woven fabric, made from a spectrum that is stated."""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, final

import numpy as np
from scipy import fft

from fefinger.geometry import profiles
from fefinger.scene.indenter import Indenter
from fefinger.scene.key import Key
from fefinger.support.arrays import Array


REPEAT = 8
"""Yarns along a side of the square that repeats."""


@final
@dataclass(frozen=True)
class Fabric(Indenter):
    """A rigid plate like a plain weave: a crown where a yarn crosses another, and finer fibers.

    The heights of the weave are height / 4 (1 + cos k u) (1 + cos k v) with k = 2 pi / yarn: their
    spectrum has lines at 1 / yarn along both yarns, and where both meet. Fibers add waves of random
    phases (`seed`), as rough as `roughness` (root mean square), from the length `yarn` down to
    `fiber`, whose spectrum falls with the wavenumber q as q^-3.6. The pattern repeats after eight
    yarns; a crown lies at the point that the smooth plate would touch first.
    """

    sharp = True
    raised = True
    mirrored = False  # fibers are at random

    yarn: Annotated[float, Key("Distance of the yarns", unit="mm", at_least=0.2, at_most=5)] = 1.0
    height: Annotated[float, Key("Height of the crowns", unit="mm", above=0, at_most=1)] = 0.15
    fiber: Annotated[float, Key("Shortest wave of the fibers", unit="mm", at_least=0.05)] = 0.2
    roughness: Annotated[
        float, Key("Roughness of the fibers", unit="mm", at_least=0, at_most=0.5)
    ] = 0.004
    seed: Annotated[int, Key("Seed of the fibers", at_least=0)] = 0
    angle: float = 30.0
    tilt: float = 0.0
    roll: float = 0.0

    @property
    def tile(self) -> float:
        """Side in mm of the square that repeats."""
        return REPEAT * self.yarn

    @cached_property
    def heights(self) -> Array:
        """Heights (n, n) mm of the square that repeats, from a crown on."""
        per_wave = 6.0  # samples in the shortest wave of the fibers
        n = 2 * int(np.ceil(per_wave * self.tile / min(self.fiber, self.yarn) / 2))
        turn = 2 * np.pi * REPEAT * np.arange(n) / n
        crowns = (1 + np.cos(turn)) / 2
        return self.height * np.multiply.outer(crowns, crowns) + self._fibers(n)

    def _fibers(self, n: int) -> Array:
        """Return the heights (n, n) mm of the fibers."""
        along, across = np.meshgrid(fft.fftfreq(n), fft.rfftfreq(n), indexing="ij")
        q = np.hypot(along, across) * n / self.tile
        inside = (q > 1 / self.yarn) & (q <= 1 / self.fiber)
        # Power of the wavenumber with which the spectrum of the fibers falls, that of a self-affine
        # surface of Hurst exponent 0.8: 2 (1 + 0.8).
        fall = 3.6
        size = np.where(inside, np.maximum(q, 1 / self.tile) ** (-fall / 2), 0.0)
        phases = np.exp(2j * np.pi * np.random.default_rng(self.seed).random(q.shape))
        waves = np.asarray(fft.irfft2(size * phases, (n, n)))
        deviation = float(waves.std())
        return waves * (self.roughness / deviation if deviation > 0 else 0.0)

    @cached_property
    def profile(self) -> profiles.Tiled:
        """The square, repeated."""
        n = len(self.heights)
        margin = 3  # samples beyond the square, for the spline through them
        index = np.arange(-margin, n + margin + 1)
        lines = self.tile / n * index.astype(np.float64)
        relief = profiles.Relief(lines, lines, self.heights[np.ix_(index % n, index % n)])
        return profiles.Tiled(relief, self.tile)

    @property
    def repeats(self) -> tuple[float, float]:
        """The distance in mm of the yarns, along both."""
        return self.yarn, self.yarn

    @property
    def feature(self) -> float:
        """Width in mm of a crown at half its height."""
        return self.yarn / 2

    @property
    def narrowest(self) -> float:
        """The same: fibers are no parts between which skin sinks."""
        return self.feature

    @cached_property
    def least_radius(self) -> float:
        """The radius in mm of its sharpest crest, of places a sample apart."""
        n = len(self.heights)
        lines = self.tile / n * np.arange(n, dtype=np.float64)
        return self.profile.relief.sharpest_radius(lines, lines)

    def describe(self) -> str:
        """Return "a rigid fabric", with its yarns and fibers."""
        return (
            f"a rigid fabric of yarns every {self.yarn:g} mm, crowns {self.height:g} mm high, with "
            f"fibers down to {self.fiber:g} mm, {1e3 * self.roughness:g} um rough"
        )
