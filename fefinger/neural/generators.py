"""Generators: from nerve displacement to current; `transduce` also includes the end organ."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.endorgans import END_ORGANS, Organ, rectify
from fefinger.support.arrays import Array
from fefinger.support.vocabulary import GENERATORS


LARGEST_CURRENT = 100.0
"""I_max of the saturating generator in µA/cm².

In constant current the peaks of Hodgkin-Huxley spikes fall below the 40 mV rule at 111 µA/cm²
(standard rates) and 113 (rates / 6); at 100 they reach 45 and 47 mV, so a generator that saturates
there never drives its membrane into depolarization block.
"""


Gain = float | Array
"""Gain in µA/cm² per mm: one, or one per unit."""


def linear(x_nerve: Array, gain: Gain) -> Array:
    """Return I = A x in µA/cm² for x in mm and A in µA/cm² per mm (thesis Eq. B.18)."""
    return gain * x_nerve


def saturating(x_nerve: Array, gain: Gain) -> Array:
    """Return I = I_max (1 - exp(-A x / I_max)), which is A x for a small x.

    The saturation that thesis 4.4.3 asks for. The exponential is the law of a fixed number of
    channels that each added displacement opens a fixed fraction of; its form is a choice.
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
    """Return the generator current in µA/cm² of a unit's type for a skin displacement in mm.

    End-organ filter, rectification, generator; `time`, `x_in` and `at` as in `PoleZero.respond`,
    `kind` an afferent type, `generator` one of GENERATORS, `organ` the filter where it is not that
    of END_ORGANS.
    """
    x_out = (organ or END_ORGANS[kind]).respond(time, x_in, at)
    return GENERATOR_BY_NAME[generator](rectify(x_out), gain)
