"""Titles of results that are shown side by side: names, and differing values of the scenes."""

from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from fefinger.results.result_record import ResultRecord
from fefinger.scene.field_units import column, split
from fefinger.support.text import flat


MOST = 3  # differences in a title
LONG = 24  # letters of a value in a title
SHOWN = ("indenter.", "motion.", "finger.")  # the outputs of a scene do not change its picture
SUBJECT = "finger.subject"
SIZES = ("finger.width", "finger.thickness", "finger.pad_radius")  # set by the subject


def titles(
    results: Sequence[ResultRecord], folders: Sequence[str | PathLike[str]] = ()
) -> tuple[str, ...]:
    """Return a title for each result: name of its scene, its folder's where there are several.

    With the values in which the scenes differ, as many as there is room for.
    """
    names = [result.scene.name for result in results]
    if len(results) == 1:
        return tuple(names)
    if folders:
        ours = [Path(folder).resolve() for folder in folders]
        folder_names = [path.parent.name if path.suffix == ".nc" else path.name for path in ours]
        names = [folder if folder == name else f"{folder}: {name}"
                 for folder, name in zip(folder_names, names, strict=True)]  # fmt: skip
    tables = [dict(flat(result.scene.to_dict())) for result in results]
    every = dict.fromkeys(key for table in tables for key in table if key.startswith(SHOWN))
    varied = [key for key in every if len({repr(table.get(key)) for table in tables}) > 1]
    kinds = {key.removesuffix("kind") for key in varied if key.endswith(".kind")}
    # Other values of parts of different kinds are not comparable.
    varied = [key for key in varied if key.endswith(".kind") or not key.startswith(tuple(kinds))]
    if SUBJECT in varied:
        varied = [key for key in varied if key not in SIZES]
    varied.sort(key=lambda key: (not key.endswith(".kind"), SHOWN.index(key.split(".")[0] + ".")))
    return tuple(
        ", ".join([name, *_differences(table, varied)])
        for name, table in zip(names, tables, strict=True)
    )


def _differences(table: Mapping[str, Any], varied: Sequence[str]) -> Iterator[str]:
    for key in varied[:MOST]:
        value = table.get(key, "none")
        text = f"{value:g}" if isinstance(value, float) else str(value)
        if not isinstance(value, str):
            text = f"{text} {split(column(key, table['motion.kind']))[1]}".strip()
        yield f"{key} {text}" if len(text) <= LONG else f"another {key}"
    if len(varied) > MOST:
        yield f"{len(varied) - MOST} more"
