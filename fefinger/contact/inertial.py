"""Contact of a body of viscoelastic modes with residual flexibility: one step, with inertia.

The displacement of the pad is u = R y + sum of phi_k a_k: R is the residual flexibility (the static
one less the modes', a static correction for the modes left out), y the elastic pressure as
in `frictionless`, a_k the amplitudes of `oscillators`. A step ends at u = F p + what the past
left, with F = R / g + sum of phi_k b_k phi_k', b_k >= 0: contact is the complementarity problem of
statics with another F. What touches has no mass of its own beyond the modes, so that contact
opens and closes without chatter (Khenous, Laborde and Renard, Eur. J. Mech. A 27:918, 2008).
Pressures that alternate from step to step move no mode that swings: closed contact lets no error
grow, however long the step.

In a static step (a rest, too long for the modes) they deform as in statics; their own past goes on.
"""

from typing import NamedTuple

import numpy as np

from fefinger.contact import active_set
from fefinger.contact.active_set import DONE, LcpState
from fefinger.contact.frictionless import press
from fefinger.contact.oscillators import Complex, Oscillators
from fefinger.contact.prony_history import (
    PronyHistory,
    increments,
    load_history,
    prony_history,
    store_history,
)
from fefinger.contact.stepper import Stepper, Target
from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit
from fefinger.support.tolerances import COMPLEMENTARITY


class ModalState(NamedTuple):
    """State of the modes and the factors of a step.

    participation (n, n_pad): work of each unit load on each mode; residual_flexibility (n_pad,
    n_pad): R, the static one less the modes'; residues (n, s); filtered (n, s): the force
    of each mode, filtered by each of its poles; force, earlier (n,): at the end of the last step
    and of the one before; amplitude, free_amplitude (n,): at the end, and the same without the
    pressure of the step; moved (n_pad,): R p; pressed, factor (n_pad,): work, the loaded vertices
    and their pressures.
    """

    participation: Array
    residual_flexibility: Array
    residues: Complex
    filtered: Complex
    force: Array
    earlier: Array
    amplitude: Array
    free_amplitude: Array
    moved: Array
    pressed: Integers
    factor: Array


class StepFactors(NamedTuple):
    """Coefficients that depend on the step length.

    decay, earlier, before, after (n, s): of the filters; gains (n,): amplitude at the end of the
    step per force at its end; flexibility F (n_pad, n_pad) of the end of the step; static: whether
    modes deform as in statics.
    """

    decay: Complex
    earlier: Complex
    before: Complex
    after: Complex
    gains: Array
    flexibility: Array
    static: bool


def modal_state(
    oscillators: Oscillators, participation: Array, residual_flexibility: Array
) -> ModalState:
    """Allocate the modes at rest; participation and residual_flexibility as in the state."""
    n, n_pad = participation.shape
    return ModalState(
        participation=np.ascontiguousarray(participation, dtype=np.float64),
        residual_flexibility=np.ascontiguousarray(residual_flexibility, dtype=np.float64),
        residues=oscillators.residues.copy(),
        filtered=np.zeros_like(oscillators.poles),
        force=np.zeros(n),
        earlier=np.zeros(n),
        amplitude=np.zeros(n),
        free_amplitude=np.zeros(n),
        moved=np.zeros(n_pad),
        pressed=np.zeros(n_pad, dtype=np.int64),
        factor=np.zeros(n_pad),
    )


def step_factors(
    oscillators: Oscillators,
    participation: Array,
    residual_flexibility: Array,
    dt: float,
    *,
    static: bool,
) -> StepFactors:
    """Compute the factors of a step of `dt` s; `static`: the modes deform as in statics."""
    g = 1.0 + float(increments(oscillators.weights, oscillators.rates, dt).sum())
    decay, earlier, before, after = oscillators.filters(dt, swing=not static)
    # A copy: numba compiles a view of the real parts as another type, which takes seconds.
    dynamic = (oscillators.residues * after).sum(axis=1).real.copy()
    gains = 1.0 / (oscillators.omega_squared * g) if static else dynamic
    flexibility = residual_flexibility / g + (participation.T * gains) @ participation
    return StepFactors(
        *(decay, earlier, before, after, gains),
        np.ascontiguousarray((flexibility + flexibility.T) / 2),
        static,
    )


@njit(cache=True)
def _step(
    s: LcpState,
    m: PronyHistory,
    o: ModalState,
    f: StepFactors,
    search: Array,
    gap: Array,
    projected: Array,
    limits: Integers,
    work: Array,
    dt: float,
    value: float,
    by_force: bool,
) -> int:
    g = load_history(m, dt)
    _free_amplitude(m, o, f, g)
    offset, free, nothing = work[0], work[1], work[2]  # the free gap takes the past into account
    for j in range(len(gap)):
        free[j] = gap[j] - m.moved_past[j] / g
    for k in range(len(o.free_amplitude)):
        a = o.free_amplitude[k]
        row = o.participation[k]
        for j in range(len(gap)):
            free[j] += a * row[j]
    failed = press(
        s, search, free, nothing, 1.0, projected, limits, offset, value, by_force, COMPLEMENTARITY
    )
    if failed == DONE:
        _store(s, m, o, f, dt, g)
    return failed


