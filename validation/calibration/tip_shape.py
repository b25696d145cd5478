"""Shape of the fingers: from a flat pad to a round tip, step by step, and as they are shipped.

After each step modulus and exponent are fitted to the force of Table 2.1 again; then a press tells
what the array would show, where a plate presses hardest, and how fast waves are.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from fefinger.validation.calibration import sensitivity
from fefinger.validation.calibration.report import ROUND_TIP, round_tip
from fefinger.validation.calibration.subject_target import printed, target_of
from fefinger.validation.case import Case, Expected
from fefinger.validation.human.suite import MANFREDI, RAYLEIGH
from fefinger.validation.problems.chain import SUBJECTS

from fefinger.calibration import pad_radius as pad
from fefinger.calibration import slow_press
from fefinger.calibration.curve import ForceLaw, curve
from fefinger.calibration.outcome import stiffening
from fefinger.calibration.targets import prony_of
from fefinger.mechanics import solid
from fefinger.results import pressure
from fefinger.scene import library
from fefinger.scene.finger import Finger


SUBJECT = "a.h."
"""Whose finger is changed step by step."""

FLAT = 17.14
"""Pad radius in mm of a.h. with which an array returns R without the other steps."""

EXPONENTS = (2.0, 3.0, 4.0)
"""Exponents of the pulp at which the fingers are pressed for the fit."""

FITTED = 8
"""Fitted parameters: modulus, exponent, three weights and three rates."""

PART = 0.15
"""Depth over the thickness; on a.h. that of flat-press, 1.5 mm."""

SHORT = {"d.p.": (13.0, 1.4)}
"""R in mm of fingers that cannot have the printed one, and where their pressure is highest."""

CENTRAL = 1.0
"""Distance in mm from the center of pressure up to which a highest pressure counts as central."""

EDGE = (
    "The flat pad takes up the height of the finger, which then turns to its tip within 14 degrees "
    "of slope: the contact reaches this edge, and skin is squeezed there between plate and nail."
)
NARROW = (
    "R is more than the width of this finger, 12 mm: no pad that turns to its tip is so flat. With "
    "the bone farther from the tip R grows, but a plate then presses hardest off the center."
)
CAPTION = (
    "From a finger of a.h. with a flat pad to the shipped one with a round tip, each step on top "
    "of those before, modulus and exponent refitted to the force of Table 2.1; then the shipped "
    "fingers. R is what the thesis's fit finds in simulated frames to 2.3 N, or to the end of the "
    "press (printed: 14 mm for a.h.). Pressure, place and area are those of relaxed tissue under "
    "the plate at 30 degrees at 0.15 of the thickness. The printed pad radius and the round tip "
    "bring the pressure to the middle, but make it too narrow; a shorter bone, and skin that is "
    "stiffer and stiffens more than the pulp, widen it again."
)
MIDDLE = "a mean over 1 mm² on facets of 0.4 to 0.8 mm"
FIRST, ALL = f"flat pad of {FLAT:g} mm", "all of these"
"""First and last step, which are measured on the standard mesh too."""
PULP = "The force of the subject at light touch fixes the modulus of the pulp."


@dataclass(frozen=True)
class Figures:
    """A finger with its tissue, and what it shows.

    modulus kPa and exponent of the pulp; misfit: of stiffness and relaxation, 1 where it is the
    scatter of the data; radius mm: R of the thesis's fit to frames up to `heaviest` N; of the
    relaxed press at PART: force N, area mm², highest pressure kPa over 1 mm² and off_center mm,
    its distance from the center of pressure; instantaneous speeds m/s of surface waves in the bulk
    of skin and pulp.
    """

    step: str
    resolution: str
    modulus: float
    exponent: float
    misfit: float
    radius: float
    heaviest: float
    force: float
    area: float
    highest: float
    off_center: float
    skin_speed: float
    pulp_speed: float


def steps() -> Iterator[tuple[str, Finger]]:
    """Yield the steps and their fingers of published tissue: each step keeps those before it."""
    one = Finger.subject(SUBJECT, resolution="coarse", tissue=library.PUBLISHED)
    new = Finger.subject(SUBJECT)
    yield FIRST, replace(one, pad_radius=FLAT)
    one = replace(one, pad_radius=new.pad_radius)
    yield f"pad radius of {new.pad_radius:g} mm", one
    one = replace(one, tip_radius=new.tip_radius)
    yield f"and a tip of radius {new.tip_radius:g} mm", one
    one = replace(one, tip_tissue=new.tip_tissue)
    yield f"and the bone {new.tip_tissue:g} mm before the tip", one
    stiff = library.prior_skin(one.subcutaneous)
    yield f"and skin {library.SKIN_RATIO:g} times as stiff as pulp", replace(one, skin=stiff)


def refitted(finger: Finger, law: sensitivity.Laws) -> Finger:
    """Return the finger with modulus, exponent and relaxation fitted to Table 2.1."""
    fitted = sensitivity.fit(finger, law, EXPONENTS)
    if fitted is None:
        raise ValueError(f"{finger.resolution}: expected two presses or more, received fewer")
    values = fitted.solution.values
    scale = values["modulus"] / finger.subcutaneous.modulus
    one = law(finger, values["exponent"])
    skin, pulp = (
        replace(each, modulus=scale * each.modulus) for each in (one.skin, one.subcutaneous)
    )
    return replace(one, skin=skin, subcutaneous=pulp, prony=prony_of(values))


def figures(step: str, finger: Finger) -> Figures:
    """Press the finger of a subject whose tissue is fitted."""
    assert finger.subject_name is not None
    wanted, prony = target_of(finger.subject_name), finger.prony
    law = ForceLaw(curve(slow_press.press(finger, "solid"))[0], prony)
    fitted = law.stiffness(wanted.force)
    rest = [
        (fitted - wanted.stiffness) / wanted.stiffness_sd,
        (prony.relaxation(wanted.time) - wanted.relaxation) / wanted.relaxation_sd,
    ]
    scene = slow_press.pressed(finger, PART)
    response = solid.respond(scene)
    assert response.pad is not None
    assert response.pressure is not None
    assert response.contact_area is not None
    loads = response.pressure[-1] * response.pad.areas
    highest, place = pressure.highest(response.pad, response.pressure[-1:])
    center = loads @ response.pad.points / loads.sum()
    skin, pulp = finger.skin, finger.subcutaneous
    return Figures(
        step,
        finger.mesh,
        pulp.modulus,
        pulp.exponent or 0.0,
        float(sum(each @ each for each in rest)) / (sum(map(len, rest)) - FITTED),
        pad.thesis_fit(pad.simulated(law)).radius,
        min(pad.heaviest(law), pad.HEAVIEST),
        float(response.force[-1]),
        float(response.contact_area[-1]),
        highest,
        float(np.linalg.norm(place - center)),
        *(speed(each.modulus / prony.long_time, each.density) for each in (skin, pulp)),
    )


def speed(modulus: float, density: float) -> float:
    """Return the speed in m/s of Rayleigh waves at a modulus in kPa, incompressible."""
    return RAYLEIGH * math.sqrt(1e3 * modulus / 3 / density)


def shipped(subject: str, resolution: str = "coarse") -> Figures:
    """Return the figures of a shipped finger."""
    return figures(subject, Finger.subject(subject, resolution=resolution))


def measured() -> list[dict[str, Any]]:
    """Measure all steps on the coarse mesh, the first and last one on the standard mesh too.

    Then the shipped fingers, on both.
    """
    trials = [(name, finger, sensitivity.both) for name, finger in steps()]
    (_, first, _), (_, last, _) = trials[0], trials[-1]
    trials.append((f"and {library.SKIN_EXPONENT_RATIO:g} times its exponent", last, stiffening))
    trials.append((FIRST, replace(first, resolution="standard"), sensitivity.both))
    trials.append((ALL, replace(last, resolution="standard"), stiffening))
    rows = [figures(step, refitted(finger, of)) for step, finger, of in trials]
    meshes = ("coarse", "standard")
    rows += [shipped(subject, mesh) for subject in SUBJECTS for mesh in meshes]
    return [asdict(row) for row in rows]


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the cases of the report; without `quick`, of new presses of the shipped fingers too."""
    before = of_report(FIRST)
    name = f"a.h., {FIRST}: distance of the highest pressure from the center, flat-press"
    measure = partial(before.__getitem__, "off_center")
    limits = Expected(3.34, 0.15, "mm")
    yield Case(
        name, measure, limits, f"reports/{ROUND_TIP}", wanted=0.0, shortfall=EDGE, reason=MIDDLE
    )
    for subject in SUBJECTS:
        row = of_report(subject)
        yield from _fit(subject, row)
        yield _central(subject, "the report", partial(row.__getitem__, "off_center"))
        if not quick:
            yield _central(subject, "a new press, coarse mesh", partial(_off_center, subject))
    yield from _waves(of_report(SUBJECT))


