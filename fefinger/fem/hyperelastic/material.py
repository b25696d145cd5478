"""Material of a body at finite strain: a hyperelastic law with its moduli, and the law compiled.

The potential is mu W(I1, I2) + p (J - 1) - p² / 2K, with W of `fefinger.laws` and the pressure
p = K (J - 1) as an unknown of its own, so that K may be infinite.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from fefinger.fem.elements.forms import Elastic
from fefinger.laws import LAWS, NEO_HOOKEAN, Law
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number
from fefinger.support.compiled import callback


CompiledLaw = Callable[[float, float, Array], tuple[float, float, float, float, float, float]]
"""Law for the loops over elements: I1 - 3, I2 - 3 and parameters give W and its derivatives."""


@dataclass(frozen=True)
class Material:
    """One hyperelastic material.

    shear: mu in kPa; compressibility: 1 / K in 1/kPa; law, with the values of its parameters.
    """

    shear: float
    compressibility: float
    law: Law = NEO_HOOKEAN
    values: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        number("material.shear", self.shear, above=0, unit="kPa")
        number("material.compressibility", self.compressibility, at_least=0, unit="1/kPa")

    def energy(self, i1: Array, i2: Array) -> Array:
        """Return the energy of distortion in kPa at I1 - 3 and I2 - 3."""
        return self.shear * self.law.at(i1, i2, self.values).w

    @property
    def at_rest(self) -> tuple[float, float]:
        """Derivatives of the energy by I1 and I2 at rest in kPa, half of mu together."""
        rest = self.law.at(0.0, 0.0, self.values)
        return self.shear * float(rest.w1), self.shear * float(rest.w2)

    @property
    def row(self) -> Array:
        """The numbers (2 + n_parameters,) that the compiled loops take: mu, 1 / K, parameters."""
        return np.array([self.shear, self.compressibility, *self.values])


def material_of(elastic: Elastic, law: str = "neo-hookean", **parameters: float) -> Material:
    """Return the material of the law called `law` that is `elastic` at small strain."""
    chosen = LAWS.named("law", law)
    return Material(elastic.shear, elastic.compressibility, chosen, chosen.values(parameters))


@cache
def compiled(law: Law) -> CompiledLaw:
    """Compile a law, or read it from the cache of numba.

    Raises InputError for a function that numba does not compile.
    """
    try:
        function: CompiledLaw = callback(law.density, numbers=2, results=6)
    except TypeError as error:
        raise InputError(
            f"law {law.name!r}: expected a function that numba compiles, with numbers and "
            f"functions of NumPy alone, received {law.density.__qualname__}: {error}"
        ) from error
    return function
