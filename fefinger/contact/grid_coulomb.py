"""Contact with Coulomb friction on a periodic grid, whose flexibility is known by wavenumber.

Pressure at a given traction (`grid_solver.py`), and traction at a given pressure, in turn until
neither changes (Panagiotopoulos, Ing.-Arch. 44:421, 1975). At a given pressure p the traction t is
the least of a convex energy over the discs |t| <= mu p. A semi-smooth Newton method moves it: of
points that stick the slip is 0, of those that slip the part of it across the traction (Alart and
Curnier, Comput. Methods Appl. Mech. Eng. 92:353, 1991). Its systems are symmetric and are solved by
conjugate gradients, preconditioned by wavenumber; a step that stays in the discs, as long as the
energy falls, needs no other guard.

Vectors of 3n have the pressures first, then the tractions along both axes.
"""

from typing import NamedTuple

import numpy as np
from scipy import fft

from fefinger.contact.active_set import DONE, ENDLESS
from fefinger.contact.grid_solver import GridSolver, Window
from fefinger.contact.stepper import State
from fefinger.support.arrays import Array, Flags, Integers


ROUNDS = 40
"""Most times that pressure and traction are solved in turn; four to six are usual."""

FIRST, FALLING = 1e-3, 0.03
"""Tolerance of the first turn, if larger than that of the solution, and of a turn over the last."""


class Flexibility(NamedTuple):
    """Displacements in mm per kPa of every wave, as of `scipy.fft.rfft2`, (..., n_x, n_y // 2 + 1).

    normal: into the body, of a pressure; coupled (2, ...): i times it is the displacement into the
    body of a traction along each axis, -i times it the one along the axis of a pressure;
    tangential (3, ...): along the first axis of a traction there, the second, and of each other.
    """

    normal: Array
    coupled: Array
    tangential: Array


class _Slip(NamedTuple):
    """Where traction is sought, of m points: on is where it may be, slips where it is at its bound.

    along (2, m): its direction there; stiff (m,): what holds it across, mm/kPa.
    """

    on: Flags
    slips: Flags
    along: Array
    stiff: Array

    def free(self, values: Array) -> Array:
        """Return a copy of vectors (2, m) without the components that a step must not change."""
        part = np.where(self.slips, np.sum(values * self.along, axis=0), 0.0)
        return np.where(self.on, values - part * self.along, 0.0)