def of_report(step: str) -> dict[str, Any]:
    """Return the figures of a step, or of a shipped finger, on the standard mesh."""
    rows = [row for row in round_tip() if (row["step"], row["resolution"]) == (step, "standard")]
    return rows[0]


def _fit(subject: str, row: dict[str, Any]) -> Iterator[Case]:
    source = f"Tables 2.1 and 3.2, by reports/{ROUND_TIP}"
    name = f"{subject}: misfit of stiffness and relaxation"
    reason = "1 is the scatter of the data; the fits are far below"
    yield Case(name, partial(row.__getitem__, "misfit"), Expected(0.0, 0.05), source, reason=reason)
    short = subject in SHORT
    yield Case(
        f"{subject}: R that the thesis's fit finds",
        partial(row.__getitem__, "radius"),
        Expected(SHORT[subject][0] if short else printed(subject).radius, 0.5, "mm"),
        source,
        wanted=printed(subject).radius if short else None,
        shortfall=NARROW if short else "",
        reason="rounding of a printed R",
    )


def _off_center(subject: str) -> float:
    return shipped(subject).off_center


def _central(subject: str, by: str, measure: Callable[[], float]) -> Case:
    short = subject in SHORT
    return Case(
        f"{subject}: distance of the highest pressure from the center under the plate, {by}",
        measure,
        Expected(SHORT[subject][1], 0.2, "mm") if short else Expected(0.0, CENTRAL, "mm"),
        "Figures 3-3 to 3-6: one peak in the middle",
        wanted=0.0 if short else None,
        shortfall=NARROW if short else "",
        reason=MIDDLE,
    )


