"""Rows of a study from a result: force, size, shape and place of the contact, and spikes.

Places are in the plane of the object, from first touch on the smooth skin: distal and sideways.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fefinger.geometry.finger_mesh import triangle_areas
from fefinger.geometry.profiles import directions
from fefinger.mechanics.evidence.stated_errors import at_force
from fefinger.mechanics.hertz import tissue
from fefinger.mechanics.situation import Situation
from fefinger.mesh.extend import FirstTouch, first_touch
from fefinger.mesh.recipe import Recipe
from fefinger.plan import choose, settled
from fefinger.result import Result
from fefinger.results import pressure as pressures
from fefinger.results.pressure import SPREAD
from fefinger.results.pressure import moments as shape_of
from fefinger.results.records import Pad, Rung
from fefinger.scene.indenter import direction
from fefinger.scene.indenters import STANDARD
from fefinger.scene.motions import Ramp
from fefinger.studies.grid import ERRORS, Row
from fefinger.studies.tables import (
    SAME,
    NamedTime,
    Slope,
    at,
    dynamic_stiffness,
    named_times,
    stiffness,
    until,
)
from fefinger.support.arrays import Array
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.theory.contact.elliptic import LONGEST, Elliptic
from fefinger.theory.relaxation import hereditary_integral


LEVEL = 4.0
"""Pressure in kPa whose isobar bounds the contact: the lowest in Figure 3-3 of Pawluk (1997)."""

VIBRATES = Slope(float("nan"), 0, "none: the motion vibrates, see dynamic_stiffness_N_per_mm")
"""Stiffness in a vibration, where loading and unloading alternate."""

OPENS = "none: contact opens in the last cycles of the vibration, or no cycle is whole"
"""Why a vibration has no dynamic stiffness."""

QUANTITIES = "depth", "force", "pressure", "area", "strain"
"""Names of the quantities of ERRORS in a plan."""

SPEED = 10.0
"""Speed in mm/s of the press whose errors are looked up; it changes errors of formulas alone, by
a few percent."""

NODES = 64, 32
"""Gauss points along the radius and over a quarter turn; more change a mean by less than 1e-6, for
half axes of up to 50 mm."""


def rows(
    result: Result, *, forces: tuple[float, ...] = (), depths: tuple[float, ...] = ()
) -> list[Row]:
    """Make the rows of a result: at its peak and end, and at forces in N and depths in mm.

    A force or depth is first crossed on the loading, by linear interpolation in time; the `status`
    of a row says if it is not reached.
    """
    times = named_times(result.response.force, result.depth, forces, depths)
    highest: dict[float, float] = {}  # mean pressure over 1 mm² in kPa, by index in time
    if result.pressure is not None and result.pad is not None:
        places = [time.where for time in times if not time.missed]
        then = np.array([at(result.pressure, where) for where in places])
        highest = dict(zip(places, pressures.peaks(result.pad, then).tolist(), strict=True))
    view, plan = _view(result), result.plan
    about: dict[str, object] = {
        "mechanics": plan.mechanics,
        "mesh": (plan.settings and plan.settings.resolution) or "",
        "evidence": plan.chosen.evidence,
        "seconds": sum(result.seconds.values()),
        "notes": " ".join(result.spikes.notes) if result.spikes else "",
    }
    if result.scene.ask.population is not None:
        about["seed"] = result.scene.ask.population.seed
    return [
        {
            "at": time.name,
            "status": time.missed or "done",
            **({} if time.missed else _row(result, view, time, highest.get(time.where))),
            **about,
        }
        for time in times
    ]


def _row(result: Result, view: "PlaneView | None", when: NamedTime, highest: float | None) -> Row:
    """Make the columns of a row that depend on time; `highest`: pressure over 1 mm² then."""
    where, control = when.where, result.scene.motion.control
    wave, time = result.scene.motion.trajectory.wave, float(at(result.time, where))
    slope = VIBRATES
    if wave is None or time <= wave.start:
        slope = stiffness(result.time, result.depth, result.response.force, where, control=control)
    row: dict[str, Any] = {
        "time_s": time,
        "depth_mm": float(at(result.depth, where)),
        "force_N": float(at(result.response.force, where)),
        "stiffness_N_per_mm": slope.value,
        "stiffness_points": slope.points,
        "stiffness_note": slope.note,
    }
    if when.name == "end":
        row |= _oscillation(result)
    if result.contact_area is not None:
        row["contact_area_mm2"] = float(at(result.contact_area, where))
    if highest is not None:
        row["highest_pressure_1mm2_kPa"] = highest
    if result.strain is not None:
        size = np.linalg.norm(at(result.strain, where), axis=(1, 2))
        row["strain_rms_percent"] = 100 * float(np.sqrt(np.mean(size**2)))
    row |= stated(result, where, when.given or control)
    if result.spikes is not None:
        row |= _spikes(result, row["time_s"])
        if when.name == "end":  # other runs are counted as a whole
            for kind, (_, least, largest) in result.spikes.totals().items():
                row |= {f"least_spikes_{kind}": least, f"largest_spikes_{kind}": largest}
    if view is not None and row["force_N"] > 0:
        row |= _shape(view, where)
    if view is not None and view.touch is not None:
        row |= hertz(result, view.touch, where)
    return row


def _oscillation(result: Result) -> Row:
    """Make the columns of a vibration; a note where it has no stiffness; {} without vibration."""
    motion, force = result.scene.motion, result.response.force
    if motion.trajectory.wave is None:
        return {}
    ratio = dynamic_stiffness(motion, result.time, result.depth, force)
    if ratio is None:
        return {"stiffness_note": OPENS}
    return {
        "dynamic_stiffness_N_per_mm": abs(ratio),
        "phase_deg": float(np.degrees(np.angle(ratio))),
    }


def _spikes(result: Result, time: float) -> dict[str, int]:
    """Count the spikes of all units and of each type, at the end organs up to a time in s."""
    trains = result.spikes
    assert trains is not None
    counts = [int((trains.at_end_organs(i) <= time).sum()) for i in range(len(trains))]
    row = {"spikes": sum(counts)}
    for kind, count in zip(trains.types, counts, strict=True):
        row[f"spikes_{kind}"] = row.get(f"spikes_{kind}", 0) + count
    return row


@dataclass(frozen=True)
class PlaneView:
    """The pad of a result projected onto the plane of the object.

    pressure (n_t, n_pad) kPa; places (n_pad, 2) mm from first touch, distal and sideways; areas
    (n_triangles,) mm² on the skin; touch: first touch on the smooth skin, None without a mesh.
    """

    result: Result
    pad: Pad
    pressure: Array
    places: Array
    areas: Array
    touch: FirstTouch | None


def _view(result: Result) -> PlaneView | None:
    """Project the pad onto the plane of the object; None if pressure or first touch is lacking."""
    pad, contact = result.pad, _first_touch(result)
    if pad is None or result.pressure is None or contact is None:
        return None
    origin, axis, touch = contact
    areas = triangle_areas(pad.points[pad.triangles])
    places = (pad.points - origin) @ directions(axis).T
    return PlaneView(result, pad, result.pressure, places, areas, touch)


def _first_touch(result: Result) -> tuple[Array, Array, FirstTouch | None] | None:
    """Return the point (3,) mm of first touch, the direction of travel (3,), and the skin there.

    Without a mesh it is the point above the end organs.
    """
    scene, sites = result.scene, result.sites
    if "mesh" in result.response.sources and scene.indenter.place is None:
        axis = direction(scene.indenter.plate or STANDARD)
        touch = first_touch(Recipe.of(scene.finger), axis)
        return touch.point, axis, touch
    if sites is None or scene.ask.population is not None:
        return None
    axis = -sites.normals[0]
    return sites.points[0] - sites.depths[0] * axis, axis, None


def _without_rounding(value: float) -> float:
    # Shift in mm, asymmetry or ellipticity below which a value is rounding, and set to 0.
    rounding = 1e-9
    return 0.0 if abs(value) < rounding else value


def _shape(view: PlaneView, where: float) -> Row:
    """Make columns of the shape of the pressure; without a reach where LEVEL is not reached."""
    now, triangles = at(view.pressure, where), view.pad.triangles
    shape = shape_of(view.places, triangles, view.areas, now)
    row = {
        "shift_distal_mm": _without_rounding(float(shape.center[0])),
        "shift_side_mm": _without_rounding(float(shape.center[1])),
        "asymmetry": _without_rounding(shape.asymmetry),
        "ellipticity": _without_rounding(shape.ellipticity),
        "long_axis_deg": shape.long_axis,
    }
    line = pressures.isobar(view.places, triangles, now, LEVEL)[..., 0]
    if line.size:
        row |= {
            "reach_distal_mm": float(line.max()),
            "reach_proximal_mm": float(-line.min()),
        }
    return row


def stated(result: Result, where: float, given: str) -> dict[str, float]:
    """Return the expected relative errors of a row's values by column, as far as they are known.

    A row is at a `given` "depth" or "force", which has no error. If the motion prescribes it,
    errors from the largest force on are those in the plan; else the same mechanics states them for
    a press that ends at the depth of the row. The error of the force is relative to its peak and
    grows as the force falls; the others are not known once the indenter withdraws.
    """
    force, depth = until(result.response.force, where), until(result.depth, where)
    rung, errors = result.plan.chosen, result.plan.chosen.errors
    fallen = force.max() < result.response.force.max() * (1 - SAME)
    if (fallen or given != result.scene.motion.control) and min(depth.max(), force.max()) > 0:
        rung, errors = _pressed(result, float(depth.max()), given)
    by_quantity = dict(errors) if depth[-1] >= depth.max() * (1 - SAME) else {}
    if force[-1] > 0 and given == "depth":
        by_quantity["force"] = rung.error * float(force.max() / force[-1])
    columns = zip(QUANTITIES, ERRORS.values(), strict=True)
    expected = {column: by_quantity.get(name, np.nan) for name, column in columns}
    return {column: error for column, error in expected.items() if np.isfinite(error)}


def _pressed(result: Result, depth: float, given: str) -> tuple[Rung, Mapping[str, float]]:
    """Return the errors of the same mechanics in a press to a depth in mm.

    At that depth or, where the force is given, at that force.
    """
    scene = settled(result.scene, result.plan)
    scene = replace(scene, motion=Ramp(SPEED, depth, corner=0))
    rung = choose(scene, result.plan.mechanics).chosen
    if given == "depth" or not np.isfinite(rung.error):
        return rung, rung.errors
    return rung, at_force(rung.errors, rung.error, Situation.of(scene))


def hertz(result: Result, touch: FirstTouch, where: float) -> Row:
    """Make the columns of elliptic Hertz contact with the curvatures at first touch.

    The half-space is pressed as deep as the finger; it has the mean compliance of skin and pulp and
    relaxes as the finger does. {} for a concave skin, an object that is neither plate nor sphere,
    or once the contact has shrunk.
    """
    scene, indenter = result.scene, result.scene.indenter
    if indenter.flat is None and indenter.ball_radius is None:
        return {}
    curvature = 1 / indenter.ball_radius if indenter.ball_radius is not None else 0.0
    (low, high), axes = np.linalg.eigh(touch.curvature + curvature * np.eye(2))
    depth = until(result.depth, where)
    if low <= 0 or high / low > LONGEST or (np.diff(depth) < -SAME * depth.max()).any():
        return {}
    unit = Elliptic(1 / low, 1 / high, 1 / high, *tissue(scene.finger))
    time, part = until(result.time, where), np.maximum(depth, 0.0) * high
    mean = np.sqrt(part) * share(np.sqrt(part)[:, None] * unit.semi_axes)
    prony = scene.finger.prony
    force, peak, highest = (
        hereditary_integral(prony, time, elastic)[-1] / prony.long_time
        for elastic in (part**1.5, np.sqrt(part), mean)
    )
    distal, side = (1 / (k + curvature) for k in np.diag(touch.curvature))
    return {
        "hertz_radius_distal_mm": float(distal),
        "hertz_radius_side_mm": float(side),
        "hertz_force_N": float(force * unit.force) * NEWTON_PER_MILLINEWTON,
        "hertz_contact_area_mm2": float(part[-1] * unit.area),
        "hertz_highest_pressure_1mm2_kPa": float(highest * unit.peak_pressure),
        "hertz_peak_pressure_kPa": float(peak * unit.peak_pressure),
        "hertz_ellipticity": round(1 - unit.axis_ratio, 12),
        "hertz_long_axis_deg": float((np.degrees(np.arctan2(*axes[::-1, 0])) + 90) % 180 - 90),
    }


def share(semi_axes: Array) -> Array:
    """Return the mean pressure over 1 mm² over the peak of Hertz's, for half axes (n, 2) in mm.

    The mean is about the center, weighted as in `pressures.peaks`.
    """
    (s, ds), (t, dt) = (np.polynomial.legendre.leggauss(count) for count in NODES)
    near, turn = (s + 1) / 2, np.pi / 4 * (t + 1)  # dense about the middle; the angle
    height = 1 - near**2  # pressure over its peak
    weights = np.outer(height**2 * near * ds, np.pi * dt)  # four quarters
    a, b = semi_axes.T
    across = (np.outer(a, np.cos(turn)) ** 2 + np.outer(b, np.sin(turn)) ** 2) / (2 * SPREAD**2)
    falls = np.exp(-(1 - height[:, None] ** 2) * across[:, None, :])
    return np.asarray(a * b * np.einsum("nst,st->n", falls, weights) / (2 * np.pi * SPREAD**2))
