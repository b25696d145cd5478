"""A press with a path or with friction: its candidates, its contact, and what it is said of it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fefinger.fem.body import Reduced, Solid
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.contact.patch import Patch, directed, patch
from fefinger.fem.contact.sliding_march import slide, slide_with_friction
from fefinger.fem.contact.travel import Travel, envelope
from fefinger.fem.contact.viscoelastic import History, Prescribed, Relaxation
from fefinger.geometry.profiles import frame
from fefinger.mechanics.press import problem
from fefinger.mechanics.press.problem import Press
from fefinger.support.arrays import Array


SLIDING = (
    "Sliding: the pressure acts along the normal of the plate (of the travel), not of the slopes "
    "of the object; the skin meets the heights that lie ahead of its undeformed points.",
)
"""Note on every answer with a path or friction."""

COULOMB = (
    "Friction: Coulomb's law with one coefficient for stick and slip, at every vertex of the skin, "
    "in the plane of the plate."
)


def candidates(
    body: Solid,
    obstacle: Obstacle,
    path: Array,
    deepest: float,
    rings: int,
    within: NDArray[np.bool_] | None = None,
) -> Patch:
    """Return the patch of a path (n, 2) mm and a depth: unit loads along the axis of the obstacle.

    Between sparse dots at first touch the plane of their crests is within the finger already.
    """
    under = envelope(obstacle, path)
    inside = max(0.0, -float(under.gap(body.space.points[np.unique(body.pad)])[0].min()))
    reach = problem.REACH * (deepest + inside) - inside
    return patch(body.space, body.pad, body.normals, under, reach, rings, within)


def with_tractions(body: Solid, on: Patch, axis: Array) -> Patch:
    """Return a patch with unit loads along the axis and both directions across it (3n).

    In the medial plane of half a finger there is none across that plane.
    """
    along, across = (directed(body.space, on, each) for each in frame(axis)[:2])
    if body.half:
        beside = body.space.points[on.vertices, 1] != 0
        across = across @ sparse.diags_array(beside.astype(float))
    loads = sparse.hstack([on.loads, along, across]).tocsc()
    return replace(on, vertices=np.tile(on.vertices, 3), loads=loads)


def reduced_to(
    press: Press, on: Patch, probe: sparse.csr_matrix, report: Callable[[float], None]
) -> Reduced:
    """Reduce the body to a patch; with friction to its tractions as well."""
    if not press.friction:
        return press.method.reduce(press.body, on, probe, report)
    three = with_tractions(press.body, on, press.obstacle.axis)
    made = press.method.reduce(press.body, three, probe, report)
    return replace(made, patch=on)


def solved(
    press: Press,
    reduced: Reduced,
    relaxation: Relaxation,
    prescribed: Prescribed,
    report: Callable[[float], None],
) -> History:
    """Solve the contact along the path of the motion.

    Raises
    ------
    InputError
        If contact reaches the end of the object.
    ConvergenceError
        If a contact solution is not reached.
    """
    on = reduced.patch
    travel = Travel.of(press.body.space, press.body.normals, on, press.obstacle)
    shift = press.motion.shift(press.time)
    if press.friction:
        return slide_with_friction(
            reduced.flexibility,
            press.friction,
            travel,
            on.projected,
            relaxation,
            prescribed,
            shift,
            report,
        )
    return slide(reduced.flexibility, travel, on.projected, relaxation, prescribed, shift, report)