def _waves(row: dict[str, Any]) -> Iterator[Case]:
    name = "a.h.: surface wave speed by the instantaneous modulus of skin"
    measure = partial(row.__getitem__, "skin_speed")
    limits = Expected(7.0, 1.4, "m/s")
    yield Case(name, measure, limits, MANFREDI, reason="scatter of subjects and bands")
    name = "a.h.: surface wave speed by the instantaneous modulus of pulp"
    measure = partial(row.__getitem__, "pulp_speed")
    limits = Expected(2.25, 0.05, "m/s")
    yield Case(name, measure, limits, MANFREDI, wanted=7.0, shortfall=PULP, reason="as found")


def table() -> dict[str, Any]:
    """Return the table of the steps."""
    heads = (
        *("finger of a.h., or shipped", "mesh", "E of pulp in kPa", "its exponent", "misfit"),
        "R in mm",
        *("highest pressure in kPa", "its distance from the center in mm", "area in mm²"),
        "waves in skin, pulp in m/s",
    )
    keys = (*("modulus", "exponent", "misfit", "radius", "highest", "off_center", "area"),)
    cells = [
        [
            row["step"],
            row["resolution"],
            *(f"{row[key]:.3g}" for key in keys),
            f"{row['skin_speed']:.2g}, {row['pulp_speed']:.2g}",
        ]
        for row in round_tip()
    ]
    return {"caption": CAPTION, "heading": heads, "rows": cells}
