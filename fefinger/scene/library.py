"""Published parameter sets with their sources and confidence, and the tables of the thesis.

Confidence: "high": read in the source. "medium": a widely reused value, quoted from memory; check
it before relying on it. "low": an estimate that fills a gap.
"""

import math
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cache, partial
from typing import Literal

from fefinger.scene.tissue import Tissue
from fefinger.support.checks import InputError, choice, reject_unknown
from fefinger.support.inputs import parse_toml, read_text, unreadable
from fefinger.theory.relaxation import Prony


SOURCE = "Pawluk (1997), A Viscoelastic Model of the Human Fingerpad, PhD thesis, Harvard"


MEANS = "means"
"""Row of the tables for whom Pawluk (1997) did not measure."""


@dataclass(frozen=True)
class Lumped:
    """A row of Table 2.1: T(x) = (b/m) [exp(m (x - x0)) - 1], and its relaxation function.

    width and thickness of the fingertip in mm, m 1/mm, b N/mm; VAF_k and VAF_G: variance accounted
    for in stiffness and relaxation.
    """

    width: float
    thickness: float
    m: float
    b: float
    prony: Prony
    vaf: tuple[float, float]


@dataclass(frozen=True)
class Quasistatic:
    """A row of Table 3.2: effective radius R mm, m 1/mm and b kPa/mm of t(u) (Eq. 3.11).

    `b` is the printed value, most likely c0 b, the steady-state value (the text says that c0 b was
    fitted, and tables 2.1 and 3.2 agree only in that reading).
    """

    radius: float
    m: float
    b: float


@cache
def lumped() -> dict[str, Lumped]:
    """Table 2.1 of Pawluk (1997): lumped force at 60 mm/s, per subject (confidence high)."""
    rows = {
        "d.p.": (12, 9.5, 3.2, 0.092, (0.22, 0.45, 0.15, 0.18), (253, 14, 0.66), (0.98, 0.99)),
        "d.s.": (14, 11.5, 1.6, 0.28, (0.29, 0.40, 0.19, 0.13), (183, 11, 0.77), (0.97, 0.85)),
        "a.h.": (14, 10, 2.1, 0.18, (0.25, 0.40, 0.19, 0.16), (224, 14, 0.63), (0.98, 0.88)),
        "p.w.": (17, 13, 1.6, 0.22, (0.29, 0.38, 0.20, 0.13), (264, 22, 0.69), (0.96, 0.77)),
        "means": (14, 11, 2.1, 0.19, (0.26, 0.41, 0.18, 0.15), (231, 15, 0.69), (0.97, 0.87)),
    }
    return {name: Lumped(*row[:4], Prony(*row[4:6]), row[6]) for name, row in rows.items()}


def relaxation() -> dict[str, Prony]:
    """Table 3.1 of Pawluk (1997): relaxation of the pressure, per subject (confidence high)."""
    return {
        "d.p.": Prony((0.33, 0.44, 0.13, 0.10), (163, 2.8, 0.31)),
        "d.s.": Prony((0.33, 0.42, 0.16, 0.08), (256, 9.7, 0.91)),
        "a.h.": Prony((0.29, 0.47, 0.13, 0.10), (226, 8.6, 0.61)),
        "p.w.": Prony((0.33, 0.42, 0.16, 0.08), (238, 20.5, 0.79)),
        "f.c.": Prony((0.29, 0.49, 0.11, 0.10), (175, 8.2, 0.59)),
        "means": Prony((0.31, 0.45, 0.14, 0.09), (212, 10.0, 0.64)),
    }


def quasistatic() -> dict[str, Quasistatic]:
    """Table 3.2 of Pawluk (1997): quasi-static pressure, per subject (confidence high).

    The mean radius is 14.6 mm, the mean of the column; the thesis prints 14.
    """
    return {
        "d.p.": Quasistatic(15, 2.1, 2.3),
        "d.s.": Quasistatic(12, 1.1, 6.1),
        "a.h.": Quasistatic(14, 1.9, 1.9),
        "p.w.": Quasistatic(17, 1.1, 3.6),
        "f.c.": Quasistatic(15, 1.7, 3.8),
        "means": Quasistatic(14.6, 1.6, 3.5),
    }


def subjects() -> tuple[str, ...]:
    """Names of the subjects of Pawluk (1997); f.c. has no width and thickness."""
    return tuple(name for name in relaxation() if name != MEANS)


Confidence = Literal["high", "medium", "low"]

DIGITS = 6
"""Of lengths in mm that are in proportion to others."""


