"""Spike trains of afferent units, with exports to files and tables."""

from datetime import datetime
from os import PathLike
from typing import TYPE_CHECKING, Any

from fefinger.neural import exports
from fefinger.neural.train_record import TrainRecord
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


class SpikeTrains(TrainRecord):
    """Spike trains of afferent units, with exports to files and tables."""

    def __repr__(self) -> str:
        """Show the numbers of spikes, not the arrays."""
        return f"<SpikeTrains, {self.t_start:g} to {self.t_stop:g} s: {self.summary()}>"

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Write one row per spike: unit, type, place in mm and time in s."""
        exports.to_csv(self, path)

    def to_npz(self, path: str | PathLike[str]) -> None:
        """Write all fields to an NPZ file, which `from_npz` reads back bit by bit."""
        exports.to_npz(self, path)

    @classmethod
    def from_npz(cls, path: str | PathLike[str]) -> "SpikeTrains":
        """Read spike trains that `to_npz` wrote; InputError for another file."""
        fields = exports.read_npz(path)
        try:
            return cls(**fields)
        except InputError as error:
            raise InputError(f"{path}: {error}") from error

    def to_pandas(self) -> "pd.DataFrame":
        """Convert to a table, one row per spike: unit, type, place and depth in mm, time in s."""
        return exports.to_pandas(self)

    def to_xarray(self) -> "xr.Dataset":
        """Convert to a Dataset: signals over time and unit, and all spikes."""
        return exports.to_xarray(self)

    def to_neo(self) -> Any:
        """Convert to a neo.Block: an annotated SpikeTrain per unit, and signals (extra `neo`)."""
        return exports.to_neo(self)

    def to_nwb(
        self,
        path: str | PathLike[str],
        *,
        description: str = "simulated spike trains of tactile afferents",
        started: datetime | None = None,
    ) -> None:
        """Write an NWB file of the units and the displacement that drove them (extra `nwb`)."""
        exports.to_nwb(self, path, description=description, started=started)
