"""Table and figures of suite `calibration`: curves, what stiffens a finger, and the array."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from fefinger.validation.calibration.report import calibrated, rows
from fefinger.validation.calibration.split import PARTS
from fefinger.validation.calibration.subject_target import target_of
from fefinger.validation.oracles.fingerpad import Fingerpad
from fefinger.validation.panels import panel, panels

from fefinger.calibration import pad_radius as pad
from fefinger.calibration.array_sensor import ArraySensor, aligned, blurred
from fefinger.calibration.curve import ForceLaw
from fefinger.scene import library
from fefinger.support.arrays import Array
from fefinger.view.figures import INK, WIDE


COLORS = ("#0072B2", "#D55E00", "#009E73", "#AA4499")
PART_COLORS = dict(zip(PARTS, ("#56B4E9", "#E69F00", "#009E73", "#D55E00", "#BBBBBB"), strict=True))

STIFFNESS = (
    "Stiffness against instantaneous force: the line of Table 2.1 (dashed) and the calibrated "
    "finger. A finger begins without stiffness, as Hertz's contact does; the line does not."
)


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure: stiffness, split, profiles."""
    yield _split_caption(), _split()
    yield STIFFNESS, _stiffness()
    yield _profile_caption(), _profiles()


def _split_caption() -> str:
    parts = {name: [row["split"]["shares"][name] for row in rows().values()] for name in PARTS}
    words = {name: f"{100 * min(v):.0f} to {100 * max(v):.0f} %" for name, v in parts.items()}
    return (
        "Causes of the exponential stiffening of Table 2.1 by subject: m of the line k = m P + b, "
        "a fit of stiffness against force over the depths of the ramp. The growth of the contact "
        f"on a half-space explains {words['contact']} of m, bone and shape {words['bone']}, finite "
        f"strain of tissue without stiffening {words['strain']}, the fitted exponent of the tissue "
        f"{words['tissue']}; {words['rest']} are unexplained. The shares depend on the order in "
        "which the causes are added, which is that of the models."
    )


def _split() -> Any:
    made, axes = panel(WIDE, 3.0)
    names = list(rows())
    for place, name in enumerate(names):
        left = 0.0
        for part, color in PART_COLORS.items():
            value = rows()[name]["split"][part]
            axes.barh(place, value, left=left, color=color, label=part if place == 0 else None)
            left += value
        axes.plot([library.lumped()[name].m] * 2, [place - 0.45, place + 0.45], color=INK)
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.set_xlabel("m / 1/mm (line: Table 2.1)")
    axes.legend(ncols=len(PARTS), loc="lower right", bbox_to_anchor=(1, 1), frameon=False)
    return made


def _stiffness() -> Any:
    made, axes = panel(WIDE, 3.2)
    for name, color in zip(rows(), COLORS, strict=False):
        wanted, calibration = target_of(name), calibrated(name)
        stiffnesses = calibration.law.stiffness(wanted.force)
        axes.plot(wanted.force, wanted.stiffness, "--", color=color)
        axes.plot(wanted.force, stiffnesses, color=color, label=name)
    axes.set_xlabel("T / N")
    axes.set_ylabel("dT/dx / N/mm")
    axes.legend(frameon=False)
    return made


def _table_caption() -> str:
    return (
        "The calibrated sets: relaxed modulus of the subcutaneous tissue and exponent with one "
        f"standard deviation (the skin has {library.SKIN_RATIO:g} times the modulus and "
        f"{library.SKIN_EXPONENT_RATIO:g} times the exponent, chosen), the line through the "
        "stiffness, the parts of m, and what the thesis's fit finds in the simulated frames. They "
        f"are fits of a model, not measurements of tissue. {_cost()}"
    )


def _cost() -> str:
    """Cost of the calibrations, cached presses included."""
    costs = []
    for name in rows():
        calibration = calibrated(name)
        spent = sum(stage.presses_cpu for stage in calibration.stages)
        costs.append(f"{name} {spent:.0f} s ({calibration.finger['resolution']} mesh)")
    return f"Presses took, in CPU time: {', '.join(costs)}; the fits a few seconds each."