@dataclass(frozen=True)
class TissueSet:
    """Relaxed elastic properties of the two soft layers, with their source.

    The rest describes the finger that a set was fitted to: pad_radius, tip_tissue, tip_radius,
    width and thickness mm, and prony. None: the subject's, and the shape's own, are used.
    """

    skin: Tissue
    subcutaneous: Tissue
    source: str
    confidence: Confidence
    pad_radius: float | None = None
    prony: Prony | None = None
    tip_tissue: float | None = None
    tip_radius: float | None = None
    width: float | None = None
    thickness: float | None = None

    def lengths(self, width: float, thickness: float) -> dict[str, float | None]:
        """Return pad_radius, tip_radius and tip_tissue in mm on a finger of a size in mm.

        They are in proportion to the fitted finger's, the pad radius to the width and the
        tip to the thickness: then the profile of the palm keeps its form.
        """
        wider = width / (self.width or width)
        thicker = thickness / (self.thickness or thickness)
        return {
            "pad_radius": self.pad_radius and round(wider * self.pad_radius, DIGITS),
            "tip_radius": self.tip_radius and round(thicker * self.tip_radius, DIGITS),
            "tip_tissue": self.tip_tissue and round(thicker * self.tip_tissue, DIGITS),
        }


def maeno1998() -> TissueSet:
    """Layers of Maeno et al. (1998), with epidermis and dermis combined into one skin.

    Epidermis 136 kPa, dermis 80 kPa, subcutaneous tissue 34 kPa, all with Poisson's ratio 0.48
    (confidence medium: widely reused digits, the paper itself was not read). The skin here is one
    layer of 1 mm: 0.4 mm of epidermis over 0.6 mm of dermis, so its modulus is the mean weighted
    by thickness, (0.4 x 136 + 0.6 x 80) / 1.0 = 102.4 kPa, which keeps the stiffness of the layer
    against stretching, the way in which a skin over soft tissue carries most of its load.
    """
    return TissueSet(
        skin=Tissue(102.4, 0.48, 1.0),
        subcutaneous=Tissue(34, 0.48),
        source="Maeno, Kobayashi, Yamazaki (1998), JSME Int. J. C 41, 94-100",
        confidence="medium",
    )


def dandekar2003() -> TissueSet:
    """Human moduli of Dandekar et al. (2003): a stiff skin over very soft tissue.

    Outer layer 180 kPa, inner 18 kPa, Poisson's ratio 0.48 (confidence medium: the abstract says
    that such a contrast is needed to match the profile under a line load, the digits are quoted
    from memory). The thickness of 1 mm is taken from the other sets.
    """
    return TissueSet(
        skin=Tissue(180, 0.48, 1.0),
        subcutaneous=Tissue(18, 0.48),
        source="Dandekar, Raju, Srinivasan (2003), J. Biomech. Eng. 125, 682-691",
        confidence="medium",
    )


VISCOUS = "_viscous"
"""Suffix of the sets whose relaxation extends to a kHz."""

VISCOUS_FROM = 1480 / (2 * math.pi * 1.78)
"""Hz at which fingertips lose as much as they store: 132, that of 1.48 N/mm and 1.78 N s/m."""


def _viscous(name: str) -> TissueSet:
    """Tissue set `name` with a relaxation that extends to a kHz (confidence low).

    Published relaxation ends near 260 1/s, so that tissue loses nothing above some 100 Hz.
    Wiertlewski and Hayward (J. Biomech. 45:1869, 2012) vibrated the fingertips of seven people
    along the skin: spring and damper of 1.48 P^0.35 N/mm and 1.78 P^0.35 N s/m under P in N, whose
    ratio varies little (digits as two later works quote them). One branch more has that ratio of
    loss to stiffness below its rate, which was not measured; the relaxed modulus stays. A finger of
    maeno1998 that sticks to a plate then has the measured impedance from 50 to 400 Hz within its
    scatter (`reports/waves.html`). The confidence stays low, because along the normal a magnitude
    that is nearer to the published relaxation was measured (Pawluk 1997, section 2.3). Sudden
    strains meet some 8 times the stiffness: a set for vibrations, not for impacts.
    """
    base = TISSUE_SETS[name]()
    slow = base.prony or relaxation()[MEANS]
    # Below its rate a branch is a damper, of weight / rate; before it the stiffness is the sum.
    # Rate in 1/s of the branch that models the viscous loss: 1 kHz, beyond the measured band.
    fastest = 6283.0
    fast = fastest / (2 * math.pi * VISCOUS_FROM)
    weights = (*slow.weights, fast)
    total = math.fsum(weights)
    return replace(
        base,
        source=f"{base.source}; Wiertlewski and Hayward (2012) above 40 Hz",
        confidence="low",
        prony=Prony(tuple(weight / total for weight in weights), (*slow.v, fastest)),
    )


