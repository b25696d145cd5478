"""Products with a flexibility that is known by wavenumber, of stresses in a window of a grid.

In single precision. A window is moved to the corner of the grid: rows of it that are empty are not
transformed.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from fefinger.support.arrays import Array, Flags


AROUND = 3
"""Grid points about the contact that a window has."""

Waves = NDArray[np.complex64]

Spectrum = NDArray[np.float32]


class Window(NamedTuple):
    """A part of a grid of `points`, by rows."""

    points: tuple[int, int]
    rows: slice
    columns: slice

    @classmethod
    def about(cls, touched: Flags, points: tuple[int, int]) -> "Window":
        """Return the window about the points (n,) that are touched, at least one."""
        grid = touched.reshape(points)
        rows, columns = (_bounds(np.any(grid, axis=axis, keepdims=True).ravel()) for axis in (1, 0))
        return cls(points, rows, columns)

    @property
    def shape(self) -> tuple[int, int]:
        """Points of the window along both axes."""
        return self.rows.stop - self.rows.start, self.columns.stop - self.columns.start

    def part(self, values: Array) -> Array:
        """Return the values (..., m) of a window of those (..., n) of a grid, a copy."""
        grid = values.reshape(*values.shape[:-1], *self.points)[..., self.rows, self.columns]
        return grid.reshape(*values.shape[:-1], -1)

    def put(self, values: Array, part: Array) -> None:
        """Set the values (..., n) of a grid to those (..., m) of its window."""
        grid = values.reshape(*values.shape[:-1], *self.points)
        grid[..., self.rows, self.columns] = part.reshape(*values.shape[:-1], *self.shape)

    def waves(self, part: Array) -> Waves:
        """Return the transforms (..., n_x, n_y // 2 + 1) of values (..., m) of the window."""
        rows, columns = self.points
        single = part.astype(np.float32).reshape(*part.shape[:-1], *self.shape)
        along = fft.rfft(single, columns, axis=-1)
        return np.asarray(fft.fft(along, rows, axis=-2, overwrite_x=True))

    def values(self, waves: Waves) -> Array:
        """Return the values (..., m) in the window of transforms, which are overwritten."""
        rows, columns = self.shape
        back = fft.ifft(waves, axis=-2, overwrite_x=True)[..., :rows, :]
        grid = fft.irfft(back, self.points[1], axis=-1)[..., :columns]
        return np.asarray(grid, np.float64).reshape(*waves.shape[:-2], -1)

    def product(self, part: Array, spectrum: Spectrum) -> Array:
        """Return values (..., m) of the window, convolved with what has a spectrum."""
        waves = self.waves(part)
        waves *= spectrum
        return self.values(waves)


def _bounds(touched: Flags) -> slice:
    """Return the slice about the lines (n,) that are touched, and AROUND more."""
    at = np.flatnonzero(touched)
    return slice(max(int(at[0]) - AROUND, 0), min(int(at[-1]) + AROUND + 1, len(touched)))
