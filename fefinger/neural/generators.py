"""Generators: from nerve displacement to current; `transduce` also includes the end organ."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.endorgans import END_ORGANS, Organ
from fefinger.support.arrays import Array
from fefinger.support.vocabulary import GENERATORS


LARGEST_CURRENT = 100.0
"""I_max of the saturating generator in µA/cm².

In constant current the peaks of Hodgkin-Huxley spikes fall below the 40 mV rule at 111 µA/cm²
(standard rates) and 113 (rates / 6); at 100 they reach 45 and 47 mV, so a generator that saturates
there never drives its membrane into depolarization block.
"""

GAINS: dict[str, float] = {"SAI": 319.9, "SAII": 101.0, "FAI": 127.0, "FAII": 13190.0}
"""Generator gains in µA/cm² per mm, fitted by one rule to published thresholds.

The rule: a unit just gives the defining response of its type when its skin is pressed at 4 mm/s to
the published threshold of the type and held there (the one-dimensional case of the thesis: the
whole displacement reaches the end organ). The response is sustained firing for SAI and SAII, one
spike for FAI and FAII; membrane with rates / 6, saturating generator. Values are rounded up to four
digits; `validation/neural/gains.py` has the thresholds with their sources, computes the gains again
and compares the rates with published ones.

Not fitted: the thesis filters pass a ramp ten times better than a hold, so an SA unit that fires in
the hold from its threshold on gives its first spike to a ramp of a few um (SAI 4, SAII 13), where
human units need about 60 and 300 um (Table 1 of doi:10.1152/jn.90990.2008), and its slowed membrane
keeps its rates below 27 Hz. Gains from those thresholds would be 14 and 5 times lower and leave
every SA unit silent in a hold of 1.5 mm.
"""

Gain = float | Array
"""Gain in µA/cm² per mm: one, or one per unit."""


def linear(x_nerve: Array, gain: Gain) -> Array:
    """Return I = A x in µA/cm² for x in mm and A in µA/cm² per mm (thesis Eq. B.18)."""
    return gain * x_nerve


def saturating(x_nerve: Array, gain: Gain) -> Array:
    """Return I = I_max (1 - exp(-A x / I_max)), which is A x for a small x.

    The saturation that thesis 4.4.3 asks for. The exponential is the law of a fixed number of
    channels of which each added displacement opens a fixed fraction; its form is a choice.
    """
    return -LARGEST_CURRENT * np.expm1(-gain * x_nerve / LARGEST_CURRENT)


Generator = Callable[[Array, Gain], Array]

GENERATOR_BY_NAME: dict[str, Generator] = dict(zip(GENERATORS, (saturating, linear), strict=True))


def transduce(
    kind: str,
    time: ArrayLike,
    x_in: ArrayLike,
    *,
    gain: Gain,
    generator: str = "saturating",
    at: ArrayLike | None = None,
    organ: Organ | None = None,
) -> Array:
    """Return the generator current in µA/cm² of an afferent type for a skin displacement in mm.

    End-organ filter, half-wave rectification (thesis Eq. B.19: no known coupling could pull the
    nerve ending, 4.2.1), generator. `time`, `x_in` and `at` as in `PoleZero.respond`; `organ`: the
    filter, by default the one of END_ORGANS.
    """
    x_nerve = np.maximum((organ or END_ORGANS[kind]).respond(time, x_in, at), 0.0)
    return GENERATOR_BY_NAME[generator](x_nerve, gain)
