"""Gains of the generators, fitted by one rule to published thresholds.

The rule: a unit just gives the defining response of its type when its skin is pressed at 4 mm/s to
the published threshold displacement of the type and held there (the one-dimensional case of the
thesis: the whole displacement reaches the end organ). That is sustained firing in the hold for SAI
and SAII, and one spike for FAI and FAII. Membrane with rates / 6, saturating generator.

Resulting rates in Hz at 0.1, 0.2, 0.5, 1 and 1.5 mm of hold: SAI 0, 10, 15, 18, 20 (published
for monkey units, see THRESHOLDS: 0, 0 to 9, 0 to 15, 10 to 30, 22 to 45); SAII 0, 0, 0, 13, 15. A
sinusoid that grows slowly first fires FAI at 11 um (16 Hz) and FAII at 14 um (64 Hz) and 5 um (400
Hz), amplitude; that of FAII falls on beyond 512 Hz, where the published bands of units end.

Not fitted by the rule: the thesis filters pass a ramp ten times better than a hold, so an SA
unit that fires in the hold from its threshold on gives its first spike to a ramp of a few um (SAI
4, SAII 13), where human units need about 60 and 300 um (Table 1 of doi:10.1152/jn.90990.2008), and
its slowed membrane keeps its rates below 27 Hz. Gains from those thresholds would be 14 and 5 times
lower and leave every SA unit silent in a hold of 1.5 mm.
"""

from dataclasses import dataclass


RAMP_SPEED = 4.0
"""mm/s. From 4 to 400 mm/s the gains change by up to 3 % (FAII: 30 %); slower ramps raise those of
FAI (1 mm/s: by 23 %) and FAII (3.2 times)."""


@dataclass(frozen=True)
class Threshold:
    """Displacement in mm at which a type just gives its defining response, with its source."""

    displacement: float
    sustained: bool
    source: str
    confidence: str


THRESHOLDS: dict[str, Threshold] = {
    "SAI": Threshold(
        0.2,
        True,
        "sustained SA1 firing in TouchSim (Saal et al. 2017, doi:10.1073/pnas.1704856114), "
        "measured without noise: begins between 0.1 and 0.5 mm, by unit and pin radius",
        "medium: models fitted to monkey units, small pins",
    ),
    "SAII": Threshold(
        0.8,
        True,
        "four times less sensitive to indentation than SAI (Table 1 of doi:10.1152/jn.90990.2008)",
        "low: the ratio of human thresholds to a first spike, applied to sustained firing",
    ),
    "FAI": Threshold(
        0.0138,
        False,
        "median of human units, Johansson & Vallbo (1979), J Physiol 297:405, at 4 mm/s",
        "low: quoted, not read; Knibestol (1973, PMC1350502) gives 0.05 to 1.65 mm",
    ),
    "FAII": Threshold(
        0.0092,
        False,
        "median of human units, Johansson & Vallbo (1979), J Physiol 297:405, at 4 mm/s",
        "medium: quoted; Table 1 of doi:10.1152/jn.90990.2008 also gives 0.01 mm",
    ),
}

GAINS: dict[str, float] = {"SAI": 319.9, "SAII": 101.0, "FAI": 127.0, "FAII": 13190.0}
"""Generator gains in µA/cm² per mm by the rule, rounded up to four digits, so that the response is
there at the threshold itself; `validation/neural/gains.py` computes them again."""
