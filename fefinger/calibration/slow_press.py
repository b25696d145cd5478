"""The slow press of a relaxed finger by the plate: all of mechanics that a calibration needs.

With one G the force at any pace is an integral of this one curve, and the curve is proportional to
the moduli at a fixed ratio of them. So a finger is solved once per shape and exponent; every press
is kept in the user's cache under the hash of what decides it, and a calibration that was
interrupted goes on where it stopped.
"""

import hashlib
import json
import time
import zlib
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from fefinger.results.candidate import MECHANICS
from fefinger.results.records import Response
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Flat
from fefinger.scene.motion import Ramp
from fefinger.scene.scene import Scene
from fefinger.support import cache
from fefinger.support.atomic_write import moved
from fefinger.support.checks import ConvergenceError, InputError, Stopped
from fefinger.theory.array.sensor import ArraySensor
from fefinger.theory.relaxation import Prony


Array = NDArray[np.float64]

DAMAGED = (OSError, ValueError, KeyError, EOFError, BadZipFile, zlib.error)
"""What reading a press raises that is not there or damaged: it is solved again."""

FORMAT = 8
"""Raised when the mechanics or this file change, so that presses are solved again."""

PART = {"solid": 0.2, "condensed": 0.18, "linear": 0.18}
"""Depth of a press over the thickness of the finger: some 2.3 N of a slow press in `solid`."""

EVENLY = 401
"""Times of a press at small strain that are kept."""

USUAL, SPARE, LATER = 4.0, 40.0, 15.0
"""Factors of `fem.passage.Allowance`: a step takes 0 to 3 of them, and what a press has to spare is
about what it takes as a whole; presses that pass a snap have taken up to 27 more. Where the pad
buckles, a step can take hundreds and come nowhere; the fit goes on with what was reached, and later
presses of it spare less."""

PLATE = Flat(30.0)
RELAXED = Prony((1.0,), ())


@dataclass(frozen=True)
class Press:
    """A slow press of relaxed tissue.

    depth (n,) mm and force (n,) N of solved steps, without the first touch; felt (n, 64) kPa, what
    the array of the thesis reads without noise; area (n,) mm²; seconds of CPU that it took; halt:
    why it ended before its depth, or "".
    """

    depth: Array
    force: Array
    felt: Array
    area: Array
    seconds: float
    halt: str = ""


def press(finger: Finger, mechanics: str, part: float | None = None, spare: float = SPARE) -> Press:
    """Return the press of a finger by "condensed" or "solid", from the cache or solved now.

    `part` is its depth over the thickness of the finger, by default that of PART; `spare` the
    factors that `solid` may take beyond the usual ones.

    Raises
    ------
    InputError
        If the plate cannot press the finger so deep.
    ConvergenceError
        If hardly a step is solved.
    """
    scene = pressed(finger, part or PART[mechanics])
    place = root() / f"{key(scene, mechanics, spare)}.npz"
    with suppress(*DAMAGED), place.open("rb") as opened, np.load(opened) as kept:
        depth, force, read, area = (kept[name] for name in ("depth", "force", "felt", "area"))
        return Press(depth, force, read, area, float(kept["seconds"]), str(kept["halt"]))
    found = _solved(scene, mechanics, spare)
    with suppress(OSError):  # without room for it, it is solved again the next time
        _keep(found, place)
    return found


def small(finger: Finger) -> Press:
    """Return the press at small strain: by `condensed`, or where it does not reach by `linear`.

    The operator of `condensed` ends at the sides of the finger, where a flat pad has candidates for
    contact; `linear` gives the same numbers without one.
    """
    try:
        return press(finger, "condensed")
    except InputError:
        return press(finger, "linear")


def pressed(finger: Finger, part: float = PART["solid"]) -> Scene:
    """Return the scene of a press."""
    motion = Ramp(1.0, part * finger.thickness, corner=0.0)
    ask = Ask(strain=False, fields=False)
    return Scene(
        name="press",
        finger=replace(finger, prony=RELAXED),
        indenter=PLATE,
        motion=motion,
        ask=ask,
    )


def shapable(finger: Finger) -> bool:
    """Return whether a finger of this size can have this pad radius."""
    from fefinger.mesh.parametric import parametric
    from fefinger.mesh.recipe import Recipe

    if finger.surface is not None:
        return True
    try:
        parametric(Recipe.of(finger))
    except InputError:
        return False
    return True


def root() -> Path:
    """Return the folder of the presses."""
    return cache.root() / "presses"


def key(scene: Scene, mechanics: str, spare: float = SPARE) -> str:
    """Return the hash of all that decides a press."""
    from fefinger.mesh.recipe import Recipe

    table = scene.to_dict()
    parts = [FORMAT, mechanics, spare, table, Recipe.of(scene.finger).key()]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:24]


def _solved(scene: Scene, mechanics: str, spare: float) -> Press:
    started, halt = time.process_time(), ""
    try:
        response = _respond(scene, mechanics, spare)
    except Stopped as stop:
        response, halt = stop.reached, str(stop)
    steps = _steps(scene, response, mechanics)
    force = response.force[steps]
    if len(force) < 8 or not (np.diff(force) > 0).all():
        message = (
            f"press: expected a force that rises over 8 steps or more, found {len(force)} on the "
            f"finger of {scene.finger.thickness:g} mm{f' ({halt})' if halt else ''}"
        )
        raise ConvergenceError(message)
    assert response.contact_area is not None
    return Press(
        response.depth[steps],
        force,
        felt(scene, response)[steps],
        response.contact_area[steps],
        time.process_time() - started,
        halt,
    )


def _respond(scene: Scene, mechanics: str, spare: float) -> Response:
    """Return what the mechanics answers, by `solid` as far as a calibration spares the work."""
    from fefinger.mechanics import get

    if not MECHANICS[mechanics].finite:
        return get(mechanics).respond(scene)
    from fefinger.fem.hyperelastic.load_path import Allowance
    from fefinger.mechanics import solid

    return solid.respond(scene, allowance=Allowance(USUAL, spare))


def _steps(scene: Scene, response: Response, mechanics: str) -> NDArray[np.int64]:
    """Return the numbers of the times to keep: those that `solid` solves, and EVENLY many others.

    What is not in contact is left out.
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


def felt(scene: Scene, response: Response) -> Array:
    """Return what the array feels (n_t, 64) kPa, centered on the last pressure."""
    from fefinger.results import array_sensor

    assert response.pad is not None
    assert response.pressure is not None
    pad, pressure = response.pad, response.pressure
    points = array_sensor.plane(scene.indenter, pad.points)
    loads = pressure[-1] * pad.areas
    points = points - loads @ points / loads.sum()
    return np.asarray(pressure @ array_sensor.response(ArraySensor(), pad, points).T)


def _keep(found: Press, place: Path) -> None:
    place.parent.mkdir(parents=True, exist_ok=True)
    values: dict[str, Any] = dict(vars(found))
    with moved(place) as new:
        np.savez_compressed(new, **values)