def saal2017() -> TissueSet:
    """Homogeneous tissue of TouchSim: 50 kPa and Poisson's ratio 0.4 (confidence high).

    Read in the source code of TouchSim, where it was fitted to a half-space without bone: a set for
    comparisons with theory, not for a finger.
    """
    return TissueSet(
        skin=Tissue(50, 0.4, 1.0),
        subcutaneous=Tissue(50, 0.4),
        source="Saal, Delhaye, Rayhaun, Bensmaia (2017), PNAS 114, E5693 (TouchSim, constants.py)",
        confidence="high",
    )


CALIBRATED = "calibrated.json"
"""Report of the calibrations that gave the sets below."""

_FITTED: dict[str, tuple[float, float, float, tuple[float, ...], tuple[float, ...]]] = {
    "d.p.": (2.925, 11.29, 12.5, (0.2208, 0.4504, 0.1496, 0.1792), (252.6, 13.91, 0.6659)),
    "d.s.": (11.09, 4.327, 10.5, (0.2907, 0.3989, 0.188, 0.1224), (181.3, 10.48, 0.7957)),
    "a.h.": (4.763, 3.525, 14.0, (0.2559, 0.4037, 0.1858, 0.1547), (221.0, 13.58, 0.6822)),
    "p.w.": (4.476, 4.018, 17.0, (0.296, 0.3851, 0.1956, 0.1233), (259.4, 21.07, 0.7528)),
    MEANS: (4.574, 4.457, 14.6, (0.2648, 0.4134, 0.1771, 0.1446), (228.3, 14.43, 0.7328)),
}
"""Subcutaneous modulus kPa, exponent, pad radius mm, weights and rates of G, from the reports."""

_TIPS = {
    "d.p.": (0.25, 0.75),
    "d.s.": (0.4, 0.6),
    "a.h.": (0.25, 0.62),
    "p.w.": (0.25, 0.65),
    MEANS: (0.22, 0.65),
}
"""Radius of the tip, and tissue between tip and bone, over the thickness; chosen, not fitted.

So that a plate at 30 degrees presses hardest in the middle of its contact, with the pad radius of
Table 3.2 or near it (suite `calibration`)."""

SKIN_RATIO = 10.0
"""Skin over subcutaneous modulus of the calibrated sets: that of Dandekar (2003), a prior."""

SKIN_EXPONENT_RATIO = 2.9
"""Exponent of their skin over that of their pulp: chosen with the tips of the fingers."""


def calibrated_name(subject: str) -> str:
    """Name of the calibrated set of a subject, such as "calibrated_ah" for "a.h."."""
    return f"calibrated_{subject.replace('.', '')}"


@cache
def _calibrated(subject: str) -> TissueSet:
    """Fit of the model (Demiray's law in both layers) to a subject; not a measurement of tissue.

    With modulus and exponent `solid` reproduces the stiffness against force of Table 2.1, with the
    pad radius the R of Table 3.2 (confidence low: modulus and exponent trade against each other and
    against SKIN_RATIO and SKIN_EXPONENT_RATIO, which are chosen; the reports have the
    uncertainties). The relaxation is from Table 2.1. At small strain the exponents have no
    effect, and the set is too soft.
    """
    modulus, exponent, radius, c, v = _FITTED[subject]
    report = CALIBRATED if subject != MEANS else "calibrated-means.json"
    size, (tip_radius, tip_tissue) = lumped()[subject], _TIPS[subject]
    return TissueSet(
        skin=prior_skin(Tissue(modulus, 0.48, law="demiray", exponent=exponent)),
        subcutaneous=Tissue(modulus, 0.48, law="demiray", exponent=exponent),
        source="fitted on the standard mesh by `fefinger calibrate` to the curves of subject "
        f"{subject} in Tables 2.1 and 3.2 of {SOURCE} (reports/{report}): a fit of a "
        "model, not a measurement of tissue",
        confidence="low",
        pad_radius=radius,
        prony=Prony(c, v),
        tip_tissue=round(tip_tissue * size.thickness, DIGITS),
        tip_radius=round(tip_radius * size.thickness, DIGITS),
        width=size.width,
        thickness=size.thickness,
    )


