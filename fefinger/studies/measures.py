"""What a study tells of a result: force, shape and place of the contact, spikes, at some times.

Places are in the plane of the object, from the first touch on the smooth skin: towards the tip
(distal) and sideways.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.result import Result
from fefinger.results import pressure as pressures
from fefinger.results.array_sensor import response
from fefinger.results.records import Array, Integers
from fefinger.studies.errors import stated
from fefinger.studies.hertz import hertz
from fefinger.studies.slope import stiffness
from fefinger.studies.times import Moment, at, moments
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.theory.array.sensor import ArraySensor, isobar
from fefinger.theory.contact.pressure_moments import Moments
from fefinger.theory.contact.pressure_moments import moments as shape_of


if TYPE_CHECKING:
    from fefinger.mesh.first_touch import FirstTouch

FELT = 4.0
"""Standard deviations of its noise above which an element of the array counts as touched."""

LEVEL = 4.0
"""Pressure in kPa whose isobar bounds the contact, the step between those of Figure 3-3."""

ROUNDING = 1e-9
"""In mm, or as a share of the force: a shift or an asymmetry below it is that of rounding."""

READINGS = "readings_kPa"
"""Key of what the array reads, element by element; a list, which tables leave out."""


def rows(
    result: Result, *, forces: tuple[float, ...] = (), depths: tuple[float, ...] = ()
) -> list[dict[str, Any]]:
    """Return what a study tells of a result at its peak and end, at forces in N and depths in mm.

    A force or depth is met where the loading reaches it first, between two time steps along
    straight lines in time; one that is not reached has a row that says so in `status`.
    """
    times = moments(result.response.force, result.depth, forces, depths)
    highest = _highest(result, [time.where for time in times if not time.missed])
    seen, plan = _view(result), result.plan
    about = {
        "mechanics": plan.mechanics,
        "mesh": (plan.settings and plan.settings.resolution) or "",
        "evidence": plan.chosen.evidence,
        "seconds": sum(result.seconds.values()),
        "notes": " ".join(result.spikes.notes) if result.spikes else "",
    }
    if result.scene.ask.population is not None:
        about["seed"] = result.scene.ask.population.seed
    return [
        {"at": time.name, "status": time.missed or "done"}
        | ({} if time.missed else _row(result, seen, time, highest.get(time.where)))
        | about
        for time in times
    ]


def _highest(result: Result, places: Sequence[float]) -> dict[float, float]:
    """Return the highest pressure in kPa as a mean over 1 mm² at some places in time."""
    if result.pressure is None or result.pad is None:
        return {}
    then = np.array([at(result.pressure, where) for where in places])
    return dict(zip(places, pressures.peaks(result.pad, then).tolist(), strict=True))


def _row(
    result: Result, seen: "View | None", moment: Moment, highest: float | None
) -> dict[str, Any]:
    """Return the numbers at one time, by column."""
    where, control = moment.where, result.scene.motion.control
    slope = stiffness(result.time, result.depth, result.response.force, where, control=control)
    row: dict[str, Any] = {
        "time_s": float(at(result.time, where)),
        "depth_mm": float(at(result.depth, where)),
        "force_N": float(at(result.response.force, where)),
        "stiffness_N_per_mm": slope.value,
        "stiffness_points": slope.points,
        "stiffness_note": slope.note,
    }
    if result.contact_area is not None:
        row["contact_area_mm2"] = float(at(result.contact_area, where))
    if highest is not None:
        row["highest_pressure_1mm2_kPa"] = highest
    if result.strain is not None:
        size = np.linalg.norm(at(result.strain, where), axis=(1, 2))
        row["strain_rms_percent"] = 100 * float(np.sqrt(np.mean(size**2)))
    row |= stated(result, where, moment.given or control)
    if result.spikes is not None:
        row |= _spikes(result, row["time_s"])
    if seen is not None and row["force_N"] > 0:
        row |= _shape(seen, where) | _sensed(seen, where)
    if seen is not None and seen.touch is not None:
        row |= hertz(result, seen.touch, where)
    return row


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
    touch: "FirstTouch | None"


def _view(result: Result) -> View | None:
    """Return the pad as its object sees it; None without a pressure or a known first touch."""
    from fefinger.mesh.first_touch import directions

    pad, found = result.pad, _first_touch(result)
    if pad is None or result.pressure is None or found is None:
        return None
    origin, axis, touch = found
    a, b, c = np.moveaxis(pad.points[pad.triangles], 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    return View(result, (pad.points - origin) @ directions(axis).T, areas, touch)


def _first_touch(result: Result) -> "tuple[Array, Array, FirstTouch | None] | None":
    """Return the place (3,) mm of first touch, the travel (3,), and the skin there.

    On the finger's mesh it is that on its smooth skin; else the place above the end organs.
    """
    from fefinger.mesh.first_touch import first_touch
    from fefinger.mesh.recipe import Recipe
    from fefinger.scene.indenter import STANDARD, direction

    scene, sites = result.scene, result.sites
    if "mesh" in result.response.sources and scene.indenter.place is None:
        axis = direction(scene.indenter.plate or STANDARD)
        touch = first_touch(Recipe.of(scene.finger), axis)
        return touch.point, axis, touch
    if sites is None or scene.ask.population is not None:
        return None
    axis = -sites.normals[0]
    return sites.points[0] - sites.depths[0] * axis, axis, None


def _sure(value: float) -> float:
    """Return a value, 0 instead of the rounding of a symmetric one."""
    return 0.0 if abs(value) < ROUNDING else value


def _named(prefix: str, found: Moments) -> dict[str, Any]:
    return {
        f"{prefix}shift_distal_mm": _sure(float(found.center[0])),
        f"{prefix}shift_side_mm": _sure(float(found.center[1])),
        f"{prefix}asymmetry": _sure(found.asymmetry),
        f"{prefix}ellipticity": found.ellipticity,
        f"{prefix}long_axis_deg": found.long_axis,
    }


def _shape(seen: View, where: float) -> dict[str, Any]:
    """Return the columns on the shape of the contact as it is."""
    pad, pressure = seen.result.pad, seen.result.pressure
    assert pad is not None
    assert pressure is not None
    now = at(pressure, where)
    found = shape_of(seen.places, pad.triangles, seen.areas, now)
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
    if seen.result.scene.indenter.flat is None:
        return {}
    heaviest = pressure[int(np.argmax(seen.result.response.force))] * pad.areas
    middle = heaviest @ seen.places / heaviest.sum()
    try:
        weights = response(sensor, pad, seen.places - middle)
    except ValueError as error:
        return {"sensor_note": f"not read: {error}"}
    felt, element = weights @ at(pressure, where), sensor.pitch**2
    places = sensor.positions + middle
    triangles = _both_ways(sensor)
    halves = np.full(len(triangles), element / 4)
    return {
        "sensor_force_N": float(felt.sum() * element) * NEWTON_PER_MILLINEWTON,
        "sensor_area_mm2": float((felt > FELT * sensor.noise).sum() * element),
        "sensor_peak_kPa": float(felt.max()),
        **_named("sensor_", shape_of(places, triangles, halves, felt)),
        **_reach("sensor_", places, triangles, felt),
        "sensor_middle_distal_mm": float(middle[0]),
        READINGS: [float(value) for value in felt],
    }


def _both_ways(sensor: ArraySensor) -> Integers:
    """Return the triangles of an array with either diagonal of its squares, so that none leans."""
    mirrored = np.arange(sensor.elements**2).reshape(sensor.elements, -1)[:, ::-1].ravel()
    return np.concatenate([sensor.triangles, mirrored[sensor.triangles]])
