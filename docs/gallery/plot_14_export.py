"""
Export to NWB, xarray and pandas
================================

A result and its spikes in the formats of other programs.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
from pynwb import NWBHDF5IO

import fefinger as ff


folder = Path(tempfile.mkdtemp())
result = ff.run("flat-press")

# %%
# xarray: everything, labeled and with units.
data = result.to_xarray()
print(data[["force", "depth"]])

# %%
# pandas: one row per spike.
table = result.spikes.to_pandas()
print(table.head())

fig, axis = plt.subplots(figsize=(6, 2.4), layout="constrained")
axis.eventplot([rows["time_s"] for _, rows in table.groupby("type")], linelengths=0.8)
axis.set(xlabel="time / s", yticks=range(4), yticklabels=sorted(table["type"].unique()))
plt.show()

# %%
# One row per unit, silent ones too, for rates.
print(result.spikes.units_to_pandas())

# %%
# NWB: units with their spike times, for the tools of electrophysiology.
result.spikes.to_nwb(folder / "spikes.nwb")

with NWBHDF5IO(folder / "spikes.nwb", "r") as file:
    units = file.read().units
    print(units.colnames, "-", len(units), "units")

# %%
# A folder with all of it, and a report for a browser.
for path in result.save(folder / "out"):
    print(Path(path).name)
