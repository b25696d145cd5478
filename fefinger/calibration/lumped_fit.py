"""Fit the lumped finger to a user's ramp and hold: `fefinger fit DATA.csv`.

The file has the columns time, position (growing into the finger) and force (positive in
compression), in any order, unit and format of `recording_files`; others are ignored. Both
identifications of `theory/lumped/identify.py` are made, with their uncertainties.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fefinger.support import atomic_write, recording_files
from fefinger.support.arrays import Array
from fefinger.support.atomic_write import keep
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.inputs import first_line
from fefinger.support.text import strict_json, table
from fefinger.support.units import DURATION, FORCE, TRAVEL
from fefinger.theory.lumped import identify, ramp_hold
from fefinger.theory.lumped import spring as lumped
from fefinger.theory.lumped.identify import Identification


QUANTITIES = ("time", "position", "force")
WAYS = ("thesis", "joint")
PARAMETER_UNITS = {"b": "N/mm", "m": "1/mm", "x0": "mm", "c": "", "v": "1/s"}

LIKELY = {"position": TRAVEL, "force": FORCE, "time": DURATION}
"""Range of each column for a finger."""


@dataclass(frozen=True)
class LumpedFit:
    """A record, (n_t,) each, and its two identifications."""

    time: Array
    position: Array
    force: Array
    thesis: Identification
    joint: Identification


def fit(
    file: str | Path, *, terms: int = identify.TERMS, columns: Mapping[str, str] | None = None
) -> LumpedFit:
    """Identify the lumped model in both ways from a file, with `terms` exponentials.

    `columns` as of `read`.

    Raises InputError if the file cannot be read or used; the message names column and row;
    ConvergenceError if a fit does not converge.
    """
    time, position, force = read(file, columns=columns)
    try:
        fits = [
            way(time, position, force, terms=terms) for way in (identify.thesis, identify.joint)
        ]
    except ValueError as error:
        raise InputError(f"{file}: {error}") from None
    except RuntimeError as error:
        raise ConvergenceError(f"{file}: {error}") from None
    return LumpedFit(time, position, force, *fits)


def read(
    file: str | Path,
    *,
    fewest: int = 2 * ramp_hold.FEWEST,
    of: str = "a ramp and hold",
    columns: Mapping[str, str] | None = None,
) -> tuple[Array, Array, Array]:
    """Read and check time in s from 0, position in mm and force in N, each (n,), of a file.

    `fewest`: least number of rows; `of`: kind of record, for the message; `columns`: headers of
    time, position or force that cannot be told, as of `Recording.pick`.
    """
    time, position, force = recording_files.read(str(file), file).pick(QUANTITIES, columns).T
    if len(time) < fewest:
        raise InputError(f"{file}: expected at least {fewest} rows of {of}, received {len(time)}")
    for name, values in zip(QUANTITIES, (time, position, force), strict=True):
        _check_unit(str(file), name, values)
    _check_signs(str(file), position, force)
    return time - time[0], position, force


def _check_unit(file: str, name: str, values: Array) -> None:
    likely = LIKELY[name]
    size = float(np.abs(values).max() if name == "force" else np.ptp(values))
    hint = likely.hint(size)
    if not hint:
        return
    if np.ptp(values) == 0:
        msg = f"{file}: {name}: expected numbers that change, received {values[0]:g} in every row"
        raise InputError(msg)
    raise InputError(
        f"{file}: {name}: expected {likely.unit}, with a {likely.what} of {likely.low:g} to "
        f"{likely.high:g}, received {size:.3g}{hint}; convert the column"
    )


def _check_signs(file: str, position: Array, force: Array) -> None:
    if force.max() < -force.min():
        msg = f"{file}: force: expected pressing to be positive, received up to {force.min():.3g} N"
        raise InputError(msg)
    highest = int(force.argmax())
    until = position[: highest + 1]
    if position[highest] < (until.min() + until.max()) / 2:
        raise InputError(
            f"{file}: position: expected values that grow into the finger, received values that "
            "fall while the force rises; change their sign"
        )


def record(fit: LumpedFit) -> dict[str, Any]:
    """Record a fit as plain values: value and one standard deviation of every parameter."""
    ways = {way: getattr(fit, way) for way in WAYS}
    return {"samples": len(fit.time)} | {
        way: {
            "parameters": {
                name: {
                    "value": value,
                    "uncertainty": each.uncertainty[name],
                    "unit": PARAMETER_UNITS.get(name, PARAMETER_UNITS.get(name[0], "")),
                }
                for name, value in each.parameters.items()
            },
            "mse_percent": 100 * each.mse,
            "vaf_stiffness": each.vaf_stiffness,
            "vaf_hold": each.vaf_hold,
            "warnings": list(each.warnings),
        }
        for way, each in ways.items()
    }


def summary(fit: LumpedFit) -> str:
    """Format a fit as text: the joint fit beside the procedure of Pawluk (1997)."""
    ways = {way: record(fit)[way] for way in ("joint", "thesis")}
    spread = "{value:.4g} +- {uncertainty:.2g}"
    rows = [
        [name, first["unit"], *(spread.format(**way["parameters"][name]) for way in ways.values())]
        for name, first in ways["joint"]["parameters"].items()
    ]
    rows.append(["mse", "%", *(f"{way['mse_percent']:.3g}" for way in ways.values())])
    heading = ["", "unit", "ramp and hold together", "procedure of the thesis"]
    lines = [table(rows, heading), f"\n{ADVICE}"]
    for name, way in ways.items():
        lines += [f"warning ({name}): {sentence}" for sentence in way["warnings"]]
    return "\n".join(lines)


ADVICE = (
    "T(x) = (b/m) [exp(m (x - x0)) - 1] and G(t) = c0 + sum ci exp(-vi t) (Pawluk 1997, Eq. 2.1 to "
    "2.3); +- is one\nstandard deviation. Use the left column: the thesis takes the ramp for "
    "instantaneous, so its b is low and\nits c0 high by much more than the uncertainty says."
)


HEADING = "time_s,position_mm,force_N,joint_N,thesis_N"
"""First line of `fit.csv`."""


def keep_others(folder: Path) -> None:
    """Raise InputError where `fit.csv` in a folder is another table, as the record itself."""
    name = "fit.csv"
    if (folder / name).exists() and first_line(folder / name) != HEADING:
        keep([name], folder, "fit")


def save(fit: LumpedFit, folder: Path) -> list[str]:
    """Write `fit.json` and `fit.csv` into an existing folder.

    The table has the record up to the end of the hold, with the smoothed position that is the
    input of both models, and their forces. InputError where the files cannot be written.
    """
    used = ramp_hold.split(fit.time, fit.position, fit.force)
    position = used.smooth_position
    models = [
        lumped.force(way.spring, way.prony, used.time, position) for way in (fit.joint, fit.thesis)
    ]
    columns = np.column_stack([used.time, position, used.force, *models])
    texts = {"fit.json": strict_json(record(fit)) + "\n"}
    with atomic_write.together(folder, texts), atomic_write.in_place(folder / "fit.csv") as rows:
        np.savetxt(rows, columns, "%.9g", ",", header=HEADING, comments="")
    return [str(folder / name) for name in ("fit.json", "fit.csv")]
