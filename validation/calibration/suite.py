"""Suite `calibration`: recovery of twins, prediction of data not fitted, and shipped tissue sets.

The calibrated subjects are read from `reports/calibrated.json` (see
`fefinger.validation.evidence.calibration`).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from fefinger.validation.calibration import figures as calibration_figures
from fefinger.validation.calibration import (
    sensitivity_figures,
    solid_twin,
    subjects,
    tip_shape,
    twin,
)
from fefinger.validation.calibration.report import calibrated, rows
from fefinger.validation.calibration.subject_target import target_of
from fefinger.validation.calibration.subjects import PRINTED
from fefinger.validation.case import Case, Expected

from fefinger.calibration import targets
from fefinger.calibration.curve import curve, family
from fefinger.calibration.inverse import Residual, Unknown, Values, jacobian
from fefinger.calibration.press_store import Work
from fefinger.calibration.record_target import BIAS
from fefinger.calibration.search import EXPONENTS
from fefinger.calibration.slow_press import SlowPress, press
from fefinger.calibration.targets import Forces
from fefinger.mechanics import solid
from fefinger.scene import library
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.motions import RampHold
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array


SEEDS = 10
DEPTH = 1.4  # mm


def order() -> float:
    """Return the order of the remainder of Taylor's series with the Jacobian of a fit."""
    finger = twin.start()
    linear = family((1.0,), finger.pad_radius, lambda _: press(finger, "condensed"))
    forces = Forces(target_of("a.h."), linear, 34.0, 3.0, finger.pad_radius)
    values = {each.name: each.start for each in forces.unknowns} | {"t_b": 0.02}
    rest = remainders(forces.residual, forces.unknowns, values)
    return float(np.log2(rest[0] / rest[2]) / 2)


def relaxing(subject: str) -> float:
    """Return by how much `solid` with the shipped set is off the prediction, over the peak force.

    On a ramp and hold of the thesis, with relaxation in the elements, on the coarse mesh.
    """
    tissue = library.calibrated_name(subject)
    scene = Scene(
        finger=Finger.subject(subject, tissue=tissue, resolution="coarse"),
        motion=RampHold(60.0, DEPTH, hold=0.5, corner=0.0),
        ask=Ask(strain=False, fields=False, pressure=False),
    )
    response = solid.respond(scene)
    model = calibrated(subject).predict(response.time, response.depth)
    return float(np.abs(model - response.force).max() / response.force.max())


