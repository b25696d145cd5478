"""The rows of a study, stiffness from force and depth, and files: CSV, Parquet or netCDF.

CSV holds the numbers only; Parquet and netCDF also hold the inputs of the study.
"""

import os
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fefinger.scene.motion import Motion
from fefinger.scene.schema import split
from fefinger.studies.grid import MEASURES, MISSED, meaning
from fefinger.support.arrays import Array, Flags
from fefinger.support.atomic_write import check_name, in_place, netcdf
from fefinger.support.checks import InputError
from fefinger.support.inputs import read_json
from fefinger.support.text import entries
from fefinger.support.vocabulary import Control


if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


ENDINGS = ".csv", ".parquet", ".nc"

NAMES = "table.csv", "study.json", "report.html"
"""Files of a saved study, besides the answers to its scenes."""


@dataclass(frozen=True)
class StudyRows:
    """The rows of a study in the order of its grid.

    name of the scene; over: columns of the grid; rows: one per scene and time; failures: (values of
    the grid, sentence); scenes: how many; reused: how many of them were finished before; about:
    inputs and provenance of the study.
    """

    name: str
    over: tuple[str, ...]
    rows: tuple[dict[str, Any], ...]
    failures: tuple[tuple[dict[str, object], str], ...]
    scenes: int
    reused: int
    about: dict[str, Any]

    def __repr__(self) -> str:
        """Show the grid and the numbers of scenes, not the rows."""
        grid = ", ".join(f"{name} ({len(each)})" for name, each in self.about["grid"].items())
        done = self.scenes - len(self.failures)
        return f"<Study of {self.name} over {grid}: {done} of {self.scenes} scenes answered>"

    def table(self) -> "pd.DataFrame":
        """Return the rows as a table whose `attrs` hold the inputs of the study."""
        import pandas as pd

        plain = [{k: v for k, v in row.items() if not isinstance(v, list)} for row in self.rows]
        columns = list(dict.fromkeys(key for row in plain for key in row))
        table = pd.DataFrame(plain, columns=columns)
        table.attrs = {"scene": self.name, **dict(entries(self.about))}
        return table


def check(path: str | PathLike[str], option: str) -> None:
    """Raise InputError of `option` if no table can be written to `path`."""
    path = Path(path)
    if path.suffix.lower() not in ENDINGS:
        listed = ", ".join(ENDINGS)
        msg = f"{option}: expected a file that ends in one of {listed}, received {path.name!r}"
        raise InputError(msg)
    if not os.path.isdir(path.parent):
        msg = f"{option}: expected a file in a folder that exists, received {str(path)!r}"
        raise InputError(msg)
    if os.path.isdir(path) or not os.access(path.parent, os.W_OK):
        what = "a folder" if os.path.isdir(path) else "one in a folder that cannot be written to"
        msg = f"{option}: expected a file that can be written, received {what}: {str(path)!r}"
        raise InputError(msg)
    check_name(path, option)
    if path.suffix.lower() == ".parquet" and find_spec("pyarrow") is None:
        raise InputError(
            f"{option}: expected pyarrow to be installed for a Parquet file, found none; run `pip "
            "install 'fefinger[parquet]'`, or name a file that ends in .csv or .nc"
        )


def write(study: StudyRows, path: str | PathLike[str], option: str = "table") -> str:
    """Write the table of a study to a file that ends in one of ENDINGS, and return its path.

    The file appears complete or not at all. Raises InputError of `option` as `check`.
    """
    check(path, option)
    path = Path(path)
    with in_place(path) as new:
        if path.suffix.lower() == ".csv":
            study.table().to_csv(new, index=False)
        elif path.suffix.lower() == ".parquet":
            _uniform(study.table()).to_parquet(new, engine="pyarrow", index=False)
        else:
            new.write_bytes(netcdf(dataset(study)))
    return str(path)


def _uniform(table: "pd.DataFrame") -> "pd.DataFrame":
    """Return the table with texts in the columns that are not numeric, as Parquet needs it."""
    from pandas.api.types import is_numeric_dtype

    for name in table:
        if not is_numeric_dtype(table[name]):
            table[name] = table[name].map(lambda value: value if value is None else str(value))
    return table