@njit(cache=True)
def _free_amplitude(m: PronyHistory, o: ModalState, f: StepFactors, g: float) -> None:
    """Compute the amplitudes at the end of the step for zero pressure then (history terms)."""
    for k in range(len(o.free_amplitude)):
        if f.static:
            total = 0.0
            for j in range(len(m.past)):
                total -= o.participation[k, j] * m.past[j]
            o.free_amplitude[k] = f.gains[k] * total
        else:
            value = 0.0
            for i in range(o.residues.shape[1]):
                left = f.decay[k, i] * o.filtered[k, i] + f.before[k, i] * o.force[k]
                left += f.earlier[k, i] * o.earlier[k]
                value += (o.residues[k, i] * left).real
            o.free_amplitude[k] = value


@njit(cache=True)
def _store(
    s: LcpState, m: PronyHistory, o: ModalState, f: StepFactors, dt: float, g: float
) -> None:
    """Update the history of the pad and of the modes with the pressure at the end of a step."""
    count = active_set.combine(o.moved, o.residual_flexibility, s.x, o.pressed, o.factor)
    for k in range(len(o.force)):
        force = 0.0
        for i in range(count):
            force += o.participation[k, o.pressed[i]] * o.factor[i]
        for i in range(o.residues.shape[1]):
            left = f.decay[k, i] * o.filtered[k, i] + f.before[k, i] * o.force[k]
            left += f.earlier[k, i] * o.earlier[k]
            o.filtered[k, i] = left + f.after[k, i] * force
        o.amplitude[k] = o.free_amplitude[k] + f.gains[k] * force
        o.earlier[k], o.force[k] = o.force[k], force
    store_history(m, s.x, o.moved, dt, g)


InertialParts = tuple[Oscillators, Array, Array, Array, Array, float, *tuple[Integers, ...]]
"""A body of modes with a pad, and the limits of its contact, if any, as of `InertialContact`."""


class InertialContact(Stepper):
    """A body of modes with a pad, through time.

    Parameters
    ----------
    oscillators, participation, residual_flexibility
        The modes, and (n, n_pad), (n_pad, n_pad) as in `ModalState`.
    gap, projected, limits
        As of `FrictionlessContact`.
    longest
        Length in s of a step beyond which modes deform as in statics.
    """

    def __init__(
        self,
        oscillators: Oscillators,
        participation: Array,
        residual_flexibility: Array,
        gap: Array,
        projected: Array,
        longest: float,
        limits: Integers | None = None,
    ) -> None:
        count, n_modes = len(gap), len(participation)
        self.oscillators, self.longest = oscillators, longest
        self._gap, self.projected = np.array(gap), np.array(projected)
        self._work = np.zeros((3, count))
        self.lcp = active_set.lcp_state(residual_flexibility)
        self.modes: ModalState = modal_state(oscillators, participation, residual_flexibility)
        self._factors: dict[float, StepFactors] = {}
        self._dt = -1.0
        self._elastic = np.zeros(count + n_modes)
        modes = self.modes
        kept = modes.filtered, modes.force, modes.earlier, modes.amplitude, self._elastic
        history = prony_history((oscillators.weights, oscillators.rates), count)
        no_limits = np.full(count, DONE, dtype=np.int64) if limits is None else limits
        super().__init__(self.lcp, history, no_limits, kept)

    @property
    def elastic(self) -> Array:
        """Elastic pressures (n_pad,) kPa on the residual flexibility, then amplitudes (n,)."""
        return self._elastic

    def factors(self, dt: float) -> StepFactors:
        """Return the factors of a step, computed once per length."""
        # Significant digits of the length of a step: lengths that differ by rounding are the same.
        digits = 9
        key = float(f"{dt:.{digits - 1}e}")
        if key not in self._factors:
            cached = 64  # lengths of steps whose factors are stored
            if len(self._factors) >= cached:
                self._factors.clear()
            self._factors[key] = self.make_factors(key)
        if key != self._dt:
            self.lcp.flexibility[:] = self._factors[key].flexibility
            self._dt = key
        return self._factors[key]

    def make_factors(self, dt: float) -> StepFactors:
        """Compute the factors of a step of `dt` s."""
        static, modes = not 0 < dt <= self.longest, self.modes
        parts = self.oscillators, modes.participation, modes.residual_flexibility
        return step_factors(*parts, dt, static=static)

    def _advance(self, dt: float, target: Target) -> int:
        arrays = self._gap, self.projected, self.limits, self._work
        outcome = _step(
            *(self.lcp, self.history, self.modes, self.factors(dt), self.search, *arrays),
            *(dt, target.value, target.by_force),
        )
        if outcome == DONE:
            count = len(self._gap)
            self._elastic[:count] = self.history.elastic
            self._elastic[count:] = self.modes.amplitude
        return int(outcome)

    def _rebuild(self) -> None:
        active_set.rebuild(self.lcp)
