"""The runs of the trade-off: one scene by one mechanics on one mesh, kept under the user's cache.

Each is a process of its own, so that its CPU time and memory are its own, and is run once: a
campaign that was stopped goes on where it was.
"""

import hashlib
import resource
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.empty_cache import empty_cache
from fefinger.validation.tradeoff import scenes
from numpy.typing import NDArray

from fefinger.mechanics import get
from fefinger.mechanics.evidence import machine
from fefinger.mechanics.press.discretization import refinement_location
from fefinger.mesh.store import load_or_build
from fefinger.results import pressure as pressures
from fefinger.results.candidate import MECHANICS
from fefinger.results.records import Response
from fefinger.scene.indenters import Flat
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support import cache
from fefinger.support.atomic_write import moved
from fefinger.support.checks import ConvergenceError, InputError


Array = NDArray[np.float64]

FORMAT = 8
"""Raised when the mechanics or what is kept change so that kept runs are to be made again."""

PITCH, TAXELS = 1.0, 17
"""Spacing in mm and number per side of the taxels that the pressure is compared on."""

FINE = 0.15
"""Length in mm of the parts that edges of the pad are cut into to share forces out to taxels."""

DEPTHS = 12
"""Evenly spaced depths of a press at which the taxels are kept."""


@dataclass(frozen=True)
class Run:
    """What is run: kind is "press" or "base", name that of its scene; resolution of the mesh.

    `refine` divides every time step.
    """

    kind: str
    name: str
    mechanics: str
    resolution: str
    refine: int = 1

    @property
    def scene(self) -> Scene:
        """The scene."""
        return getattr(scenes, self.kind)(self.name, self.resolution)

    @property
    def label(self) -> str:
        """What the run is called."""
        finer = f", steps / {self.refine}" if self.refine > 1 else ""
        return f"{self.kind} {self.name}: {self.mechanics} on {self.resolution}{finer}"

    @property
    def path(self) -> Path:
        """Where the run is kept."""
        key = f"{FORMAT} {self.label} {self.scene.to_toml()}"
        digest = hashlib.sha256(key.encode()).hexdigest()[:16]
        return cache.root() / "tradeoff" / f"{digest}.npz"


def campaign() -> tuple[Run, ...]:
    """Return all runs, the ones that more depends on first."""
    cheap = [
        Run("press", name, mechanics, "standard")
        for name in scenes.BASE
        for mechanics in ("hertz", "layered")
    ]
    small = [
        Run("press", name, mechanics, resolution)
        for resolution in ("coarse", "standard")
        for mechanics in ("linear", "condensed")
        for name in scenes.BASE
    ]
    rough = [Run("press", name, "solid", "coarse") for name in scenes.BASE]
    direct = [Run("base", name, "solid", "coarse") for name in scenes.MOTIONS]
    converged = [Run("press", name, "solid", "standard") for name in scenes.BASE]
    fine = [Run("press", name, "linear", "fine") for name in scenes.BASE]
    return (*cheap, *small, *rough, *converged, *direct, *steps(), *fine)


def steps() -> tuple[Run, ...]:
    """Return the runs that tell what the time steps do."""
    return tuple(
        Run("base", name, mechanics, "coarse", refine)
        for name in ("flat-30 fast, deep", "flat-30 sinusoid")
        for mechanics, finer in (("linear", 4), ("solid", 2))
        for refine in (1, finer)
    )


def respond(run: Run, scene: Scene) -> Response:
    """Answer the scene of a run."""
    if run.refine == 1:
        return get(run.mechanics).respond(scene)
    from fefinger.mechanics.press import finite_strain, small_strain

    solver = finite_strain if MECHANICS[run.mechanics].finite else small_strain
    return solver.respond(scene, mechanics=run.mechanics, notes=(), refine=run.refine)


