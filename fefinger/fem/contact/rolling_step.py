"""Compiled contact step of a condensed body under a rolling plate.

As `step_compiled`, but the history is a traction in the plane of rolling, because the normal
changes from step to step: history and its displacement have two components per vertex. The
flexibility along the normal is a quadratic form in the normal, evaluated again when the plate has
turned; the inverse in `lcp_compiled` is then slightly out of date, which its refinement corrects.
"""

from typing import NamedTuple

import numpy as np

from fefinger.fem.contact import lcp_compiled as contact
from fefinger.fem.contact.lcp_compiled import BEYOND, DONE, LcpState
from fefinger.fem.contact.step_compiled import PadState, load_history, store_history
from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


class RollingPlate(NamedTuple):
    """The plate, and the flexibility of the pad under tractions in the plane of rolling.

    Vectors of 2n have the x components first. forms (3, n, n): F_xx, F_xz + F_zx and F_zz; columns
    (2n, 2n): F of both components; moments (2, n) mm³ and weights (n,) mm² of the pad's vertices;
    rim (k,): vertices where contact is a failure; normal (2,); traction and moved (2n,): the last
    traction and F times it; chosen and factor (2n,): work.
    """

    forms: Array
    columns: Array
    moments: Array
    weights: Array
    rim: Integers
    normal: Array
    traction: Array
    moved: Array
    chosen: Integers
    factor: Array


def plate(flexibility: Array, moments: Array, weights: Array, rim: Integers) -> RollingPlate:
    """Allocate a plate without contact; `flexibility` is (2, n, 2, n)."""
    n = len(weights)
    (xx, xz), (zx, zz) = flexibility.transpose(0, 2, 1, 3)
    return RollingPlate(
        forms=np.array([xx, xz + zx, zz]),
        columns=np.ascontiguousarray(flexibility.reshape(2 * n, 2 * n)),
        moments=np.ascontiguousarray(moments),
        weights=np.ascontiguousarray(weights),
        rim=np.ascontiguousarray(rim),
        normal=np.zeros(2),
        traction=np.zeros(2 * n),
        moved=np.zeros(2 * n),
        chosen=np.zeros(2 * n, dtype=np.int64),
        factor=np.zeros(2 * n),
    )


@njit(cache=True)
def step(
    s: LcpState, m: PadState, p: RollingPlate, dt: float, x: float, z: float, travel: float
) -> int:
    """Advance by `dt` s to a plate with the normal (x, z), displaced `travel` mm along it.

    Return DONE, with the contact pressure in s.x and the elastic traction in m.elastic; or a
    failure, BEYOND for contact on the rim, with the state unchanged.
    """
    n, active, before = len(s.x), contact.save(s), (p.normal[0], p.normal[1])
    _set_normal(s, p, x, z)
    g = load_history(m, dt)
    offset = m.offset[:n]
    for j in range(n):
        gap = x * p.moments[0, j] + z * p.moments[1, j] - travel * p.weights[j]
        offset[j] = g * gap - (x * m.moved_past[j] + z * m.moved_past[n + j])
    failed = contact.solve(s, offset, m.tolerance[0])
    for j in p.rim:
        if failed == DONE and s.x[j] > 0.0:
            failed = BEYOND
    if failed != DONE:
        _set_normal(s, p, before[0], before[1])
        contact.restore(s, active)
        return failed
    for j in range(n):
        p.traction[j], p.traction[n + j] = x * s.x[j], z * s.x[j]
    contact.combine(p.moved, p.columns, p.traction, p.chosen, p.factor)
    store_history(m, p.traction, p.moved, dt, g)
    return DONE


@njit(cache=True, fastmath={"contract"})
def _set_normal(s: LcpState, p: RollingPlate, x: float, z: float) -> None:
    """Set the normal (x, z): project the flexibility on it, and update F x of the last pressure."""
    if x == p.normal[0] and z == p.normal[1]:
        return
    p.normal[0], p.normal[1] = x, z
    n = len(s.x)
    a, b, c = x * x, x * z, z * z
    for i in range(n):
        row, xx, xz, zz = s.flexibility[i], p.forms[0, i], p.forms[1, i], p.forms[2, i]
        for j in range(n):
            row[j] = a * xx[j] + b * xz[j] + c * zz[j]
    contact.product(s)
