"""The trade-off on the base scenes: every candidate's errors through time, its spikes and costs."""

import time
from typing import Any

import numpy as np
from fefinger.validation.tradeoff import errors as presses
from fefinger.validation.tradeoff import motion, runs, scenes
from fefinger.validation.tradeoff.errors import (
    Press,
    converged,
    errors,
    hertzian,
    mesh_errors,
    press,
)
from fefinger.validation.tradeoff.rules import LIMIT, answers, identified
from fefinger.validation.tradeoff.runs import Run

from fefinger.mechanics import get
from fefinger.mechanics.evidence import machine
from fefinger.mechanics.situation import Situation
from fefinger.neural.membranes import LARGEST_STEP
from fefinger.results.candidate import Candidate
from fefinger.results.result_record import green_lagrange
from fefinger.scene.scene import Scene


EXACT = 5e-6
"""s: step of the Runge-Kutta run that integrators are compared with."""

TOLERANCES = (1e-3, 1e-4, 1e-5)
"""s: tolerances of spike times that are tried."""


def found(name: str) -> dict[str, Press]:
    """Return the press by every candidate, the identified ones as well."""
    fitted, presses_by_name = identified(), answers(name)
    presses_by_name["hertz identified"] = hertzian(name, fitted)
    if "layered" in presses_by_name:
        presses_by_name["layered identified"] = presses_by_name["layered"].scaled(fitted.stiffness)
    return presses_by_name


def spent(candidate: str, name: str) -> dict[str, float]:
    """Return seconds and memory of the press of a candidate.

    expected_s: as the planner states them, from reports measured on a free machine; cpu_s: of the
    run, beside which others ran; memory_MB: of its process.
    """
    mechanics, mesh = _run_of(candidate)
    expected = get(mechanics).cost(Situation.of(scenes.press(name, mesh))) / machine.slowness({})
    if candidate == "lumped":
        return {"expected_s": expected}
    arrays = runs.load(Run("press", name, mechanics, mesh))
    assert arrays is not None
    return {
        "expected_s": float(f"{expected:.4g}"),
        "cpu_s": float(arrays["cpu_s"]),
        "memory_MB": float(arrays["memory_MB"]),
    }


def _run_of(label: str) -> tuple[str, str]:
    """Return mechanics and mesh of the run that a candidate was measured by."""
    candidate = Candidate.of(label)
    mesh = candidate.resolution
    return candidate.mechanics, mesh if mesh in ("coarse", "standard") else "standard"


def split(name: str) -> dict[str, dict[str, Any]]:
    """Return numerical, model and total errors at the full depth of a press, and what it cost."""
    true, rows = converged(name).press, {}
    for candidate, pressed in found(name).items():
        mechanics = Candidate.of(candidate).mechanics
        all_, zero = errors(pressed, true), dict.fromkeys(presses.QUANTITIES, 0.0)
        numerical, model = zero, _last(all_)
        if mechanics in ("condensed", "linear"):
            limit = converged(name, LIMIT.get(mechanics, mechanics))
            numerical, model = _last(mesh_errors(pressed, limit)), _last(errors(limit.press, true))
        elif mechanics == "solid":
            numerical, model = _last(mesh_errors(pressed, converged(name))), zero
        quantities = ("force",) if mechanics == "lumped" else presses.QUANTITIES
        rows[candidate] = {
            "numerical": {key: numerical[key] for key in quantities},
            "model": {key: model[key] for key in quantities},
            "total": {key: value for key, value in _last(all_).items() if key in quantities},
            **spent(candidate, name),
        }
    return rows


def _last(values: dict[str, Any]) -> dict[str, float]:
    return {key: float(f"{each[-1]:.4g}") for key, each in values.items()}


def base(name: str) -> dict[str, Any]:
    """Return the errors of a base scene by candidate, those of its spikes, and separability."""
    pressed, _ = scenes.MOTIONS[name]
    scene, true = scenes.base(name), converged(pressed)
    reference = motion.motion_history(true.press, scene, fast=True)
    heard = Run("press", pressed, "solid", "standard")
    trains = motion.spikes(reference, heard)
    rows: dict[str, Any] = {}
    for candidate, press_of_candidate in found(pressed).items():
        passed = motion.motion_history(press_of_candidate, scene, fast=True)
        row: dict[str, Any] = motion.errors(passed, reference)
        if candidate == "lumped":
            row = {"force": row["force"]}
        else:
            fired = motion.spikes(passed, Run("press", pressed, *_run_of(candidate)))
            row["spikes"] = motion.spike_errors(fired, trains)
        rows[candidate] = _rounded(row | spent(candidate, pressed))
    run = motion.direct(name, "solid", "coarse")
    return {
        "press": pressed,
        "motion": scene.motion.kind,
        "peak_mm": scene.motion.peak,
        "seconds": scene.motion.duration,
        "peak_force_N": float(reference.force.max()),
        "spikes": dict(zip(scenes.TYPES, map(len, trains.times), strict=True)),
        "bars": {key: float(f"{value[-1]:.4g}") for key, value in true.bars.items()},
        "candidates": rows,
        "separable": separable(name),
        "linear_against_direct": None if run is None else _direct(pressed, scene, run),
    }


