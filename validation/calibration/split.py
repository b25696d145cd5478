"""Stiffening of a calibrated finger by cause: contact, bone and shape, strain, tissue.

The measure is m of the line k = m P + b through stiffness against force (Pawluk 1997, Eq. 2.4),
over the depths that the subject's ramp reaches. It does not change with the modulus, so every model
is taken at its own.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from fefinger.validation.calibration.subject_target import target_of

from fefinger.calibration import slow_press, targets
from fefinger.calibration.curve import curve
from fefinger.calibration.outcome import line, stiffening
from fefinger.calibration.record import Calibration
from fefinger.calibration.search import EXPONENTS
from fefinger.scene import library
from fefinger.support.arrays import Array


PARTS = {
    "contact": "growth of the contact: Hertz's half-space",
    "bone": "bone and shape of the finger: the same tissue on it, at small strain",
    "strain": "finite strain: tissue that itself does not stiffen",
    "tissue": "the exponent of the tissue that was fitted",
    "rest": "what Table 2.1 has more, or less",
}
COUNT = 40
"""Forces at which the stiffness is taken, evenly."""


def split(calibration: Calibration) -> dict[str, float]:
    """Return m in 1/mm of a subject by parts, which add up to m of Table 2.1."""
    finger = targets.finger_of(
        calibration.target, resolution="coarse", pad_radius=calibration.finger["pad_radius"]
    )
    wanted = target_of(calibration.target)
    deep = float(calibration.curve.depth(wanted.prony.long_time * wanted.force[-1]))
    deep = min(deep, calibration.deepest)
    linear, _ = curve(slow_press.small(finger))
    finite, _ = curve(slow_press.press(stiffening(finger, EXPONENTS[0]), "solid"))
    chain = [
        steepness(lambda x: x**1.5, deep),
        steepness(linear.force, deep),
        steepness(finite.force, deep),
        steepness(calibration.curve.force, deep),
        library.lumped()[calibration.target].m,
    ]
    parts = np.diff(chain, prepend=0.0).tolist()
    return dict(zip(PARTS, parts, strict=True)) | {"depth": deep}


def steepness(force: Callable[[Array], Array], deepest: float) -> float:
    """Return m in 1/mm of a force law over depths up to `deepest` mm."""
    depth = np.linspace(0.0, deepest, 2001)
    forces = force(depth)
    k = np.gradient(forces, depth)
    even = np.linspace(0.0, float(forces[-1]), COUNT + 1)[1:]
    return line(even, np.interp(even, forces, k))[0]


def table(calibration: Calibration) -> dict[str, Any]:
    """Return the split and the share of every part in m of Table 2.1."""
    parts = split(calibration)
    whole = library.lumped()[calibration.target].m
    return parts | {"shares": {name: parts[name] / whole for name in PARTS}}
