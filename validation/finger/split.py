"""What Hertz leaves out on a real finger, cause by cause: read from `reports/solid-force.json`.

The chain of models and its order are in `chain.CHAIN`. Two of its causes are also taken the other
way round, because a split depends on its order.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from fefinger.validation.evidence.solid import REPORT as SOLID
from fefinger.validation.problems.chain import DEPTHS, SUBJECTS, models, scene

from fefinger.mechanics.evidence.presses import read
from fefinger.scene import library
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import hereditary_integral


AT = {"flat-30": 6, "sphere-5": 6, "sphere-2": DEPTHS}
"""Which of the DEPTHS the split is given at: a tenth of the thickness, and 0.6 mm."""


def rows() -> dict[str, Any]:
    """Return the rows of the report by subject and press."""
    return dict(read(SOLID)["rows"])


def row(subject: str, press: str) -> dict[str, Any]:
    """Return a row of the report."""
    return dict(rows()[f"{subject}/{press}"])


def part(subject: str, press: str) -> Array:
    """Return depth over thickness (DEPTHS,) of a press in the report."""
    press_row = row(subject, press)
    return np.array(press_row["depth_mm"]) / press_row["thickness_mm"]


def force(subject: str, press: str, model: str) -> Array:
    """Return the relaxed force (DEPTHS,) in N, nan where a model or the report has none."""
    if subject not in subjects(press):
        return np.full(DEPTHS, np.nan)
    return np.array(row(subject, press)["force_N"][model], dtype=np.float64)


def factors(subject: str, press: str, number: int | None = None) -> dict[str, float]:
    """Return by what each model of the chain multiplies the force of the one before it.

    `number` counts the DEPTHS from 1; that of AT by default. nan where a model has no force.
    """
    k = (number or AT[press]) - 1
    chain = [float(force(subject, press, model)[k]) for model in models(press)]
    return {
        model: after / before
        for model, before, after in zip(models(press)[1:], chain[:-1], chain[1:], strict=True)
    }


def other_order(subject: str, press: str) -> dict[str, float]:
    """Return the factors of the shape without layers, and of the layers on the finger."""
    k = AT[press] - 1
    bone, whole, finger = (float(force(subject, press, m)[k]) for m in ("bone", "whole", "linear"))
    return {"whole": whole / bone, "layered": finger / whole}


def together(subject: str) -> float:
    """Return the factor of shape and angle under the plate: the finger over the flat stack."""
    k = AT["flat-30"] - 1
    finger, flat = (force(subject, "flat-30", model)[k] for model in ("linear", "layered"))
    return float(finger / flat)


def last(subject: str) -> int:
    """Return the largest even number of DEPTHS at which finite strain has a force under a plate."""
    numbers = np.flatnonzero(np.isfinite(force(subject, "flat-30", "solid"))) + 1
    return int(numbers[numbers % 2 == 0].max())


def steepness(subject: str, model: str, press: str = "flat-30") -> float:
    """Return m in 1/mm of the spring (b / m) (exp(m x) - 1) through the forces at x and x / 2.

    F(x) / F(x / 2) = exp(m x / 2) + 1 (Pawluk 1997, Eq. 2.3); x is the `last` depth.
    """
    number = last(subject)
    deep, half = (force(subject, press, model)[k - 1] for k in (number, number // 2))
    depth = row(subject, press)["depth_mm"][number - 1]
    return float(np.log(deep / half - 1) / (depth / 2))


def printed(subject: str) -> tuple[float, float]:
    """Return m in 1/mm of Tables 2.1 and 3.2 of the thesis."""
    return library.lumped()[subject].m, library.quasistatic()[subject].m


def unexplained(subject: str, press: str, model: str) -> float:
    """Return the force with relaxation at the end over the integral of G over the relaxed force.

    With one G, small strain gives 1 (the force is separable in depth and time).
    """
    from scipy.interpolate import CubicSpline

    pressed = scene(subject, press, relaxed=False)
    depth = row(subject, press)["depth_mm"]
    relaxed = CubicSpline([0.0, *depth], [0.0, *force(subject, press, model)])
    time = np.linspace(0.0, pressed.motion.duration, 2001)
    elastic = relaxed(pressed.motion.value(time))
    prony = pressed.finger.prony
    whole = hereditary_integral(prony, time, elastic)[-1] / prony.long_time
    return float(row(subject, press)["relaxing_N"][model][-1] / whole)


def subjects(press: str) -> tuple[str, ...]:
    """Return the subjects that the report has under an object."""
    return tuple(subject for subject in SUBJECTS if f"{subject}/{press}" in rows())


def texts() -> tuple[str, ...]:
    """Return the finding in a few sentences, each to be quoted by itself, with their numbers."""
    at, press = AT["flat-30"], "flat-30"
    whole = _range(lambda s: _over_hertz(s, "solid", at), "{:.1f}")
    flat = _range(lambda s: _over_hertz(s, "layered", at), "{:.1f}")
    shape = _range(together, "{:.2f}")
    finite = _range(lambda s: factors(s, press)["solid"], "{:.2f}")
    deep = _range(lambda s: factors(s, press, last(s))["solid"], "{:.2f}")
    ball = _range(lambda s: _over_hertz(s, "solid", AT["sphere-5"], "sphere-5"), "{:.1f}")
    bone, narrow, small = (_under_ball(model) for model in ("bone", "linear", "solid"))
    rates = {model: _rate(model) for model in models(press) if model != "level"}
    theirs = _range(lambda s: printed(s)[0], "{:.1f}")
    tissue = row(SUBJECTS[0], "demiray")["exponent"]
    stiffening = _range(lambda s: steepness(s, "solid", press="demiray"), "{:.2f}")
    return (
        f"A plate at 30 degrees, pressed to a tenth of the finger's thickness, meets {whole} times "
        f"the force of Hertz's half-space of the same tissue, on the {len(SUBJECTS)} fingers.",
        f"A flat layer of skin and pulp over bone would make it {flat} times; the finger is narrow "
        f"and gives way at its sides and tip, a factor of {shape}, which takes back most of what "
        "the bone adds. Layers matter little: the half-space has their mean compliance.",
        f"Finite strain is a factor of {finite} at that depth and of {deep} at {_deepest()} of the "
        "thickness: small strain is too soft, and the more so the deeper.",
        f"Under a ball of 5 mm it is {ball} times Hertz's force at that depth: the bone is a "
        f"factor of {bone}, the shape of the finger {narrow}, finite strain {small}.",
        "Stiffening, stated as m of the exponential spring (b / m) (exp(m x) - 1) between the "
        f"deepest press x and x / 2, is {rates['hertz']} per mm for Hertz (the growing contact "
        f"alone), {rates['layered']} for the flat stack, {rates['linear']} on the finger and "
        f"{rates['solid']} at finite strain; the thesis fitted {theirs} (Table 2.1). So contact, "
        "bone and finite strain give part of the exponential stiffening with tissue that itself "
        "does not stiffen (neo-Hookean); the rest may come from tissue that does, or from pads "
        f"thinner or flatter than the shape here: with exp({tissue:g} (I1 - 3)) (Demiray) it is "
        f"{stiffening} per mm.",
    )


def _deepest() -> str:
    """Return the depth of the deepest press over the thickness, of all subjects."""
    ends = sorted({f"{part(s, 'flat-30')[last(s) - 1]:.2f}" for s in SUBJECTS})
    return " to ".join(dict.fromkeys((ends[0], ends[-1])))


def apart() -> float:
    """Return the largest part by which `solid` on the coarse mesh differs from the standard one.

    At the depths of AT; under the ball of 2 mm the coarse mesh is too coarse.
    """
    differences = []
    for name in rows():
        subject, press = name.split("/")
        if press in AT and row(subject, press).get("coarse") is not None:
            k = AT[press] - 1
            coarse = row(subject, press)["coarse"]["solid"][k]
            differences.append(abs(coarse / force(subject, press, "solid")[k] - 1))
    return max(differences)


def _rate(model: str) -> str:
    return _range(lambda subject: steepness(subject, model), "{:.2f}")


def _under_ball(model: str) -> str:
    return _range(lambda subject: factors(subject, "sphere-5")[model], "{:.2f}")


def _over_hertz(subject: str, model: str, number: int, press: str = "flat-30") -> float:
    mine, hertz = (force(subject, press, name)[number - 1] for name in (model, "hertz"))
    return float(mine / hertz)


def _range(value: Callable[[str], float], digits: str) -> str:
    values = [value(subject) for subject in SUBJECTS]
    if not np.isfinite(values).all():
        missing = [subject for subject, each in zip(SUBJECTS, values, strict=True) if each != each]
        message = f"reports/{SOLID}: expected the forces of all subjects, none of {missing}"
        raise InputError(message)
    return f"{digits.format(min(values))} to {digits.format(max(values))}"