def dataset(study: StudyRows) -> "xr.Dataset":
    """Convert the rows of a study to arrays over the fields of its grid and over `at`.

    Entries of failed scenes, and at forces or depths that are not reached, are nan or empty.
    """
    import pandas as pd
    import xarray as xr

    keys = [*study.over, "at"]
    rows = [row for row in study.rows if row["at"]]
    axes = {
        name: list(dict.fromkeys(row[name] for row in (study.rows if name != "at" else rows)))
        for name in keys
    }
    every = pd.MultiIndex.from_product(axes.values())
    table = study.table()
    failed = table[table["at"] == ""].set_index(list(study.over)).index
    done = table[table["at"] != ""]
    done = done.drop(columns=keys).set_axis(pd.MultiIndex.from_frame(done[keys])).reindex(every)
    absent = np.where(every.droplevel(-1).isin(failed), "failed", MISSED)
    done["status"] = done["status"].fillna(pd.Series(absent, every))
    shape = tuple(len(values) for values in axes.values())
    arrays = {
        name: (
            keys,
            _plain(done[name]).reshape(shape),
            _about(name, MEASURES.get(name) or meaning(name)),
        )
        for name in done
    }
    coordinates = {
        name: (name, values, _about(name, split(name)[0])) for name, values in axes.items()
    }
    return xr.Dataset(arrays, coordinates, table.attrs)


def _plain(column: "pd.Series") -> NDArray[np.generic]:
    """Return a column as an array of numbers or of texts."""
    from pandas.api.types import is_numeric_dtype

    if is_numeric_dtype(column):
        return column.to_numpy()
    return column.fillna("").astype(str).to_numpy(dtype=object)


def _about(name: str, words: str) -> dict[str, str]:
    unit = split(name)[1]
    units = {"units": unit.replace("²", "2")} if unit else {}
    return {"long_name": words, **units}


def set_aside(study: StudyRows, folder: Path) -> list[str]:
    """Move the files of an earlier study of other scenes into a subfolder; return the new paths.

    Files of a study whose scenes are all in the present one, which repeats or extends it, stay to
    be replaced. Files of these names that no study wrote are moved too.
    """
    moved = [name for name in NAMES if (folder / name).exists()]
    with suppress(OSError, ValueError, KeyError, TypeError, AttributeError):
        before = read_json(folder / "study.json")
        scenes = {row.get("scene") for row in before["rows"]} - {None}
        if scenes <= {row.get("scene") for row in study.rows}:
            return []
    if not moved:
        return []
    count = 1
    while (folder / f"earlier-{count}").exists():
        count += 1
    aside = folder / f"earlier-{count}"
    aside.mkdir()
    return [str((folder / name).rename(aside / name)) for name in moved]


SAME = 1e-9
"""Relative difference up to which two forces or depths are the same level."""

WINDOW = 1.3
"""The fit covers depths from 1 / WINDOW to WINDOW times the depth; if the loading ends before, it
begins that much lower."""

POINTS = 5
"""Fewest time steps of a fit."""

MOVING = 0.5
"""Share of the top rate below which the motion counts as a hold, in which the force relaxes."""

RESTING = "none: not on the loading, or slower than half the top rate of the motion"


class NamedTime(NamedTuple):
    """A time of a row: its name, and where it is as a fractional index of the time steps.

    `where` is nan if the time is never reached; then `missed` is the reason. given: "force" or
    "depth" at a given level of it, "" for peak and end.
    """

    name: str
    where: float
    missed: str
    given: str = ""


def named_times(
    force: Array, depth: Array, forces: tuple[float, ...], depths: tuple[float, ...]
) -> list[NamedTime]:
    """Find the peak and the end of force (n_t,) N and depth (n_t,) mm, and crossings of levels.

    A crossing is the first on the loading, by linear interpolation between two steps.
    """
    top, deepest = first(force, force.max()), first(depth, depth.max())
    times = [NamedTime("peak", float(top), ""), NamedTime("end", float(len(force) - 1), "")]
    for name, unit, signal, levels in (
        ("force", "N", force[: top + 1], forces),
        ("depth", "mm", depth[: deepest + 1], depths),
    ):
        for level in levels:
            where = _reached(signal, level)
            reason = f"{MISSED}: {name} = {signal[-1]:.4g} {unit} at most"
            missed = reason if np.isnan(where) else ""
            times.append(NamedTime(f"{level:g} {unit}", where, missed, given=name))
    return times


def first(signal: Array, level: float) -> int:
    """Return the index at which a signal first reaches a level, within rounding."""
    return int(np.argmax(signal >= level - SAME * abs(level)))


