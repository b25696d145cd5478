"""Figures of Pawluk (1997), chapter 3 and appendix A, in the thesis's own axes."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from fefinger.validation.oracles import goodwin
from fefinger.validation.panels import panels
from fefinger.validation.thesis.array import ELEMENTS, LEVEL, blurred_nodes, felt_history, sinusoid
from fefinger.validation.thesis.ball import bonded
from fefinger.validation.thesis.figures import COLORS, canvas
from fefinger.validation.thesis.pressure import PROFILES, ball, pad
from fefinger.validation.thesis.sensor import array_pressure, ball_pressure

from fefinger.calibration.array_sensor import ArraySensor
from fefinger.support.arrays import Array
from fefinger.theory.contact.hertz import Hertz
from fefinger.view.figures import INK, STEEL, figure


SLOW = 0.2  # mm/s
GOODWIN_FORCES = (20.0, 15.0, 10.0)  # gf


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure in the order of the thesis."""
    yield (
        "Figure 3-2. Readings of elements 0, 2, 4 and 6 mm from the center in a press at "
        "0.2 mm/s, means, b of Table 3.2 read as c0 b.",
        _slow(),
    )
    yield (
        "Figure 3-3. Isobars 4 kPa apart at 0.54, 1.1 and 2.3 N. The model's are circles; the "
        "measured ones are not, from proximal to distal.",
        _isobars(),
    )
    yield (
        "Figure 3-4. Pressure profiles at 0.54, 1.1 and 2.3 N: filtered by the array (lines) "
        "and as they are (dashes).",
        _profiles(),
    )
    yield "Figure 3-5. Relaxation after a ramp at 60 mm/s: force, and elements.", _relaxation()
    yield (
        "Figure 3-6. A 4 Hz sinusoid of 0.4 mm about 1.5 mm; the caption has 8 Hz, the text "
        "4 Hz. Elements 0, 2, 4 and 6 mm from the center.",
        _sinusoid(),
    )
    yield (
        "Figure 3-8. Relative peak pressure against the curvature of a sphere, Eq. 3.23. At "
        "zero it is 0.196 for 20 gf, not about 0.3 (cross).",
        _goodwin(),
    )
    yield "Figure 3-10. Contact radius relative to that of a plate, Eq. 3.25.", _radius()
    yield "Figure A-4. Response of an element against the distance of a load.", _response()
    yield (
        "Figure A-5. The fitted rubber ball: pressure at 0.59 mm, filtered (line) and not "
        "(dashes), and net force, on a cover that is a half-space (lines) or a bonded layer "
        "(dots). The cross is the force that the thesis gives, 1.8 N.",
        _ball(),
    )


def _elements(axis: Any, time: Array, pressures: Array) -> None:
    for r, color, values in zip(ELEMENTS, COLORS, pressures.T, strict=False):
        axis.plot(time, values, color=color, label=f"{r:g} mm")
    axis.legend()


def _slow() -> Any:
    drawn, axis = canvas("time / s", "pressure / kPa", xlim=(0, 11))
    time = np.linspace(0.0, 11.0, 300)
    _elements(axis, time, felt_history(time, SLOW * time)[1])
    return drawn


def _isobars() -> Any:
    means = pad("means", "relaxed")
    drawn = figure(5.6, 2.5)
    line = np.linspace(-7.0, 7.0, 161)
    x, y = np.meshgrid(line, line)
    for axis, (newtons, depth, *_) in zip(
        drawn.subplots(1, 3, sharey=True), PROFILES["relaxed"], strict=True
    ):
        pressure = means.relaxed_pressure(np.hypot(x, y), depth)
        levels = np.arange(LEVEL, pressure.max(), LEVEL)
        axis.contour(x, y, pressure, levels=levels, colors=INK, linewidths=0.8)
        axis.set(title=f"{newtons:g} N", xlabel="mm", aspect="equal")
    return drawn


