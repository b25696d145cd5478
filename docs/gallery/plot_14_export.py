"""
Export to NWB, xarray and pandas
================================

A result and its spikes in the formats of other programs.
"""

import tempfile
from pathlib import Path

import fefinger as ff


folder = Path(tempfile.mkdtemp())
result = ff.run("flat-press")

# %%
# xarray: everything, labeled and with units.
data = result.to_xarray()
print(data[["force", "depth"]])

# %%
# pandas: one row per spike.
print(result.spikes.to_pandas().head())

# %%
# NWB: units with their spike times, for the tools of electrophysiology.
result.spikes.to_nwb(folder / "spikes.nwb")
from pynwb import NWBHDF5IO  # noqa: E402


with NWBHDF5IO(folder / "spikes.nwb", "r") as file:
    units = file.read().units
    print(units.colnames, "-", len(units), "units")

# %%
# A folder with all of it, and a report for a browser.
for path in result.save(folder / "out"):
    print(Path(path).name)
