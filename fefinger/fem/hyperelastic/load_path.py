"""A hyperelastic body in contact through time, with a relaxing second Piola-Kirchhoff stress.

S(t) = integral of G(t - s) dS_e(s) (Fung's quasi-linear viscoelasticity), by the exponential
recursion of `viscoelastic.Relaxation` at every integration point: exact for stresses that are
linear over a step. A step that does not converge is quartered, within a `FactorizationBudget`.

The history of Coulomb friction, with slip and lost work, is carried from step to step. As
`contact.frictional` at small strain: where the kinetic coefficient is less than the static one, a
vertex has the kinetic one from the step after its first slip to the step in which it sticks again,
or leaves contact.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Self

import numpy as np

from fefinger.contact.frictional import STUCK
from fefinger.contact.prony_history import Relaxation
from fefinger.fem.contact.deformed_gap import ContactSurface
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.continuum import Continuum, HistoryStress
from fefinger.fem.hyperelastic.newton import Equilibrium, Exhausted
from fefinger.fem.hyperelastic.state import Friction, State, Target
from fefinger.geometry.profiles import frame
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import ConvergenceError
from fefinger.support.processes import one_thread


class FrictionHistory:
    """Friction of a contact through time, with the static and the kinetic coefficient `mu`.

    Attributes
    ----------
    coefficient
        (n,): of each candidate in the next step.
    slip
        (2, n) mm of the skin over the obstacle since first contact.
    sticking
        (n,): which candidates under pressure did not slip in the last step.
    lost
        µJ: the work of friction so far.
    """

    def __init__(self, contact: ContactSurface, mu: tuple[float, float]) -> None:
        self.contact, self.mu = contact, mu
        count = len(contact)
        self.coefficient: Array = np.full(count, mu[0])
        self.slip: Array = np.zeros((2, count))
        self.sticking: Flags = np.zeros(count, dtype=np.bool_)
        self.lost = 0.0

    def after(self, before: State) -> Friction:
        """Return the friction of a step that starts from an equilibrium."""
        return Friction(self.coefficient, before)

    def advance(self, before: State, state: State) -> None:
        """Update slip, work and coefficients with the equilibrium at the end of a step."""
        slid = self.contact.slip(self.contact.at(state), state, before)
        pressed = state.pressure > 0
        full = self.coefficient * state.pressure * (1 - STUCK)
        self.sticking = pressed & (np.hypot(*state.traction) < full)
        self.coefficient = np.where(pressed & ~self.sticking, self.mu[1], self.mu[0])
        self.slip = np.where(pressed, self.slip + slid / self.contact.projected, 0.0)
        self.lost -= float((state.traction * slid)[:, pressed].sum())


@dataclass(frozen=True)
class SideLoad:
    """What an object pulls along the plane across its axis, at n_t equilibria.

    force (n_t, 2) mN of pressure and friction on the meshed part; axial (n_t,) mN of friction along
    the axis; torque (n_t,) mN mm of friction about the axis through the center of pressure; with
    friction traction (n_t, 2, n) kPa, slip (n_t, 2, n) mm since first contact, sticking (n_t, n)
    and the work (n_t,) in µJ so far. The first axis is left out of a single one.
    """

    force: Array
    axial: Array
    torque: Array
    traction: Array
    slip: Array
    sticking: Flags
    work: Array

    @classmethod
    def of(
        cls, contact: ContactSurface, space: Space, state: State, friction: FrictionHistory | None
    ) -> Self:
        """Collect the loads of an equilibrium."""
        across, count, none = frame(contact.obstacle.axis)[:2], space.n_displacements, np.zeros(())
        gap = contact.at(state)
        pressed = (gap.loads @ state.pressure)[:count].reshape(-1, 3)
        if friction is None:
            empty = np.empty((2, 0))
            return cls(pressed.sum(axis=0) @ across.T, none, none, empty, empty, empty > 0, none)
        pulled = (gap.tangential @ state.traction.ravel())[:count].reshape(-1, 3)
        places = (space.node_points + state.values[:count].reshape(-1, 3)) @ across.T
        along = pressed @ contact.obstacle.axis
        center = along @ places / along.sum() if along.any() else np.zeros(2)
        x, y = (places - center).T
        sideways = pulled @ across.T
        return cls(
            force=(pressed + pulled).sum(axis=0) @ across.T,
            axial=pulled.sum(axis=0) @ contact.obstacle.axis,
            torque=x @ sideways[:, 1] - y @ sideways[:, 0],
            traction=state.traction,
            slip=friction.slip,
            sticking=friction.sticking,
            work=np.array(friction.lost),
        )

    @classmethod
    def stacked(cls, every: Sequence[Self]) -> Self:
        """Join the loads of single equilibria."""
        names = [each.name for each in fields(cls)]
        return cls(*(np.array([getattr(each, name) for each in every]) for name in names))


SPLITS, PARTS = 3, 4
"""Levels of subdivision of a step, and parts per level.

