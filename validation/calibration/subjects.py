"""Cases of suite `calibration` on the shipped subjects: force, sinusoids, and the thesis's array.

What the report says of a finger's pressure, between presses of other pads and exponents, is
measured again by a press of its own on the coarse mesh.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
from fefinger.validation.calibration import sensitivity
from fefinger.validation.calibration.figures import profile
from fefinger.validation.calibration.report import calibrated, rows
from fefinger.validation.calibration.subject_target import (
    FREQUENCIES,
    SubjectTarget,
    printed,
    target_of,
)
from fefinger.validation.case import Case, Expected, Noted

from fefinger.calibration import pad_radius as pad
from fefinger.calibration import targets
from fefinger.calibration.curve import Curve, ForceLaw, curve
from fefinger.calibration.outcome import line, stiffening
from fefinger.calibration.slow_press import press
from fefinger.scene import library
from fefinger.support.arrays import Array


PRINTED = {"mse": 0.07, "peak": 0.18}
"""Errors of the thesis's own prediction of sinusoids (section 2.4.2), as fractions."""

MIDDLE = 1
"""Number of the profile at 1.1 N, the middle one of Figure 3-4."""

FLATTER = (
    "Tissue that stiffens enough for Table 2.1 draws the pressure together below the bone; skin "
    "that is stiffer than the pulp, and a bone farther from the tip, spread it again. The radius "
    "that the thesis's fit finds is so met; the width, which weighs the tails of the pressure, is "
    "not."
)

STIFFER = (
    "A pad that is flat enough for the pressure of Table 3.2 begins stiffer than the line of Table "
    "2.1, whose b is carried on from larger forces, and stiffens less."
)


def cases(subject: str, *, quick: bool) -> Iterator[Case]:
    """Yield the cases of a shipped subject."""
    yield from _force(subject)
    name = f"{subject}: shipped tissue set against the report"
    measure = partial(shipped, subject)
    reason = "rounded to the digits that are shipped"
    yield Case(name, measure, Expected(0.0, 5e-3), "reports/calibrated.json", reason=reason)
    if not quick:
        yield Case(
            f"{subject}: R, m and c0 b of Table 3.2 through the array and back, the largest miss",
            partial(sensitivity.oracle, subject),
            Expected(0.0, 0.02),
            "Table 3.2: its half-space to 2.3 N, with the noise of the array",
            reason="half a unit of the last printed digit of m and b is 1 to 5 %",
        )
        yield from _pressed_again(subject)


def _force(subject: str) -> Iterator[Case]:
    calibration, row = calibrated(subject), library.lumped()[subject]
    sd, _ = line_sd(target_of(subject))
    name = f"{subject}: m of stiffness against force of the calibrated finger"
    limits = Expected(row.m, 3 * sd, "1/mm")
    reason = "three standard deviations that VAF_k leaves over these forces"
    yield Case(name, lambda: calibration.residuals["m"], limits, "Table 2.1", reason=reason)
    for frequency in FREQUENCIES:
        for what, limit in PRINTED.items():
            yield Case(
                f"{subject}: {what} error of {frequency} Hz, which was not fitted",
                partial(lambda f, w: calibration.checks[f][w], f"{frequency} Hz", what),
                Expected(0.0, limit),
                "the lumped model of Table 2.1",
                reason="what the thesis reached on its subjects",
            )


def _pressed_again(subject: str) -> Iterator[Case]:
    row, calibration = printed(subject), calibrated(subject)
    kept_curve = "the report, whose curves are between presses"
    name = f"{subject}: a new press of the calibrated finger, coarse mesh"
    measure = partial(again, subject)
    reason = "exponents and radii between those of the presses, and a mesh of its own"
    yield Case(name, measure, Expected(0.0, 0.05), "the curve in the report", reason=reason)
    yield Case(
        f"{subject}: b of stiffness against force of a new press, coarse mesh",
        partial(first_stiffness, subject),
        Expected(calibration.residuals["b"], 3 * line_sd(target_of(subject))[1], "N/mm"),
        f"{kept_curve}; wanted is Table 2.1",
        wanted=library.lumped()[subject].b,
        shortfall=STIFFER,
        reason="three standard deviations that VAF_k leaves over these forces",
    )
    yield Case(
        f"{subject}: R that the thesis's fit finds in frames of a new press, coarse mesh",
        partial(radius_again, subject),
        Expected(calibration.residuals["array radius"], 0.06 * row.radius, "mm"),
        f"{kept_curve}; wanted is Table 3.2",
        wanted=row.radius,
        shortfall=FLATTER,
        reason="rounding of a printed R, and the pressure of a coarse mesh within 5 %",
    )
    stored = rows()[subject]["profiles"][MIDDLE]
    yield Case(
        f"{subject}: width of the pressure of a new press at {stored['force_N']:.2g} N over that "
        "of Table 3.2",
        partial(width_again, subject, stored),
        Expected(
            width(*(np.array(stored[key]) for key in ("distance_mm", "finger_kPa")))
            / width(*(np.array(stored[key]) for key in ("distance_mm", "thesis_kPa"))),
            0.05,
            "1",
        ),
        f"{kept_curve}; wanted is the half-space of Table 3.2, as read by the array",
        wanted=1.0,
        shortfall=FLATTER,
        reason="the pressure of a coarse mesh",
    )


