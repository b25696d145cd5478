"""Hyperelastic laws of soft tissue: strain energy of two invariants, and its derivatives.

W(I1, I2) is the energy of distortion for a shear modulus of 1. The invariants are isochoric, I1 =
J^(-2/3) tr C and I2 = J^(-4/3) (tr(C)² - tr C²) / 2 of C = F'F; the change of volume has an energy
of its own. `fem/hyperelastic/material.py` alone computes stress and moduli from W. Users add
a `Law` by `fefinger.register`.
"""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fefinger.support import registry
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number, shown
from fefinger.support.registry import Registry


LAWS: "Registry[Law]" = registry.LAWS
"""The laws of the package and of users, by name."""

STRETCHES = np.exp(0.1 * np.array([[1.0, -0.5], [-1.0, 0.5], [1.0, 0.0], [0.1, -0.1], [0.4, 0.4]]))
"""Two principal stretches (n, 2) of states without change of volume, in which a law is checked."""

STEP = 1e-4
"""Change of I1 and I2 for derivatives by differences."""

DERIVATIVES = ("W", "dW/dI1", "dW/dI2", "d²W/dI1²", "d²W/dI1dI2", "d²W/dI2²")


Values = tuple[Array | float, ...]


class Density(NamedTuple):
    """Strain energy for a shear modulus of 1, and its derivatives by I1 and I2."""

    w: Array
    w1: Array
    w2: Array
    w11: Array
    w12: Array
    w22: Array