Halves instead of quarters fail more often, and every failed attempt costs a full iteration.
"""


@dataclass(frozen=True)
class Series:
    """A Prony series with the long-time value 1: weights (1 + n,) that add to 1, rates (n,) 1/s."""

    weights: Array
    rates: Array


class StressHistory:
    """Viscoelastic stress history of a body: one Prony series for each tissue.

    With `deviatoric` the pressure does not relax.
    """

    def __init__(
        self, body: Continuum, series: Mapping[int, Series], *, deviatoric: bool = False
    ) -> None:
        self.body, self.deviatoric = body, deviatoric
        self._parts: list[tuple[Integers, Relaxation]] = []
        for label, prony in series.items():
            cells = np.flatnonzero(body.space.tissue == label)
            size = len(cells) * body.weights.shape[1] * 6
            self._parts.append((cells, Relaxation(prony.weights, prony.rates, size)))

    def over(self, step: float) -> HistoryStress:
        """Return the relaxation factors and the history stress of a step of `step` s."""
        gains = np.ones((len(self.body.weights), 2))
        past = np.zeros((*self.body.weights.shape, 6))
        for cells, relaxation in self._parts:
            gain, history = relaxation.history(step)  # g and h
            gains[cells, 0] = gain
            gains[cells, 1] = 1.0 if self.deviatoric else gain
            past[cells] = history.reshape(len(cells), -1, 6)
        return HistoryStress(gains, past)

    def advance(self, step: float, values: Array) -> None:
        """Update the internal variables with the converged unknowns at the end of a step."""
        if not self._parts:
            return
        isochoric, volumetric = self.body.stress(values)
        elastic = isochoric if self.deviatoric else isochoric + volumetric
        for cells, relaxation in self._parts:
            relaxation.advance(step, elastic[cells].ravel())


@dataclass(frozen=True)
class LoadPath:
    """Prescribed motion of the indenter: `value` is depth in mm or force in mN over time in s.

    shift(t) (3,) mm: the place of the indenter across its axis.
    """

    control: str
    times: Array
    value: Callable[[float], float]
    shift: Callable[[float], Array] = lambda t: np.zeros(3)

    @property
    def peak(self) -> float:
        """The largest value at the times."""
        return max(map(self.value, self.times.tolist()), default=0.0)


@dataclass(frozen=True)
class FactorizationBudget:
    """Limit on tangent factorizations along a load path.

    usual: for every step of the path, its parts included; spare: beyond those, for all steps
    together. Factorizations are counted, not seconds, so that the same load path stops at the
    same step on every machine.
    """

    usual: float = math.inf
    spare: float = 0.0

    def after(self, spent: float) -> "FactorizationBudget":
        """Return the remaining allowance after a step with `spent` factorizations."""
        return replace(self, spare=self.spare - max(spent - self.usual, 0.0))


@one_thread
def follow(
    equilibrium: Equilibrium,
    history: StressHistory,
    path: LoadPath,
    observe: Callable[[int, State], None],
    progress: Callable[[float], None] = lambda fraction: None,
    allowance: FactorizationBudget | None = None,
    friction: FrictionHistory | None = None,
) -> int:
    """Solve the load path step by step; return the number of steps taken.

    `observe` is called with the index and the state of every time. The body is at rest before
    the first time, whose value is reached by a jump. Without an `allowance` the number of
    factorizations has no limit. With `friction` the equilibrium is one with tractions.

    Raises ConvergenceError if a step does not converge after SPLITS splits, or takes more than the
    allowance has left; all before it has been observed.
    """
    body, contact = equilibrium.body, equilibrium.contact
    none = np.zeros((2, 0 if friction is None else len(contact)))
    shift = path.shift(float(path.times[0]))
    state = State(np.zeros(body.space.n_unknowns), np.zeros(len(contact)), 0.0, shift, none)
    solver = _PathSolver(equilibrium, history, path, path.peak, state, state, friction)
    remaining = allowance or FactorizationBudget()
    for k, time in enumerate(path.times):
        before = equilibrium.factors
        equilibrium.allowed = before + remaining.usual + remaining.spare
        solver.advance(float(path.times[k - 1]) if k else float(time), float(time), SPLITS)
        remaining = remaining.after(equilibrium.factors - before)
        observe(k, solver.state)
        progress((k + 1) / len(path.times))
    return solver.steps


@dataclass
class _PathSolver:
    """Solver of a load path, with the last two states; `peak`: the largest value of the path."""

    equilibrium: Equilibrium
    stress: StressHistory
    path: LoadPath
    peak: float
    state: State
    previous: State
    friction: FrictionHistory | None = None
    value: float = 0.0
    previous_value: float = 0.0
    steps: int = 0

    def advance(self, start: float, stop: float, splits: int) -> None:
        """Solve the step from time `start` to `stop`; subdivide it where it does not converge."""
        value = float(self.path.value(stop))
        history = self.stress.over(stop - start)
        shift = self.path.shift(stop)
        friction = None if self.friction is None else self.friction.after(self.state)
        target = Target(self.path.control, value, history, self.peak, shift, friction)
        try:
            state = self.equilibrium.find(self._guess(value, shift), target)
        except ConvergenceError as error:
            if splits == 0 or stop == start or isinstance(error, Exhausted):
                message = f"at {stop:.6g} s ({self.path.control} {value:.6g}): {error}"
                raise ConvergenceError(message) from error
            for begin, end in pairwise(np.linspace(start, stop, PARTS + 1).tolist()):
                self.advance(begin, end, splits - 1)
            return
        self.stress.advance(stop - start, state.values)
        if self.friction is not None:
            self.friction.advance(self.state, state)
        self.previous, self.state = self.state, state
        self.previous_value, self.value = self.value, value
        self.steps += 1

    def _guess(self, value: float, shift: Array) -> State:
        """Extrapolate the last two states linearly to a new depth or force, or along a path.

        In a rest the body is taken to creep as far as in the step before. The pressures are part
        of it: an old factor errs by their change, as its contact loads belong to another shape.
        """
        last = self.value - self.previous_value
        if last == 0:
            ratio = self._part(shift) if value == self.value else 0.0
        else:
            ratio = (value - self.value) / last
        farthest = 2.0  # extrapolation of a step, over the step before it
        ratio = float(np.clip(ratio, -farthest, farthest))
        guess = self.previous.toward(self.state, 1.0 + ratio)
        pressed = guess.pressure > 0
        traction = np.where(pressed, guess.traction, 0.0) if self.friction else guess.traction
        return replace(guess, pressure=np.maximum(guess.pressure, 0.0), traction=traction)

    def _part(self, shift: Array) -> float:
        """Return the length of a step along the path over the step before it; 1 in a rest."""
        last, now = self.state.shift - self.previous.shift, shift - self.state.shift
        if not last.any():
            return 0.0 if now.any() else 1.0
        return float(now @ last / (last @ last))
