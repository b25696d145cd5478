"""Suite `waves`: inertia against closed forms, a second method, and published fingers."""

from collections.abc import Iterator
from functools import cache, partial
from typing import Any

import numpy as np
from fefinger.validation.case import Case, Expected, Noted, Row, tabled
from fefinger.validation.waves import bodies, direct, drawings, finger, loops


TENTH_PERCENT = 1e-3


def layer_error(cells: int) -> float:
    """Return the largest relative error of a shear layer on a moving base from 1 Hz to 1 kHz."""
    frequency = np.geomspace(1.0, 1000.0, 120)
    exact = bodies.layer_exact(frequency)
    return float(np.abs(bodies.on_moving_base(cells, frequency) / exact - 1).max())


def layer_order() -> float:
    """Return the order of convergence of the third frequency of a layer held at its base."""
    exact = 5 * bodies.shear_speed(bodies.PULP) / (4 * bodies.HEIGHT)
    coarse, fine = (bodies.shear_layer(cells).modes.frequencies[2] / exact - 1 for cells in (6, 12))
    return float(np.log2(coarse / fine))


@cache
def ball_errors(*, twisting: bool, finest: int) -> tuple[float, ...]:
    """Return the relative errors of a frequency of a ball on successively halved meshes."""
    root = bodies.torsional_root() if twisting else bodies.spheroidal_root()
    exact = root * bodies.shear_speed(bodies.INCOMPRESSIBLE) / (2 * np.pi)
    meshes = [bodies.ball(number, twisting=twisting) for number in range(2, finest + 1)]
    return tuple(float(mesh.modes.frequencies[0] / exact - 1) for mesh in meshes)


def ball_limit(*, twisting: bool, finest: int) -> float:
    """Return the relative error of a frequency of a ball, extrapolated with order 2."""
    coarse, fine = ball_errors(twisting=twisting, finest=finest)[-2:]
    return (4 * fine - coarse) / 3


def ball_order(*, twisting: bool, finest: int) -> float:
    """Return the order of convergence of a frequency of a ball."""
    coarse, fine = ball_errors(twisting=twisting, finest=finest)[-2:]
    return float(np.log2(coarse / fine))


