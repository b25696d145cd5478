"""From an elastic press to any motion of the same object: nested contact of a body with one G.

Exact for small strain and displacements; for `solid`, whose stress relaxes in the deformed body,
it is an approximation that the report measures against direct runs.
"""

from dataclasses import dataclass

import numpy as np
from fefinger.validation.tradeoff import runs
from fefinger.validation.tradeoff.errors import Press, norm
from fefinger.validation.tradeoff.runs import Run

from fefinger.mechanics.evidence.tradeoff import STATED
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.neural.trains import SpikeTrains
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.theory.contact.ting import press_by_depth, radius_nodes


NODES = 96

FORCE, AREA, STRAIN, PRESSURE = 1.5, 1.0, 1.0, 1.0
"""Powers of the depth that force, area, strain and highest pressure over 1 mm² begin with: Hertz's,
and between its 3/2 far from the contact (or where that is small) and 1/2 close to it."""

COST = 1e3
"""Cost per s of moving a spike, of Victor and Purpura: 1 ms off counts as one spike."""


@dataclass(frozen=True)
class MotionHistory:
    """An answer through time.

    time (n_t,) s, force (n_t,) N, pressure (n_t,) kPa, the highest over 1 mm², area (n_t,) mm²,
    strain (n_t, 4, 3, 3) at the sites.
    """

    time: Array
    force: Array
    pressure: Array
    area: Array
    strain: Array


def motion_history(pressed: Press, scene: Scene, *, fast: bool = False) -> MotionHistory:
    """Return the motion of a scene, by depth, on the finger of a press of relaxed tissue.

    The highest pressure is taken to stay where it is on the pad, as that of a ball does.
    """
    time = time_grid(scene.motion, fast=fast)
    nodes = radius_nodes(scene.motion.peak * (1 + 1e-9), NODES)
    prony = scene.finger.prony
    history = press_by_depth(prony, time, scene.motion.value(time), nodes)
    force = history.stress(_curve(pressed.depth, pressed.force, nodes, FORCE)) / prony.long_time
    area = _curve(pressed.depth, pressed.area, history.edge, AREA)
    strain = history.strain(_curve(pressed.depth, pressed.strain, nodes, STRAIN))
    highest = history.stress(_curve(pressed.depth, pressed.pressure, nodes, PRESSURE))
    return MotionHistory(time, force, highest / prony.long_time, area, strain)


def direct(name: str, mechanics: str, resolution: str, refine: int = 1) -> MotionHistory | None:
    """Return a base scene that a mechanics was run on; None where it refused."""
    arrays = runs.load(Run("base", name, mechanics, resolution, refine))
    if arrays is None:
        return None
    names = ("time", "force", "highest", "area", "strain")
    return MotionHistory(*(arrays[key] for key in names))


def errors(history: MotionHistory, true: MotionHistory) -> dict[str, float]:
    """Return the errors of what is stated.

    Of the force the largest through time, of its peak; of the rest that when the force is largest.
    """
    at = int(np.argmax(true.force))
    force = np.interp(true.time, history.time, history.force)
    apart = {
        name: norm(_at(history, name, true.time[at]) - value) / norm(value)
        for name, value in ((name, getattr(true, name)[at : at + 1]) for name in STATED[1:])
    }
    largest = float(np.abs(force - true.force).max() / true.force.max())
    return {"force": largest, **{name: float(value[0]) for name, value in apart.items()}}


def _at(history: MotionHistory, name: str, time: float) -> Array:
    """Return the value (1, ...) of a passage at a time."""
    values = getattr(history, name)
    rows = [np.interp(time, history.time, row) for row in values.reshape(len(values), -1).T]
    return np.reshape(rows, (1, *values.shape[1:]))


def spikes(
    history: MotionHistory, reference: Run, dt: float | None = None, tolerance: float | None = None
) -> SpikeTrains:
    """Return the spikes of the four central units; `reference` ran the press that sets lengths."""
    from fefinger.validation.tradeoff.scenes import TYPES

    from fefinger.neural.membranes import LARGEST_STEP
    from fefinger.neural.reference import Reference, equivalent_displacements
    from fefinger.neural.units import simulate_units

    arrays = runs.load(reference)
    assert arrays is not None
    reference_press = Reference(
        float(arrays["reference_depth"]),
        TYPES,
        arrays["reference_normals"],
        arrays["reference"],
    )
    x_in = equivalent_displacements(history.strain, arrays["normals"], TYPES, reference_press)
    return simulate_units(
        history.time,
        x_in,
        types=TYPES,
        dt=dt or LARGEST_STEP,
        tolerance=tolerance,
        check=False,
    )


def spike_errors(trains: SpikeTrains, true: SpikeTrains) -> dict[str, float]:
    """Errors of the spikes of all four units: counts, first spikes and distance.

    count: missing or extra spikes over all; first_ms: the largest difference of first spikes, nan
    where one has none; distance: of Victor and Purpura at 1 ms, per spike.
    """
    from fefinger.neural.statistics import victor_purpura

    total = max(sum(len(times) for times in true.times), 1)
    pairs = list(zip(trains.times, true.times, strict=True))
    first = [1e3 * abs(a[0] - b[0]) for a, b in pairs if len(a) and len(b)]
    return {
        "count": sum(abs(len(a) - len(b)) for a, b in pairs) / total,
        "first_ms": max(first, default=float("nan")),
        "distance": sum(victor_purpura(a, b, COST) for a, b in pairs) / total,
    }


def _curve(depth: Array, values: Array, wanted: Array, order: float) -> Array:
    """Return values (m, ...) at wanted (m,) depths, smooth, and growing as depth^order at first."""
    from scipy.interpolate import PchipInterpolator

    def power(d: Array) -> Array:
        return np.asarray((d**order).reshape(-1, *np.ones(values.ndim - 1, int)))

    ratio = PchipInterpolator(depth, values / power(depth), axis=0)
    return np.asarray(ratio(np.clip(wanted, depth[0], depth[-1])) * power(wanted))
