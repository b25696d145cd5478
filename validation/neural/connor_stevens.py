"""Connor-Stevens membrane: Hodgkin-Huxley with a fast transient potassium (A) current."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.membranes.firing import (
    Firing,
    Run,
    fired,
    in_blocks,
    largest_step,
    signals,
    trimmed,
)
from fefinger.support.arrays import Array
from fefinger.support.checks import number


BLOCK_AFTER = 0.010
"""Time in s, over the speed, from which a stay of more than 20 mV above rest without a spike is a
block; spikes are shorter."""

_FINEST = 1e-5
"""Longest step in s; spike times at 9 to 40 uA/cm² are right to 0.04 ms in the first 0.15 s."""


@dataclass(frozen=True)
class ConnorStevens:
    """Membrane with Hodgkin-Huxley currents and a fast transient potassium current: thesis 4.4.2.

    The A current opens below threshold and inactivates slowly, which delays the next spike: firing
    starts at any low rate, where HodgkinHuxley jumps to 50 Hz (10 Hz with rates / 6), at kinetics
    that are not slowed. At 16 Hz, where HodgkinHuxley(6) gives one impulse per cycle of A (1 - cos
    wt) at A = 6.25, 12.5, 25 and 50 uA/cm², this one gives 1, 4, 8 and 13.5; the frequency of one
    impulse per cycle depends on the amplitude. `transient` is the conductance of the A current in
    mS/cm²; at 20 and below the membrane fires without a stimulus. All rates are divided by
    `rate_divisor`.

    The nerve of a crab leg at 18 C. Connor, Walter & McKown (1977), Biophys J 18:81, as given by
    Dayan & Abbott (2001), Theoretical Neuroscience, section 6.6, Eq. 6.27 to 6.38. Spikes as in
    HodgkinHuxley: upward through 40 mV above rest, re-armed below 20 mV.
    """

    transient: float = 47.7
    rate_divisor: float = 1.0

    def __post_init__(self) -> None:
        """Check the two numbers."""
        number("transient", self.transient, at_least=30.0, at_most=60.0, unit="mS/cm²")
        number("rate_divisor", self.rate_divisor, at_least=1.0, at_most=100.0)

    def rest(self) -> Array:
        """Find the lowest state without net current: absolute potential in mV and n, m, h, a, b."""
        from fefinger.validation.neural import connor_stevens_compiled as compiled
        from scipy.optimize import brentq

        def state(e: float) -> Array:
            return np.array([e, *compiled.kinetics(e)[1::2]])

        def inward(e: float) -> float:
            total, drive = compiled.membrane(state(e), e, self.transient)
            return float(drive - total * e)

        scan = np.linspace(-80.0, 0.0, 801)
        first = int(np.argmax([inward(e) < 0.0 for e in scan]))
        return state(brentq(inward, scan[first - 1], scan[first], xtol=1e-13))

    def fire(
        self,
        time: ArrayLike,
        current: ArrayLike,
        *,
        dt: float | None = None,
        stimulus_driven: bool = True,
    ) -> Firing:
        """Integrate from rest; parameters and errors as `HodgkinHuxley.fire`.

        A Strang splitting, second order, with steps of at most `dt` and 1e-5 s. The five gates in
        `final` are n, m, h, a and b.
        """
        time_ms, columns = signals(time, current)
        step = 1e3 * min(largest_step(dt), _FINEST)
        return fired(partial(self._run, time_ms, columns, step), stimulus_driven=stimulus_driven)

    def _run(
        self,
        time_ms: Array,
        columns: Array,
        step: float,
        frozen: bool,
    ) -> Run:
        """Integrate all units: spike times in ms; per unit final state, peak in mV, ms in block."""
        from fefinger.validation.neural import connor_stevens_compiled as compiled

        rest = self.rest()
        numbers = self.transient, 1.0 / self.rate_divisor, 1e3 * BLOCK_AFTER * self.rate_divisor
        room = int(2.0 * (time_ms[-1] - time_ms[0])) + 16

        def unit(column: Array) -> Run:
            spikes = np.empty((1, room))
            count, peak, block, final = compiled.integrate(
                time_ms, column[:, 0], step, numbers, frozen, rest, spikes[0]
            )
            final[0] -= rest[0]
            return trimmed(spikes, np.array([count])), np.array([[*final, peak, block]])

        return in_blocks(unit, columns, 1)
