"""Preliminary end organs of thesis 4.2.2: spring, damper, second derivative."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.neural.endorgans import PoleZero
from fefinger.support.checks import InputError, number


def spring(skin: float, organ: float, nerve: float) -> PoleZero:
    """Filter of three springs in series (Fig. 4-4a): the nerve's share of a skin displacement.

    k_s k_e / (k_s k_e + k_n (k_s + k_e)); Eq. 5.8 prints its limit for a stiff nerve. Stiffnesses
    above 0, in any one unit. Three dampers in series (Fig. 4-5a) share in the same way.
    """
    k_s = number("skin", skin, above=0.0)
    k_e = number("organ", organ, above=0.0)
    k_n = number("nerve", nerve, above=0.0)
    return PoleZero((), (), k_s * k_e / (k_s * k_e + k_n * (k_s + k_e)))


def derivative(*poles: float) -> PoleZero:
    """Filter that is a derivative below its poles, one order per pole.

    One pole: velocity in mm/s, the damper model that thesis 4.3.3 closes with a pole at 10 to 100
    Hz. Two distinct poles: acceleration in mm/s². Poles in Hz.
    """
    return PoleZero((0.0,) * len(poles), poles, math.prod(2.0 * math.pi * p for p in poles))


@dataclass(frozen=True)
class Derivative:
    """The pure derivative of order 1 or 2, for smooth inputs: the damper model of thesis 4.2.2.

    Divided differences, each at the mean of the times that it spans and linear in between: exact
    for polynomials of one degree more, of second order in the step otherwise, however uneven.
    """

    order: int

    def __post_init__(self) -> None:
        """Check the order."""
        if self.order not in (1, 2):
            msg = f"order: expected 1 or 2, received {self.order!r}"
            raise InputError(msg)

    def frequency_response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return (2 pi i f)^order at frequencies in Hz."""
        return (2j * np.pi * np.asarray(frequency, float)) ** self.order

    def respond(
        self, time: ArrayLike, x_in: ArrayLike, at: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """Return the derivative in mm/s^order of (n_t,) or (n_t, n_units) mm at times `at`.

        Raises InputError for too few times or a repeated one: a jump has no derivative.
        """
        time, x_in = np.asarray(time, float), np.asarray(x_in, float)
        if len(time) <= self.order or np.any(np.diff(time) <= 0):
            msg = (
                f"time: expected at least {self.order + 1} times that increase, for a derivative "
                "of a smooth input; use a filter with poles for an input that jumps"
            )
            raise InputError(msg)
        columns = x_in.reshape(len(time), -1)
        for k in range(1, self.order + 1):
            columns = k * np.diff(columns, axis=0) / (time[k:] - time[:-k])[:, None]
        spans = np.lib.stride_tricks.sliding_window_view(time, self.order + 1).mean(axis=1)
        wanted = time if at is None else np.asarray(at, float)
        out = np.column_stack([np.interp(wanted, spans, column) for column in columns.T])
        return out.reshape(wanted.shape + x_in.shape[1:])
