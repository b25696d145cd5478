"""How fast inertia is: modes of a finger, harmonic answers, a step in a loop, and a scene.

Half the standard finger of a.h. with published tissue under the plate at 30 degrees. A step is
timed in processor time of its thread, with as many end organs as a fingertip has. Baselines are
what was aimed at.
"""

import resource
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial

import numpy as np
from fefinger.validation.bench.organs import COUNT, crowd
from fefinger.validation.bench.suites import Figure, Progress
from fefinger.validation.bench.timing import of_each, timed

from fefinger.mechanics.loop import Loop
from fefinger.mechanics.press.modal_body import finger_modes
from fefinger.mechanics.press.operator import operator
from fefinger.mechanics.vibrations import Vibrations
from fefinger.results.records import Sites
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.support.processes import one_thread


MESH, TISSUE = "standard", "maeno1998"
DT, SHORT = 2e-4, 5e-5
"""Steps in s; the short one resolves all modes."""

STEPS, POINTS = 3000, 200
DEEPEST = 2.0
BAND = 1000.0  # Hz that the modes have to reach
AIMS = {"modes": 120.0, "memory": 3.0, "points": 1.0, "step": 1.0, "scene": 10.0}


@one_thread
def figures(progress: Progress) -> list[Figure]:
    """Measure modes, harmonic answers, steps and the scene vibration-200Hz."""
    measured = _modes()
    progress("modal", 0.4)
    measured += _loop()
    progress("modal", 0.7)
    measured += _scene()
    progress("modal", 1.0)
    return measured


def _finger() -> Finger:
    return Finger.subject("a.h.", tissue=TISSUE, resolution=MESH)


def _modes() -> list[Figure]:
    """Measure the modes of half the finger, which are computed anew."""
    finger = _finger()
    solid = operator(finger, half=True)
    anonymous = replace(solid, identities=(None,))  # then nothing is read from the cache
    modes, seconds = timed(lambda: finger_modes(finger, anonymous))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    return [
        Figure(
            f"{len(modes.omega_squared)} modes of half the finger", seconds, "CPU s", AIMS["modes"]
        ),
        Figure("frequency of the last of them, relaxed", modes.complete, "Hz", BAND),
        Figure("peak memory until then", peak, "GB", AIMS["memory"]),
    ]


def _loop() -> list[Figure]:
    """Measure harmonic answers, and steps with many end organs."""
    sites = crowd(Vibrations(_finger(), Flat(30), deepest=DEEPEST).sites)
    measured = [row for dt in (DT, SHORT) for row in _steps(sites, dt)]
    quick = Vibrations(_finger(), Flat(30), deepest=DEEPEST)
    frequency = np.geomspace(1.0, 400.0, POINTS)
    first, again = (
        timed(partial(quick.harmonic, frequency, depth=depth))[1] for depth in (1.0, 0.7)
    )
    return [
        *measured,
        Figure(f"harmonic answer at {POINTS} frequencies, first", first, "CPU s", AIMS["points"]),
        Figure(f"harmonic answer at {POINTS} frequencies, again", again, "CPU s", AIMS["points"]),
    ]


def _steps(sites: Sites, dt: float) -> list[Figure]:
    """Measure steps of `dt` s with the modes that they resolve."""
    loop = Loop(
        _finger(),
        Flat(30),
        mechanics="modal",
        deepest=DEEPEST,
        sites=sites,
        substep=dt,
        precision="single",
    )
    at = dt * np.arange(STEPS)
    depths = np.minimum(1.0, 20 * at) + 0.05 * np.sin(2 * np.pi * 150 * at)
    spent = of_each(lambda depth: loop.step(dt, depth=depth), np.maximum(depths, 0.0).tolist())
    assert loop.prepared.body is not None
    modes, nodes = loop.prepared.body.participation.shape
    what = f"{1e3 * dt:g} ms, {modes} modes, {nodes} contact nodes, {COUNT} end organs"
    return [
        Figure(f"step of {what}: median", float(np.median(spent)), "ms", AIMS["step"]),
        Figure(f"step of {what}: 99 %", float(np.quantile(spent, 0.99)), "ms"),
    ]


def _scene() -> list[Figure]:
    """Measure `fefinger run vibration-200Hz` once more, when all that is kept is at hand."""
    command = [sys.executable, "-m", "fefinger", "run", "vibration-200Hz", "--json"]
    run = partial(subprocess.run, command, capture_output=True, check=True)
    run()
    started, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    run()
    wall, after = time.perf_counter() - started, resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    what = "fefinger run vibration-200Hz, from kept modes"
    return [Figure(what, spent, "CPU s", AIMS["scene"]), Figure(what, wall, "s", AIMS["scene"])]
