"""Spike trains of afferent units, with the signals that made them."""

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
    """What the afferent units fired, and the files and tables that it is exported to."""

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Write one row per spike: unit, type, place in mm and time in s."""
        exports.to_csv(self, path)

    def to_npz(self, path: str | PathLike[str]) -> None:
        """Write everything to an NPZ file that `from_npz` reads back to the last bit."""
        exports.to_npz(self, path)

    @classmethod
    def from_npz(cls, path: str | PathLike[str]) -> "SpikeTrains":
        """Return what `to_npz` wrote; InputError for another file."""
        fields = exports.read_npz(path)
        try:
            return cls(**fields)
        except InputError as error:
            msg = f"{path}: {error}"
            raise InputError(msg) from error

    def to_pandas(self) -> "pd.DataFrame":
        """Return a table with one row per spike: unit, type, place and depth in mm, time in s."""
        return exports.to_pandas(self)

    def to_xarray(self) -> "xr.Dataset":
        """Return a dataset of the signals over time and unit, and of all spikes."""
        return exports.to_xarray(self)

    def to_neo(self) -> Any:
        """Return a neo.Block: one annotated SpikeTrain per unit, and the signals (extra `neo`)."""
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
