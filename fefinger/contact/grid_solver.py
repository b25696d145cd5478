"""Complementarity on a periodic grid, whose compliance is known by wavenumber.

F x + b >= 0, x >= 0, x . (F x + b) = 0, with F by Fourier transform; or, under a prescribed sum of
x, the same with b + d for an unknown number d. Conjugate gradients on the points in contact with
projections (Polonsky and Keer, Wear 231:206, 1999), preconditioned by the inverse of the compliance
of every wave (after Vollebregt, J. Optim. Theory Appl. 162:931, 2014). That preconditioner is
computed in single precision: it changes the path to the solution, not the solution.
"""

import numpy as np
from scipy import fft

from fefinger.contact.active_set import DONE, ENDLESS, SINGULAR
from fefinger.contact.stepper import State
from fefinger.support.arrays import Array, Flags
from fefinger.support.compiled import njit


ITERATIONS = 500
"""Most iterations of a solution. Ridges under dots take 12 to 20, a first touch 50."""


class GridSolver:
    """Solver of contact on a periodic grid; it starts from its last solution.

    Parameters
    ----------
    compliance
        (n_x, n_y // 2 + 1), as of `scipy.fft.rfft2`: displacement in mm per kPa of every wave. That
        of the mean may be any; all others are above 0.
    points
        Grid points (n_x, n_y).

    Attributes
    ----------
    x, moved
        Pressure (n,) kPa, and F times it in mm, by rows of the grid.
    place
        (n,): 0 of points in contact, else -1.
    rigid
        The depth in mm at which x has the prescribed sum, over the one of `offset`.
    counts
        (2,): iterations of the last solution, solutions so far.
    """

    def __init__(self, compliance: Array, points: tuple[int, int]) -> None:
        self.points, count = points, points[0] * points[1]
        self.compliance = np.array(compliance, dtype=np.float64)
        stiffness = 1.0 / np.abs(self.compliance.ravel()[1:])
        # The mean is as stiff as the longest wave: without it that compliance may be 0.
        least = np.append(stiffness.min(), stiffness).reshape(self.compliance.shape)
        self._stiffness = least.astype(np.float32)
        self.x, self.moved, self.rigid = np.zeros(count), np.zeros(count), 0.0
        self.place, self.counts = np.full(count, -1, dtype=np.int64), np.zeros(2, dtype=np.int64)

    @property
    def volatile(self) -> State:
        """Arrays that a failed solution leaves changed."""
        return self.x, self.moved, self.place, self.counts

    def displacement(self, pressure: Array) -> Array:
        """Return F x (n,) mm of a pressure x (n,) kPa."""
        waves = fft.rfft2(pressure.reshape(self.points))
        waves *= self.compliance
        return np.asarray(fft.irfft2(waves, self.points)).ravel()

    def _softened(self, residual: Array) -> Array:
        """Return the preconditioned residual (n,)."""
        waves = fft.rfft2(residual.reshape(self.points).astype(np.float32))
        waves *= self._stiffness
        return np.asarray(fft.irfft2(waves, self.points), dtype=np.float64).ravel()

    def solve(self, offset: Array, start: Array, tolerance: float, total: float = 0.0) -> int:
        """Solve for x from a start (n,) >= 0 with b = `offset` (n,) mm; return DONE or a failure.

        Gaps are closed, and open, to `tolerance` times the largest displacement. With a `total`
        above 0 that is the sum of x, and the gaps are those at the depth `rigid`.
        """
        p, free = self.x, total <= 0.0
        p[:] = start if free else start * (total / start.sum())
        self.moved[:] = self.displacement(p)
        way, before = np.zeros_like(p), np.zeros_like(p)
        product = 0.0
        self.counts[1] += 1
        for count in range(ITERATIONS):
            self.counts[0] = count
            rigid = 0.0 if free else rigid_gap(p, self.moved, offset)
            rest, active, worst, scale = residual(p, self.moved, offset, rigid)
            if worst <= tolerance * scale:
                self.place[:] = np.where(p > 0.0, 0, -1)
                self.rigid = rigid
                return DONE
            if not free:
                leveled(rest, active)
            z = self._softened(rest)
            masked(z, active)
            if not free:
                leveled(z, active)
            change, now = products(z, rest, before)
            part = max(0.0, change / product) if product > 0.0 else 0.0
            turn(way, z, part, active)
            if not free:
                leveled(way, active)
            moved = self.displacement(way)
            stiff, slope = float(way @ moved), float(way @ rest)
            if not stiff > 0.0:
                return SINGULAR if now > 0.0 else ENDLESS
            clipped = step(p, way, slope / stiff)
            if clipped:
                if not free:
                    p *= total / p.sum()
                self.moved[:] = self.displacement(p)
            else:
                self.moved -= slope / stiff * moved
            before[:], product = rest, now
        return ENDLESS


