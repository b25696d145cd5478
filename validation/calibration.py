"""Suite `calibration`: twins are recovered, what was not fitted is predicted, and what is shipped.

The calibrated subjects are read from `reports/calibrated.json` (see `evidence_calibration`).
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from fefinger.validation import calibration_figures, calibration_twin
from fefinger.validation.calibration_report import calibrated, rows
from fefinger.validation.case import Case
from numpy.typing import NDArray

from fefinger import library
from fefinger.calibration import inverse, pad, target
from fefinger.calibration.calibrate import EXPONENTS, Work
from fefinger.calibration.calibrate import SMALLER as SMALLER_PAD
from fefinger.calibration.curve import curve, family
from fefinger.calibration.force import Forces
from fefinger.calibration.outcome import FREQUENCIES, layer
from fefinger.calibration.press import Press, press
from fefinger.mechanics import solid
from fefinger.scene import Ask, Finger, RampHold, Scene


Array = NDArray[np.float64]


SEEDS, FEW = 10, 2
DEPTH = 1.4  # mm
PRINTED = {"mse": 0.07, "peak": 0.18}
"""Errors of the thesis's own prediction of sinusoids (section 2.4.2), as fractions."""

SMALLER = (
    "Tissue that stiffens enough for Table 2.1 draws the pressure together: in this finger the "
    "thesis's fit finds a smaller R, a larger c0 b and a smaller m than Table 3.2, which is of "
    "another session."
)


def order() -> float:
    """Return the order of the remainder of Taylor's series with the Jacobian of a fit."""
    finger = calibration_twin.start()
    linear = family((1.0,), finger.pad_radius, lambda _: press(finger, "condensed"))
    forces = Forces(target.subject("a.h."), linear, 34.0, 3.0, finger.pad_radius)
    values = {each.name: each.start for each in forces.unknowns} | {"t_b": 0.02}
    rest = inverse.taylor(forces.residual, forces.unknowns, values)
    return float(np.log2(rest[0] / rest[2]) / 2)


def shipped(subject: str) -> float:
    """Return the largest relative difference of the shipped set and the report."""
    found = calibrated(subject)
    kept = library.tissue_set(library.calibrated_name(subject))
    pairs = [(kept.pad_radius, found.finger["pad_radius"])]
    for mine, theirs in ((kept.skin, found.skin), (kept.subcutaneous, found.subcutaneous)):
        pairs += [(getattr(mine, name), theirs[name]) for name in ("modulus", "exponent")]
    assert kept.prony is not None
    pairs += zip(
        kept.prony.weights + kept.prony.v, found.prony.weights + found.prony.v, strict=True
    )
    return max(abs(mine / theirs - 1) for mine, theirs in pairs)


