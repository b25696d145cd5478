"""Complementarity on a periodic grid, and products with a compliance known by wavenumber.

F x + b >= 0, x >= 0, x . (F x + b) = 0, with F by Fourier transform; or, under a prescribed sum of
x, the same with b + d for an unknown number d. Conjugate gradients on the points in contact with
projections (Polonsky and Keer, Wear 231:206, 1999), preconditioned by the inverse of the compliance
of every wave (after Vollebregt, J. Optim. Theory Appl. 162:931, 2014).

They run on a window about the contact, in single precision: what a step adds to F x is small. The
solution is judged in double precision on the whole grid, and gone on with where it falls short.

A window is moved to the corner of the grid: rows of it that are empty are not transformed.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from fefinger.contact.active_set import DONE, ENDLESS, SINGULAR
from fefinger.contact.stepper import State
from fefinger.support.arrays import Array, Flags
from fefinger.support.compiled import njit


AROUND = 3
"""Grid points about the contact that a window has."""

Waves = NDArray[np.complex64]

Spectrum = NDArray[np.float32]


class Window(NamedTuple):
    """A part of a grid of `points`, by rows."""

    points: tuple[int, int]
    rows: slice
    columns: slice

    @classmethod
    def about(cls, touched: Flags, points: tuple[int, int]) -> "Window":
        """Return the window about the points (n,) that are touched, at least one."""
        grid = touched.reshape(points)
        rows, columns = (_bounds(np.any(grid, axis=axis, keepdims=True).ravel()) for axis in (1, 0))
        return cls(points, rows, columns)

    @property
    def shape(self) -> tuple[int, int]:
        """Points of the window along both axes."""
        return self.rows.stop - self.rows.start, self.columns.stop - self.columns.start

    def part(self, values: Array) -> Array:
        """Return the values (..., m) of a window of those (..., n) of a grid, a copy."""
        grid = values.reshape(*values.shape[:-1], *self.points)[..., self.rows, self.columns]
        return grid.reshape(*values.shape[:-1], -1)

    def put(self, values: Array, part: Array) -> None:
        """Set the values (..., n) of a grid to those (..., m) of its window."""
        grid = values.reshape(*values.shape[:-1], *self.points)
        grid[..., self.rows, self.columns] = part.reshape(*values.shape[:-1], *self.shape)

    def waves(self, part: Array) -> Waves:
        """Return the transforms (..., n_x, n_y // 2 + 1) of values (..., m) of the window."""
        rows, columns = self.points
        single = part.astype(np.float32).reshape(*part.shape[:-1], *self.shape)
        along = fft.rfft(single, columns, axis=-1)
        return np.asarray(fft.fft(along, rows, axis=-2, overwrite_x=True))

    def values(self, waves: Waves) -> Array:
        """Return the values (..., m) in the window of transforms, which are overwritten."""
        rows, columns = self.shape
        back = fft.ifft(waves, axis=-2, overwrite_x=True)[..., :rows, :]
        grid = fft.irfft(back, self.points[1], axis=-1)[..., :columns]
        return np.asarray(grid, np.float64).reshape(*waves.shape[:-2], -1)

    def product(self, part: Array, spectrum: Spectrum) -> Array:
        """Return values (..., m) of the window, convolved with what has a spectrum."""
        waves = self.waves(part)
        waves *= spectrum
        return self.values(waves)


def _bounds(touched: Flags) -> slice:
    """Return the slice about the lines (n,) that are touched, and AROUND more."""
    at = np.flatnonzero(touched)
    return slice(max(int(at[0]) - AROUND, 0), min(int(at[-1]) + AROUND + 1, len(touched)))


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
    counts
        (2,): iterations of the last solution, solutions so far.
    """

    def __init__(self, compliance: Array, points: tuple[int, int]) -> None:
        self.points, count = points, points[0] * points[1]
        self.give(compliance)
        self.x, self.moved, self._rigid = np.zeros(count), np.zeros(count), 0.0
        self.place, self.counts = np.full(count, -1, dtype=np.int64), np.zeros(2, dtype=np.int64)

    def give(self, compliance: Array) -> None:
        """Set the compliance, with what follows from it."""
        self.compliance = np.array(compliance, dtype=np.float64)
        stiffness = 1.0 / np.abs(self.compliance.ravel()[1:])
        # The mean is as stiff as the longest wave: without it that compliance may be 0.
        least = np.append(stiffness.min(), stiffness).reshape(self.compliance.shape)
        self._single = self.compliance.astype(np.float32)
        self._stiffness = least.astype(np.float32)

    @property
    def rigid(self) -> float:
        """The depth in mm at which x has the prescribed sum, over the one of `offset`."""
        return self._rigid

    @property
    def volatile(self) -> State:
        """Arrays that a failed solution leaves changed."""
        return self.x, self.moved, self.place, self.counts

    def displacement(self, pressure: Array) -> Array:
        """Return F x (n,) mm of a pressure x (n,) kPa."""
        return displacement(pressure, self.compliance, self.points)

    def clear(self) -> None:
        """Return to no contact."""
        self.x[:], self.moved[:], self.place[:] = 0.0, 0.0, -1

    def solve(self, offset: Array, tolerance: float, total: float = 0.0) -> int:
        """Solve for x from the last one with b = `offset` (n,) mm; return DONE or a failure.

        Gaps are closed, and open, to `tolerance` times the largest displacement. With a `total`
        above 0 that is the sum of x, and the gaps are those at the depth `rigid`.
        """
        x, moved, free = self.x, self.moved, total <= 0.0
        if not (free or x.any()):
            x[:] = winkler(offset, total, 1.0 / float(np.abs(self.compliance).max()))
        x *= 1.0 if free else total / x.sum()
        self.counts[:] = 0, self.counts[1] + 1
        rounds = 20  # most windows of a solution; nearly all take one
        stricter = 0.5  # tolerance in single precision, over that of the solution
        for _ in range(rounds):
            moved[:] = self.displacement(x)
            rigid = 0.0 if free else rigid_gap(x, moved, offset)
            _, active, worst, scale = residual(x, moved, offset, rigid)
            if worst <= tolerance * scale:
                self.place[:] = np.where(x > 0.0, 0, -1)
                self._rigid = rigid
                return DONE
            window = Window.about(active, self.points)
            outcome = self._descend(window, offset, stricter * tolerance, total)
            if outcome != DONE:
                return outcome
        return ENDLESS

    def _descend(self, w: Window, offset: Array, tolerance: float, total: float) -> int:
        """Solve in a window, as `solve`; other points have no pressure."""
        x, moved, b = w.part(self.x), w.part(self.moved), w.part(offset)
        free, product, outcome = total <= 0.0, 0.0, ENDLESS
        way, before, clipped = np.zeros((3, len(x)))
        while self.counts[0] < ITERATIONS:
            rigid = 0.0 if free else rigid_gap(x, moved, b)
            rest, active, worst, scale = residual(x, moved, b, rigid)
            if worst <= tolerance * scale:
                outcome = DONE
                break
            self.counts[0] += 1
            if not free:
                leveled(rest, active)
            z = w.product(rest, self._stiffness)
            change, now = masked(z, active, rest, before, level=not free)
            part = max(0.0, change / product) if product > 0.0 else 0.0
            turn(way, z, part, active, level=not free)
            turned = w.product(way, self._single)
            stiff, slope = products(way, turned, rest)
            if not stiff > 0.0:
                outcome = SINGULAR if now > 0.0 else ENDLESS
                break
            if step(x, moved, way, turned, slope / stiff, clipped):
                share = 1.0 if free else total / x.sum()
                moved[:] = share * (moved + w.product(clipped, self._single))
                x *= share
            before, product = rest, now
        w.put(self.x, x)
        return outcome


def displacement(pressure: Array, compliance: Array, points: tuple[int, int]) -> Array:
    """Return the displacement (n,) mm of a pressure (n,) kPa, by the compliance of every wave."""
    waves = fft.rfft2(pressure.reshape(points)) * compliance
    return np.asarray(fft.irfft2(waves, points)).ravel()


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
def masked(z: Array, active: Flags, rest: Array, before: Array, level: bool) -> tuple[float, float]:
    """Set values that are not active to 0, the mean of the others too if to `level`.

    Return z . (rest - before) and z . rest.
    """
    if level:
        leveled(z, active)
    change, now = 0.0, 0.0
    for i in range(len(z)):
        if not active[i]:
            z[i] = 0.0
        now += z[i] * rest[i]
        change += z[i] * (rest[i] - before[i])
    return change, now


@njit(cache=True)
def turn(way: Array, z: Array, part: float, active: Flags, level: bool) -> None:
    """Set the next direction: z and a part of the last one, on the active points."""
    for i in range(len(way)):
        way[i] = z[i] + part * way[i] if active[i] else 0.0
    if level:
        leveled(way, active)


@njit(cache=True)
def products(way: Array, moved: Array, rest: Array) -> tuple[float, float]:
    """Compute way . moved and way . rest."""
    stiff, slope = 0.0, 0.0
    for i in range(len(way)):
        stiff += way[i] * moved[i]
        slope += way[i] * rest[i]
    return stiff, slope


@njit(cache=True)
def step(x: Array, moved: Array, way: Array, turned: Array, size: float, clipped: Array) -> bool:
    """Go back along a direction, to 0 at most; return whether a point would go beyond.

    turned (m,): F times the direction; clipped (m,): what is added to stay at 0.
    """
    beyond = False
    for i in range(len(x)):
        after = x[i] - size * way[i]
        moved[i] -= size * turned[i]
        x[i], clipped[i] = max(after, 0.0), max(-after, 0.0)
        beyond = beyond or after < 0.0
    return beyond


def winkler(offset: Array, total: float, stiffness: float) -> Array:
    """Return the pressure (n,) with a sum `total` of springs of `stiffness` kPa/mm under gaps (n,).

    A start where nothing is known.
    """
    order = np.sort(offset)
    sums = np.arange(1, len(order) + 1) * order - np.cumsum(order)
    count = int(np.searchsorted(sums, total / stiffness))
    reached = (order[:count].sum() + total / stiffness) / max(count, 1)
    return np.maximum(reached - offset, 0.0) * stiffness