def left_out(subject: str) -> float:
    """Return the largest relative error of the force at an exponent whose press is left out."""
    work = Work(targets.finger_of(subject, resolution="coarse"), None)
    radius = work.finger.pad_radius

    def pressed(exponent: float) -> SlowPress:
        return work.press("solid", "coarse", radius, exponent)

    missed = []
    for exponent in EXPONENTS[1:-1]:
        rest = family([each for each in EXPONENTS if each != exponent], radius, pressed)
        omitted, _ = curve(pressed(exponent))
        depth = np.linspace(0.2, 1.0, 50) * min(rest.deepest, omitted.deepest)
        between = rest.at(exponent, radius).force(depth)
        missed.append(np.abs(between / omitted.force(depth) - 1).max())
    return float(max(missed))


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield twins, predictions, the array and the shipped sets."""
    yield from _twin(0 if quick else SEEDS)
    name = "order of the remainder with the Jacobian of the fit"
    yield Case(name, order, Expected(2.0, 0.2), "Taylor's theorem")
    if not quick:
        yield from _other_mesh(SEEDS)
        yield from _of_solid(SEEDS)
        yield Case(
            "a.h.: force between exponents, one press of four left out",
            partial(left_out, "a.h."),
            Expected(5.4e-3, 4e-4),
            "the press that was left out",
            reason="contact on the coarse mesh",
            wanted=0.0,
            shortfall="The aim is 0.5 %. It is missed at 2 mm, the deepest, where the stiffest "
            "tissue bears five times the force of the softest; the presses that are used are half "
            "as far apart.",
        )
        name = "a.h.: ramp and hold of solid with the shipped set, off the prediction"
        source = "one G and the elastic curve in the report"
        reason = "the coarse mesh, and a stress that relaxes at finite strain: 1 to 2 % each"
        yield Case(name, partial(relaxing, "a.h."), Expected(0.0, 0.04), source, reason=reason)
    for subject in rows():
        yield from subjects.cases(subject, quick=quick)
    yield from tip_shape.cases(quick=quick)


def _recovered(twin: str, measure: Callable[[], float], name: str, seeds: int) -> Case:
    """Return the case that a calibration finds a parameter of a twin within its uncertainty."""
    title = f"{twin}: seeds of {seeds} in which {name} is within its stated uncertainty"
    limits = Expected(seeds, 1.0, "seeds")
    reason = "two standard deviations hold 95 %, so one of ten may be outside"
    return Case(title, measure, limits, "the parameters of the twin", reason=reason)


def _twin(seeds: int) -> Iterator[Case]:
    for name in twin.TRUTH if seeds else ():
        yield _recovered("twin", partial(twin.recovered, name, seeds), name, seeds)
    for what, limit in PRINTED.items():
        yield Case(
            f"twin: {what} error of sinusoids of 2 to 16 Hz, which were not fitted",
            partial(twin.worst_sinusoid, what),
            Expected(0.0, limit),
            "the twin itself, without noise",
            reason="what the thesis reached on its subjects: to be better than that",
        )


def _other_mesh(seeds: int) -> Iterator[Case]:
    """Yield the twin of the standard mesh, which is calibrated on the coarse one: no crime."""
    mesh, other = twin.STANDARD, "twin of the standard mesh, calibrated on the coarse"
    for name in twin.TRUTH:
        measure = partial(twin.recovered, name, seeds, mesh)
        case = _recovered(other, measure, name, seeds)
        if name in twin.LESS_SURE:
            known = Expected(twin.LESS_SURE[name], 1.0, "seeds")
            case = replace(case, expected=known, wanted=seeds, shortfall=twin.TOO_SURE)
        yield case
    for name in ("pad_radius", "t_b", "t_m"):
        yield Case(
            f"{other}: {name} over the true one less 1, mean of {seeds} seeds",
            partial(twin.missed, name, seeds, mesh),
            Expected(0.0, twin.SPREAD * twin.STATED[name]),
            "the parameters of the twin",
            reason="two of the standard deviations that the calibration states",
        )


def _of_solid(seeds: int) -> Iterator[Case]:
    """Yield the twin that relaxes in its elements, which is calibrated through `solid`."""
    for name in (*solid_twin.TISSUE, "exponent"):
        measure = partial(solid_twin.recovered, name, seeds)
        yield _recovered("twin of solid", measure, name, seeds)
    weights = partial(solid_twin.weights, seeds)
    yield _recovered("twin of solid", weights, "each weight of G", seeds)
    for name in solid_twin.TRUTH:
        title = f"twin of solid: {name} over the true one less 1, mean of {seeds} seeds"
        measured = partial(solid_twin.missed, name, seeds)
        source, off = "the parameters of the twin", solid_twin.OFF
        if name not in solid_twin.BIASED:
            yield Case(title, measured, Expected(0.0, off), source, reason=BIAS)
            continue
        known = Expected(solid_twin.BIASED[name], 0.02)
        yield Case(
            *(title, measured, known, source),
            wanted=0.0,
            shortfall=f"{BIAS} {solid_twin.SKIN}",
            reason="as found",
        )


def finding() -> dict[str, Any]:
    """Return the tables of the calibrated subjects and of what moves what is found."""
    if not rows():
        return {}
    return {
        "tables": [calibration_figures.table(), *sensitivity_figures.tables(), tip_shape.table()]
    }


def figures() -> Iterator[tuple[str, Any]]:
    """Yield captions and matplotlib Figures of the calibrated subjects."""
    if rows():
        yield from calibration_figures.figures()
        yield from sensitivity_figures.figures()


def remainders(residual: Residual, unknowns: Sequence[Unknown], values: Values) -> Array:
    """First-order remainders (3,) at steps of 0.02, 0.01, 0.005 in a random direction.

    With a correct Jacobian each is a quarter of the one before.
    """
    matrix = jacobian(residual, unknowns, values)
    way = np.random.default_rng(0).normal(size=len(unknowns))
    here, out = residual(values), []
    for size in (0.02, 0.01, 0.005):
        moved = values | {
            each.name: each.outside(each.inside(values[each.name]) + size * w)
            for each, w in zip(unknowns, way.tolist(), strict=True)
        }
        out.append(np.linalg.norm(residual(moved) - here - size * matrix @ way))
    return np.array(out)