def _direct(pressed: str, scene: Scene, run: motion.MotionHistory) -> dict[str, float] | None:
    """Return the model error of `linear` against `solid` run through the scene, both coarse."""
    coarse = press(pressed, "linear", "coarse")
    return (
        None
        if coarse is None
        else _rounded(motion.errors(motion.motion_history(coarse, scene, fast=True), run))
    )


def _rounded(row: dict[str, Any]) -> dict[str, Any]:
    return {
        key: _rounded(value) if isinstance(value, dict) else float(f"{value:.4g}")
        for key, value in row.items()
    }


def separable(name: str) -> dict[str, float] | None:
    """Return the error of carrying a coarse press of `solid` to a motion, against a direct run."""
    pressed, _ = scenes.MOTIONS[name]
    pressed_solid, run = press(pressed, "solid", "coarse"), motion.direct(name, "solid", "coarse")
    if pressed_solid is None or run is None:
        return None
    return _rounded(
        motion.errors(motion.motion_history(pressed_solid, scenes.base(name), fast=True), run)
    )


def strain_measures() -> dict[str, dict[str, float]]:
    """Compare the logarithmic strain of the deepest presses with other strain measures.

    Green and Lagrange's strain of the same deformation, and the small strain of `linear` on the
    standard mesh: Frobenius norms over the end organs, relative.
    """
    rows = {}
    for name in scenes.BASE:
        pressed, small = press(name, "solid", "standard"), press(name, "linear", "standard")
        assert pressed is not None
        assert small is not None
        log = pressed.strain[-1]
        green = green_lagrange(log)
        size = float(np.linalg.norm(log))
        rows[name] = {
            "largest_log_strain": float(np.abs(np.linalg.eigvalsh(log)).max()),
            "green_lagrange": float(np.linalg.norm(green - log)) / size,
            "small": float(np.linalg.norm(small.strain[-1] - log)) / size,
            "small_against_green_lagrange": float(
                np.linalg.norm(small.strain[-1] - green) / np.linalg.norm(green)
            ),
        }
    return {name: _rounded(row) for name, row in rows.items()}


def integrators() -> dict[str, dict[str, dict[str, float]]]:
    """Return errors of spikes and CPU seconds of the membrane's settings, by base scene."""
    found_ = {}
    for name in ("flat-30 fast, deep", "sphere-10 slow, shallow"):
        pressed, _ = scenes.MOTIONS[name]
        passed = motion.motion_history(converged(pressed).press, scenes.base(name), fast=True)
        heard = Run("press", pressed, "solid", "standard")
        exact = motion.spikes(passed, heard, dt=EXACT)
        settings: dict[str, dict[str, float]] = {
            f"steps of {1e6 * LARGEST_STEP:g} us (default)": {"dt": LARGEST_STEP},
            "steps of 25 us": {"dt": 25e-6},
        }
        settings |= {f"tolerance {1e3 * x:g} ms": {"tolerance": x} for x in TOLERANCES}
        rows = {}
        for label, setting in settings.items():
            motion.spikes(passed, heard, **setting)  # compiles
            started = time.process_time()
            trains = motion.spikes(passed, heard, **setting)
            cost = time.process_time() - started
            rows[label] = _rounded(
                motion.spike_errors(trains, exact)
                | {"cpu_s": cost, "worst_ms": _worst(trains, exact)}
            )
        found_[name] = rows
    return found_


def _worst(trains: Any, exact: Any) -> float:
    """Return the largest error of a spike time in ms, of units with the same count."""
    pairs = zip(trains.times, exact.times, strict=True)
    apart = [np.abs(a - b).max() for a, b in pairs if len(a) == len(b) and len(a)]
    return 1e3 * float(max(apart, default=np.nan))


def front(points: dict[str, tuple[float, float]]) -> list[str]:
    """Return the names of the points (cost, error) that no other beats in both, cheapest first."""
    order = sorted(points, key=lambda name: points[name])
    best, names = np.inf, []
    for name in order:
        if points[name][1] < best:
            best = points[name][1]
            names.append(name)
    return names