def half_space_error(edge: float) -> Noted:
    """Return the largest error of a vibrating disc on a half-space from 300 to 700 Hz."""
    body, load = bodies.half_space(edge)
    frequencies = np.array([300.0, 400.0, 500.0, 600.0, 700.0])
    weights = bodies.LOSSY
    computed = body.receptance(load, frequencies, relaxation=weights) / load.sum()
    exact = np.array([bodies.half_space_exact(f) for f in frequencies])
    errors = np.abs(computed - exact) / np.abs(exact)
    each = zip(frequencies, errors, strict=True)
    text = ", ".join(f"{100 * error:.2g} % at {f:g} Hz" for f, error in each)
    return Noted(float(errors.max()), text)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the cases; the quick ones need no finger of their own."""
    yield from _closed_forms(quick=quick)
    yield from tabled(LOOPS)
    if not quick:
        for name in direct.PATHS:
            yield from _direct(name)
        yield from tabled(FINGERS)
        yield from finger.verdicts()


def _closed_forms(*, quick: bool) -> Iterator[Case]:
    title = "viscoelastic shear layer on a moving base, 1 Hz to 1 kHz: largest error"
    origin = "1 / cos(k h) with the complex modulus; 12 modes and the static term"
    yield Case(title, partial(layer_error, 12), Expected.between(0.0, TENTH_PERCENT), origin)
    title = "layer held at its base: order of convergence of the third frequency"
    yield Case(title, layer_order, Expected(4.0, 0.3), "(2 n - 1) c / 4 h; quadratic elements")
    finest = 3 if quick else 4
    for twisting, name, source in (
        (True, "torsional", "j2(x) = x j3(x)"),
        (False, "spheroidal", "no traction on a gradient and a double curl (Lamb 1882)"),
    ):
        title = f"free incompressible ball, lowest {name} frequency: extrapolated error"
        measure = partial(ball_limit, twisting=twisting, finest=finest)
        yield Case(title, measure, Expected(0.0, 3e-4 if quick else 5e-5), source)
        title = f"free incompressible ball, lowest {name} frequency: order of convergence"
        measure = partial(ball_order, twisting=twisting, finest=finest)
        yield Case(title, measure, Expected(2.0, 0.05), "flat facets on a ball")
    yield Case(
        "disc of 1 mm that vibrates a lossy half-space, 300 to 700 Hz: largest error",
        partial(half_space_error, 0.5),
        Expected.between(0.0, 0.01),
        "Lamb's integral, Miller and Pursey (1954); held 24 mm away, where waves have died out",
        reason="the modes that are left out, and the edge of the disc, where strain is singular",
    )


def _direct(name: str) -> Iterator[Case]:
    """Yield the comparison of a motion with direct integration."""
    source = "backward differences of second order for every unknown of the mesh, without modes"
    for what, measure, limit in (
        ("force over its peak", direct.force_error, 0.01),
        ("strain of each type over its peak", direct.strain_error, 0.01),
        ("number of spikes of each type", direct.spikes, 1.0),
    ):
        title = f"{name} beside direct integration: largest difference of the {what}"
        expected = Expected.between(0.0, limit, "spikes" if limit == 1.0 else "1")
        yield Case(title, partial(measure, name), expected, source)


LOOPS: dict[str, Row] = {
    "static limit: force, strain and pressure of `condensed`, largest difference": Row(
        loops.static_difference,
        Expected.between(0.0, 1e-12),
        "`condensed` on the same mesh, ramp and rest in long steps",
    ),
    "time against frequency, one mode and a static rest: amplitude of a prescribed motion": Row(
        loops.one_mode_difference,
        Expected.between(0.0, 1e-6),
        "closed form; steps of a 1000th and a 2000th of a cycle, extrapolated",
    ),
    "time against frequency on a finger at 200 Hz: force in 60 steps per cycle": Row(
        partial(loops.finger_error, 60),
        Expected.between(0.0, 3e-3),
        "the same modes in closed form",
    ),
    "time against frequency on a finger at 200 Hz: order in the length of the step": Row(
        loops.finger_order,
        Expected(2.0, 0.25),
        "the same modes in closed form; 60 and 120 steps per cycle",
    ),
    "energy: work of the indenter less what is stored, moves and is lost, over the work": Row(
        loops.energy_difference,
        Expected.between(0.0, 3e-3),
        "a press at 200 mm/s that rings, in steps of 20 us",
    ),
    "passivity and causality: largest real part of all poles, over their modulus": Row(
        loops.largest_growth,
        Expected.between(-2.0, 0.0),
        "every pole decays, so that nothing comes before its cause",
    ),
    "causality: share of the answer to a knock that comes before it": Row(
        loops.before_the_knock,
        Expected.between(0.0, 1e-3),
        "inverse Fourier transform of the harmonic answer of a mode and its rest",
    ),
    "linearity: force of twice the amplitude over twice the force, less 1": Row(
        loops.nonlinearity,
        Expected.between(0.0, 1e-5),
        "1 and 2 nm about 1 mm, at 150 Hz: the contact stays as it is",
    ),
}
"""Stepping through time, on half a coarse finger."""


FINGERS: dict[str, Row] = {
    "mirror: force and strain under balls at both sides of the finger, largest difference": Row(
        finger.mirror_difference, Expected.between(0.0, 1e-6), "mirror image of the scene"
    ),
    "stated error of the modes against what 900 of them change, 50 to 450 Hz: "
    "share that holds": Row(
        finger.stated_errors_hold,
        Expected.between(0.95, 1.0),
        "three times as many modes on the same mesh",
    ),
    "stiffening tissue about a preload: relaxed tangent over a secant of `solid`, less 1": Row(
        finger.preload_slope,
        Expected(0.0, 1e-4),
        "equilibria of `solid` 0.1 % deeper and shallower, at finite strain",
        "a secant, in which the contact grows",
    ),
    "stiffening tissue about a preload: G* a + b against the tangent at a complex G*": Row(
        finger.two_part_statics,
        Expected.between(0.0, 0.02),
        "`solid`, linearized; a and b from two real factors",
        "the body is not of one dimension",
    ),
    "stiffening tissue about a preload, 20 Hz through time: error of the oscillation, peak to "
    "peak, over what is stated": Row(
        finger.through_time,
        Expected.between(0.0, 1.0),
        "`solid`, without inertia; d.s. at a preload that no stated error was measured at",
    ),
    "stiffening tissue about a preload, viscous relaxation, 100 to 300 Hz through time: error "
    "of the oscillation over what is stated": Row(
        finger.vibration_through_time,
        Expected.between(0.0, 1.0),
        "`solid`, linearized about the compressed finger, with mass; d.s. at a preload that no "
        "stated error was measured at",
    ),
    **{
        f"stiffening tissue about a preload, {kind} relaxation, 60 to 200 Hz: error of the "
        "harmonic answer over what is stated": Row(
            partial(finger.preload_error, kind),
            Expected.between(0.0, 1.0),
            "`solid`, linearized about the compressed finger; d.s. at a preload that no stated "
            "error was measured at",
        )
        for kind in ("published", "viscous")
    },
}
"""Fingers that need modes of their own, and stiffening tissue about a finite preload."""


figures = drawings.figures


def finding() -> dict[str, Any]:
    """Return the findings of the suite as sentences."""
    return {"texts": list(drawings.TEXTS)}
