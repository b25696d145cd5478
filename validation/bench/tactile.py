"""How fast a tactile finger is: steps on two meshes, many worlds, its start, and its memory.

The finger of a.h. with published tissue, under a ball that goes round in contact. A step is timed
in processor time of its thread, many worlds by the clock and in all threads. Baselines are what was
aimed at.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from functools import partial

import numpy as np
from fefinger.validation.bench.suites import Figure, Progress
from fefinger.validation.bench.timing import load, of_each, timed

from fefinger.mechanics.tactile_finger import TactileFinger
from fefinger.scene.finger import Finger
from fefinger.shapes import Sphere
from fefinger.support.arrays import Array
from fefinger.support.processes import one_thread


BALL, DT, STEPS = Sphere(8.0), 1e-3, 1500
WORLDS, REPEATS = 1000, 10
FRICTION = 0.6

AIMS = {
    ("coarse", 0.0): (0.4, 1.0),
    ("coarse", FRICTION): (0.8, 2.0),
    ("standard", 0.0): (1.0, None),
    ("standard", FRICTION): (None, None),
}
"""Median and 99 % of the steps in ms, by mesh and coefficient of friction."""

TOGETHER = 0.2  # s of a step of all worlds

START = """import fefinger as ff
ff.TactileFinger(ff.Finger.subject('a.h.', resolution='coarse'), deepest=1.5)"""


def figures(progress: Progress) -> list[Figure]:
    """Measure steps, many worlds, memory and starts."""
    measured = [load()]
    for part, mesh in enumerate(("coarse", "standard")):
        measured += _steps(mesh)
        progress("tactile", 0.3 * (part + 1))
    measured += _worlds()
    progress("tactile", 0.7)
    measured += _starts()
    progress("tactile", 1.0)
    return measured


def places(count: int) -> Iterator[Array]:
    """Give places (3,) mm of the ball, which comes into contact, goes round and back."""
    for k in range(count):
        angle = 2 * np.pi * k / 500
        deep = 0.9 * min(k / 200, 1.0) + 0.1 * np.sin(7 * angle)
        yield np.array([-4.0 + 1.5 * np.sin(angle), 1.5 * np.cos(angle), deep - 2.0 - BALL.radius])


@one_thread
def _steps(mesh: str) -> list[Figure]:
    """Measure single steps, the start from what is kept, and the memory of a mesh."""
    finger, measured = Finger.subject("a.h.", tissue="maeno1998", resolution=mesh), []
    for friction in (0.0, FRICTION):
        _made(finger, friction)
        tip, start = timed(partial(_made, finger, friction))
        spent = of_each(partial(_step, tip), list(places(STEPS)))
        what = f"step, {mesh} mesh of {len(tip.pad.areas)} vertices, friction {friction:g}"
        median, most = AIMS[mesh, friction]
        measured += [
            Figure(f"{what}: median", float(np.median(spent)), "ms", median),
            Figure(f"{what}: 99 %", float(np.quantile(spent, 0.99)), "ms", most),
        ]
    state = sum(each.nbytes for each in tip.state().arrays)
    touch = tip.step([(BALL, np.eye(3), np.array([0.0, 0.0, -20.0]))], DT)
    return [
        *measured,
        Figure(f"start from what is kept, {mesh} mesh", start, "CPU s"),
        Figure(f"compliance, {mesh} mesh", touch.maps.compliance.nbytes / 1e6, "MB"),
        Figure(f"state of a world, {mesh} mesh", state / 1e3, "kB"),
    ]


def _made(finger: Finger, friction: float) -> TactileFinger:
    return TactileFinger(finger, friction=friction, finite_strain=False)


def _step(tip: TactileFinger, place: Array) -> None:
    tip.step([(BALL, np.eye(3), place)], DT)


def _worlds() -> list[Figure]:
    """Measure steps of many worlds by the clock, in all threads."""
    finger, spent = Finger.subject("a.h.", tissue="maeno1998", resolution="coarse"), []
    tips = TactileFinger(finger, finite_strain=False, worlds=WORLDS, precision="single")
    apart = np.linspace(-0.3, 0.3, WORLDS)[:, None] * [1.0, 1.0, 0.5]
    for place in list(places(300))[-REPEATS:]:
        began = time.perf_counter()
        tips.step([(BALL, np.eye(3), place + apart)], DT)
        spent.append(time.perf_counter() - began)
    what = f"step of {WORLDS} worlds, coarse mesh, without friction: median, by the clock"
    return [Figure(what, float(np.median(spent)), "s", TOGETHER)]


def _starts() -> list[Figure]:
    """Measure starts of a finger at finite strain: with nothing kept, and then again."""
    measured = []
    with tempfile.TemporaryDirectory() as kept:
        environment = os.environ | {"XDG_CACHE_HOME": kept}
        for when in ("with nothing kept but compiled code", "again"):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([sys.executable, "-c", START], check=True, env=environment)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            measured.append(Figure(f"start at finite strain, coarse mesh, {when}", spent, "CPU s"))
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e6
    return [*measured, Figure("peak memory of these starts", peak, "GB")]
