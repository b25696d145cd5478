"""Force control: the depth at which a contact bears a prescribed force.

The force rises with the depth, and is 0 up to first touch. Newton's method, or secants where the
slope is not known, inside a bracket that starts at first touch and is open above at first. One
search serves every contact: it is told the force at the depth that it proposed, and proposes the
next, so that a solver calls it in compiled code or from Python.
"""

from collections.abc import Callable

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.compiled import njit
from fefinger.support.tolerances import LEAST_FORCE, SMALL_FORCE


CORRECTIONS = 60
"""Depths that a search tries before it gives up."""

PATIENCE = 8
"""Secants that are tried before they alternate with bisections."""

DEPTH, PEAK, STIFFNESS = 0, 1, 2
"""Indices of a search: the depth in mm, the present one or the next to try; the largest force in mN
so far, which scales the tolerance of small forces; the last slope of a secant in mN/mm."""

_CLOSE, _TOUCH, _LOW, _HIGH, _LAST_DEPTH, _LAST_EXCESS, _TRIED = range(3, 10)

FOUND, TRY, LOST = 0, 1, 2
"""Verdicts on a depth: it bears the force; try the next; none was found."""


def depth_search() -> Array:
    """Allocate the state (10,) of a search, at a depth of 0."""
    return np.zeros(10)


@njit(cache=True, inline="always")
def begin(search: Array, touch: float, force: float, match: float) -> None:
    """Begin to search for a force in mN above 0, from the present depth or first touch (mm).

    match: relative error of the force.
    """
    search[PEAK] = max(search[PEAK], force)
    search[_CLOSE] = match * max(force, SMALL_FORCE * search[PEAK], LEAST_FORCE)
    search[_TOUCH] = search[_LOW] = search[_LAST_DEPTH] = touch
    search[_HIGH], search[_LAST_EXCESS], search[_TRIED] = np.inf, -force, 0.0
    # A little beyond first touch, where there is a contact whose slope Newton can follow.
    search[DEPTH] = max(search[DEPTH], touch + 1e-6 * (1.0 + abs(touch)))


@njit(cache=True, inline="always")
def judge(search: Array, excess: float, slope: float) -> int:
    """Judge the depth by the force beyond the wanted one, in mN, and set the next: a verdict.

    slope: of the force in mN/mm; 0 or less where it is not known.
    """
    if abs(excess) <= search[_CLOSE]:
        return FOUND
    search[_TRIED] += 1.0
    if search[_TRIED] >= CORRECTIONS:
        return LOST
    depth, touch = search[DEPTH], search[_TOUCH]
    known = slope > 0.0
    if not known:
        slope = _secant(search, excess)
    if excess < 0.0:
        search[_LOW] = depth
    else:
        search[_HIGH] = depth
    low, high = search[_LOW], search[_HIGH]
    depth = depth - excess / slope if slope > 0.0 else 2.0 * depth - touch
    # Secants crawl where the slope changes by orders of magnitude: then every other try bisects.
    slow = not known and search[_TRIED] > PATIENCE and search[_TRIED] % 2 == 0
    if not (low < depth and depth < high) or (slow and np.isfinite(high)):
        depth = (low + high) / 2.0 if np.isfinite(high) else low + 2.0 * (low - touch)
    search[DEPTH] = depth
    return TRY


@njit(cache=True, inline="always")
def _secant(search: Array, excess: float) -> float:
    depth, last_depth, last = search[DEPTH], search[_LAST_DEPTH], search[_LAST_EXCESS]
    slope = (excess - last) / (depth - last_depth) if depth != last_depth else 0.0
    if last_depth == search[_TOUCH] and search[STIFFNESS] > slope:
        slope = search[STIFFNESS]  # the first secant, from first touch, is too soft
    search[_LAST_DEPTH], search[_LAST_EXCESS] = depth, excess
    if slope > 0.0:
        search[STIFFNESS] = slope
    return slope


def depth_of_force(
    borne: Callable[[float], tuple[float, float]],
    touch: float,
    force: float,
    *,
    guess: float,
    peak: float,
    match: float,
) -> tuple[float, int]:
    """Find the depth in mm of a force in mN above 0; also return how many depths were tried.

    borne(depth) gives the force in mN and its slope in mN/mm; touch mm: the depth of first touch;
    peak: the largest force of the path. The last depth tried is returned; it bears the force unless
    the count is more than CORRECTIONS.
    """
    search = depth_search()
    search[DEPTH], search[PEAK] = guess, peak
    begin(search, touch, force, match)
    for count in range(1, CORRECTIONS + 1):
        depth = float(search[DEPTH])
        reached, slope = borne(depth)
        if judge(search, reached - force, slope) == FOUND:
            return depth, count
    return depth, CORRECTIONS + 1