@njit(cache=True)
def rigid_gap(p: Array, moved: Array, offset: Array) -> float:
    """Compute the mean of F x + b over the points in contact."""
    total, count = 0.0, 0
    for i in range(len(p)):
        if p[i] > 0.0:
            total += moved[i] + offset[i]
            count += 1
    return total / count


@njit(cache=True)
def residual(
    p: Array, moved: Array, offset: Array, rigid: float
) -> tuple[Array, Flags, float, float]:
    """Compute gaps (n,) where there is contact or penetration, 0 elsewhere, and where that is.

    Also the largest of them, and the largest displacement, in mm.
    """
    rest, active = np.zeros_like(p), np.zeros(len(p), dtype=np.bool_)
    worst, scale = 0.0, 0.0
    for i in range(len(p)):
        gap = moved[i] + offset[i] - rigid
        if p[i] > 0.0 or gap < 0.0:
            active[i], rest[i] = True, gap
            worst, scale = max(worst, abs(gap)), max(scale, abs(moved[i]), abs(offset[i] - rigid))
    return rest, active, worst, scale


@njit(cache=True)
def leveled(values: Array, active: Flags) -> None:
    """Subtract from the active values their mean."""
    total, count = 0.0, 0
    for i in range(len(values)):
        if active[i]:
            total += values[i]
            count += 1
    for i in range(len(values)):
        if active[i]:
            values[i] -= total / count


@njit(cache=True)
def masked(values: Array, active: Flags) -> None:
    """Set the values that are not active to 0."""
    for i in range(len(values)):
        if not active[i]:
            values[i] = 0.0


@njit(cache=True)
def products(z: Array, rest: Array, before: Array) -> tuple[float, float]:
    """Compute z . (rest - before) and z . rest."""
    change, now = 0.0, 0.0
    for i in range(len(z)):
        now += z[i] * rest[i]
        change += z[i] * (rest[i] - before[i])
    return change, now


@njit(cache=True)
def turn(way: Array, z: Array, part: float, active: Flags) -> None:
    """Set the next direction: z and a part of the last one, on the active points."""
    for i in range(len(way)):
        way[i] = z[i] + part * way[i] if active[i] else 0.0


@njit(cache=True)
def step(p: Array, way: Array, size: float) -> bool:
    """Go back along a direction, to 0 at most; return whether a point has come to 0."""
    clipped = False
    for i in range(len(p)):
        p[i] -= size * way[i]
        if p[i] < 0.0:
            p[i] = 0.0
            clipped = True
    return clipped


def winkler(offset: Array, total: float, stiffness: float) -> Array:
    """Return the pressure (n,) with a sum `total` of springs of `stiffness` kPa/mm under gaps (n,).

    A start where nothing is known.
    """
    order = np.sort(offset)
    sums = np.arange(1, len(order) + 1) * order - np.cumsum(order)
    count = int(np.searchsorted(sums, total / stiffness))
    reached = (order[:count].sum() + total / stiffness) / max(count, 1)
    return np.maximum(reached - offset, 0.0) * stiffness