def table() -> dict[str, Any]:
    """Return the calibrated sets with what of the stiffening is whose."""
    heads = ["", "mesh", "E in kPa", "exponent", "m (2.1)", "b (2.1)", *PARTS, "R (3.2)"]
    rows_ = [_cells(name) for name in rows()]
    return {"caption": _table_caption(), "heading": [*heads, "c0 b (3.2)"], "rows": rows_}


def _cells(name: str) -> list[str]:
    calibration, split = calibrated(name), rows()[name]["split"]
    values = calibration.residuals
    pair = "{:.3g} ({:.3g})"
    return [
        name,
        calibration.finger["resolution"],
        f"{calibration['modulus'].value:.1f} ± {calibration['modulus'].sd:.1f}",
        f"{calibration['exponent'].value:.2f} ± {calibration['exponent'].sd:.2f}",
        pair.format(values["m"], values["m, wanted"]),
        pair.format(values["b"], values["b, wanted"]),
        *(f"{split[part]:.2f}" for part in PARTS),
        pair.format(values["array radius"], values["array radius, wanted"]),
        pair.format(values["array c0_b"], values["array c0_b, wanted"]),
    ]


def _profile_caption() -> str:
    reached = [each["force_N"] for row in rows().values() for each in row["profiles"]]
    return (
        "What the array reads, over its largest value, against the distance from the center of "
        "pressure (proximal to the left), at 0.54, 1.1 and 2.3 N of a slow press (where a press "
        f"ends earlier, there: up to {max(reached):.2g} N): the calibrated finger (dots) and the "
        "half-space of Table 3.2 (line). The finger's pressure is not that of a round "
        "body: it is longer along the finger than across."
    )


def _profiles() -> Any:
    names = list(rows())
    made, axes = panels(WIDE, 1.9 * len(names), len(names), 3, sharex=True, sharey=True)
    for line, name in zip(np.reshape(axes, (-1, 3)), names, strict=True):
        for ax, each in zip(line, rows()[name]["profiles"], strict=True):
            r, mine, theirs = (
                np.array(each[key]) for key in ("distance_mm", "finger_kPa", "thesis_kPa")
            )
            ax.plot(r, mine / mine.max(), ".", color=COLORS[0], markersize=3)
            ax.plot(r, theirs / theirs.max(), color=INK, linewidth=1)
            ax.set_title(f"{name}, {each['force_N']:.2g} N", fontsize=8)
    made.supxlabel("distance from the center of pressure / mm", fontsize=9)
    made.supylabel("reading / its largest value", fontsize=9)
    return made


@dataclass(frozen=True)
class PressureProfile:
    """Pressure in kPa on the array against the `distance` in mm, at one force in N.

    `finger` is the calibrated one, `thesis` the half-space of Table 3.2; `force` is the force that
    the press reached, at most the requested one.
    """

    force: float
    distance: Array
    finger: Array
    thesis: Array


def profile(law: ForceLaw, subject: str, force: float) -> PressureProfile:
    """Compute the pressure profiles of finger and thesis at a force in N of a slow press.

    If the curve ends before that force, both are at the force where it ends.
    """
    sensor = ArraySensor()
    depth = pad.slow_press(law, force)
    readings = pad.slow(law.prony, depth, law.array_pressure(depth))[-1]
    reached = float(pad.slow(law.prony, depth, law.relaxed(depth))[-1])
    frames = aligned(np.zeros((1, len(readings))), readings[None], sensor)
    row = library.quasistatic()[subject]
    half_space = Fingerpad(row.radius, row.m, row.b, library.relaxation()[subject])
    deep = float(half_space.depth_at(1e3 * reached, relaxed=True))
    theirs = blurred(
        lambda r: half_space.relaxed_pressure(r, deep),
        float(half_space.contact_radius(deep)),
        frames.distance,
    )
    signed = frames.distance * np.where(sensor.positions[:, 0] < 0, -1.0, 1.0)
    order = np.argsort(signed)
    return PressureProfile(reached, signed[order], readings[order], theirs[order])
