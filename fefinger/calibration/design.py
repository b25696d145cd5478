"""Which press would tell what: expected deviations of a calibration, before the experiment.

By the Fisher information of the model that a calibration fits, with its priors, the noise of the
rig, and the least errors of the model.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.inverse import Values, judged
from fefinger.calibration.noise import white
from fefinger.calibration.press_store import Work
from fefinger.calibration.record_target import MESH, ONE_G, RecordTarget
from fefinger.calibration.rig import Rig
from fefinger.calibration.search import EXPONENTS, biased, row, with_skin
from fefinger.calibration.slow_press import PLATE
from fefinger.calibration.targets import (
    MODULUS,
    SHAPE,
    TOUCH,
    Forces,
    prony_of,
    relaxation_unknowns,
)
from fefinger.calibration.trace import trace
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.support.checks import InputError
from fefinger.support.progress import Progress
from fefinger.support.text import table
from fefinger.theory.lumped.identify import Identification
from fefinger.theory.lumped.ramp_hold import FEWEST, split
from fefinger.theory.lumped.spring import Spring


REST, CLEAR = 0.1, 0.5
"""Rest in s before the motion, and free travel in mm before touch."""

FORCE_NOISE, POSITION_NOISE = 5.0, 2e-3
"""Noise in mN and mm of a rig of which none is given."""

MEANS = library.calibrated_name(library.MEANS)

EXPECTED = 3.5
"""Exponent of the tissue that is expected, about that of the calibrated subjects."""

TOLD = (MODULUS, SHAPE, TOUCH, "delay", "c1/c0", "v1", "v2", "v3")
"""Parameters whose deviations are shown."""


@dataclass(frozen=True)
class Candidate:
    """A press that could be made: speed mm/s, depth mm, hold s, samples per s."""

    speed: float
    depth: float
    hold: float
    rate: float


CANDIDATES = tuple(
    Candidate(speed, depth, hold, rate)
    for speed in (5.0, 20.0, 60.0)
    for depth in (1.0, 1.5)
    for hold in (2.0, 10.0)
    for rate in (1e3, 1e4)
    if rate * depth / speed >= 2 * FEWEST
)
"""Presses of usual rigs, of which a record has enough samples on the ramp."""


@dataclass(frozen=True)
class Planned:
    """A press with the standard deviations that a calibration of it is expected to state.

    Those of TOLD: relative ones, but of x0 in mm and of the delay in ms.
    """

    press: Candidate
    deviations: Values


def design(
    finger: Finger,
    rig: Rig,
    presses: Iterable[Candidate] = CANDIDATES,
    progress: Progress | None = None,
) -> tuple[Planned, ...]:
    """Return presses with the deviations that they are expected to leave, on the coarse mesh.

    finger: its size and tissue, about which the priors are; the pulp is expected to stiffen by
    EXPECTED, to have the modulus of the finger of the mean curves, and to relax as the mean of
    Pawluk (1997).

    Raises ConvergenceError if a press of the finger cannot be solved.
    """
    work = Work(replace(finger, resolution="coarse"), progress)
    radius, rest = work.finger.pad_radius, work.finger.subcutaneous.modulus
    with work.stage("solid, coarse"):
        curves = with_skin(work, row(work, radius, EXPONENTS))
    values = {MODULUS: library.tissue_set(MEANS).subcutaneous.modulus, SHAPE: EXPECTED, TOUCH: 0.0}
    values |= {each.name: each.start for each in relaxation_unknowns(library.MEANS)}
    law = ForceLaw(curves.at(EXPECTED, radius), prony_of(values), values[MODULUS] / rest)
    found = []
    for press in presses:
        ratio = work.finger.skin.modulus / rest
        forces = Forces(expected(press, law, rig), curves, rest, ratio, radius)
        known = {each.name: each.start for each in forces.unknowns} | values
        solution = biased(judged(forces.residual, forces.unknowns, known, (), 0))
        deviations = {
            each.name: solution.deviations[each.name] / (known[each.name] if each.log else 1.0)
            for each in forces.unknowns
        }
        deviations[SHAPE] /= EXPECTED
        found.append(Planned(press, {name: deviations.get(name, 0.0) for name in TOLD}))
    return tuple(found)


def expected(press: Candidate, law: ForceLaw, rig: Rig) -> RecordTarget:
    """Return the record that a press of a finger would give, with the noise of the rig."""
    begins, ends = REST + CLEAR / press.speed, REST + (CLEAR + press.depth) / press.speed
    time = np.arange(0.0, ends + press.hold, 1 / press.rate)
    position = np.clip(press.speed * (time - REST), 0.0, CLEAR + press.depth) - CLEAR
    inside = time >= begins - 1 / press.rate
    force = np.zeros_like(time)
    force[inside] = law.loading(time[inside], position[inside])
    try:
        record = split(time, position, force)
    except ValueError as error:
        raise InputError(f"press at {press.speed:g} mm/s, {press.rate:g} Hz: {error}") from None
    noise = white(1e-3 * (rig.force_noise or FORCE_NOISE))
    jitter = rig.position_noise or POSITION_NOISE
    reduced = trace(replace(record, position_noise=jitter), force[: len(record.time)], jitter)
    lumped = Identification(Spring(0.2, 2.0, 0.0), law.prony, {}, 0.0, 1.0)
    size = len(reduced.time)
    least = (MESH["coarse"], ONE_G)
    target = RecordTarget(
        *("design", record, lumped, reduced, 0.0, noise, jitter, rig, "coarse", "", PLATE),
        least,
        np.eye(size),
    )
    return target.about(law, {TOUCH: 0.0})


def told(planned: Sequence[Planned]) -> str:
    """Return a table of presses, and a sentence for the best of each parameter."""
    heads = ("mm/s", "mm", "hold s", "Hz", *(f"{n} %" for n in TOLD if n not in (TOUCH, "delay")))
    rows = []
    for each in planned:
        press = each.press
        shown = (sd for name, sd in each.deviations.items() if name not in (TOUCH, "delay"))
        parts = [f"{100 * sd:.2g}" for sd in shown]
        rows.append(
            [f"{press.speed:g}", f"{press.depth:g}", f"{press.hold:g}", f"{press.rate:g}", *parts]
        )
    lines = ["Expected standard deviations of a calibration:", table(rows, heads)]
    for name in TOLD:
        best = min(planned, key=lambda each: each.deviations[name])
        worst = max(planned, key=lambda each: each.deviations[name])
        press, sds = best.press, (best.deviations[name], worst.deviations[name])
        unit = {TOUCH: " mm", "delay": " ms"}.get(name, " %")
        scale = 100 if unit == " %" else 1
        lines.append(
            f"{name}: best by {press.speed:g} mm/s to {press.depth:g} mm, held {press.hold:g} s at "
            f"{press.rate:g} Hz: {scale * sds[0]:.2g}{unit}, instead of up to "
            f"{scale * sds[1]:.2g}{unit}"
        )
    return "\n".join(lines)
