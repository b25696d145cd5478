"""A grid of taxels over the pad of a tactile finger."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fefinger.contact.pad_worlds import Pad
from fefinger.support.arrays import Array
from fefinger.support.checks import integer, number


@dataclass(frozen=True)
class TaxelGrid:
    """A grid of taxels over the pad, rows along x (distal) and columns along y.

    pitch mm; center (2,) mm of the grid: beneath the middle of the pad by default. The skin beside
    the grid belongs to the nearest taxel, so that no force is lost.
    """

    rows: int
    columns: int
    pitch: float = 1.6
    center: tuple[float, float] = (-4.0, 0.0)

    def __post_init__(self) -> None:
        """Check the numbers."""
        integer("taxels.rows", self.rows, at_least=1)
        integer("taxels.columns", self.columns, at_least=1)
        number("taxels.pitch", self.pitch, above=0, unit="mm")

    @property
    def places(self) -> Array:
        """Middle (rows * columns, 2) mm of each taxel, column by column within a row."""
        x, y = (
            middle + self.pitch * (np.arange(n) - (n - 1) / 2)
            for middle, n in zip(self.center, (self.rows, self.columns), strict=True)
        )
        return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)

    def weights(self, pad: Pad) -> sparse.csr_matrix:
        """Return N/kPa (n_taxels, n) of unit tractions: integrals of their hats over a taxel."""
        counts = self.rows, self.columns
        start = self.places[0]
        at = np.rint((pad.places[..., :2] - start) / self.pitch).astype(int)
        row, column = (np.clip(at[..., k], 0, counts[k] - 1) for k in (0, 1))
        taxel = np.broadcast_to((row * self.columns + column)[:, None], pad.hats.shape)
        owner = np.broadcast_to(pad.owner[:, :, None], pad.hats.shape)
        owned = owner >= 0
        entries = 1e-3 * pad.hats[owned], (taxel[owned], owner[owned])
        return sparse.csr_matrix(entries, shape=(self.rows * self.columns, len(pad.areas)))
