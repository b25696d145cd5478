"""Slow press of a relaxed finger by the plate, cached: the mechanics input of a calibration.

With one G the force at any rate is a hereditary integral of this curve, and the curve is
proportional to the moduli at a fixed ratio of them. So a finger is solved once per shape and
exponent. Every press is stored in the user's cache under a hash of its inputs, and an interrupted
calibration continues where it stopped.
"""

import hashlib
import json
import time
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fefinger.calibration.array_sensor import ArraySensor, plane, reading_matrix
from fefinger.results.candidate import MECHANICS
from fefinger.results.records import Response
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support import cache
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError, InputError, Stopped
from fefinger.theory.relaxation import Prony


FORMAT = 8
"""Version in the hash; increased when the mechanics or this file change, to solve presses again."""

FILE = "press.npz"
"""File of a cached press."""

PART = {"solid": 0.2, "condensed": 0.18, "linear": 0.18}
"""Depth of a press over the thickness of the finger: some 2.3 N of a slow press in `solid`."""

EVENLY = 401
"""Number of stored times of a press at small strain."""

USUAL, SPARE, LATER = 4.0, 40.0, 15.0
"""Tangent factorizations of `load_path.FactorizationBudget`. A step takes 0 to 3 of them, and the
spare ones are about as many as a whole press takes; presses past a snap-through took up to 27 more.
Where the pad buckles, a step can take hundreds without converging; the fit then uses the part that
was reached, and later presses have fewer spare ones."""

PLATE = Flat(30.0)
RELAXED = Prony((1.0,), ())


@dataclass(frozen=True)
class SlowPress:
    """A slow press of relaxed tissue.

    depth (n,) mm and force (n,) N of solved steps, without the first touch; array_pressure (n, 64)
    kPa: noise-free readings of the thesis's array; area (n,) mm²; seconds of CPU; halt: the reason
    if it ended before its depth, or "".
    """

    depth: Array
    force: Array
    array_pressure: Array
    area: Array
    seconds: float
    halt: str = ""


def press(
    finger: Finger,
    mechanics: str,
    part: float | None = None,
    spare: float = SPARE,
    indenter: Indenter = PLATE,
) -> SlowPress:
    """Load the press of a finger by "condensed" or "solid" from the cache, or solve it.

    `part` is its depth over the thickness of the finger, default PART; `spare`: the
    tangent factorizations of `solid` beyond the usual ones.

    Raises InputError if the object cannot press the finger to that depth, and ConvergenceError if
    fewer than 8 steps are solved.
    """
    scene = pressed(finger, part or PART[mechanics], indenter)
    place = cache.root() / "presses" / key(scene, mechanics, spare)
    stored = cache.load(place, _read)
    if stored is not None:
        return stored
    solved = _solved(scene, mechanics, spare)
    reach = f"{len(solved.depth)} depths to {solved.depth[-1]:.3g} mm and {solved.force[-1]:.3g} N"
    with (
        suppress(OSError),  # on a full disk it is solved again the next time
        cache.appearing(place, f"press of a calibration: {reach}") as new,
    ):
        np.savez_compressed(new / FILE, **vars(solved))
    return solved


def _read(place: Path) -> SlowPress:
    with np.load(place / FILE) as stored:
        names = ("depth", "force", "array_pressure", "area")
        depth, force, read, area = (stored[name] for name in names)
        return SlowPress(depth, force, read, area, float(stored["seconds"]), str(stored["halt"]))


def small(finger: Finger, indenter: Indenter = PLATE) -> SlowPress:
    """Press at small strain: by `condensed` or, where contact leaves its operator, by `linear`.

    The operator of `condensed` ends at the sides of the finger, where a flat pad has contact
    candidates; `linear` gives the same numbers.
    """
    try:
        return press(finger, "condensed", indenter=indenter)
    except InputError:
        return press(finger, "linear", indenter=indenter)


def pressed(finger: Finger, part: float = PART["solid"], indenter: Indenter = PLATE) -> Scene:
    """Make the scene of a press."""
    motion = Ramp(1.0, part * finger.thickness, corner=0.0)
    ask = Ask(strain=False, fields=False)
    return Scene(
        name="press",
        finger=replace(finger, prony=RELAXED),
        indenter=indenter,
        motion=motion,
        ask=ask,
    )


def shapable(finger: Finger) -> bool:
    """Whether a finger of this size can have this pad radius."""
    from fefinger.mesh.parametric import parametric
    from fefinger.mesh.recipe import Recipe

    if finger.surface is not None:
        return True
    try:
        parametric(Recipe.of(finger))
    except InputError:
        return False
    return True


def key(scene: Scene, mechanics: str, spare: float = SPARE) -> str:
    """Hash of all inputs of a press."""
    from fefinger.mesh.recipe import Recipe

    table = scene.to_dict()
    parts = [FORMAT, mechanics, spare, table, Recipe.of(scene.finger).key()]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:24]


def _solved(scene: Scene, mechanics: str, spare: float) -> SlowPress:
    from fefinger.fem.hyperelastic.load_path import FactorizationBudget
    from fefinger.mechanics import get, solid

    started, halt = time.process_time(), ""
    try:
        if MECHANICS[mechanics].finite:
            response = solid.respond(scene, allowance=FactorizationBudget(USUAL, spare))
        else:
            response = get(mechanics).respond(scene)
    except Stopped as stop:
        response, halt = stop.reached, str(stop)
    steps = _steps(scene, response, mechanics)
    force = response.force[steps]
    if len(force) < 8 or not (np.diff(force) > 0).all():
        raise ConvergenceError(
            f"press: expected a force that rises over at least 8 steps, received {len(force)} "
            f"steps on the finger of {scene.finger.thickness:g} mm{f' ({halt})' if halt else ''}"
        )
    assert response.contact_area is not None
    return SlowPress(
        response.depth[steps],
        force,
        array_pressure(scene, response)[steps],
        response.contact_area[steps],
        time.process_time() - started,
        halt,
    )


def _steps(scene: Scene, response: Response, mechanics: str) -> Integers:
    """Select the stored times: those that `solid` solves, or EVENLY many at small strain.

    Times without contact are left out.
    """
    from fefinger.mechanics.press.load_steps import load_steps, tissue_relaxations
    from fefinger.mechanics.press.time_steps import time_grid

    if MECHANICS[mechanics].finite:
        time = time_grid(scene.motion, fast=False)
        chosen = load_steps(scene.motion, time, tissue_relaxations(scene.finger)).chosen
        chosen = chosen[chosen < len(response.time)]
    else:
        count = min(EVENLY, len(response.time))
        chosen = np.linspace(0, len(response.time) - 1, count).astype(np.int64)
    return chosen[response.force[chosen] > 0]


def array_pressure(scene: Scene, response: Response) -> Array:
    """Compute the readings (n_t, 64) kPa of the array, centered on the last center of pressure.

    Zeros under an object that is no plate, on which no array lies.
    """
    assert response.pad is not None
    assert response.pressure is not None
    pad, pressure = response.pad, response.pressure
    if scene.indenter.flat is None:
        return np.zeros((len(pressure), len(ArraySensor().positions)))
    points = plane(scene.indenter, pad.points)
    loads = pressure[-1] * pad.areas
    points = points - loads @ points / loads.sum()
    return np.asarray(pressure @ reading_matrix(ArraySensor(), pad, points).T)
