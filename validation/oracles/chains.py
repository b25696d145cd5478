"""End organs as chains of springs and dampers between skin and nerve ending.

Stiffnesses are in mN/mm and dampings in mN s/mm; for a displacement input only their ratios count.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.neural.endorgans import PoleZero, respond_modes
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number


@dataclass(frozen=True)
class SpringDamper:
    """A spring (mN/mm, 0 or more) and a damper (mN s/mm, above 0) in parallel."""

    stiffness: float
    damping: float

    def __post_init__(self) -> None:
        """Check the spring and the damper."""
        number("stiffness", self.stiffness, at_least=0.0, unit="mN/mm")
        number("damping", self.damping, above=0.0, unit="mN s/mm")

    @property
    def corner(self) -> float:
        """The corner frequency in Hz: stiffness / damping in rad/s, over 2 pi (Eq. 4.4)."""
        return self.stiffness / self.damping / (2.0 * np.pi)


@dataclass(frozen=True, kw_only=True)
class Chain:
    """Skin spring, spring-damper pairs of the end organ and nerve spring, all in series.

    One pair is the SA chain of Eq. B.21, two pairs the FA chain of Eq. B.27. Each pair gives a zero
    at its corner frequency. All elements carry the same force, so

        x_in / x_nerve = 1 / M + sum (K_n / b_i) / (s + z_i),  M = K_s / (K_s + K_n),

    which makes the poles the eigenvalues of diag(z) + v v', v_i² = K_s K_n / (K_s + K_n) / b_i:
    they interlace with the zeros, z1 < p1 < z2 < p2, whatever the springs and dampers. Pairs with
    the same corner act as one, and the chain loses a zero and a pole.

    Pawluk (1997), Eq. 4.3 to 4.5, B.21 to B.28.
    """

    skin: float
    organ: tuple[SpringDamper, ...]
    nerve: float

    def __post_init__(self) -> None:
        """Check the springs."""
        number("skin", self.skin, above=0.0, unit="mN/mm")
        number("nerve", self.nerve, above=0.0, unit="mN/mm")

    def displacement_filter(self) -> PoleZero:
        """Return x_nerve / x_in, dimensionless, for a displacement of the skin."""
        zeros, dampings = self._pairs()
        gain = self.skin / (self.skin + self.nerve)
        return PoleZero(zeros, _poles(zeros, dampings, gain * self.nerve), gain)

    def force_filter(self, parallel: float) -> PoleZero:
        """Return x_nerve / force in mm/mN with a spring in mN/mm beside the whole chain.

        Fig. 4-18: for a displacement the parallel spring changes nothing; of a force it takes its
        share. With none (0) the chain carries the whole force and every unit answers it as the
        bare nerve ending does, 1 / K_n (4.4.1). The zeros are those of the displacement filter,
        each pole lies between its zero and the pole there.
        """
        parallel = number("parallel", parallel, at_least=0.0, unit="mN/mm")
        if parallel == 0.0:
            return PoleZero((), (), 1.0 / self.nerve)
        zeros, dampings = self._pairs()
        stiffness = 1.0 / (1.0 / parallel + 1.0 / self.skin + 1.0 / self.nerve)
        gain = stiffness / (parallel * self.nerve)
        return PoleZero(zeros, _poles(zeros, dampings, stiffness), gain)

    def _pairs(self) -> tuple[tuple[float, ...], Array]:
        """Return the distinct corners in Hz, ascending, and the damping in series at each."""
        corners = np.array([pair.corner for pair in self.organ])
        zeros, which = np.unique(corners, return_inverse=True)
        mobility = np.bincount(which, [1.0 / pair.damping for pair in self.organ], len(zeros))
        return tuple(zeros.tolist()), 1.0 / mobility


def slow_chain(skin: float, organ: SpringDamper, nerve: float) -> Chain:
    """Return the chain of SA units (Fig. 4-6b, Eq. B.21)."""
    return Chain(skin=skin, organ=(organ,), nerve=nerve)


def fast_chain(skin: float, first: SpringDamper, second: SpringDamper, nerve: float) -> Chain:
    """Return the chain of FA units (Fig. 4-7b, Eq. B.27)."""
    return Chain(skin=skin, organ=(first, second), nerve=nerve)


def realize(organ: PoleZero, *, nerve: float = 1.0) -> Chain:
    """Return the chain with this displacement filter and this nerve spring in mN/mm.

    The inverse of `Chain.displacement_filter`, by partial fractions of x_in / x_nerve.

    Raises InputError where no springs and dampers have this filter: zeros and poles that do not
    interlace, as in the FAI and FAII filters of the thesis, or a gain that is not between 0 and 1.
    """
    nerve = number("nerve", nerve, above=0.0, unit="mN/mm")
    z, p = np.sort(organ.zeros), np.sort(organ.poles)
    ladder = np.column_stack([z, p]).ravel()
    if np.any(np.diff(ladder) <= 0):
        msg = (
            f"organ: expected zeros and poles that interlace, z1 < p1 < z2 < p2, as those of any "
            f"chain of springs and dampers do; received zeros {organ.zeros} and poles "
            f"{organ.poles} Hz; keep it as a filter"
        )
        raise InputError(msg)
    gain = number("organ.gain", organ.gain, above=0.0, below=1.0)
    pairs = []
    for i, zero in enumerate(z):
        others = np.prod(np.delete(z, i) - zero)
        damping = nerve * gain * others / (2.0 * np.pi * np.prod(p - zero))
        pairs.append(SpringDamper(2.0 * np.pi * zero * damping, damping))
    return Chain(skin=nerve * gain / (1.0 - gain), organ=tuple(pairs), nerve=nerve)


@dataclass(frozen=True)
class Resonant:
    """Filter gain prod(s + z) / prod(s + p) with complex pairs of poles, as `PoleZero` otherwise.

    zeros and poles in Hz; poles distinct, in conjugate pairs, with real parts above 0. No chain of
    springs and dampers has such poles.
    """

    zeros: tuple[float, ...]
    poles: tuple[complex, ...]
    gain: float

    def frequency_response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the ratio at frequencies in Hz, of any shape."""
        s = 1j * np.asarray(frequency, float)[..., None]
        return self.gain * ((s + self.zeros) / (s + self.poles)).prod(axis=-1)

    def respond(self, time: ArrayLike, x_in: ArrayLike, at: ArrayLike | None = None) -> Array:
        """Return the output for an input that is linear between its samples, exactly."""
        z, p = np.array(self.zeros), np.array(self.poles)
        residues = [np.prod(z - pole) / np.prod(np.delete(p, i) - pole) for i, pole in enumerate(p)]
        at_rest = self.gain * float(np.real(np.prod(z) / np.prod(p)))
        return respond_modes(
            at_rest, -self.gain * np.array(residues) / p, 2.0 * np.pi * p, time, x_in, at
        )


