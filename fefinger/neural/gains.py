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

import numpy as np

from fefinger.neural.generators import transduce
from fefinger.neural.membranes import HodgkinHuxley


RAMP_SPEED = 4.0
"""mm/s. From 4 to 400 mm/s the gains change by up to 3 % (FAII: 30 %); slower ramps raise those of
FAI (1 mm/s: by 23 %) and FAII (3.2 times)."""

HOLD, SUSTAINED = 4.0, 0.5
"""s: length of the hold, and of its end in which a sustained response must still fire."""


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
"""Generator gains in uA/cm² per mm: what `threshold_gain` computes, rounded up to four
digits, so that the response is there at the threshold itself."""


def threshold_gain(kind: str, *, generator: str = "saturating", digits: float = 1e-5) -> float:
    """Compute the gain in uA/cm² per mm of an afferent type by the rule.

    Bisection on the logarithm of the gain, to the relative precision `digits`; deterministic.
    """
    low, high = 1.0, 1e6
    while high / low > 1.0 + digits:
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if responds(kind, middle, generator) else (middle, high)
    return high


def responds(kind: str, gain: float, generator: str = "saturating") -> bool:
    """Test whether a type with this gain gives its defining response at its threshold."""
    threshold = THRESHOLDS[kind]
    end = threshold.displacement / RAMP_SPEED
    time = np.array([0.0, end, end + (HOLD if threshold.sustained else 0.1)])
    x_in = np.array([0.0, threshold.displacement, threshold.displacement])
    at = np.linspace(0.0, time[-1], int(np.ceil(time[-1] / 5e-5)) + 1)
    current = transduce(kind, time, x_in, gain=gain, generator=generator, at=at)
    (times,) = HodgkinHuxley().fire(at, current, stimulus_driven=False).times
    since = time[-1] - SUSTAINED if threshold.sustained else 0.0
    return bool(np.any(times >= since))