@dataclass(frozen=True, eq=False)
class Law:
    """A hyperelastic law.

    Parameters
    ----------
    name
        By which a tissue chooses it, as "neo-hookean".
    density
        Function of I1 - 3, I2 - 3 and the list of its parameters that returns six numbers: the
        energy W for a shear modulus of 1, dW/dI1, dW/dI2, d²W/dI1², d²W/dI1dI2 and d²W/dI2². It
        is written with functions of NumPy, so that it takes arrays, and numba can compile it.
    parameters
        Names of the parameters with their defaults; None for one that a tissue has to give.
    """

    name: str
    density: Callable[[Array, Array, Array], Values]
    parameters: Mapping[str, float | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check that there is a function."""
        if not callable(self.density):
            raise InputError(
                f"law.density: expected a function of I1 - 3, I2 - 3 and the parameters, received "
                f"{shown(self.density)}"
            )

    def at(self, i1: ArrayLike, i2: ArrayLike, values: Sequence[float] = ()) -> Density:
        """Return energy and derivatives at I1 - 3 and I2 - 3, numbers or arrays of one shape.

        Raises
        ------
        InputError
            A function that fails, or that does not return six numbers.
        """
        one, two = np.broadcast_arrays(np.asarray(i1, float), np.asarray(i2, float))
        try:
            with np.errstate(all="ignore"):
                found = self.density(one, two, np.asarray(values, float))
                each = [np.broadcast_to(np.asarray(x, float), one.shape) for x in found]
        except Exception as error:
            raise InputError(
                f"law {self.name!r}: expected a function of I1 - 3, I2 - 3 and the parameters, "
                f"written with NumPy, received {type(error).__name__}: {error}"
            ) from error
        if len(each) != len(DERIVATIVES):
            raise InputError(
                f"law {self.name!r}: expected its function to return six numbers, "
                f"{', '.join(DERIVATIVES)}, received {len(each)}"
            )
        return Density(*each)

    def values(self, given: Mapping[str, float]) -> tuple[float, ...]:
        """Return the parameters in their order, with defaults where `given` has none.

        Raises
        ------
        InputError
            A parameter that is missing, unknown, or no finite number.
        """
        for name, value in given.items():
            if name not in self.parameters:
                raise InputError(
                    f"{name}: expected none for the law {self.name!r}, received {value!r}"
                )
        found = {name: given.get(name, default) for name, default in self.parameters.items()}
        for name, each in found.items():
            if each is None:
                raise InputError(f"{name}: missing; expected a number for the law {self.name!r}")
        return tuple(number(name, value) for name, value in found.items())

    def stiffening(self, i1: ArrayLike, i2: ArrayLike, values: Sequence[float]) -> Array:
        """Return the logarithm of dW/dI1 over its value at rest, 0 if that is not positive.

        For Demiray's law it is the exponent b (I1 - 3).
        """
        rest, now = self.at(0.0, 0.0, values), self.at(i1, i2, values)
        if not rest.w1 > 0:
            return np.zeros_like(now.w1)
        with np.errstate(all="ignore"):
            return np.asarray(np.log(now.w1 / rest.w1))

    def stiffens(self, values: Sequence[float]) -> bool:
        """Return whether a derivative of W, and so the stiffness, depends on the strain."""
        found = self.at(*_states(), values)
        return any(bool(np.any(each != 0)) for each in (found.w11, found.w12, found.w22))

    def check(self, values: Sequence[float]) -> None:
        """Compare the derivatives with differences of the energy, at rest and at STRETCHES.

        Stretches at which the energy is not finite are left out.

        Raises
        ------
        InputError
            A derivative that does not fit the energy; an energy at rest that is not 0; a shear
            modulus 2 (dW/dI1 + dW/dI2) at rest that is not 1.
        """
        _check(self, tuple(values))

    def _compare(self, values: Sequence[float]) -> None:
        rest = self.at(0.0, 0.0, values)
        modulus = 2 * float(rest.w1 + rest.w2)
        # Relative error of a derivative, by which rounding may differ from differences of the
        # energy.
        fits = 1e-6
        if not (abs(float(rest.w)) < fits and abs(modulus - 1) < fits):
            raise InputError(
                f"law {self._text(values)}: expected at rest an energy of 0 and a shear modulus "
                f"2 (dW/dI1 + dW/dI2) of 1, received {float(rest.w):.6g} and {modulus:.6g}; the "
                "modulus of the tissue multiplies the law"
            )
        i1, i2 = (np.append(0.0, each) for each in _states())
        exact = self.at(i1, i2, values)
        for k, by, source in ((1, 0, 0), (2, 1, 0), (3, 0, 1), (4, 1, 1), (4, 0, 2), (5, 1, 2)):
            slope, doubt = self._slope(i1, i2, values, source, by)
            wrong = ~(np.abs(exact[k] - slope) <= fits * (np.abs(exact[k]) + 0.5) + 2 * doubt)
            wrong &= np.isfinite(exact.w) & np.isfinite(slope)
            if wrong.any():
                n = int(np.argmax(wrong))
                raise InputError(
                    f"law {self._text(values)}: expected {DERIVATIVES[k]} = {slope[n]:.6g}, the "
                    f"difference of {DERIVATIVES[source]}, at I1 - 3 = {i1[n]:.4g} and I2 - 3 = "
                    f"{i2[n]:.4g}, received {exact[k][n]:.6g}; correct its function"
                )

    def _slope(
        self, i1: Array, i2: Array, values: Sequence[float], of: int, by: int
    ) -> tuple[Array, Array]:
        """Return the derivative of output `of` by I1 (`by` 0) or I2 (1), and its uncertainty."""

        def difference(step: float) -> Array:
            one, two = (step, 0.0) if by == 0 else (0.0, step)
            up, down = self.at(i1 + one, i2 + two, values), self.at(i1 - one, i2 - two, values)
            return np.asarray((up[of] - down[of]) / (2 * step))

        with np.errstate(all="ignore"):
            wide, narrow = difference(STEP), difference(STEP / 2)
            return (4 * narrow - wide) / 3, np.abs(narrow - wide)

    def fingerprint(self, values: Sequence[float]) -> str:
        """Return a hash of the energy and derivatives with these parameters."""
        numbers = np.concatenate(self.at(*_states(), values))
        text = ",".join(f"{each:.12g}" for each in numbers)
        return hashlib.sha256(text.encode()).hexdigest()

    def _text(self, values: Sequence[float]) -> str:
        numbers = [f"{k} = {v:g}" for k, v in zip(self.parameters, values, strict=True)]
        return f"{self.name!r}" + (f" with {', '.join(numbers)}" if numbers else "")


@lru_cache(maxsize=1024)
def _check(law: Law, values: tuple[float, ...]) -> None:
    """Check a law once: every tissue of every scene that is read asks for it."""
    law._compare(values)


def _states() -> tuple[Array, Array]:
    """Return I1 - 3 and I2 - 3 of STRETCHES."""
    squares = np.column_stack([STRETCHES, 1 / STRETCHES.prod(axis=1)]) ** 2
    return squares.sum(axis=1) - 3, (1 / squares).sum(axis=1) - 3


def _neo_hookean(i1: Array, i2: Array, p: Array) -> Values:
    return i1 / 2, 0.5, 0.0, 0.0, 0.0, 0.0


def _mooney_rivlin(i1: Array, i2: Array, p: Array) -> Values:
    share = p[0]
    return (share * i1 + (1 - share) * i2) / 2, share / 2, (1 - share) / 2, 0.0, 0.0, 0.0


def _demiray(i1: Array, i2: Array, p: Array) -> Values:
    b = p[0]
    grown = np.expm1(b * i1)
    rise = 1.0 + grown
    return grown / (2 * b), rise / 2, 0.0, b * rise / 2, 0.0, 0.0


def _veronda_westmann(i1: Array, i2: Array, p: Array) -> Values:
    b = p[0]
    grown = np.expm1(b * i1)
    rise = 1.0 + grown
    return grown / b - i2 / 2, rise, -0.5, b * rise, 0.0, 0.0


NEO_HOOKEAN = Law("neo-hookean", _neo_hookean)
"""W = (I1 - 3) / 2: the stiffness of Gaussian chains, with no stiffening."""

MOONEY_RIVLIN = Law("mooney-rivlin", _mooney_rivlin, {"share": 0.5})
"""W = [s (I1 - 3) + (1 - s) (I2 - 3)] / 2 (Mooney 1940, Rivlin 1948)."""

DEMIRAY = Law("demiray", _demiray, {"exponent": None})
"""W = (exp(b (I1 - 3)) - 1) / 2b (J. Biomech. 5:309, 1972)."""

VERONDA_WESTMANN = Law("veronda-westmann", _veronda_westmann, {"exponent": None})
"""W = (exp(b (I1 - 3)) - 1) / b - (I2 - 3) / 2 (J. Biomech. 3:111, 1970)."""
