"""Tissue that was measured: published layers up to a common modulus, and that of a subject."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

from fefinger.scene import library, pawluk1997
from fefinger.scene.finger import Finger


CONTRAST = 1.1
"""Factor of the ratio of the moduli within which a finger counts as measured, a convention."""

POISSON = 0.005
"""Distance from the measured Poisson's ratios, likewise."""

PUBLISHED_LAW = "neo-hookean"

HELD = ("rigid", None, "fixed")
"""Bone, nail and cut of the fingers that were measured."""


def published(finger: Finger) -> bool:
    """Whether the tissues of a finger are the published ones, but for a common factor."""
    tissues = library.tissue_set(library.PUBLISHED)
    layers = (finger.skin, finger.subcutaneous)
    thin, thick = _skin_shares()
    share = (finger.skin.thickness or 0.0) / finger.thickness
    contrast = _contrast(finger)
    return (
        finger.surface is None
        and (finger.tip_tissue, finger.tip_radius) == (None, None)
        and thin / CONTRAST <= share <= thick * CONTRAST
        and max(contrast, 1 / contrast) <= CONTRAST
        and all(
            abs(layer.poisson - measured.poisson) <= POISSON
            for layer, measured in zip(layers, (tissues.skin, tissues.subcutaneous), strict=True)
        )
        and all(layer.law == PUBLISHED_LAW and layer.prony is None for layer in layers)
        and _as_held(finger)
    )


def soft_skin(finger: Finger) -> bool:
    """Whether the skin is softer, against the tissue below it, than the published one."""
    return _contrast(finger) < 1 / CONTRAST


def of_published(finger: Finger) -> Finger:
    """Return a finger of published tissue, with the size and the modulus below the skin of one.

    The skin is as thick as its own, within the measured range.
    """
    tissues = library.tissue_set(library.PUBLISHED)
    stiffer = finger.subcutaneous.modulus / tissues.subcutaneous.modulus
    thin, thick = (share * finger.thickness for share in _skin_shares())
    skin, below = (
        replace(layer, modulus=stiffer * layer.modulus)
        for layer in (tissues.skin, tissues.subcutaneous)
    )
    return Finger(
        finger.width,
        finger.thickness,
        pad_radius=finger.pad_radius,
        tissue=library.PUBLISHED,
        skin=replace(skin, thickness=min(max(finger.skin.thickness or 0.0, thin), thick)),
        subcutaneous=below,
        prony=finger.prony,
        resolution=finger.resolution,
    )


def calibrated(finger: Finger) -> bool:
    """Whether a finger has the tissue of a subject, in the form of the fingers that were pressed.

    Its size may be another one.
    """
    if library.fitted_to(finger.tissue) is None:  # its file, if it has one, is not needed
        return False
    tissues = library.tissue_set(finger.tissue)
    tip = tissues.lengths(finger.width, finger.thickness)
    return (
        (finger.skin, finger.subcutaneous) == (tissues.skin, tissues.subcutaneous)
        and finger.surface is None
        and (finger.tip_tissue, finger.tip_radius) == (tip["tip_tissue"], tip["tip_radius"])
        and _as_held(finger)
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


def _contrast(finger: Finger) -> float:
    """Return the modulus of the skin over that below it, over the published ratio."""
    tissues = library.tissue_set(library.PUBLISHED)
    ratio = tissues.skin.modulus / tissues.subcutaneous.modulus
    return finger.skin.modulus / finger.subcutaneous.modulus / ratio


def _skin_shares() -> tuple[float, float]:
    """Return the smallest and the largest thickness of the skin over that of a pressed finger."""
    skin = library.tissue_set(library.PUBLISHED).skin.thickness or 0.0
    thicknesses = [size.thickness for size in pawluk1997.lumped().values()]
    return skin / max(thicknesses), skin / min(thicknesses)


def _as_held(finger: Finger) -> bool:
    return finger.relaxation == "whole" and (finger.bone, finger.nail, finger.cut) == HELD