def measure(run: Run) -> dict[str, Any]:
    """Return the arrays of a run, with its cost; a refusal in a sentence is kept as "refused"."""
    chosen, scene = get(run.mechanics), run.scene
    if MECHANICS[run.mechanics].meshed:  # compiles
        small = replace(scene.finger, resolution="coarse")
        chosen.respond(
            replace(scene, finger=small, indenter=Flat(30), motion=Ramp(60.0, 0.1, corner=0.0))
        )
    with _at_first(run):
        started, cpu = time.perf_counter(), time.process_time()
        try:
            response = respond(run, scene)
        except (InputError, ConvergenceError) as error:
            return {"refused": np.array(str(error))}
        ended, spent_cpu = time.perf_counter(), time.process_time() - cpu
    spent = {
        "cpu_s": spent_cpu,
        "wall_s": ended - started,
        "memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }
    return _arrays(response, run.kind == "press") | {
        name: np.array(value) for name, value in (spent | response.numbers).items()
    }


@contextmanager
def _at_first(run: Run) -> Iterator[None]:
    """Let the cache have meshes alone, that of the run too, whatever was answered before.

    A campaign would otherwise be cheaper where operators are kept from another one.
    """
    finger, touch = run.scene.finger, refinement_location(run.scene.indenter)
    if MECHANICS[run.mechanics].meshed:
        with suppress(InputError):  # the run itself says so
            load_or_build(finger, half=True, touch=None if run.mechanics == "condensed" else touch)
    with only_meshes():
        yield


def only_meshes() -> AbstractContextManager[Path]:
    """Let the cache have meshes and the speed of the machine alone."""
    meshes = cache.root() / "meshes"
    meshes.mkdir(parents=True, exist_ok=True)
    return empty_cache(meshes, machine.kept_path())


def _arrays(response: Response, pressed: bool) -> dict[str, Any]:
    assert response.contact_area is not None
    assert response.centroid is not None
    assert response.strain is not None
    assert response.sites is not None
    assert response.reference is not None
    assert response.pad is not None
    assert response.pressure is not None
    if pressed:
        wanted = response.depth.max() * np.arange(1, DEPTHS + 1) / DEPTHS
        steps = np.searchsorted(response.depth, wanted * (1 - 1e-9))
    else:
        steps = np.array([np.argmax(response.force)])
    stages = {f"stage_{name}": np.array(value) for name, value in response.seconds.items()}
    return {
        "time": response.time,
        "depth": response.depth,
        "force": response.force,
        "area": response.contact_area,
        "centroid": response.centroid,
        "strain": response.strain,
        "normals": response.sites.normals,
        "reference": response.reference.strain,
        "reference_normals": response.reference.normals,
        "reference_depth": np.array(response.reference.depth),
        "kept": steps,
        "taxels": np.array([taxels(response, int(step)) for step in steps]),
        "highest": pressures.peaks(response.pad, response.pressure),
        **stages,
    }


def taxels(response: Response, step: int) -> Array:
    """Return the forces (TAXELS, TAXELS) in mN on an array of taxels about the pressure's center.

    The pressure is linear between the points of the pad, and each small part of its force goes to
    the four taxels around it, linearly.
    """
    assert response.pad is not None
    assert response.pressure is not None
    assert response.centroid is not None
    pressure, out = response.pressure[step], np.zeros((TAXELS, TAXELS))
    if not (pressure > 0).any():
        return out
    pad = pressures.pressed(response.pad, pressure > 0)
    fine = pressures.net(pad, pressures.cuts(pad, FINE))
    force, points = fine.loads @ pressure, fine.between @ pad.points
    place = (points[:, :2] - response.centroid[step]) / PITCH + TAXELS // 2
    low = np.clip(np.floor(place).astype(int), 0, TAXELS - 2)
    part = np.clip(place - low, 0.0, 1.0)
    for dx in (0, 1):
        for dy in (0, 1):
            share = np.abs(1 - dx - part[:, 0]) * np.abs(1 - dy - part[:, 1])
            np.add.at(out, (low[:, 0] + dx, low[:, 1] + dy), share * force)
    return out


def done(run: Run) -> bool:
    """Return whether a run is kept."""
    return run.path.is_file()


def load(run: Run) -> dict[str, Any] | None:
    """Return the arrays of a run; None where the mechanics refused.

    Raises
    ------
    InputError
        If it was not run.
    """
    if not done(run):
        msg = f"{run.label}: not run yet; `fefinger validate tradeoff` runs what is missing"
        raise InputError(msg)
    with np.load(run.path) as file:
        arrays = dict(file)
    return None if "refused" in arrays else arrays


def do(run: Run) -> str:
    """Run and keep, and return the label."""
    arrays = measure(run)
    run.path.parent.mkdir(parents=True, exist_ok=True)
    with moved(run.path) as new:
        np.savez_compressed(new, **arrays)
    return run.label


def complete(
    runs: Iterable[Run],
    *,
    workers: int = 1,
    seconds: float = float("inf"),
    progress: Callable[[str, float], None] = lambda stage, fraction: None,
) -> None:
    """Make the runs that are missing, each in a process of its own; begin none after `seconds`."""
    todo, started = [run for run in runs if not done(run)], time.perf_counter()
    context = get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context, max_tasks_per_child=1) as pool:
        waiting: set[Future[str]] = set()
        for number, run in enumerate(todo):
            if time.perf_counter() - started > seconds:
                break
            waiting.add(pool.submit(do, run))
            if len(waiting) == workers:
                finished, waiting = wait(waiting, return_when=FIRST_COMPLETED)
                for each in finished:
                    progress(f"trade-off: {each.result()}", (number + 1) / len(todo))
        for each in wait(waiting).done:
            each.result()


if __name__ == "__main__":  # seconds to spend, for a campaign in pieces
    complete(
        campaign(), seconds=float(sys.argv[1]), progress=lambda label, _: print(label, flush=True)
    )
