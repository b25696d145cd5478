"""Quasi-linear viscoelasticity: Prony relaxation, its creep inverse and the hereditary integral.

The finite elements have a separate Prony update on purpose: an oracle shares no code with what it
checks.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


SUM_LIMITS = (0.98, 1.02)
"""Range of sums of weights that are normalized: published weights are rounded to two digits."""


def _numbers(name: str, values: Iterable[float]) -> tuple[float, ...]:
    """Check a list of finite numbers and convert it to a tuple of floats."""
    if isinstance(values, str | bytes) or not isinstance(values, Iterable):
        raise ValueError(f"prony.{name}: expected a list of numbers, received {values!r}")
    for value in (values := tuple(values)):
        real = isinstance(value, int | float | np.integer | np.floating)
        if isinstance(value, bool) or not real or not math.isfinite(value):
            raise ValueError(f"prony.{name}: expected finite numbers, received {value!r}")
    return tuple(float(value) for value in values)


@dataclass(frozen=True)
class Prony:
    """Reduced relaxation function G(t) = (c0 + sum ci exp(-vi t)) / sum c, so that G(0) = 1.

    Parameters
    ----------
    c
        Weights (c0, c1, ..., cn) as published, dimensionless; they sum to 0.98 to 1.02.
    v
        Rates (v1, ..., vn) in 1/s (the thesis calls them time constants).

    Raises
    ------
    ValueError
        Lengths that do not match, a weight below zero, c0 or a rate not above zero, or a sum of
        weights outside 0.98 to 1.02.

    Notes
    -----
    Pawluk (1997), Eq. 2.2, 3.5 and 3.12.
    """

    c: tuple[float, ...]
    v: tuple[float, ...]

    def __post_init__(self) -> None:
        """Check the weights and rates and store them as tuples of float."""
        object.__setattr__(self, "c", _numbers("c", self.c))
        object.__setattr__(self, "v", _numbers("v", self.v))
        if len(self.c) != len(self.v) + 1:
            raise ValueError(
                f"prony: expected one weight more than rates (c0 has no rate), "
                f"received {len(self.c)} weights c and {len(self.v)} rates v"
            )
        if self.c[0] <= 0 or min(self.c) < 0:
            msg = f"prony.c: expected c0 above 0 and no negative weight, received {list(self.c)}"
            raise ValueError(msg)
        if self.v and min(self.v) <= 0:
            raise ValueError(f"prony.v: expected rates above 0 1/s, received {list(self.v)}")
        low, high = SUM_LIMITS
        rounding = 1e-9  # of a sum of weights at a limit
        if not low - rounding <= math.fsum(self.c) <= high + rounding:
            raise ValueError(
                f"prony.c: expected weights that sum to {low} to {high}, received a sum of "
                f"{math.fsum(self.c):.4g}; if they are relative weights, divide them by their sum"
            )

    @property
    def weights(self) -> tuple[float, ...]:
        """Weights divided by their sum (Eq. 2.2), dimensionless, c0 first."""
        total = math.fsum(self.c)
        return tuple(value / total for value in self.c)

    @property
    def long_time(self) -> float:
        """G(infinity), the ratio of the relaxed to the instantaneous modulus."""
        return self.weights[0]

    @property
    def branches(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Weights (n,) of the exponentials over G(infinity), and their rates (n,) in 1/s."""
        return np.array(self.weights[1:]) / self.long_time, np.array(self.v)

    def relaxation(self, t: ArrayLike) -> NDArray[np.float64]:
        """Return G at the times `t` >= 0 in s, of any shape."""
        t = np.asarray(t, float)
        if np.any(~(t >= 0)):
            raise ValueError("relaxation: expected times t >= 0 s")
        weights = np.array(self.weights)
        return weights[0] + np.exp(-np.multiply.outer(t, np.array(self.v))) @ weights[1:]

    def creep(self) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
        """Return the reduced creep function J(t) = J_inf - sum k_j exp(-lam_j t), J(0) = 1.

        Returns
        -------
        J_inf : float
            1 / G(infinity).
        k : (n,) array
            Weights, not negative.
        lam : (n,) array
            Rates in 1/s, ascending; they interlace with the rates v.

        Notes
        -----
        The lam are the roots of w0 + sum w_i s / (s + v_i) at s = -lam, one below each rate: the
        eigenvalues of V - u u' with V = diag(v) and u_i = sqrt(w_i v_i). They are squares of the
        singular values of sqrt(V) [I - q q' / (1 + sqrt(w0))], q_i = sqrt(w_i), so that rates far
        apart keep their digits, and k_j = (u' x_j)² / lam_j of the eigenvectors x_j. Of terms with
        equal rates, and of those without weight, all but one or all have k = 0 and lam = v.
        """
        falling = np.argsort(self.v)[::-1]
        roots = np.sqrt(np.array(self.weights[1:])[falling])
        root_v = np.sqrt(np.array(self.v)[falling])
        rest = np.eye(len(roots)) - np.outer(roots, roots) / (1 + math.sqrt(self.long_time))
        vectors, values, _ = np.linalg.svd(root_v[:, None] * rest)
        lam = values[::-1] ** 2
        k = ((roots * root_v) @ vectors[:, ::-1]) ** 2 / lam
        return 1.0 / self.long_time, k, lam


