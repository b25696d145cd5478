"""A hyperelastic body in contact through time, with a relaxing second Piola-Kirchhoff stress.

S(t) = integral of G(t - s) dS_e(s) (Fung's quasi-linear viscoelasticity), by the exponential
recursion of `march.Relaxation` at every point of integration: exact for stresses that are linear
over a step. A step that does not converge is quartered, as far as an `Allowance` goes.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fefinger.fem.contact.viscoelastic import Relaxation
from fefinger.fem.elements.spaces import Array, Integers
from fefinger.fem.hyperelastic.continuum import Continuum, Memory
from fefinger.fem.hyperelastic.newton import Equilibrium, Exhausted
from fefinger.fem.hyperelastic.state import Asked, State
from fefinger.fem.linalg.threads import one_thread
from fefinger.support.checks import ConvergenceError


SPLITS, PARTS = 3, 4
"""How often a step is split, and into how many: halves would fail oftener, which takes long."""


@dataclass(frozen=True)
class Series:
    """A Prony series with the long-time value 1: weights (1 + n,) that add to 1, rates (n,) 1/s."""

    weights: Array
    rates: Array


class StressHistory:
    """What the past of a body leaves in its stress; each tissue relaxes with its own series.

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

    def memory(self, step: float) -> Memory:
        """Return the gains and the past of a step of `step` s."""
        gains = np.ones((len(self.body.weights), 2))
        past = np.zeros((*self.body.weights.shape, 6))
        for cells, relaxation in self._parts:
            gain, left = relaxation.history(step)
            gains[cells, 0] = gain
            gains[cells, 1] = 1.0 if self.deviatoric else gain
            past[cells] = left.reshape(len(cells), -1, 6)
        return Memory(gains, past)

    def advance(self, step: float, values: Array) -> None:
        """Accept the state at the end of a step."""
        isochoric, volumetric = self.body.stress(values)
        elastic = isochoric if self.deviatoric else isochoric + volumetric
        for cells, relaxation in self._parts:
            relaxation.advance(step, elastic[cells].ravel())


@dataclass(frozen=True)
class Path:
    """What the indenter is made to do: `value` gives a depth in mm or a force in mN at a time."""

    control: str
    times: Array
    value: Callable[[float], float]

    @property
    def peak(self) -> float:
        """The largest value at the times."""
        return max(map(self.value, self.times.tolist()), default=0.0)


@dataclass(frozen=True)
class Allowance:
    """Factors of the tangent that a passage may make.

    usual: by every step of the path, with its parts; spare: beyond them, by all steps together.
    Counted in factors, so that the same passage ends at the same step on every machine.
    """

    usual: float = math.inf
    spare: float = 0.0

    def left(self, spent: float) -> "Allowance":
        """Return what is left after a step that `spent` so many factors."""
        return replace(self, spare=self.spare - max(spent - self.usual, 0.0))


@one_thread
def follow(
    equilibrium: Equilibrium,
    history: StressHistory,
    path: Path,
    observe: Callable[[int, State], None],
    progress: Callable[[float], None] = lambda fraction: None,
    allowance: Allowance | None = None,
) -> int:
    """Solve the body at every time of the path, and show `observe` each; return the steps taken.

    The body is at rest before the first time, whose value is reached by a jump. Without an
    `allowance` the steps may take any work.

    Raises
    ------
    ConvergenceError
        If a step does not converge after SPLITS splits, or takes more than the allowance has
        left; all before it has been observed.
    """
    body, contact = equilibrium.body, equilibrium.contact
    state = State(np.zeros(body.space.n_unknowns), np.zeros(len(contact)), 0.0)
    walk = _Walk(equilibrium, history, path, path.peak, state, state)
    left = allowance or Allowance()
    for k, time in enumerate(path.times):
        before = equilibrium.factors
        equilibrium.allowed = before + left.usual + left.spare
        walk.to(float(path.times[k - 1]) if k else float(time), float(time), SPLITS)
        left = left.left(equilibrium.factors - before)
        observe(k, walk.state)
        progress((k + 1) / len(path.times))
    return walk.steps


@dataclass
class _Walk:
    """The last two states, and how to reach the next; `peak` is the largest value of the path."""

    equilibrium: Equilibrium
    history: StressHistory
    path: Path
    peak: float
    state: State
    previous: State
    steps: int = 0

    def to(self, start: float, stop: float, splits: int) -> None:
        """Go from the time `start` to `stop`, in parts if need be."""
        target = float(self.path.value(stop))
        memory = self.history.memory(stop - start)
        asked = Asked(self.path.control, target, memory, self.peak)
        try:
            found = self.equilibrium.find(self._guess(target), asked)
        except ConvergenceError as error:
            if splits == 0 or stop == start or isinstance(error, Exhausted):
                message = f"at {stop:.6g} s ({self.path.control} {target:.6g}): {error}"
                raise ConvergenceError(message) from error
            for begin, end in pairwise(np.linspace(start, stop, PARTS + 1).tolist()):
                self.to(begin, end, splits - 1)
            return
        self.history.advance(stop - start, found.values)
        self.previous, self.state = self.state, found
        self.steps += 1

    def _guess(self, target: float) -> State:
        """Extrapolate the last two states to a new depth."""
        last = self.state.depth - self.previous.depth
        if self.path.control != "depth" or last == 0:
            return self.state
        ratio = float(np.clip((target - self.state.depth) / last, -1.0, 1.0))
        values = self.state.values + ratio * (self.state.values - self.previous.values)
        return replace(self.state, values=values)
