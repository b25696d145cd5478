"""b and m of the `lumped` law for a scene, their source and their error.

The law is of a whole finger under a plate. For fingers of published tissue it was identified from
presses of `solid` (`reports/lumped-force.json`). A finger that was calibrated on a subject of the
thesis has the law of Table 2.1, to which it was fitted.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from fefinger.mechanics.evidence import measured_tissue, press_mesh
from fefinger.mechanics.evidence.press_mesh import LUMPED_LAW
from fefinger.mechanics.evidence.table import LUMPED, table
from fefinger.mechanics.situation import Situation
from fefinger.scene import pawluk1997
from fefinger.scene.finger import Finger
from fefinger.theory.lumped.spring import Spring
from fefinger.theory.relaxation import Prony


SAME = 1e-3
"""Relative difference below which sizes and ratios of moduli count as equal."""


class LumpedLaw(NamedTuple):
    """The law of a finger: b in N/mm, m in 1/mm, G, and their source.

    printed: whether they are those of Table 2.1. error: relative error of the force against `solid`
    of the same finger, not a number if unknown; evidence: its source. caveat: reason why the law
    may not be that of the scene; empty without one.
    """

    spring: Spring
    prony: Prony
    source: str
    printed: bool
    error: float
    evidence: str
    caveat: str = ""


def law(case: Situation) -> LumpedLaw:
    """Return the law of the finger of a scene, or that of Table 2.1 with a caveat."""
    finger = case.finger
    if measured_tissue.subject(finger) is not None:
        error, evidence = press_mesh.error(LUMPED_LAW, case)
        evidence = f"{evidence}: Table 2.1 against the finger that was fitted to it"
        return _printed(case, error, evidence)
    laws = table().all(LUMPED, "law", LUMPED_LAW)
    rows = [each.conditions for each in laws if _same(finger, each.conditions)]
    if not rows:
        other = "of other size or tissue" if finger.surface is None else "from a surface"
        return _printed(case, caveat=f"finger: {other} than those whose law was identified")
    flat = case.indenter.flat
    if flat is not None and not flat.tilt:
        interpolated = between(rows, flat.angle)
        if interpolated is not None:
            return _own(case, rows, *interpolated)
    angles = ", ".join(f"{angle:g}" for angle in sorted({row["angle"] for row in rows}))
    return _printed(case, caveat=f"its law is known under plates at {angles} degrees")


def _printed(
    case: Situation, error: float = float("nan"), evidence: str = "not known", caveat: str = ""
) -> LumpedLaw:
    rows, subject = pawluk1997.lumped(), case.finger.subject_name
    name = subject if subject in rows else pawluk1997.MEANS
    row, source = rows[name], f"Table 2.1, {name} ({pawluk1997.SOURCE})"
    if caveat:
        caveat = f"{caveat}; that of Table 2.1, {name}, is taken"
    return LumpedLaw(Spring(row.b, row.m), row.prony, source, True, error, evidence, caveat)


def _own(case: Situation, rows: Sequence[Mapping[str, Any]], b: float, m: float) -> LumpedLaw:
    """Return the identified law of a finger, scaled to the moduli of the scene."""
    finger = case.finger
    stiffer = finger.subcutaneous.modulus / rows[0]["subcutaneous_kPa"]
    # The presses are of relaxed tissue, b of the law is that of an instant.
    spring = Spring(stiffer * b / finger.prony.long_time, m)
    source = f"reports/{LUMPED}: identified from {' and '.join(row['source'] for row in rows)}"
    error, evidence = press_mesh.error(LUMPED_LAW, case)
    evidence = f"{evidence}, identified from presses of the same finger (reports/{LUMPED})"
    return LumpedLaw(spring, finger.prony, source, False, error, evidence)


def between(rows: Iterable[Mapping[str, Any]], angle: float) -> tuple[float, float] | None:
    """Interpolate b and m, log-linear in the angle of the plate in degrees.

    None outside of the measured angles.
    """
    by_angle = sorted(rows, key=lambda row: float(row["angle"]))
    angles = [row["angle"] for row in by_angle]
    if not angles[0] <= angle <= angles[-1]:
        return None
    b, m = (float(np.exp(np.interp(angle, angles, np.log([r[k] for r in by_angle])))) for k in "bm")
    return b, m


def _same(finger: Finger, row: Mapping[str, Any]) -> bool:
    """Whether a finger is one that was pressed, but for a factor on its moduli and for G."""
    contrast = finger.skin.modulus / finger.subcutaneous.modulus
    skin = finger.skin.thickness or 0.0
    sizes = [finger.width, finger.thickness, finger.pad_radius, contrast, skin]
    names = ("width_mm", "thickness_mm", "pad_radius_mm", "skin_over_subcutaneous", "skin_mm")
    same = np.allclose(sizes, [row[name] for name in names], rtol=SAME)
    return same and measured_tissue.published(finger)
