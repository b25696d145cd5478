"""The linear solvers on cubes held at one face, the worst shape for a factor: time and memory."""

import ctypes
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from fefinger.validation.bench.suites import Figure, Progress
from fefinger.validation.bench.timing import timed
from fefinger.validation.problems.grids import box
from scipy import sparse

from fefinger.fem.elements.forms import Elastic, stiffness
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg import system as solve
from fefinger.fem.linalg.minres import Iterative
from fefinger.support.arrays import Array, Integers
from fefinger.support.threads import one_thread


NU, MODULUS = 0.49, 34.0
SIZES = {
    "multifrontal": (7, 10, 15, 22),
    "single": (7, 10, 15, 22),
    "iterative": (7, 10, 15, 22),
}
"""Boxes along an edge for each solver: 10 thousand to 285 thousand unknowns."""

COLUMNS = 16  # loads at once, of a factor
FITTED = 3  # largest cubes that an exponent is fitted over
HARD = 10  # boxes of the cubes that are hard for MINRES
CASES = ((0.49, 1.0), (0.4999, 1.0), (0.5, 1.0), (0.49, 1e3), (0.49, 1e6))
"""Poisson's ratio of a cube, and how much stiffer the block is that floats in it."""


@dataclass(frozen=True)
class HeldCube:
    """The equations of a cube, and the seconds of their assembly."""

    space: Space
    matrix: sparse.csr_matrix
    held: Integers
    assembly: float

    @property
    def load(self) -> Array:
        """A press (n_unknowns,) on the middle of the free face."""
        places = self.space.node_points
        pressed = (places[:, 2] == 0) & (np.hypot(*(places[:, :2] - 5).T) <= 2)
        load = np.zeros((len(places), 3))
        load[pressed, 2] = 1 / pressed.sum()
        return np.concatenate([load.ravel(), np.zeros(self.space.n_unknowns - load.size)])


def cube(boxes: int, poisson: float = NU, ratio: float = 1.0) -> HeldCube:
    """Return a cube of 10 mm; with a `ratio` of moduli, a stiff block floats in its middle."""
    line = np.linspace(0.0, 10.0, boxes + 1)
    space, tissues = box(line, line, line), {1: Elastic(MODULUS, poisson)}
    if ratio != 1:
        centers = space.points[space.cells].mean(axis=1)
        inside = (np.abs(centers - 5) < 2.5).all(axis=1)
        space = Space(space.points, space.cells, np.where(inside, 2, 1).astype(np.int8))
        tissues[2] = Elastic(ratio * MODULUS, 0.3)
    _ = space.unknowns  # the mesh's own tables, which are part of meshing
    matrix, seconds = timed(lambda: stiffness(space, tissues))
    held = np.flatnonzero(np.repeat(space.node_points[:, 2] == 10, 3))
    return HeldCube(space, matrix, held, seconds)


def figures(progress: Progress) -> Iterator[Figure]:
    """Measure every solver on its sizes, fit how its costs grow, and give MINRES hard cubes."""
    sizes = sorted({boxes for sizes_of_solver in SIZES.values() for boxes in sizes_of_solver})
    rows: dict[str, list[tuple[int, dict[str, float]]]] = {name: [] for name in SIZES}
    for number, boxes in enumerate(sizes):
        given = cube(boxes)
        unknowns = given.space.n_unknowns
        yield Figure(f"cube of {unknowns} unknowns, assembly: CPU", given.assembly, "s")
        for name in (
            solver for solver, sizes_of_solver in SIZES.items() if boxes in sizes_of_solver
        ):
            values = measured(given, name)
            rows[name].append((unknowns, values))
            for key, value in values.items():
                unit = {"CPU": "s", "emory": "MB"}.get(key[-5:].split()[-1], "1")
                yield Figure(f"cube of {unknowns} unknowns, {name}, {key}", value, unit)
        progress("fem", 0.3 + 0.6 * (number + 1) / len(sizes))
    for name, sizes_of_solver in rows.items():
        yield from _exponents(name, sizes_of_solver[-FITTED:])
    for poisson, ratio in CASES:
        values = measured(cube(HARD, poisson, ratio), "iterative")
        what = f"nu {poisson:g}" + (f", moduli {ratio:g} apart" if ratio != 1 else "")
        yield Figure(f"iterative, {what}: iterations", values["one load: iterations"], "1")


@one_thread
def measured(given: HeldCube, name: str) -> dict[str, float]:
    """Return the costs of a solver by what they are of."""
    before = _memory(reset=True)
    system, prepared = timed(lambda: solve.factor(given.space, given.matrix, given.held, name))
    counted = _Counted(cast(Iterative, system.solver)) if name == "iterative" else None
    system.solver = counted or system.solver
    costs = {"prepared: CPU": prepared, "one load: CPU": timed(lambda: system.solve(given.load))[1]}
    if counted is not None:
        costs["one load: iterations"] = counted.iterations
    else:
        loads = np.random.default_rng(0).normal(size=(len(given.load), COLUMNS))
        _, costs[f"{COLUMNS} loads: CPU"] = timed(lambda: system.solve(loads))
    now = _memory()
    return costs if before is None or now is None else costs | {"peak memory": now - before}


class _Counted:
    """MINRES that counts its iterations over all rounds of refinement."""

    def __init__(self, solver: Iterative) -> None:
        self.solver, self.iterations = solver, 0

    def solve(self, right: Array) -> Array:
        """Return the approximate solution."""
        answer, taken = self.solver.minres(right)
        self.iterations += taken
        return answer


def _exponents(name: str, rows: list[tuple[int, dict[str, float]]]) -> Iterator[Figure]:
    """Yield the exponents of the unknowns that the costs of a solver grow with."""
    if len(rows) < FITTED:
        return
    unknowns = np.log([count for count, _ in rows])
    for key in rows[0][1]:
        spent = np.array([costs[key] for _, costs in rows])
        if (spent <= 0).any():  # memory that was at hand already
            continue
        slope = np.polyfit(unknowns, np.log(spent), 1)[0]
        yield Figure(f"exponent in the unknowns, {name}, {key}", float(slope), "1")


def _memory(*, reset: bool = False) -> float | None:
    """Return the peak memory of the process in MB, which starts anew with `reset`.

    None on a system that does not tell it.
    """
    with suppress(OSError):
        if reset:
            with suppress(AttributeError):  # or what was freed before would count as there
                ctypes.CDLL(None).malloc_trim(0)
            Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
        status = Path("/proc/self/status").read_text(encoding="ascii")
        return int(status.split("VmHWM:")[1].split()[0]) / 1024
    return None
