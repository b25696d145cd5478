"""End organs: mechanical filters from skin displacement to nerve displacement."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import GENERATORS


class Organ(Protocol):
    """A filter from skin to nerve displacement, with `respond` as in `PoleZero`."""

    def respond(self, time: ArrayLike, x_in: ArrayLike, at: ArrayLike | None = None) -> Array:
        """Return the output at times `at`, for an input that is zero before `time[0]`."""


@dataclass(frozen=True)
class PoleZero:
    """Filter X_out / X_in = M prod(s + z) / prod(s + p), as many zeros as poles.

    Parameters
    ----------
    zeros, poles
        Corner frequencies in Hz (z and p are 2 pi times these); poles above 0 and distinct, by a
        millionth at least.
    gain
        M, the gain at high frequency, dimensionless.

    Raises
    ------
    InputError
        Unequal numbers of zeros and poles, or corner frequencies that are not as above.

    Notes
    -----
    Pawluk (1997), Eq. 4.3 and 4.6. Evaluated as M (d + sum c_i s / (s + p_i)) with d = prod z /
    prod p, which needs only first differences of the input: jumps of velocity need no special
    treatment, and the output of a filter with a zero at 0 Hz is exactly 0 late in a hold.
    """

    zeros: tuple[float, ...]
    poles: tuple[float, ...]
    gain: float = 1.0

    def __post_init__(self) -> None:
        finite = all(math.isfinite(f) and f >= 0 for f in (*self.zeros, *self.poles))
        poles = np.sort(self.poles)
        # Smallest relative distance of two poles: partial fractions of nearer ones cancel.
        apart = 1e-6
        distinct = bool((np.diff(poles) > apart * poles[1:]).all())
        if len(self.zeros) != len(self.poles) or not (finite and distinct and all(self.poles)):
            raise InputError(
                "end organ: expected as many zeros as poles, zeros of 0 Hz or more and poles "
                f"above 0 Hz that differ by {apart:g} of themselves, received zeros {self.zeros} "
                f"and poles {self.poles} Hz"
            )

    def frequency_response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return X_out / X_in at frequencies in Hz, of any shape."""
        # In Hz: the 2 pi of as many zeros as poles cancel.
        s = 1j * np.asarray(frequency, float)[..., None]
        return self.gain * ((s + self.zeros) / (s + self.poles)).prod(axis=-1)

    def partial_fractions(self) -> tuple[float, Array, Array]:
        """Return (d, c, p): the filter is d + sum c_i s / (s + p_i), with p in rad/s."""
        z, p = np.array(self.zeros), np.array(self.poles)
        others = [np.prod(p[np.arange(len(p)) != i] - p[i]) for i in range(len(p))]
        residues = np.array([np.prod(z - p[i]) / others[i] for i in range(len(p))])
        at_rest = self.gain * float(np.prod(z / p))
        return at_rest, -self.gain * residues / p, 2.0 * np.pi * p

    def respond(self, time: ArrayLike, x_in: ArrayLike, at: ArrayLike | None = None) -> Array:
        """Filter an input that is linear between its samples, exactly.

        Parameters
        ----------
        time
            (n_t,) s, not decreasing; a repeated time is a jump of the input.
        x_in
            (n_t,) or (n_t, n_units) mm, zero before `time[0]` with the organ at rest.
        at
            (n_at,) s: output times within `time`; by default `time` itself.

        Returns
        -------
        (n_at,) or (n_at, n_units) mm.
        """
        return respond_modes(*self.partial_fractions(), time, x_in, at)


def respond_modes(
    at_rest: float,
    c: NDArray[np.inexact],
    p: NDArray[np.inexact],
    time: ArrayLike,
    x_in: ArrayLike,
    at: ArrayLike | None = None,
) -> Array:
    """Filter an input by at_rest + sum c_i s / (s + p_i), as `PoleZero.respond`.

    p (n_poles,) in rad/s with positive real parts; complex ones come in conjugate pairs, as do
    their c, and the output is real.
    """
    from fefinger.neural.endorgans_compiled import between

    time, x_in = np.asarray(time, float), np.asarray(x_in, float)
    columns = np.ascontiguousarray(x_in.reshape(len(time), -1))
    memory = _memory(time, columns, p)
    if at is None:
        out = at_rest * columns + np.einsum("i,tik->tk", c, memory).real
        return out.reshape(x_in.shape)
    at = np.asarray(at, float)
    k = np.clip(np.searchsorted(time, at, side="right") - 1, 0, max(len(time) - 2, 0))
    # After the last sample the input stays as it is.
    since, step = at - time[k], np.diff(time, append=time[-1])
    slope = np.diff(columns, axis=0, append=columns[-1:]) / np.where(step, step, np.inf)[:, None]
    out = between(at_rest, c, p, columns, slope, memory, k, since)
    return out.reshape(at.shape + x_in.shape[1:])


def modes_of(organs: Sequence[PoleZero]) -> tuple[Array, Array, Array]:
    """At rest (n,), weights (n, 2) and poles (n, 2) in rad/s of filters of one or two poles.

    As in `PoleZero.partial_fractions`; a mode that a filter lacks has no weight.
    """
    fractions = {organ: organ.partial_fractions() for organ in set(organs)}
    share, pole = np.zeros((len(organs), 2)), np.ones((len(organs), 2))
    for i, organ in enumerate(organs):
        _, c, p = fractions[organ]
        share[i, : len(c)], pole[i, : len(p)] = c, p
    return np.array([fractions[organ][0] for organ in organs]), share, pole


