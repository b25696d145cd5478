"""Contact of a body of modes through a whole motion."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fefinger.fem.contact import lcp_compiled
from fefinger.fem.contact.modal_step import (
    ModalState,
    StepFactors,
    modal_state,
    modal_step,
    step_factors,
)
from fefinger.fem.contact.oscillators import Oscillators
from fefinger.fem.contact.step_compiled import PadState, check, pad_state
from fefinger.fem.contact.viscoelastic import History, Prescribed
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import PRESS_LESS
from fefinger.support.threads import one_thread


DIGITS = 9  # significant ones of the length of a step: lengths that differ by rounding are the same
CACHED = 64  # lengths of steps whose factors are stored


class ModalContact:
    """A body of modes with a pad, stepped through time from rest.

    participation (n, n_pad) and residual_flexibility (n_pad, n_pad) as in `modal_step`; gap
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
        self.lcp = lcp_compiled.lcp_state(residual_flexibility)
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
    contact: ModalContact,
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
    contact.pad.peak[0] = prescribed.value.max(initial=0.0)
    n_pad, n_modes, count = len(contact.pad.gap), len(contact.modes.force), len(grid.stored)
    depth, pressure = np.empty(count), np.empty((count, n_pad))
    elastic = np.empty((count, n_pad + n_modes))
    steps, row = np.diff(time, prepend=time[0]).tolist(), 0
    for k, (dt, target) in enumerate(zip(steps, prescribed.value.tolist(), strict=True)):
        check(contact.step(dt, target, by_force=by_force), advice=PRESS_LESS)
        if k == grid.stored[row]:
            depth[row], pressure[row] = contact.pad.depth[0], contact.lcp.x
            elastic[row, :n_pad] = contact.pad.elastic
            elastic[row, n_pad:] = contact.modes.amplitude
            row += 1
            if k % 256 == 0:
                progress((k + 1) / len(time))
            if row == count:
                break
    progress(1.0)
    return History(depth, pressure, elastic, int(contact.lcp.counts[lcp_compiled.SOLVED]))