class GridCoulomb:
    """Solver of contact with friction on a periodic grid; it starts from its last solution.

    Parameters
    ----------
    flexibility
        `Flexibility`.
    points
        Grid points (n_x, n_y).
    mu
        Coefficient of every point at first.

    Attributes
    ----------
    x, moved
        Pressures and tractions (3n,) kPa, and the flexibility times them in mm.
    mu
        Coefficients (n,).
    place, rigid, counts
        As of `GridSolver`.
    residual
        Largest distance of a traction from Coulomb's law, over the largest pressure.
    """

    def __init__(self, flexibility: Flexibility, points: tuple[int, int], mu: float) -> None:
        self.points, count = points, points[0] * points[1]
        self.flexibility, self.residual = flexibility, 0.0
        self.normal = GridSolver(flexibility.normal, points)
        self.x, self.moved = np.zeros((2, 3 * count))
        self.mu = np.full(count, float(mu))
        self._single = flexibility.tangential.astype(np.float32)
        self._pulled = (-1j * flexibility.coupled).astype(np.complex64)
        self._mean = (self._single[0] + self._single[1]) / 2
        # Of a point alone, by the sum over all waves, also of the columns that are not stored.
        whole = 2 * self._mean.sum() - self._mean[:, 0].sum() - self._mean[:, -1].sum()
        self.own = float(whole) / count

    @property
    def place(self) -> Integers:
        """0 of points in contact, else -1."""
        return self.normal.place

    @property
    def counts(self) -> Integers:
        """Iterations for the last pressure, and solutions for a pressure so far."""
        return self.normal.counts

    @property
    def rigid(self) -> float:
        """The depth in mm at which x has the prescribed sum, over the one of `offset`."""
        return self.normal.rigid

    @property
    def volatile(self) -> State:
        """Arrays that a failed solution leaves changed."""
        return self.x, self.moved, *self.normal.volatile

    def displacement(self, x: Array) -> Array:
        """Return the flexibility times pressures and tractions x (3n,), in mm."""
        waves = fft.rfft2(x.reshape(3, *self.points))
        normal, (first, second), (one, two, cross) = self.flexibility
        p, u, v = waves
        out = np.stack(
            [
                normal * p + 1j * (first * u + second * v),
                one * u + cross * v - 1j * first * p,
                cross * u + two * v - 1j * second * p,
            ]
        )
        return np.asarray(fft.irfft2(out, self.points)).ravel()

    def clear(self) -> None:
        """Return to no contact."""
        self.normal.clear()
        self.x[:] = self.moved[:] = 0.0

    def solve(self, offset: Array, tolerance: float, total: float = 0.0) -> int:
        """Solve for x from the last one with b = `offset` (3n,) mm; return DONE or a failure.

        Gaps and slips are those of F x + b, closed to `tolerance` times the largest displacement.
        With a `total` above 0 that is the sum of the pressures.
        """
        n, x, moved, close = len(self.mu), self.x, self.moved, max(tolerance, FIRST)
        for _ in range(ROUNDS):
            lifted = moved[:n] - self.normal.moved
            outcome = self.normal.solve(offset[:n] + lifted, close, total)
            if outcome != DONE:
                return outcome
            if not self._slide(offset[n:], close):
                return ENDLESS
            moved[:] = self.displacement(x)
            if close <= tolerance and self._balanced(offset, tolerance):
                return DONE
            close = max(tolerance, FALLING * close)
        return ENDLESS

    def _balanced(self, offset: Array, tolerance: float) -> bool:
        """Whether gaps and slips of the present x are closed, to twice the tolerance of each."""
        n, loaded = len(self.mu), self.x[: len(self.mu)] > 0.0
        gap = self.moved[:n] + offset[:n] - self.rigid
        missing = np.where(loaded, np.abs(gap), np.maximum(-gap, 0.0))
        slip, t = (each.reshape(2, n) for each in (self.moved[n:] + offset[n:], self.x[n:]))
        apart = np.hypot(*(t - within(t - slip / self.own, self.mu * self.x[:n])))
        self.residual = float(apart.max() / max(self.x[:n].max(), 1e-300))
        worst = max(float(missing.max()), self.own * float(apart.max()))
        return worst <= 2 * tolerance * self._scale()

    def _scale(self) -> float:
        return float(np.abs(self.normal.moved).max())

    def _slide(self, offset: Array, tolerance: float) -> bool:
        """Take over the pressure, and solve for the traction under it; False if it is not found.

        offset (2n,): of the slip. The traction starts from the last one, within its new bounds.
        """
        n, t = len(self.mu), self.x[len(self.mu) :].reshape(2, -1)
        touched = (self.x[:n] > 0.0) | (self.normal.x > 0.0)
        if not touched.any():
            return True
        w = Window.about(touched, self.points)
        change = self.normal.x - self.x[:n]
        self.x[:n] = self.normal.x
        slip = w.part((self.moved[n:] + offset).reshape(2, n))
        slip += w.values(self._pulled * w.waves(w.part(change)))
        bound, before = w.part(self.mu * self.x[:n]), w.part(t)
        now = within(before, bound)
        slip += self._product(w, now - before)
        found = self._newton(w, now, slip, bound, tolerance * self._scale())
        w.put(t, now)
        return found

    def _newton(self, w: Window, t: Array, slip: Array, bound: Array, close: float) -> bool:
        """Move a traction t (2, m) and its slip to where no projection changes it."""
        newton = 60  # most steps of Newton's method for a traction
        for _ in range(newton):
            aim = t - slip / self.own
            size = np.hypot(*aim)
            projected = within(aim, bound)
            if self.own * np.hypot(*(t - projected)).max() <= close:
                t[:] = projected  # what slips is at its bound, but for rounding
                return True
            slips = size > bound
            s = _Slip(
                bound > 0.0,
                slips,
                aim / np.where(size > 0.0, size, 1.0),
                np.where(slips, self.own * (size / np.where(bound > 0.0, bound, 1.0) - 1.0), 0.0),
            )
            edge = np.where(s.on, np.where(slips, bound * s.along, t), 0.0)
            turned = slip + self._product(w, edge - t)
            way = within(edge + self._solved(w, s, -s.free(turned)), bound) - t
            falls = -float(np.sum(slip * way))
            if not falls > 0.0:  # along the slip the energy falls
                way = projected - t
                falls = -float(np.sum(slip * way))
            moved = self._product(w, way)
            bends = float(np.sum(moved * way))
            if not (falls > 0.0 and bends > 0.0):
                return True  # as close as single precision sees; the next turn has exact slips
            part = min(1.0, falls / bends)
            t += part * way
            slip += part * moved
        return False

    def _product(self, w: Window, t: Array) -> Array:
        """Return displacements (2, m) of tractions (2, m)."""
        u, v = w.waves(t)
        one, two, cross = self._single
        return w.values(np.stack([one * u + cross * v, cross * u + two * v]))

    def _solved(self, w: Window, s: _Slip, right: Array) -> Array:
        """Return the change (2, m) that a Newton step asks for, by conjugate gradients."""
        held = s.stiff[s.on & s.slips]
        typical = float(np.median(held)) if len(held) else 0.0
        inverse = 1.0 / (self._mean + np.float32(typical))
        # Where little pressure is, much holds the traction: all that is held is scaled to the same.
        even = np.sqrt(typical / np.maximum(s.stiff, typical)) if typical > 0.0 else 1.0
        out, rest, way = np.zeros_like(right), right.copy(), np.zeros_like(right)
        forcing = 0.05  # part of the right side that conjugate gradients leave
        enough, product = forcing * float(np.linalg.norm(right)), 0.0
        products = 200  # most products of a step of Newton's method
        for _ in range(products):
            if float(np.linalg.norm(rest)) <= enough:
                break
            z = s.free(even * w.product(even * rest, inverse))
            now = float(np.sum(z * rest))
            way = z + (now / product if product > 0.0 else 0.0) * way
            turned = s.free(self._product(w, way)) + s.stiff * way
            size = now / float(np.sum(way * turned))
            out += size * way
            rest -= size * turned
            product = now
        return out


def within(t: Array, bound: Array) -> Array:
    """Return tractions (2, m), those beyond their bounds (m,) on them."""
    size = np.hypot(*t)
    return np.asarray(t * np.where(size > bound, bound / np.where(size > 0.0, size, 1.0), 1.0))