def chord_steps(
    organ: PoleZero, time: ArrayLike, x_in: ArrayLike, error: float, *, bend: float = 0.0
) -> Array:
    """Longest sampling step (n_t - 1,) in s, per interval of `time`, of the output of an organ.

    Straight lines between such samples deviate from the output by at most `error` mm in every
    column: the error of a chord is the curvature times step² / 8, and the curvature is largest just
    after the sample that begins an interval. `bend` in 1/mm, times the squared speed of the output,
    is the curvature that a generator behind the organ adds.
    """
    at_rest, c, p = organ.partial_fractions()
    time, x_in = np.asarray(time, float), np.asarray(x_in, float)
    columns, step = x_in.reshape(len(time), -1), np.diff(time)
    slope = np.diff(columns, axis=0) / np.where(step > 0, step, np.inf)[:, None]
    memory = _memory(time, columns, p)[:-1]
    bent, speed = np.zeros(slope.shape), np.abs(at_rest * slope)
    for i, pole in enumerate(p):
        fading = np.abs(c[i] * (pole * memory[:, i] - slope))
        bent += pole * fading
        speed += fading
    bent += bend * speed**2
    most = bent.max(axis=1, initial=0.0)
    return np.sqrt(8.0 * error / np.maximum(most, 1e-300))


def _memory(time: Array, columns: Array, p: NDArray[np.inexact]) -> NDArray[np.inexact]:
    """Integrals of exp(-p (t - s)) dx(s) up to every time, (n_t, n_poles, n_units)."""
    from fefinger.neural.endorgans_compiled import remember

    a = np.multiply.outer(np.diff(time), p)
    ramp = np.where(a != 0, -np.expm1(-a) / np.where(a != 0, a, 1.0), 1.0)
    out = np.empty((len(time), len(p), columns.shape[1]), p.dtype)
    # Zero before the first sample: its value is a jump, which every mode takes whole.
    out[0] = columns[0]
    remember(np.exp(-a), ramp, np.ascontiguousarray(columns), out)
    return out


END_ORGANS: dict[str, PoleZero] = {
    "SAI": PoleZero(zeros=(0.1,), poles=(1.0,)),
    "SAII": PoleZero(zeros=(0.5,), poles=(5.0,)),
    "FAI": PoleZero(zeros=(0.0, 0.0), poles=(1.0, 10.0)),
    "FAII": PoleZero(zeros=(0.0, 0.0), poles=(100.0, 1000.0)),
}
"""Filters of the afferent types, thesis 4.3.4, with M = 1.

The FA filters are phenomenological: the spring and damper chain of Eq. B.27 interlaces its zeros
and poles, so it cannot have both zeros at 0 Hz.
"""


LARGEST_CURRENT = 100.0
"""I_max of the saturating generator in µA/cm².

In constant current the peaks of Hodgkin-Huxley spikes fall below the 40 mV rule at 111 µA/cm²
(standard rates) and 113 (rates / 6); at 100 they reach 45 and 47 mV, so a generator that saturates
there never drives its membrane into depolarization block.
"""

GAINS: dict[str, float] = {"SAI": 319.9, "SAII": 101.0, "FAI": 127.0, "FAII": 13190.0}
"""Generator gains in µA/cm² per mm, fitted by one rule to published thresholds.

The rule: a unit just gives the defining response of its type when its skin is pressed at 4 mm/s to
the published threshold of the type and held there (the one-dimensional case of the thesis: the
whole displacement reaches the end organ). The response is sustained firing for SAI and SAII, one
spike for FAI and FAII; membrane with rates / 6, saturating generator. Values are rounded up to four
digits; `validation/neural/gains.py` has the thresholds with their sources, computes the gains again
and compares the rates with published ones.

Not fitted: the thesis filters pass a ramp ten times better than a hold, so an SA unit that fires in
the hold from its threshold on gives its first spike to a ramp of a few um (SAI 4, SAII 13), where
human units need about 60 and 300 um (Table 1 of doi:10.1152/jn.90990.2008), and its slowed membrane
keeps its rates below 27 Hz. Gains from those thresholds would be 14 and 5 times lower and leave
every SA unit silent in a hold of 1.5 mm.
"""

Gain = float | Array
"""Gain in µA/cm² per mm: one, or one per unit."""


def linear(x_nerve: Array, gain: Gain) -> Array:
    """Return I = A x in µA/cm² for x in mm and A in µA/cm² per mm (thesis Eq. B.18)."""
    return gain * x_nerve


def saturating(x_nerve: Array, gain: Gain) -> Array:
    """Return I = I_max (1 - exp(-A x / I_max)), which is A x for a small x.

    The saturation that thesis 4.4.3 asks for. The exponential is the law of a fixed number of
    channels of which each added displacement opens a fixed fraction; its form is a choice.
    """
    return -LARGEST_CURRENT * np.expm1(-gain * x_nerve / LARGEST_CURRENT)


Generator = Callable[[Array, Gain], Array]

GENERATOR_BY_NAME: dict[str, Generator] = dict(zip(GENERATORS, (saturating, linear), strict=True))


def transduce(
    kind: str,
    time: ArrayLike,
    x_in: ArrayLike,
    *,
    gain: Gain,
    generator: str = "saturating",
    at: ArrayLike | None = None,
    organ: Organ | None = None,
) -> Array:
    """Return the generator current in µA/cm² of an afferent type for a skin displacement in mm.

    End-organ filter, half-wave rectification (thesis Eq. B.19: no known coupling could pull the
    nerve ending, 4.2.1), generator. `time`, `x_in` and `at` as in `PoleZero.respond`; `organ`: the
    filter, by default the one of END_ORGANS.
    """
    x_nerve = np.maximum((organ or END_ORGANS[kind]).respond(time, x_in, at), 0.0)
    return GENERATOR_BY_NAME[generator](x_nerve, gain)
