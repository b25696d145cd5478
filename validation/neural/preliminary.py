"""Preliminary end organs of thesis 4.2.2 and 4.3.3: springs in series, and derivatives."""

import math

from fefinger.neural.endorgans import PoleZero


def spring(skin: float, organ: float, nerve: float) -> PoleZero:
    """Filter of three springs in series (Fig. 4-4a): the nerve's share of a skin displacement.

    k_s k_e / (k_s k_e + k_n (k_s + k_e)); Eq. 5.8 prints its limit for a stiff nerve. Stiffnesses
    above 0, in any one unit. Three dampers in series (Fig. 4-5a) share in the same way.
    """
    return PoleZero((), (), skin * organ / (skin * organ + nerve * (skin + organ)))


def derivative(*poles: float) -> PoleZero:
    """Filter that is a derivative below its poles, one order per pole.

    One pole: velocity in mm/s, the damper model that thesis 4.3.3 closes with a pole at 10 to 100
    Hz. Two distinct poles: acceleration in mm/s². Poles in Hz.
    """
    return PoleZero((0.0,) * len(poles), poles, math.prod(2.0 * math.pi * p for p in poles))