ELASTIC = Prony((1.0,), ())
"""G of a body that does not relax."""


def in_series(prony: Prony, share: float, other: Prony = ELASTIC) -> Prony:
    """Return G of a body that relaxes with `prony` in series with one that does with `other`.

    share, 0 to below 1: the part of the compliance at t = 0 that the other body has.

    Notes
    -----
    The creep functions add: J = share J_2 + (1 - share) J_1, with J_1 = 1 + sum k_j (1 -
    exp(-lam_j t)) and J_2 alike. With w_j² = (1 - share) k_j lam_j of the terms of J_1, share k_j
    lam_j of those of J_2, the transform of G is s G(s) = 1 / (1 + sum w_j² / (s + lam_j)) = 1 - w'
    (s + diag(lam) + w w')^-1 w, so that the rates v are the eigenvalues of that matrix and the
    weights (w' x)² / v of its eigenvectors x.
    """
    if share == 0:
        return prony
    if not 0 < share < 1:
        raise ValueError(f"in_series: expected a share of 0 to below 1, received {share!r}")
    parts = (prony.creep(), 1 - share), (other.creep(), share)
    k = np.concatenate([part * each for (_, each, _), part in parts])
    lam = np.concatenate([each for (_, _, each), _ in parts])
    w = np.sqrt(k * lam)
    rates, vectors = np.linalg.eigh(np.diag(lam) + np.outer(w, w))
    weights = (w @ vectors) ** 2 / rates
    relaxed = 1 / (1 + k.sum())
    return Prony((relaxed, *weights.tolist()), tuple(rates.tolist()))


def exprel(z: ArrayLike) -> NDArray[np.float64]:
    """Return (exp(z) - 1) / z, 1 at 0, to full precision."""
    z = np.asarray(z, float)
    return np.where(z != 0, np.expm1(z) / np.where(z != 0, z, 1.0), 1.0)


