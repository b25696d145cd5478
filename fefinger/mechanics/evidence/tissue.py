"""Tissue and form of the fingers that were pressed."""

from collections.abc import Mapping
from functools import cache

from fefinger.scene import library
from fefinger.scene.finger import Finger


POISSON = 0.005
"""Difference of Poisson's ratios that counts as none."""

HELD = ("rigid", None, "fixed")
"""Bone, nail and cut of the fingers that were measured."""


def as_pressed(finger: Finger) -> bool:
    """Whether a finger has the form of those that were pressed: no scan, rigid bone, one G(t)."""
    held = (finger.bone, finger.nail, finger.cut) == HELD
    return held and finger.surface is None and finger.relaxation == "whole"


def published(finger: Finger) -> bool:
    """Whether the tissues are the published ones, but for their moduli and the skin's thickness."""
    tissues = library.tissue_set(library.PUBLISHED)
    pairs = (finger.skin, tissues.skin), (finger.subcutaneous, tissues.subcutaneous)
    return (
        as_pressed(finger)
        and (finger.tip_tissue, finger.tip_radius) == (None, None)
        and all(
            layer.law == own.law
            and layer.prony is None
            and abs(layer.poisson - own.poisson) <= POISSON
            for layer, own in pairs
        )
    )


@cache
def largest_exponents() -> Mapping[str, float]:
    """Return the largest exponent of stiffening of each layer among the fingers of subjects."""
    fitted = [library.tissue_set(name) for name in library.TISSUE_SETS if library.fitted_to(name)]
    return {
        "skin": max(each.skin.exponent or 0.0 for each in fitted),
        "subcutaneous": max(each.subcutaneous.exponent or 0.0 for each in fitted),
    }


def subject(finger: Finger) -> str | None:
    """Return the subject whose unchanged calibrated finger this is; None for other fingers."""
    name = finger.subject_name
    if name is None or finger.tissue != library.calibrated_name(name):
        return None
    shipped = Finger.subject(name, tissue=finger.tissue, resolution=finger.resolution)
    return name if finger == shipped else None