def under_force(organ: PoleZero, *, nerve: float, parallel: float) -> PoleZero | Resonant:
    """Return x_nerve / force in mm/mN of a filter H with a spring in mN/mm beside it.

    force = (K_parallel + K_nerve H) x_in, hence H / (K_parallel + K_nerve H). For filters that no
    chain realizes, as FAI and FAII; their poles become complex when the nerve spring is strong.

    Raises InputError for springs that are not positive, or two poles that coincide.
    """
    nerve = number("nerve", nerve, above=0.0, unit="mN/mm")
    parallel = number("parallel", parallel, at_least=0.0, unit="mN/mm")
    if parallel == 0.0:
        return PoleZero((), (), 1.0 / nerve)
    stiff = parallel + nerve * organ.gain
    shared = parallel * np.poly(-np.array(organ.poles)) + nerve * organ.gain * np.poly(
        -np.array(organ.zeros)
    )
    poles = -np.roots(shared)
    gaps = np.abs(np.subtract.outer(poles, poles)) + np.diag(np.full(len(poles), np.inf))
    if np.any(gaps < 1e-6 * np.abs(poles)):
        msg = f"parallel: two poles coincide at {parallel:g} mN/mm; change it by a percent"
        raise InputError(msg)
    if np.all(np.isreal(poles)):
        return PoleZero(organ.zeros, tuple(np.sort(poles.real).tolist()), organ.gain / stiff)
    return Resonant(organ.zeros, tuple(poles.tolist()), organ.gain / stiff)


def _poles(zeros: Sequence[float], dampings: Array, stiffness: float) -> tuple[float, ...]:
    """Return the poles in Hz of pairs in series with a spring: roots of 1 + sum k / b / (s + z)."""
    v = np.sqrt(stiffness / dampings / (2.0 * np.pi))
    return tuple(np.linalg.eigvalsh(np.diag(zeros) + np.outer(v, v)).tolist())
