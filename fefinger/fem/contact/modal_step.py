"""Contact of a body of viscoelastic modes with residual flexibility: compiled step, whole motion.

The displacement of the pad is u = R y + sum of phi_k a_k: R is the residual flexibility (the static
one less that of the modes, a static correction for the modes left out), y the elastic pressure as
in `step_compiled`, a_k the amplitudes of `oscillators`. A step ends at u = F p + what the past
left, with F = R / g + sum of phi_k b_k phi_k', b_k >= 0: contact is the complementarity problem of
statics with another F. What touches has no mass of its own but that of the modes, so that contact
opens and closes without chatter (Khenous, Laborde and Renard, Eur. J. Mech. A 27:918, 2008).
Pressures that alternate from step to step move no mode that swings: closed contact lets no error
grow, however long the step.

In a static step (a rest, too long for the modes) they deform as in statics; their own past goes on.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fefinger.fem.contact import lcp_compiled as contact
from fefinger.fem.contact.lcp_compiled import DONE, Floats, LcpState
from fefinger.fem.contact.oscillators import Complex, Oscillators
from fefinger.fem.contact.step_compiled import (
    Output,
    PadState,
    check,
    load_history,
    pad_state,
    reset,
    solve_target,
    store_history,
)
from fefinger.fem.contact.viscoelastic import History, Prescribed, increments
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import PRESS_LESS
from fefinger.support.compiled import njit
from fefinger.support.threads import one_thread


DIGITS = 9  # significant ones of the length of a step: lengths that differ by rounding are the same
CACHED = 64  # lengths of steps whose factors are stored


class ModalState(NamedTuple):
    """State of the modes and the factors of a step.

    participation (n, n_pad): work of each unit load on each mode; residual_flexibility (n_pad,
    n_pad): R, which the modes leave of that of statics; residues (n, s); filtered (n, s): the force
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
    pressed: NDArray[np.int64]
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
    dynamic = (oscillators.residues * after).sum(axis=1).real
    gains = 1.0 / (oscillators.omega_squared * g) if static else dynamic
    flexibility = residual_flexibility / g + (participation.T * gains) @ participation
    return StepFactors(
        *(decay, earlier, before, after, gains),
        np.ascontiguousarray((flexibility + flexibility.T) / 2),
        static,
    )


@njit(cache=True)
def modal_step(
    s: LcpState,
    m: PadState,
    o: ModalState,
    f: StepFactors,
    dt: float,
    target: float,
    by_force: bool,
    limits: NDArray[np.int64],
) -> int:
    """Advance by `dt` s to a depth in mm or a force in mN; return DONE or a failure.

    The contact pressure is then in s.x, the elastic one in m.elastic, the amplitudes in
    o.amplitude. limits (n_pad,): outcome of contact at a vertex, as in `step_compiled`. A step that
    fails leaves all as it was.
    """
    active, depth, peak = contact.save(s), m.depth[0], m.peak[0]
    g = load_history(m, dt)
    _free_amplitude(m, o, f, g)
    gap, past = np.empty(len(m.gap)), np.zeros(len(m.gap))  # the gap takes the past into account
    for j in range(len(gap)):
        gap[j] = m.gap[j] - m.moved_past[j] / g
    for k in range(len(o.free_amplitude)):
        a = o.free_amplitude[k]
        row = o.participation[k]
        for j in range(len(gap)):
            gap[j] += a * row[j]
    failed = solve_target(s, m, gap, past, 1.0, target, by_force)
    for j in range(len(s.x)):
        if failed == DONE and s.x[j] > 0.0:
            failed = limits[j]
    if failed == DONE:
        _store(s, m, o, f, dt, g)
    else:
        contact.restore(s, active)
        m.depth[0], m.peak[0] = depth, peak
    return failed


@njit(cache=True)
def release(s: LcpState, m: PadState, o: ModalState) -> None:
    """Reset pad and modes to rest: no contact and no history."""
    reset(s, m)
    o.filtered[:] = 0.0
    for row in (o.force, o.earlier, o.amplitude):
        row[:] = 0.0