def hereditary_integral(prony: Prony, time: ArrayLike, signal: ArrayLike) -> NDArray[np.float64]:
    """Integral of G(t - s) d signal(s) up to every time, exact for a piecewise linear signal.

    Parameters
    ----------
    prony
        The reduced relaxation function G.
    time
        (n_t,) s, not decreasing; a repeated time is a jump of the signal.
    signal
        (n_t,) or (n_t, k), zero before `time[0]`: the first value counts as a jump.

    Returns
    -------
    (n_t,) or (n_t, k) array in the unit of the signal.

    Raises
    ------
    ValueError
        Times that decrease, values that are not finite, or shapes that do not match.

    Notes
    -----
    Pawluk (1997), Eq. 2.3. Each exponential obeys q(t + dt) = q(t) e^-x + dsignal (1 - e^-x) / x
    with x = v dt, stable for any dt.
    """
    time, signal = checked_signal("hereditary_integral", time, signal, columns=True)
    flat, weights = signal.reshape(len(time), -1), np.array(prony.weights)
    x = np.multiply.outer(np.diff(time), np.array(prony.v))[:, :, None]
    decay, added = np.exp(-x), exprel(-x) * np.diff(flat, axis=0)[:, None]
    terms = np.empty((len(time), len(prony.v), flat.shape[1]))
    # At rest before: the first value is a jump, which every exponential takes whole.
    terms[0] = flat[0]
    if flat.shape[1] == 1:
        terms[:, :, 0] = recursion(decay[:, :, 0], added[:, :, 0], float(flat[0, 0]))
    else:
        for before, after, fading, more in zip(terms, terms[1:], decay, added, strict=False):
            np.multiply(fading, before, out=after)
            after += more
    out = weights[0] * flat + np.tensordot(weights[1:], terms, (0, 1))
    return out.reshape(signal.shape)


def recursion(
    decay: NDArray[np.float64], gain: NDArray[np.float64], start: float
) -> NDArray[np.float64]:
    """Compute q_0 = start and q_(n+1) = decay_n q_n + gain_n, (1 + n, m) for (n, m) of both.

    Notes
    -----
    Two steps in a row are a step of the same kind, so that log2(n) passes double the span of every
    step (Hillis and Steele, 1986): four times as fast as a loop in Python at a thousand steps.
    """
    q = np.concatenate([np.full((1, decay.shape[1]), start), gain])
    decay = np.concatenate([np.zeros((1, decay.shape[1])), decay])
    span = 1
    while span < len(q):
        q[span:] += decay[span:] * q[:-span]
        decay[span:] *= decay[:-span]
        span *= 2
    return q


def checked_signal(
    owner: str, time: ArrayLike, signal: ArrayLike, *, columns: bool = False
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Convert time (n_t,) and signal (n_t,), or with `columns` (n_t, k), to arrays.

    ValueError for other shapes, no sample, values that are not finite, or times that decrease.
    """
    time, signal = np.asarray(time, float), np.asarray(signal, float)
    if time.ndim != 1 or signal.ndim not in (1, 1 + columns) or not 0 < len(time) == len(signal):
        raise ValueError(
            f"{owner}: expected time (n_t,) and signal (n_t,){' or (n_t, k)' if columns else ''}, "
            f"received {time.shape} and {signal.shape}"
        )
    finite = np.isfinite(time).all() and np.isfinite(signal).all()
    if not (finite and np.all(np.diff(time) >= 0)):
        raise ValueError(f"{owner}: expected finite values and times that never decrease")
    return time, signal


def creep_integral(prony: Prony, time: ArrayLike, signal: ArrayLike) -> NDArray[np.float64]:
    """Integral of J(t - s) d signal(s) up to every time, with J the creep function (inverse of G).

    The inverse of `hereditary_integral`. For a force history it is the elastic force with the same
    contact, as long as the contact grows. Arguments and errors as there.

    Notes
    -----
    J = 1 + sum k_j (1 - exp(-lam_j t)), and each term r obeys, with x = lam dt, r(t + dt) = r e^-x
    + signal (1 - e^-x) + dsignal (1 - (1 - e^-x) / x), without cancellation at any creep strain.
    """
    time, signal = checked_signal("creep_integral", time, signal, columns=True)
    _, k, lam = prony.creep()
    x = np.multiply.outer(np.diff(time), lam)
    gains = -np.expm1(-x)
    # 1 - (1 - e^-x) / x, by its series where the difference cancels.
    late = np.where(x < 1e-4, x / 2 - x**2 / 6, 1.0 - exprel(-x))
    flat = signal.reshape(len(time), -1)
    creep = np.zeros((len(lam), flat.shape[1]))
    out = flat.copy()
    for i, change in enumerate(np.diff(flat, axis=0)):
        gain = gains[i][:, None]
        creep = creep + gain * (flat[i] - creep) + late[i][:, None] * change
        out[i + 1] += k @ creep
    return out.reshape(signal.shape)
