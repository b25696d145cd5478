"""The relaxing hemisphere in FEBio and in this project: force, CPU time and memory.

`python -m fefinger.validation.problems.febio FEBIO4 reports` solves it with both programs in turn,
on the same mesh and at the same times.
"""

import os
import re
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from fefinger.validation.fem.solid import MODULUS, RAMP, SERIES, TIMES, WEIGHTS
from fefinger.validation.problems.febio_deck import SETTINGS, deck
from fefinger.validation.problems.hemisphere import SPEED, Hemisphere
from fefinger.validation.provenance import save, short

from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.hyperelastic.material import material_of
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError
from fefinger.support.processes import one_thread
from fefinger.support.tolerances import PRESS_EQUILIBRIUM


REPORT, SIZES, RUNS = "febio.json", (4.0, 2.4), 3  # mm of the cells; the first compiles
COUNTS = {
    "steps": "time steps completed",
    "iterations": "equilibrium iterations",
    "residuals": "right hand evaluations",
    "factors": "stiffness reformations",
}
LAUNCH = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(used.ru_utime + used.ru_stime, used.ru_maxrss)
"""
"""Program that prints the CPU s and the peak memory in kB of a command; a process of its own, as a
child starts with the peak of the process that forked it."""


def read_force(text: str) -> tuple[Array, Array]:
    """Return times in s and forces in N on the whole hemisphere, from FEBio's data of the plate."""
    rows = re.findall(r"\*Time *= *(\S+)\n\*Data.*\n\d+ +(\S+)", text)
    times, forces = np.array(rows, dtype=np.float64).reshape(-1, 2).T
    return times, 4e-3 * forces


def read_counts(log: str) -> dict[str, int]:
    """Return the numbers of steps, iterations, residuals, factors and retries of FEBio's log."""
    matches = {name: re.search(rf"{text} \.* : (\d+)", log) for name, text in COUNTS.items()}
    counts = {name: int(match[1]) for name, match in matches.items() if match}
    return counts | {"retries": log.count("Retrying time step")}


def run_febio(program: Path, ball: Hemisphere) -> dict[str, Any]:
    """Solve with FEBio and one thread; force in N at TIMES."""
    single = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "MKL")}
    with TemporaryDirectory() as name:
        folder = Path(name)
        ET.ElementTree(deck(ball)).write(folder / "ball.feb", "utf-8", xml_declaration=True)
        words = [sys.executable, "-c", LAUNCH, str(program.resolve()), "-i", "ball.feb"]
        used = subprocess.check_output(words, cwd=folder, env=os.environ | single, text=True)
        log = (folder / "ball.log").read_text(encoding="utf-8", errors="replace")
        times, force = read_force((folder / "force.txt").read_text(encoding="utf-8"))
    if not np.isclose(times[-1], TIMES[-1]):
        message = f"febio: expected forces up to {TIMES[-1]:g} s, received them to {times[-1]:g} s"
        raise ConvergenceError(message)
    version = re.search(r"version (\d[\d.]*)", log)
    seconds, kilobytes = map(float, used.split())
    head = {"version": version[1] if version else "", "cpu_s": seconds}
    at = np.interp(TIMES, times, force)
    return head | {"memory_MB": kilobytes / 1024, **read_counts(log), "force_N": at}


@one_thread
def run_ours(ball: Hemisphere) -> dict[str, Any]:
    """Solve with this project, iterated as the press of a finger: meshing is not counted."""
    _ = ball.space.unknowns
    started = time.process_time()
    force, solver = ball.pressed(TIMES, SPEED, SERIES, PRESS_EQUILIBRIUM)
    counts = {
        "tolerance": solver.tolerance,
        "iterations": solver.iterations,
        "factors": solver.factors + 1,
    }
    return {"cpu_s": time.process_time() - started, **counts, "force_N": force}


def quarter(size: float) -> Hemisphere:
    """Hemisphere of `bench.solid` with cells of `size` mm at the pole, not yet solved."""
    law = material_of(Elastic(MODULUS * WEIGHTS[0], 0.49))
    return Hemisphere(law, size, sectors=6)


def summary(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the last run with the least CPU s of all, and its force at the peak and the end."""
    rounded = short(runs[-1]["force_N"], 6)
    ends = {"peak_N": rounded[RAMP], "end_N": rounded[-1]}
    return runs[-1] | {"cpu_s": min(run["cpu_s"] for run in runs), **ends, "force_N": rounded}


def report(program: Path) -> dict[str, Any]:
    """Solve RUNS times with both programs in turn, after a run that compiles."""
    run_ours(quarter(SIZES[0]))
    febio, ours = [], []
    for _ in range(RUNS):
        febio.append(run_febio(program, quarter(SIZES[-1])))
        ours.append(run_ours(quarter(SIZES[-1])))
    ball = quarter(SIZES[-1])
    difference = 100 * (febio[-1]["force_N"] - ours[-1]["force_N"]) / ours[-1]["force_N"].max()
    largest = int(np.argmax(np.abs(difference)))
    return {
        "about": "The relaxing hemisphere in FEBio and in this project: same mesh, law and times, "
        f"one thread, least CPU seconds of {RUNS} runs.",
        "nodes": ball.n_nodes,
        "cells": len(ball.space.cells),
        "free_displacements": int((~ball.held).sum()),
        "pressures": ball.space.n_unknowns - ball.space.n_displacements,
        "settings": SETTINGS,
        "febio": summary(febio),
        "fefinger": summary(ours),
        "cpu_ratio": summary(febio)["cpu_s"] / summary(ours)["cpu_s"],
        "difference_%": {
            "peak": float(difference[RAMP]),
            "end": float(difference[-1] * ours[-1]["force_N"].max() / ours[-1]["force_N"][-1]),
            "largest, of the peak": float(difference[largest]),
            "at_s": float(TIMES[largest]),
        },
    }


if __name__ == "__main__":
    save(Path(sys.argv[2]) / REPORT, report(Path(sys.argv[1])), "FEBIO4 reports")