@njit(cache=True)
def add_strain(out: Output, rows: Floats, amplitude: Floats) -> None:
    """Add the strain of modes to that of the pressures in an output; rows (n, n_strains)."""
    count = len(amplitude)
    contact.accumulate(out.strain, rows, np.arange(count), amplitude, count)


@njit(cache=True)
def _free_amplitude(m: PadState, o: ModalState, f: StepFactors, g: float) -> None:
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
def _store(s: LcpState, m: PadState, o: ModalState, f: StepFactors, dt: float, g: float) -> None:
    """Update the history of the pad and of the modes with the pressure at the end of a step."""
    count = contact.combine(o.moved, o.residual_flexibility, s.x, o.pressed, o.factor)
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


class ModalContact:
    """A body of modes with a pad, stepped through time from rest.

    participation (n, n_pad) and residual_flexibility (n_pad, n_pad) as in `ModalState`; gap
    (n_pad,) mm³ and projected (n_pad,) mm² of the patch; longest: length in s of a step beyond
    which modes deform as in statics; limits (n_pad,): outcome of contact at a vertex, DONE by
    default.
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
        self.oscillators, self.longest = oscillators, longest
        self.limits = np.zeros(len(gap), dtype=np.int64) if limits is None else limits
        self.lcp = contact.lcp_state(residual_flexibility)
        self.pad: PadState = pad_state(gap, projected, oscillators.weights, oscillators.rates)
        self.modes: ModalState = modal_state(oscillators, participation, residual_flexibility)
        self._factors: dict[float, StepFactors] = {}
        self._dt = -1.0

    def factors(self, dt: float) -> StepFactors:
        """Return the factors of a step, computed once per length."""
        key = float(f"{dt:.{DIGITS - 1}e}")
        if key not in self._factors:
            if len(self._factors) >= CACHED:
                self._factors.clear()
            static = not 0 < key <= self.longest
            modes = self.modes
            parts = self.oscillators, modes.participation, modes.residual_flexibility
            self._factors[key] = step_factors(*parts, key, static=static)
        if key != self._dt:
            self.lcp.flexibility[:] = self._factors[key].flexibility
            self._dt = key
        return self._factors[key]

    def step(self, dt: float, target: float, *, by_force: bool) -> int:
        """Advance by `dt` s to a depth in mm or a force in mN; return the outcome."""
        factors = self.factors(dt)
        lcp, pad, modes = self.lcp, self.pad, self.modes
        return int(modal_step(lcp, pad, modes, factors, dt, target, by_force, self.limits))


@dataclass(frozen=True)
class TimeGrid:
    """Times (n_t,) s of the steps, and the numbers (n_out,) of those that are stored.

    longest: length in s of the longest step in which the modes have inertia.
    """

    time: Array
    stored: Array
    longest: float


@one_thread
def march_modes(
    body: ModalContact,
    grid: TimeGrid,
    prescribed: Prescribed,
    progress: Callable[[float], None] = lambda fraction: None,
) -> History:
    """Compute the contact history of a body at rest before the first time.

    `prescribed` has the times of the grid. The `elastic_pressure` of the history holds those on the
    residual flexibility, and after them the amplitudes of the modes.

    Raises
    ------
    ConvergenceError
        If the contact or the depth under force control does not converge.
    """
    time, by_force = prescribed.time, prescribed.control == "force"
    body.pad.peak[0] = prescribed.value.max(initial=0.0)
    n_pad, n_modes, count = len(body.pad.gap), len(body.modes.force), len(grid.stored)
    depth, pressure = np.empty(count), np.empty((count, n_pad))
    elastic = np.empty((count, n_pad + n_modes))
    steps, row = np.diff(time, prepend=time[0]).tolist(), 0
    for k, (dt, target) in enumerate(zip(steps, prescribed.value.tolist(), strict=True)):
        check(body.step(dt, target, by_force=by_force), advice=PRESS_LESS)
        if k == grid.stored[row]:
            depth[row], pressure[row] = body.pad.depth[0], body.lcp.x
            elastic[row, :n_pad] = body.pad.elastic
            elastic[row, n_pad:] = body.modes.amplitude
            row += 1
            if k % 256 == 0:
                progress((k + 1) / len(time))
            if row == count:
                break
    progress(1.0)
    return History(depth, pressure, elastic, int(body.lcp.counts[contact.SOLVED]))
