"""A press with a path or with friction: candidates, contact, and the notes on it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy import sparse

from fefinger.fem.body import Reduced, Solid
from fefinger.fem.condensation import Operator
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.contact.patch import Patch, directed, patch
from fefinger.fem.contact.travel import Heights, envelope
from fefinger.geometry.profiles import frame
from fefinger.mechanics.press import operator, problem
from fefinger.mechanics.press.compliances import pressing_object
from fefinger.mechanics.press.notes import told
from fefinger.mechanics.press.placement import on_neighborhood
from fefinger.mechanics.press.problem import Press, SmallStrainHistory
from fefinger.results.records import Lateral, Pad
from fefinger.support.arrays import Array, Integers
from fefinger.support.units import NEWTON_PER_MILLINEWTON


TANGENTIAL = (
    "Sliding or friction: the pressure acts along the normal of the plate (of the travel), not of "
    "the slopes of the object; the skin meets the heights that lie ahead of its undeformed points. "
    "Stated errors are those of a press without either."
)
"""Note on every answer with a path or friction."""

ROCKING = (
    "Turning: the plate turns about the point of first touch; its distances are exact, and what "
    "its pressure pulls across the travel does not move the tissue."
)

COULOMB = "Friction: Coulomb's law at every vertex of the skin, in the plane of the plate."

WEAKER = (
    "Friction: skin that slips has the kinetic coefficient from the next time step on, until it "
    "sticks again; when skin lets go depends on the time steps."
)


def candidates(
    body: Solid,
    obstacle: Obstacle,
    path: Array,
    deepest: float,
    rings: int,
    inclines: Array | None = None,
) -> Patch:
    """Return the patch of a path (n, 2) mm and a depth: unit loads along the axis of the obstacle.

    inclines (n, 2): slopes of a plate that turns. Between sparse dots at first touch the plane of
    their crests is within the finger already.
    """
    under = envelope(obstacle, path, inclines)
    inside = max(0.0, -float(under.gap(body.space.points[np.unique(body.pad)])[0].min()))
    reach = problem.REACH * (deepest + inside) - inside
    return patch(body.space, body.pad, body.normals, under, reach, rings, body.loadable)


def with_tractions(body: Solid, on: Patch, axis: Array) -> Patch:
    """Return a patch with unit loads along the axis and both directions across it (3n).

    In the medial plane of half a finger there is none across that plane.
    """
    along, across = (directed(body.space, on, each) for each in frame(axis)[:2])
    if body.half:
        off_plane = body.space.points[on.vertices, 1] != 0
        across = across @ sparse.diags_array(off_plane.astype(float))
    loads = sparse.hstack([on.loads, along, across]).tocsc()
    return replace(on, vertices=np.tile(on.vertices, 3), loads=loads)


def reduce_to_patch(
    press: Press,
    on: Patch,
    points: Array,
    probe: sparse.csr_matrix,
    report: Callable[[float], None],
) -> Reduced:
    """Reduce the body to a patch and to the strain `probe` at points (n, 3).

    With friction to its tractions as well: the patch of the result then has the unit loads of
    both. What an operator is reduced to for a path is cached: it serves every object on it.
    """
    three = with_tractions(press.body, on, press.obstacle.axis) if press.indenter.friction else on
    if press.tangential and isinstance(press.body, Operator):
        made = operator.reduced(press.finger, press.body, three, points, lambda: probe)
    else:
        made = press.method.reduce(press.body, three, probe, report)
    own = pressing_object(press.indenter, press.body, on)
    return replace(made, patch=replace(on, loads=three.loads), object=own)


def distances(press: Press, on: Patch) -> Array:
    """Compute the distances (n_t, n_near) mm of the neighborhood of a patch from the indenter."""
    near = Heights.over(press.obstacle, press.body.space.points[on.neighborhood.vertices])
    return near.distances(press.motion.shift(press.time), press.inclines)


def lateral(press: Press, history: SmallStrainHistory, pad: Pad, column: Integers) -> Lateral:
    """Collect path, lateral force and friction; `column` (n_pad,) as of `whole_pad`."""
    on, contact, half = history.reduced.patch, history.contact, press.body.half
    sliding = contact.sliding
    assert sliding is not None
    both = np.array([2.0, 0.0]) if half else np.ones(2)
    unit = NEWTON_PER_MILLINEWTON * both
    if sliding.traction is None:
        return Lateral(sliding.shift, sliding.slopes * unit)
    assert sliding.sticking is not None
    assert sliding.slip is not None
    assert sliding.lost is not None
    force = (sliding.traction @ on.projected + sliding.slopes) * unit
    signs = np.ones((len(column), 2))
    signs[len(on.neighborhood.vertices) :, 1] = -1.0
    traction, slip = (
        signs
        * np.stack(
            [on_neighborhood(each[:, k], on.neighborhood)[:, column] for k in (0, 1)], axis=-1
        )
        for each in (sliding.traction, sliding.slip)
    )
    areas = np.bincount(column, pad.areas, minlength=len(on.neighborhood.vertices))
    return Lateral(
        shift=sliding.shift,
        force=force,
        torque=_torque(press, history),
        stick_area=np.asarray(sliding.sticking @ areas[: len(on.vertices)], dtype=np.float64),
        traction=traction if press.pressure else None,
        slip=slip if press.pressure else None,
        work=press.body.sides * sliding.lost * 1e-3,  # mJ from µJ
        outcome=outcome(press, history),
    )


def _torque(press: Press, history: SmallStrainHistory) -> Array:
    """Return the torque (n_t,) N mm of friction about the normal through the center of pressure."""
    contact, on = history.contact, history.reduced.patch
    assert contact.sliding is not None
    assert contact.sliding.traction is not None
    if press.body.half:
        return np.zeros(len(contact.depth))
    across = frame(press.obstacle.axis)[:2]
    places = (press.body.space.points[on.vertices] - press.obstacle.origin) @ across.T
    loads, total = contact.pressure * on.projected, contact.pressure @ on.projected
    center = np.divide(
        loads @ places, total[:, None], where=total[:, None] > 0, out=np.zeros((len(total), 2))
    )
    pulled = contact.sliding.traction * on.projected
    x, y = (places[:, k] - center[:, k, None] for k in (0, 1))
    return np.asarray((x * pulled[:, 1] - y * pulled[:, 0]).sum(axis=1) * NEWTON_PER_MILLINEWTON)


def notes(press: Press) -> tuple[str, ...]:
    """Return the notes on a press with a path or with friction."""
    if not press.tangential:
        return ()
    rocking = () if press.inclines is None else (ROCKING,)
    if not press.indenter.friction:
        return (TANGENTIAL, *rocking)
    weaker = (WEAKER,) if press.indenter.kinetic < press.indenter.friction else ()
    return (TANGENTIAL, *rocking, COULOMB, *weaker)


def outcome(press: Press, history: SmallStrainHistory) -> str:
    """Return in words whether the contact stuck, slipped in part, or slid, and since when."""
    contact, areas = history.contact, history.reduced.patch.areas
    sliding, area = contact.sliding, (contact.pressure > 0) @ areas
    assert sliding is not None
    assert sliding.sticking is not None
    moving = np.linalg.norm(press.motion.velocity(press.time), axis=-1) > 0
    stick = sliding.sticking @ areas
    return told(press.time, area, stick, sliding.shift, moving, sliding.cone)
