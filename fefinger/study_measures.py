"""What a study tells of a result: force, shape and place of the contact, spikes, at some times.

Places are in the plane of the object, from the first touch on the smooth skin: towards the tip
(distal) and sideways.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.records import Array, Integers, Result
from fefinger.scene import Flat, Sphere
from fefinger.sensing import response
from fefinger.theory.moments import Moments, moments
from fefinger.theory.sensor import ArraySensor, isobar
from fefinger.units import NEWTON_PER_MILLINEWTON


if TYPE_CHECKING:
    from fefinger.mesh.local import Touch

FELT = 4.0
"""Standard deviations of its noise above which an element of the array counts as touched."""

MOVING = 0.5
"""Part of its top speed below which the indenter rests: the slope of the force over the depth is
then that of relaxation, and no stiffness is told."""

LEVEL = 4.0
"""Pressure in kPa whose isobar bounds the contact, the step between those of Figure 3-3."""

SAME = 1e-9
"""Relative difference up to which two forces or depths are the same level."""

READINGS = "readings_kPa"
"""Key of what the array reads, element by element; a list, which tables leave out."""


def rows(
    result: Result, *, forces: tuple[float, ...] = (), depths: tuple[float, ...] = ()
) -> list[dict[str, Any]]:
    """Return what a study tells of a result at its peak and end, at forces in N and depths in mm.

    A force or depth is met where the loading reaches it first, between two time steps along
    straight lines in time; one that is not reached has a row that says so in `status`.
    """
    force, depth = result.response.force, result.depth
    top, deepest = _first(force, force.max()), _first(depth, depth.max())
    times = [("peak", float(top), ""), ("end", float(len(force) - 1), "")]
    for name, unit, signal, levels in (
        ("force", "N", force[: top + 1], forces),
        ("depth", "mm", depth[: deepest + 1], depths),
    ):
        for level in levels:
            where = _reached(signal, level)
            reason = f"not reached: {name} = {signal[-1]:.4g} {unit} at most"
            times.append((f"{level:g} {unit}", where, reason if np.isnan(where) else ""))
    seen = _view(result)
    about = {
        "mechanics": result.plan.mechanics,
        "stated_error": result.plan.chosen.error,
        "evidence": result.plan.chosen.evidence,
        "seconds": sum(result.seconds.values()),
        "notes": " ".join(result.spikes.notes) if result.spikes else "",
    }
    return [
        {"at": at, "status": reason or "done"}
        | ({} if reason else _row(result, seen, where))
        | about
        for at, where, reason in times
    ]


def _first(signal: Array, level: float) -> int:
    """Return the index at which a signal first reaches a level, to rounding."""
    return int(np.argmax(signal >= level - SAME * abs(level)))


def _reached(signal: Array, level: float) -> float:
    """Return where a signal first reaches a level, as an index with a fraction, or nan."""
    if signal.max() < level * (1 - SAME):
        return float("nan")
    after = _first(signal, level)
    if after == 0:
        return 0.0
    low, high = signal[after - 1], signal[after]
    return after - 1 + min(float((level - low) / (high - low)), 1.0)


def _at(signal: Array, where: float) -> Array:
    """Return a signal (n_t, ...) at an index with a fraction."""
    low, part = int(where), where - int(where)
    return signal[low] if part == 0 else (1 - part) * signal[low] + part * signal[low + 1]


def _row(result: Result, seen: "View | None", where: float) -> dict[str, Any]:
    """Return the numbers at one time, by column."""
    row: dict[str, Any] = {
        "time_s": float(_at(result.time, where)),
        "depth_mm": float(_at(result.depth, where)),
        "force_N": float(_at(result.response.force, where)),
        "stiffness_N_per_mm": _stiffness(result, where),
    }
    if result.contact_area is not None:
        row["contact_area_mm2"] = float(_at(result.contact_area, where))
    if result.pressure is not None:
        row["peak_pressure_kPa"] = float(_at(result.pressure, where).max())
    if result.spikes is not None:
        row |= _spikes(result, row["time_s"])
    if seen is not None and row["force_N"] > 0:
        row |= _shape(seen, where) | _sensed(seen, where)
    if seen is not None and seen.touch is not None:
        row |= _hertz(result, seen.touch, where)
    return row


def _stiffness(result: Result, where: float) -> float:
    """Return the slope of the force over the depth in N/mm; nan where the indenter rests."""
    rise, moved = np.diff(result.response.force), np.diff(result.depth)
    speed = np.abs(moved) / np.diff(result.time)
    step = max(int(np.ceil(where)) - 1, 0)
    resting = speed[step] < MOVING * speed.max() or moved[step] == 0
    return float("nan") if resting else float(rise[step] / moved[step])


def _spikes(result: Result, time: float) -> dict[str, int]:
    """Return how many spikes there were so far, of all units and of each type."""
    trains = result.spikes
    assert trains is not None
    counts = [int((times <= time).sum()) for times in trains.times]
    found = {"spikes": sum(counts)}
    for kind, count in zip(trains.types, counts, strict=True):
        found[f"spikes_{kind}"] = found.get(f"spikes_{kind}", 0) + count
    return found


@dataclass(frozen=True)
class View:
    """The pad as its object sees it.

    places (n, 2) mm from first touch, towards the tip and sideways; areas (m,) mm² of the triangles
    on the skin; touch: first touch on the smooth skin, where the finger has one.
    """

    result: Result
    places: Array
    areas: Array
    touch: "Touch | None"


def _view(result: Result) -> View | None:
    """Return the pad as its object sees it; None without a pressure or a known first touch."""
    from fefinger.mesh.local import directions

    pad, found = result.pad, _first_touch(result)
    if pad is None or result.pressure is None or found is None:
        return None
    origin, axis, touch = found
    a, b, c = np.moveaxis(pad.points[pad.triangles], 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    return View(result, (pad.points - origin) @ directions(axis).T, areas, touch)


def _first_touch(result: Result) -> "tuple[Array, Array, Touch | None] | None":
    """Return the place (3,) mm of first touch, the travel (3,), and the skin there.

    On the finger's mesh it is that on its smooth skin; else the place above the end organs.
    """
    from fefinger.indenter import STANDARD, direction
    from fefinger.mesh.local import first_touch
    from fefinger.mesh.recipe import Recipe

    scene, sites = result.scene, result.sites
    indenter: Any = scene.indenter
    placed = getattr(indenter, "at", None) is not None
    if "mesh" in result.response.sources and not placed:
        axis = direction(indenter if hasattr(indenter, "angle") else STANDARD)
        touch = first_touch(Recipe.of(scene.finger), axis)
        return touch.point, axis, touch
    if sites is None or scene.ask.population is not None:
        return None
    axis = -sites.normals[0]
    return sites.points[0] - sites.depths[0] * axis, axis, None


def _named(prefix: str, found: Moments) -> dict[str, Any]:
    return {
        f"{prefix}shift_distal_mm": float(found.center[0]),
        f"{prefix}shift_side_mm": float(found.center[1]),
        f"{prefix}asymmetry": found.asymmetry,
        f"{prefix}ellipticity": found.ellipticity,
        f"{prefix}long_axis_deg": found.long_axis,
    }


def _shape(seen: View, where: float) -> dict[str, Any]:
    """Return the columns on the shape of the contact as it is."""
    pad, pressure = seen.result.pad, seen.result.pressure
    assert pad is not None
    assert pressure is not None
    now = _at(pressure, where)
    found = moments(seen.places, pad.triangles, seen.areas, now)
    return _named("", found) | _reach("", seen.places, pad.triangles, now)


def _reach(prefix: str, places: Array, triangles: Integers, pressure: Array) -> dict[str, float]:
    """Return how far the outermost isobar reaches from first touch; nothing without one."""
    line = isobar(places, triangles, pressure, LEVEL)[..., 0]
    if not line.size:
        return {}
    return {
        f"{prefix}reach_distal_mm": float(line.max()),
        f"{prefix}reach_proximal_mm": float(-line.min()),
    }


def _sensed(seen: View, where: float) -> dict[str, Any]:
    """Return the same columns as the array of the thesis would have them, without its noise.

    It lies on the plate with its middle under the center of the largest pressure, as in section
    3.2.1 of the thesis, and is read in an instant.
    """
    sensor, pad, pressure = ArraySensor(), seen.result.pad, seen.result.pressure
    assert pad is not None
    assert pressure is not None
    if not isinstance(seen.result.scene.indenter, Flat):
        return {}
    heaviest = pressure[int(np.argmax(seen.result.response.force))] * pad.areas
    middle = heaviest @ seen.places / heaviest.sum()
    try:
        weights = response(sensor, pad, seen.places - middle)
    except ValueError as error:
        return {"sensor_note": f"not read: {error}"}
    felt, element = weights @ _at(pressure, where), sensor.pitch**2
    places = sensor.positions + middle
    triangles = _both_ways(sensor)
    halves = np.full(len(triangles), element / 4)
    return {
        "sensor_force_N": float(felt.sum() * element) * NEWTON_PER_MILLINEWTON,
        "sensor_area_mm2": float((felt > FELT * sensor.noise).sum() * element),
        "sensor_peak_kPa": float(felt.max()),
        **_named("sensor_", moments(places, triangles, halves, felt)),
        **_reach("sensor_", places, triangles, felt),
        "sensor_middle_distal_mm": float(middle[0]),
        READINGS: [float(value) for value in felt],
    }


def _both_ways(sensor: ArraySensor) -> Integers:
    """Return the triangles of an array with either diagonal of its squares, so that none leans."""
    mirrored = np.arange(sensor.elements**2).reshape(sensor.elements, -1)[:, ::-1].ravel()
    return np.concatenate([sensor.triangles, mirrored[sensor.triangles]])


def _hertz(result: Result, touch: "Touch", where: float) -> dict[str, Any]:
    """Return the columns of elliptic Hertz on the curvatures at first touch, at the same depths.

    The half-space has the mean compliance of skin and pulp and relaxes as the finger does: its
    modulus is the relaxed one, over G(infinity) at once. Nothing is told of a hollow skin, of an
    object that is neither plate nor sphere, or once the contact has shrunk.
    """
    from fefinger.mechanics.hertz import tissue
    from fefinger.theory.elliptic import LONGEST, Elliptic
    from fefinger.theory.relaxation import hereditary_integral

    scene, indenter = result.scene, result.scene.indenter
    if not isinstance(indenter, Flat | Sphere):
        return {}
    own = 1 / indenter.radius if isinstance(indenter, Sphere) else 0.0
    (low, high), axes = np.linalg.eigh(touch.curvature + own * np.eye(2))
    depth = np.append(result.depth[: int(where) + 1], _at(result.depth, where))
    if low <= 0 or high / low > LONGEST or (np.diff(depth) < -SAME * depth.max()).any():
        return {}
    unit = Elliptic(1 / low, 1 / high, 1 / high, *tissue(scene.finger))
    time = np.append(result.time[: int(where) + 1], _at(result.time, where))
    part = np.maximum(depth, 0.0) * high
    prony = scene.finger.prony
    force, peak = (
        hereditary_integral(prony, time, part**power)[-1] / prony.long_time for power in (1.5, 0.5)
    )
    distal, side = (1 / (k + own) for k in np.diag(touch.curvature))
    return {
        "hertz_radius_distal_mm": float(distal),
        "hertz_radius_side_mm": float(side),
        "hertz_force_N": float(force * unit.force) * NEWTON_PER_MILLINEWTON,
        "hertz_contact_area_mm2": float(part[-1] * unit.area),
        "hertz_peak_pressure_kPa": float(peak * unit.peak_pressure),
        "hertz_ellipticity": 1 - unit.axis_ratio,
        "hertz_long_axis_deg": float((np.degrees(np.arctan2(*axes[::-1, 0])) + 90) % 180 - 90),
    }