def again(subject: str) -> float:
    """Return the largest relative distance of a new press on the coarse mesh from the report."""
    found = calibrated(subject)
    finger = Finger.subject(subject, resolution="coarse", pad_radius=found.finger["pad_radius"])
    exponent = found["exponent"].value
    factor = found["modulus"].value / finger.subcutaneous.modulus
    own = replace(
        finger,
        skin=layer(finger.skin, exponent),
        subcutaneous=layer(finger.subcutaneous, exponent),
    )
    fresh, _ = curve(press(own, "solid"))
    depth = np.linspace(0.3, 1.0, 20) * min(fresh.deepest, found.deepest)
    return float(np.abs(factor * fresh.force(depth) / found.curve.force(depth) - 1).max())


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
    work = Work(Finger.subject(subject, resolution="coarse"), None)
    radius = SMALLER_PAD * work.finger.pad_radius

    def pressed(exponent: float) -> Press:
        return work.press("solid", "coarse", radius, exponent)

    missed = []
    for exponent in EXPONENTS[1:-1]:
        rest = family([each for each in EXPONENTS if each != exponent], radius, pressed)
        own, _ = curve(pressed(exponent))
        depth = np.linspace(0.2, 1.0, 50) * min(rest.deepest, own.deepest)
        between = rest.at(exponent, radius).force(depth)
        missed.append(np.abs(between / own.force(depth) - 1).max())
    return float(max(missed))


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield twins, predictions, the array and the shipped sets."""
    yield from _twins(FEW if quick else SEEDS)
    yield Case(
        "calibration",
        "order of the remainder with the Jacobian of the fit",
        order,
        2.0,
        0.2,
        "1",
        "Taylor's theorem",
    )
    if not quick:
        yield Case(
            "calibration",
            "a.h.: force between exponents, one press of four left out",
            partial(left_out, "a.h."),
            0.0,
            5e-3,
            "1",
            "the press that was left out",
            reason="twice as far apart as the presses that are used",
        )
        yield Case(
            "calibration",
            "a.h.: ramp and hold of solid with the shipped set, off the prediction",
            partial(relaxing, "a.h."),
            0.0,
            0.04,
            "1",
            "one G and the elastic curve in the report",
            reason="the coarse mesh, and a stress that relaxes at finite strain: 1 to 2 % each",
        )
    for subject in rows():
        yield from _subject(subject)
        yield Case(
            "calibration",
            f"{subject}: shipped tissue set against the report",
            partial(shipped, subject),
            0.0,
            5e-3,
            "1",
            "reports/calibrated.json",
            reason="rounded to the digits that are shipped",
        )
        if not quick:
            yield Case(
                "calibration",
                f"{subject}: a new press of the calibrated finger, coarse mesh",
                partial(again, subject),
                0.0,
                0.05,
                "1",
                "the curve in the report",
                reason="the coarse mesh is within 1 to 3 % of the standard one",
            )


def _twins(seeds: int) -> Iterator[Case]:
    for name in calibration_twin.TRUTH:
        yield Case(
            "calibration",
            f"twin: seeds of {seeds} in which {name} is within its stated uncertainty",
            partial(calibration_twin.recovered, name, seeds),
            seeds,
            1.0,
            "seeds",
            "the parameters of the twin",
            reason="two standard deviations hold 95 %, so one of ten may be outside",
        )
    for what, limit in PRINTED.items():
        yield Case(
            "calibration",
            f"twin: {what} error of sinusoids of 2 to 16 Hz, which were not fitted",
            partial(calibration_twin.worst_sinusoid, what),
            0.0,
            limit,
            "1",
            "the twin itself, without noise",
            reason="what the thesis reached on its subjects: to be better than that",
        )


def _subject(subject: str) -> Iterator[Case]:
    found = calibrated(subject)
    bulk = library.pawluk_bulk()[subject]
    yield Case(
        "calibration",
        f"{subject}: m of stiffness against force of the calibrated finger",
        lambda: found.residuals["m"],
        bulk.m,
        0.06 * bulk.m,
        "1/mm",
        "Table 2.1",
        reason="three standard deviations of m that VAF_k leaves over these forces",
    )
    for frequency in FREQUENCIES:
        for what, limit in PRINTED.items():
            yield Case(
                "calibration",
                f"{subject}: {what} error of {frequency} Hz, which was not fitted",
                partial(_predicted, subject, f"{frequency} Hz", what),
                0.0,
                limit,
                "1",
                "the lumped model of Table 2.1",
                reason="what the thesis reached on its subjects",
            )
    row = pad.printed(subject)
    yield Case(
        "calibration",
        f"{subject}: R that the thesis's fit finds in the simulated frames",
        partial(_fitted, subject),
        found.residuals["array radius"],
        0.02 * row.radius,
        "mm",
        "the report; printed is Table 3.2, measured in another session",
        printed=row.radius,
        erratum=SMALLER,
        reason="rounding of the shares in the report",
    )
    yield from _widths(subject)


def _widths(subject: str) -> Iterator[Case]:
    for number, kept in enumerate(rows()[subject]["profiles"]):
        r, mine, theirs = (
            np.array(kept[key]) for key in ("distance_mm", "finger_kPa", "thesis_kPa")
        )
        yield Case(
            "calibration",
            f"{subject}: width of the pressure at {kept['force_N']:.2g} N over that of Table 3.2",
            partial(_width_again, subject, number),
            width(r, mine) / width(r, theirs),
            0.02,
            "1",
            "the report; printed is the half-space of Table 3.2, felt by the array",
            printed=1.0,
            erratum=SMALLER,
            reason="rounding of the shares in the report",
        )


def width(r: Array, pressure: Array) -> float:
    """Return the root mean square distance in mm of a pressure from its center."""
    return float(np.sqrt(pressure @ r**2 / pressure.sum()))


def _width_again(subject: str, number: int) -> float:
    found, force = calibrated(subject), rows()[subject]["profiles"][number]["force_N"]
    made = pad.profile(found.curve, 1.0, found.prony, subject, force)
    return width(made.distance, made.finger) / width(made.distance, made.thesis)


def _predicted(subject: str, frequency: str, what: str) -> float:
    return calibrated(subject).checks[frequency][what]


def _fitted(subject: str) -> float:
    found = calibrated(subject)
    return pad.thesis_fit(pad.simulated(found.curve, 1.0, found.prony)).radius


def figures() -> Iterator[tuple[str, Any]]:
    """Yield captions and matplotlib Figures of the calibrated subjects."""
    if rows():
        yield from calibration_figures.figures()
