"""Candidate vertices of a contact: more of them as long as it reaches their rim."""

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from fefinger.fem.body import Solid
from fefinger.fem.condensation import OutsideError
from fefinger.fem.contact.patch import Patch
from fefinger.mechanics.press import limits, problem
from fefinger.support.arrays import Flags
from fefinger.support.checks import ConvergenceError


Answer = TypeVar("Answer")


def on_enough_candidates(
    body: Solid,
    depth: float,
    candidates: Callable[[float, int], Patch],
    attempt: Callable[[Patch, int], tuple[Answer, Flags]],
) -> Answer:
    """Return the answer of a contact that stays within its candidates.

    candidates(reach, rings) gives those within `reach` mm at first touch, and rings of vertices
    around them: next to an edge the gap grows within a facet to any reach, so each attempt has one
    ring more. attempt(candidates, rings) gives the answer on them, and which (n,) are pressed.
    depth mm: a first guess of the largest.

    Raises
    ------
    OutsideError
        If contact leaves the loadable part of the pad.
    ConvergenceError
        If contact spreads beyond all candidates that are tried.
    """
    reach = problem.REACH * depth
    for rings in range(problem.ATTEMPTS):
        on_pad = candidates(reach, rings)
        answer, pressed = attempt(on_pad, rings)
        reached = np.flatnonzero(on_pad.border & pressed)
        if len(reached) == 0:
            return answer
        if body.cut_off(on_pad.vertices[reached]):
            raise OutsideError(limits.OUTSIDE)
        reach *= problem.GROW
    raise ConvergenceError(limits.spread_beyond(reach))