def _reached(signal: Array, level: float) -> float:
    """Return the fractional index at which a signal first reaches a level; nan if it does not."""
    if signal.max() < level * (1 - SAME):
        return float("nan")
    after = first(signal, level)
    if after == 0:
        return 0.0
    low, high = signal[after - 1], signal[after]
    return after - 1 + min(float((level - low) / (high - low)), 1.0)


def at(signal: Array, where: float) -> Array:
    """Interpolate a signal (n_t, ...) at a fractional index."""
    low, part = int(where), where - int(where)
    return signal[low] if part == 0 else (1 - part) * signal[low] + part * signal[low + 1]


def until(signal: Array, where: float) -> Array:
    """Return a signal (n_t,) up to a fractional index, where it is interpolated."""
    return np.append(signal[: int(where) + 1], at(signal, where))


class Slope(NamedTuple):
    """A slope in N/mm, the number of fitted time steps, and the reason if the slope is nan."""

    value: float
    points: int
    note: str


def stiffness(time: Array, depth: Array, force: Array, where: float, *, control: str) -> Slope:
    """Fit the slope of force over depth at a fractional index.

    The logarithm of the force is a parabola of the logarithm of the depth. The fit is exact for a
    power law, and within 1 % inside and 3 % at the end for an exponential law, for any spacing of
    the steps. Under plates at 0 to 60 degrees to 1 N, `linear` on the coarse and the standard mesh
    differ by 1 % at 0.5 N and 2 % at the end (RMS); slopes of single steps differ by 4 and 5 %.

    time (n_t,) s, depth (n_t,) mm, force (n_t,) N; control: "depth" or "force", which the motion
    prescribes. Fitted are consecutive steps in which both rise, no slower than MOVING.
    """
    driven = Control(control).of(depth, force)
    rate = np.diff(driven) / np.diff(time)
    loading = (np.diff(depth) > 0) & (np.diff(force) > 0) & (rate >= MOVING * np.abs(rate).max())
    step, here = max(int(np.ceil(where)) - 1, 0), float(at(depth, where))
    if not loading[step] or here <= 0:
        return Slope(float("nan"), 0, RESTING)
    low, high = _stretch(loading, step)
    depth, force = depth[low:high], force[low:high]
    away = np.log(np.maximum(depth / here, 1e-300))
    above = min(np.log(WINDOW), away[-1])
    # 1e-9 is for rounding of steps at the ends of the window.
    near = (away >= above - 2 * np.log(WINDOW) - 1e-9) & (away <= above + 1e-9) & (force > 0)
    points = int(near.sum())
    if points < POINTS:
        note = f"none: {points} steps of the loading within a factor of {WINDOW:g} of the depth"
        return Slope(float("nan"), points, f"{note}, expected {POINTS}")
    size, power, _ = np.polynomial.polynomial.polyfit(away[near], np.log(force[near]), 2)
    return Slope(float(power * np.exp(size) / here), points, "")


def _stretch(good: Flags, step: int) -> tuple[int, int]:
    """Return the range of times, first and last + 1, around a step with good steps alone."""
    bad = np.flatnonzero(~good)
    before, after = bad[bad < step], bad[bad > step]
    low = int(before[-1]) + 1 if before.size else 0
    return low, (int(after[0]) if after.size else len(good)) + 1


def dynamic_stiffness(motion: Motion, time: Array, depth: Array, force: Array) -> complex | None:
    """Fit the complex ratio of force and depth, in N/mm, to the last cycles of a vibration.

    Its phase is by how much the force leads. time (n_t,) s, depth (n_t,) mm, force (n_t,) N. Means
    and slow drifts do not count. None without a whole cycle, or where contact opens in a cycle.
    """
    wave = motion.trajectory.wave
    if wave is None:
        return None
    frequency = wave.last_frequency
    # The last four cycles are fitted, or all where there are fewer.
    cycles = min(4, int((motion.duration - wave.start) * frequency * (1 + 1e-9)))
    last = time >= time[-1] - cycles / frequency * (1 + 1e-9)
    if not cycles or not (force[last] > 0).all():
        return None
    angle, drift = wave.angle(time[last] - wave.start), (time[last] - time[-1]) * frequency / cycles
    terms = np.column_stack([np.cos(angle), np.sin(angle), drift**0, drift, drift**2])
    fitted = np.linalg.lstsq(terms, np.column_stack([depth[last], force[last]]), rcond=None)[0]
    moved, pushed = fitted[0] - 1j * fitted[1]
    return complex(pushed / moved)