def first_stiffness(subject: str) -> Noted:
    """Return b in N/mm of the line through stiffness against force, moved by a new press.

    Over the forces that the new press reaches.
    """
    calibration, wanted, one = calibrated(subject), target_of(subject), fresh(subject)
    last = float(one.force(one.deepest)) / calibration.prony.long_time
    force = wanted.force[wanted.force <= last]
    laws = ForceLaw(one, calibration.prony), calibration.law
    new, old = (line(force, law.stiffness(force)) for law in laws)
    note = f"Over forces up to {force[-1]:.2g} of {wanted.force[-1]:.2g} N."
    return Noted(calibration.residuals["b"] + new[1] - old[1], note)


def radius_again(subject: str) -> Noted:
    """Return the R in mm of the report, times what a new press makes of it.

    Over the depth that both reach: the deeper the frames, the smaller R.
    """
    calibration, one = calibrated(subject), fresh(subject)
    deep = min(one.deepest, calibration.deepest)
    laws = (ForceLaw(c.until(deep), calibration.prony) for c in (one, calibration.curve))
    new, old = (pad.thesis_fit(pad.simulated(law)).radius for law in laws)
    note = (
        f"Compared to {deep:.2f} mm, where the shorter press ends, of {calibration.deepest:.2f} mm."
    )
    return Noted(calibration.residuals["array radius"] * new / old, note)


def touched(subject: str) -> tuple[float, float, float]:
    """Return how far in mm before x0 of Table 2.1 the finger is touched, for equal forces.

    Also the largest error of its elastic force at 1 and 2 mm then, and the ratio of its stiffness
    at 0.05 N. x0 is where the printed exponential begins, with the stiffness b; a round finger
    begins with none, before it. Its position is not printed, and Table 2.1 not its true touch.
    """
    from scipy.optimize import minimize_scalar

    law, wanted = calibrated(subject).law, target_of(subject)
    depths = np.array([1.0, min(2.0, float(wanted.spring.position(wanted.force[-1])))])

    def off(before: float) -> Array:
        ours = law.relaxed(depths + before) / law.prony.long_time
        return np.asarray(np.log(ours / wanted.spring.force(depths)))

    found = minimize_scalar(lambda each: float(off(each) @ off(each)), bounds=(-0.3, 0.5))
    first = np.array([0.05])
    stiff = law.stiffness(first) / wanted.spring.stiffness(first)
    return float(found.x), float(np.abs(np.expm1(off(found.x))).max()), float(stiff[0])


def line_sd(wanted: SubjectTarget) -> tuple[float, float]:
    """Return the standard deviations of m in 1/mm and b in N/mm that VAF_k leaves."""
    line = np.column_stack([wanted.force, np.ones_like(wanted.force)])
    variance = np.linalg.inv(line.T @ line).diagonal() * wanted.stiffness_sd**2
    return float(np.sqrt(variance[0])), float(np.sqrt(variance[1]))


def shipped(subject: str) -> float:
    """Return the largest relative difference of the shipped set and the report."""
    calibration = calibrated(subject)
    tissue_set = library.tissue_set(library.calibrated_name(subject))
    pairs = [(tissue_set.pad_radius, calibration.finger["pad_radius"])]
    for mine, theirs in (
        (tissue_set.skin, calibration.skin),
        (tissue_set.subcutaneous, calibration.subcutaneous),
    ):
        pairs += [(getattr(mine, name), theirs[name]) for name in ("modulus", "exponent")]
    assert tissue_set.prony is not None
    pairs += zip(
        tissue_set.prony.weights + tissue_set.prony.v,
        calibration.prony.weights + calibration.prony.v,
        strict=True,
    )
    return max(abs(mine / theirs - 1) for mine, theirs in pairs)


@cache
def fresh(subject: str, resolution: str = "coarse") -> Curve:
    """Return the curve of a new press of the calibrated finger."""
    calibration = calibrated(subject)
    finger = targets.finger_of(
        subject, resolution=resolution, pad_radius=calibration.finger["pad_radius"]
    )
    exponent = library.tissue_set(library.calibrated_name(subject)).subcutaneous.exponent
    one, _ = curve(press(stiffening(finger, exponent), "solid"))
    factor = calibration["modulus"].value / finger.subcutaneous.modulus
    return replace(one, q=one.q + np.log(factor))


def again(subject: str) -> float:
    """Return the largest relative distance of the force of a new press from the report."""
    calibration, one = calibrated(subject), fresh(subject)
    depth = np.linspace(0.3, 1.0, 20) * min(one.deepest, calibration.deepest)
    return float(np.abs(one.force(depth) / calibration.curve.force(depth) - 1).max())


def width(r: Array, pressure: Array) -> float:
    """Return the root mean square distance in mm of a pressure from its center."""
    return float(np.sqrt(pressure @ r**2 / pressure.sum()))


def width_again(subject: str, stored: dict[str, Any]) -> float:
    """Return the width of a profile in the report over that of the half-space, by a new press.

    At the force of the report, or where the new press ends.
    """
    calibration = calibrated(subject)
    new = profile(ForceLaw(fresh(subject), calibration.prony), subject, stored["force_N"])
    old = profile(calibration.law, subject, new.force)
    finger, thesis = (
        width(*(np.array(stored[key]) for key in ("distance_mm", name)))
        for name in ("finger_kPa", "thesis_kPa")
    )
    return finger / thesis * width(new.distance, new.finger) / width(old.distance, old.finger)
