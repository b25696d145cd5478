"""Measure the mesh error of the force of a press, and its correlation length in depth.

Run as `python -m fefinger.validation.evidence.curves reports`; it builds each mesh anew, in a
process and a cache of its own, and takes some five minutes of two cores. `calibrate` counts with
what is found.
"""

import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.calibration import twin
from fefinger.validation.empty_cache import empty_cache
from fefinger.validation.provenance import save, short
from scipy.optimize import minimize

from fefinger.calibration import slow_press
from fefinger.support.arrays import Array


REPORT = "mesh-curves.json"

DRAWS = {"coarse": 16, "standard": 8}
DEEPEST = 1.8  # mm
DEPTHS = np.linspace(0.5, DEEPEST, 27)
"""Before them a press is off by where touch is, a vertex, and a record has a touch of its own."""


def drawn(mesh: str) -> list[float]:
    """Return the forces at DEPTHS of a press by `condensed`, on a mesh that is built for it."""
    from fefinger.mechanics import condensed

    with empty_cache():
        finger = twin.finger(mesh)
        response = condensed.respond(slow_press.pressed(finger, 1.01 * DEEPEST / finger.thickness))
    return np.interp(DEPTHS, response.depth, response.force).tolist()


def likeliest(errors: Array) -> tuple[float, float]:
    """Return standard deviation and length in mm of an exponential covariance of errors (n, k)."""
    apart = np.abs(np.subtract.outer(DEPTHS, DEPTHS))

    def unlikely(logarithms: Array) -> float:
        sd, length = np.exp(logarithms)
        covariance = sd**2 * (np.exp(-apart / length) + 1e-9 * np.eye(len(DEPTHS)))
        squares = np.sum(errors.T * np.linalg.solve(covariance, errors.T))
        return float(len(errors) * np.linalg.slogdet(covariance)[1] + squares)

    start = np.log([errors.std(), 0.3])
    optimum = minimize(unlikely, start, method="Nelder-Mead")
    assert optimum.success, optimum.message
    sd, length = np.exp(optimum.x)
    return float(sd), float(length)


def row(errors: Array) -> dict[str, Any]:
    """Statistics of relative errors (n, k), as plain values."""
    sd, length, rms = short((*likeliest(errors), np.sqrt((errors**2).mean())), 2)
    largest = short(np.abs(errors).max(axis=1), 2)
    return {"draws": len(errors), "sd": sd, "length_mm": length, "rms": rms, "largest": largest}


def main(folder: Path) -> None:
    """Measure, and write the report."""
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=fresh, max_tasks_per_child=1) as pool:
        forces_by_mesh = {
            mesh: np.array(list(pool.map(drawn, [mesh] * n))) for mesh, n in DRAWS.items()
        }
    true = forces_by_mesh["standard"].mean(axis=0)
    errors = {mesh: forces / true - 1 for mesh, forces in forces_by_mesh.items()}
    errors["standard"] *= np.sqrt(DRAWS["standard"] / (DRAWS["standard"] - 1))  # of their own mean
    rows = {mesh: row(each) for mesh, each in errors.items()}
    save(folder / REPORT, {"depths_mm": short(DEPTHS), "rows": rows})


if __name__ == "__main__":
    main(Path(sys.argv[1]))