def prior_skin(pulp: Tissue) -> Tissue:
    """Return the skin of calibrated sets on a pulp: 1 mm thick, stiffer, and stiffening more."""
    exponent = None if pulp.exponent is None else SKIN_EXPONENT_RATIO * pulp.exponent
    return replace(pulp, modulus=SKIN_RATIO * pulp.modulus, thickness=1.0, exponent=exponent)


def macaque() -> TissueSet:
    """Fingertip of a macaque, in which the afferents of `recorded` were fitted (confidence low).

    10 mm wide and 8 mm thick with an effective pad radius of 10 mm, an estimate from the look of
    published fingertips; tip, pulp and relaxation are in proportion to the means'. Its skin
    is 3 times as stiff as the pulp (Maeno 1998) with the same exponent. With the ratios of the
    calibrated sets the strain at SAI end organs hardly grows with the curvature of small spheres,
    where recorded rates do (`validation/afferents`).
    """
    width, thickness, means = 10.0, 8.0, _calibrated(MEANS)
    pulp, skin = means.subcutaneous, maeno1998()
    ratio = skin.skin.modulus / skin.subcutaneous.modulus
    lengths = means.lengths(width, thickness)
    return TissueSet(
        skin=replace(pulp, modulus=ratio * pulp.modulus, thickness=1.0),
        subcutaneous=pulp,
        source="calibrated_means, with the ratio of the layers of maeno1998: an assumption on a "
        "finger that nobody measured",
        confidence="low",
        **(lengths | {"pad_radius": 10.0}),
        prony=means.prony,
        width=width,
        thickness=thickness,
    )


def fitted_to(tissue: str) -> str | None:
    """Name of the subject that a tissue set was fitted to; None for other sets."""
    return {calibrated_name(subject): subject for subject in _FITTED}.get(tissue)


PUBLISHED = "maeno1998"
"""Published set on which mechanics were compared."""


def default_tissue(subject: object) -> str:
    """Name of the tissue set of a finger that names none: that which was fitted to the subject.

    Of other fingers, that which was fitted to the means. Values of a layer change it.
    """
    # Values of another type are refused later, with a sentence.
    if isinstance(subject, str) and subject in _FITTED:
        return calibrated_name(subject)
    return calibrated_name(MEANS)


TISSUE_SETS: dict[str, Callable[[], TissueSet]] = {
    "maeno1998": maeno1998,
    "dandekar2003": dandekar2003,
    "saal2017": saal2017,
    "macaque": macaque,
    **{calibrated_name(subject): partial(_calibrated, subject) for subject in _FITTED},
}
TISSUE_SETS |= {f"{name}{VISCOUS}": partial(_viscous, name) for name in tuple(TISSUE_SETS)}


def tissue_set(name: str) -> TissueSet:
    """Return the tissue set called `name`, or the one in a file that ends in .toml.

    Raises InputError for an unknown name (the message suggests the nearest one), or a file without
    a tissue set.
    """
    if isinstance(name, str) and name.endswith(TISSUE_FILE):
        return _tissue_file(name)
    return TISSUE_SETS[choice("finger.tissue", name, TISSUE_SETS)]()


TISSUE_FILE = ".toml"
"""Suffix of files with a tissue set, which `fefinger calibrate` writes."""


def gone(name: str) -> bool:
    """Whether a tissue set names a file that is not there, as of a result that was saved."""
    return isinstance(name, str) and name.endswith(TISSUE_FILE) and bool(unreadable(name))


def _tissue_file(name: str) -> TissueSet:
    """Read the tissue set of a file that `fefinger calibrate` wrote."""
    expects = "a TOML file with a tissue set"
    try:
        table = parse_toml("finger.tissue", read_text("finger.tissue", name, expects))
    except tomllib.TOMLDecodeError as error:
        msg = f"finger.tissue: expected {expects}, received {name!r}, no TOML: {error}"
        raise InputError(msg) from None
    expected = [field.name for field in fields(TissueSet)]
    reject_unknown("finger.tissue", table, expected, file=name)
    try:
        layers = {layer: Tissue(**table.pop(layer)) for layer in ("skin", "subcutaneous")}
        prony = table.pop("prony", None)
        relaxation = {"prony": None if prony is None else Prony(**prony)}
        return TissueSet(**({"source": name, "confidence": "low"} | table | layers | relaxation))
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"finger.tissue: expected [skin] and [subcutaneous] with modulus, poisson, ... and, "
            f"if needed, pad_radius and prony in {name!r}, received {error}"
        ) from None
