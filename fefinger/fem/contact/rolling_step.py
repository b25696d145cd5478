"""Contact of a condensed body under a plate that turns, one step after the other.

As `loop`, but what the tissue remembers is a traction in the plane of turning, because the normal
of today is not that of the past: history and its displacement are vectors of both components. The
flexibility along the normal is a quadratic form in it, made anew when the plate has turned; the
inverse that `active` keeps is then a little out of date, which its refinement makes good.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from fefinger.fem.contact import lcp_compiled as contact
from fefinger.fem.contact.lcp_compiled import BEYOND, DONE, Active
from fefinger.fem.contact.step_compiled import Memory, recall, remember
from fefinger.fem.elements.spaces import Array, Integers


class Plate(NamedTuple):
    """The plate and what the pad does under tractions in the plane, both components in turn.

    forms (3, n, n): F_xx, F_xz + F_zx and F_zz; columns (2n, 2n): F of both components; moments (2,
    n) mm³ and weights (n,) mm² of the pad's vertices; rim (k,) those where contact is more than
    they can answer; normal (2,); traction and moved (2n,), the last traction and F times it; chosen
    and factor (2n,) work.
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


def plate(flexibility: Array, moments: Array, weights: Array, rim: Integers) -> Plate:
    """Return a plate that has not touched; `flexibility` is (2, n, 2, n)."""
    n = len(weights)
    (xx, xz), (zx, zz) = flexibility.transpose(0, 2, 1, 3)
    return Plate(
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
def step(s: Active, m: Memory, p: Plate, dt: float, x: float, z: float, travel: float) -> int:
    """Move on by `dt` s to a plate with the normal (x, z), `travel` mm along it.

    Return DONE: the contact pressure is then in s.x, the elastic traction in m.elastic. Or what
    failed, BEYOND for contact on the rim, with all as it was before the step.
    """
    n, active, before = len(s.x), contact.hold(s), (p.normal[0], p.normal[1])
    _turn(s, p, x, z)
    g = recall(m, dt)
    offset = m.offset[:n]
    for j in range(n):
        gap = x * p.moments[0, j] + z * p.moments[1, j] - travel * p.weights[j]
        offset[j] = g * gap - (x * m.moved_past[j] + z * m.moved_past[n + j])
    failed = contact.solve(s, offset, m.tolerance[0])
    for j in p.rim:
        if failed == DONE and s.x[j] > 0.0:
            failed = BEYOND
    if failed != DONE:
        _turn(s, p, before[0], before[1])
        contact.restore(s, active)
        return failed
    _press(s, p, x, z)
    remember(m, p.traction, p.moved, dt, g)
    return DONE


@njit(cache=True)
def strains(m: Memory, p: Plate, rows: Array, strain: Array) -> None:
    """Put the strain under the elastic traction into `strain`; `rows` (2n, n_strains)."""
    k = 0
    for j in range(len(m.elastic)):
        if m.elastic[j] != 0.0:
            p.chosen[k], p.factor[k] = j, m.elastic[j]
            k += 1
    strain[:] = 0.0
    contact.accumulate(strain, rows, p.chosen, p.factor, k)


@njit(cache=True, fastmath={"contract"})
def _turn(s: Active, p: Plate, x: float, z: float) -> None:
    """Make the flexibility along the normal (x, z), and what it makes of the last pressure."""
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


@njit(cache=True)
def _press(s: Active, p: Plate, x: float, z: float) -> None:
    """Make the traction of the pressure, and what it does."""
    n, k = len(s.x), 0
    for j in range(n):
        p.traction[j], p.traction[n + j] = x * s.x[j], z * s.x[j]
    for j in range(2 * n):
        if p.traction[j] != 0.0:
            p.chosen[k], p.factor[k] = j, p.traction[j]
            k += 1
    p.moved[:] = 0.0
    contact.accumulate(p.moved, p.columns, p.chosen, p.factor, k)