def _profiles() -> Any:
    means = pad("means", "relaxed")
    drawn, axis = canvas("distance from the center / mm", "pressure / kPa", xlim=(-9, 9))
    r = np.linspace(-9.0, 9.0, 361)
    for (newtons, depth, *_), color in zip(PROFILES["relaxed"], COLORS, strict=False):
        filtered = means.prony.long_time * blurred_nodes(means, np.array([depth]), np.abs(r))[0]
        axis.plot(r, filtered, color=color, label=f"{newtons:g} N")
        axis.plot(r, means.relaxed_pressure(r, depth), "--", color=color, lw=1)
    axis.legend()
    return drawn


def _relaxation() -> Any:
    drawn, (top, bottom) = panels(5.6, 3.6, 2, 1, sharex=True)
    end = 2.0 / 60.0
    time = np.concatenate([np.linspace(0.0, end, 60)[:-1], end + np.geomspace(1e-4, 6.0, 200)])
    pressed, pressures = felt_history(time, np.minimum(60 * time, 2.0))
    top.plot(time, pressed, color=INK)
    top.set(ylabel="force / N")
    _elements(bottom, time, pressures)
    bottom.set(xlabel="time / s", ylabel="pressure / kPa")
    return drawn


def _sinusoid() -> Any:
    time, depth = sinusoid()
    drawn, axis = canvas("time / s", "pressure / kPa", xlim=(0, 1.35))
    _elements(axis, time, felt_history(time, depth)[1])
    return drawn


def _goodwin() -> Any:
    drawn, axis = canvas("curvature / 1/m", "relative pressure", xlim=(0, 700), ylim=(0, 1.05))
    curvature = np.linspace(0.0, 700.0, 200)
    for force, color in zip(GOODWIN_FORCES, COLORS, strict=False):
        axis.plot(
            curvature,
            goodwin.peak_at_force(curvature / 1e3, force),
            color=color,
            label=f"{force:g} gf",
        )
    axis.plot([0], [0.3], "x", color=INK, clip_on=False, label="printed")
    axis.legend()
    return drawn


def _radius() -> Any:
    drawn, axis = canvas(
        "curvature / 1/m", "contact radius / that of a plate", xlim=(0, 700), ylim=(0, 1.05)
    )
    curvature = np.linspace(0.0, 700.0, 200)
    axis.plot(curvature, goodwin.contact_radius(curvature / 1e3), color=INK)
    return drawn


def _response() -> Any:
    drawn, axis = canvas("distance / mm", "response / that at the center", xlim=(-5, 5))
    sensor = ArraySensor(elements=1)
    place = np.linspace(-5.0, 5.0, 201)
    points = np.stack([place, np.zeros_like(place)], axis=1)
    response = sensor.weights(points, np.ones_like(place))[0]
    axis.plot(place, response / response.max(), color=INK)
    return drawn


def _ball() -> Any:
    drawn, (left, right) = panels(5.6, 3.0, 1, 2)
    r = np.linspace(0.0, 9.0, 200)
    left.plot(r, array_pressure(r), color=INK)
    left.plot(r, ball_pressure().pressure(r), "--", color=STEEL)
    left.set(xlabel="distance / mm", ylabel="pressure / kPa")
    depth = np.linspace(0.0, 0.7, 100)
    for name, color in (("fitted", COLORS[0]), ("nominal", COLORS[1])):
        plane, at = ball(name)
        force = [Hertz(at.radius, each, plane, 0.0).force / 1e3 for each in depth.tolist()]
        right.plot(depth, force, color=color, label=name)
    some = depth[4::5]
    forces = [bonded("nominal", each).force / 1e3 for each in some.tolist()]
    right.plot(some, forces, ":", color=INK, label="nominal, bonded")
    right.plot([0.59], [1.8], "x", color=INK, label="printed")
    right.set(xlabel="depth / mm", ylabel="force / N")
    right.legend()
    return drawn
