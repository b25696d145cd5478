"""The digitized points of published figures, as arrays; their files say where they come from."""

import csv
from functools import cache
from importlib import resources

import numpy as np

from fefinger.support.arrays import Array


FREQUENCIES = (20.0, 50.0, 300.0, 600.0)
"""Hz of the vibrations."""

AT_100_HZ = {"FAI": ((100.0, 100.0), (200.0, 160.0)), "FAII": ((130.0, 130.0),)}
"""Amplitudes in um and rates in Hz at 100 Hz of Muniak et al. (2007), as read by others from its
figures: the points themselves are not at hand."""


@cache
def rows(name: str) -> tuple[dict[str, str], ...]:
    """Return the rows of a file by its column names."""
    text = resources.files("fefinger.validation.afferents").joinpath(f"data/{name}.csv").read_text()
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    return tuple(csv.DictReader(lines))


def rates(kind: str, frequency: float) -> tuple[Array, Array]:
    """Amplitudes in mm and mean rates in Hz of a type at a frequency in Hz."""
    of = [
        (1e-3 * float(row["amplitude_um"]), float(row["rate_Hz"]))
        for row in rows("vibration_rates")
        if row["type"] == kind and float(row["frequency_Hz"]) == frequency
    ]
    amplitude, rate = np.array(of).T
    return amplitude, rate


def thresholds(kind: str) -> tuple[Array, Array]:
    """Frequencies in Hz and threshold amplitudes in mm of single units."""
    of = [
        (float(row["frequency_Hz"]), 1e-3 * float(row["threshold_um"]))
        for row in rows("thresholds_units")
        if row["type"] == kind
    ]
    frequency, amplitude = np.array(of).T
    return frequency, amplitude


def table(name: str) -> Array:
    """All numbers of a file without a column of text, (n_rows, n_columns)."""
    return np.array([[float(value) for value in row.values()] for row in rows(name)])
