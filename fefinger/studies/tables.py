"""The rows of a study and their files: CSV, Parquet or netCDF.

CSV holds the numbers only; Parquet and netCDF also hold the inputs of the study.
"""

import os
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fefinger.pages.page import flat
from fefinger.scene.schema import split
from fefinger.studies.grid import MEASURES, MISSED, meaning
from fefinger.support.atomic_write import check_name, in_place, netcdf
from fefinger.support.checks import InputError
from fefinger.support.inputs import read_json


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
        table.attrs = {"scene": self.name, **dict(flat(self.about))}
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
