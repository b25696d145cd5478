"""Measure errors of `layered` on a grid, under objects that are not round and under a plate.

Run as `python -m fefinger.validation.evidence.grid_errors reports [NAME ...]`; about ten minutes on
one core. The presses are those of `press_mesh.py`. Each is compared with finite strain on the
standard mesh, and what that mesh leaves (`press-mesh.json`) is added. Presses in the report
already are not solved again.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.evidence.press_errors import Press, norm
from fefinger.validation.evidence.press_mesh import MEASUREMENTS, REPORT, apart
from fefinger.validation.provenance import save, saved, short

from fefinger.mechanics import get, layered
from fefinger.mechanics.evidence.stated_errors import strain_of
from fefinger.scene import library
from fefinger.support.vocabulary import TYPES


GRID_ERRORS = "grid-errors.json"

OBJECTS = ("bar", "grating", "pin", "bar-4", "grating-6", "cylinder", "grating-10")
"""Objects that `layered` answers on a grid alone."""

PLATE = "flat-30"
"""A smooth plate, for raised parts on it: without friction `layered` needs no grid for it."""

NAMES = tuple(
    f"{owner}/{name}" for owner in (library.PUBLISHED, "a.h.") for name in (*OBJECTS, PLATE)
)
"""Presses into published tissue, and into that calibrated on a finger."""


def row(name: str, mesh: dict[str, Any]) -> dict[str, Any]:
    """Return the errors of a press over the depth over the thickness, by quantity.

    mesh: errors of `solid` on the standard mesh, and the depths they are at.
    """
    measurement = MEASUREMENTS[name]
    scene = measurement.scene("standard")
    true, grid = map(Press.of, (get("pressed").respond(scene), layered.respond_on_grid(scene)))
    part = true.depth[true.at] / measurement.finger.thickness
    at = np.divide(mesh["depth_mm"], mesh["thickness_mm"])
    left = {what: np.interp(part, at, x) for what, x in mesh["errors"]["solid standard"].items()}
    errors = {what: each + left[what] for what, each in apart(grid, true).items()}
    for site, kind in enumerate(TYPES):
        real = true.strain[true.at, site]
        error = norm(grid.strain[true.at, site] - real) / norm(real)
        errors[strain_of(kind)] = error + left["strain"]
    ratio = grid.force[true.at] / true.force[true.at]
    return {
        "part": short(part),
        "force_N": short(true.force[true.at]),
        "force_ratio": short(ratio, 3),
        "errors": {what: short(each, 3) for what, each in errors.items()},
    }


def main(folder: Path, names: tuple[str, ...]) -> None:
    """Measure what is missing and write the report after every press."""
    path = folder / GRID_ERRORS
    mesh, rows = saved(folder / REPORT)["rows"], saved(path).get("rows", {})
    for name in names:
        if name not in rows:
            rows[name] = row(name, mesh[name])
            save(path, {"rows": {each: rows[each] for each in NAMES if each in rows}})
            print(name, rows[name]["errors"]["force"][-1], flush=True)  # progress


if __name__ == "__main__":
    main(Path(sys.argv[1]), tuple(sys.argv[2:]) or NAMES)
