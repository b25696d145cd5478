"""Material of a body at finite strain: a law with its moduli, compiled stress and moduli of it.

The potential is mu W(I1, I2) + p (J - 1) - p² / 2K, with W of `fefinger.laws` and the pressure
p = K (J - 1) as an unknown of its own, so that K may be infinite.

Everything is written in the gradient of the displacement, so that stress and J - 1 keep their
digits at the smallest strains. Symmetric tensors have the components xx yy zz xy yz xz.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from fefinger.fem.elements.assembly import Elastic
from fefinger.laws import LAWS, NEO_HOOKEAN, Law
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number
from fefinger.support.compiled import callback, njit


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


PAIRS = np.array([[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]])
"""Row and column of the six components."""

Work = tuple[Array, Array, Array, Array, Array]
"""E, the inverse of C, the derivatives (6,) of the two invariants by C, and scratch (3, 3)."""

State = tuple[float, float, float, float, float, float, float]
"""J - 1, J^(-2/3), and the derivatives of the energy in kPa by I1, I2, twice I1, both, twice I2."""

FAST = {"contract", "reassoc", "nsz", "arcp"}
"""LLVM fast-math flags without "nnan" and "ninf": a diverged iterate must stay inf or nan."""


@njit(cache=True, fastmath=FAST)
def _kinematics(gradient: Array, strain: Array, inverse: Array) -> float:
    """Fill the Green-Lagrange strain (3, 3) and the inverse of C (3, 3); return J - 1."""
    h = gradient
    for i in range(3):
        for j in range(3):
            total = h[i, j] + h[j, i]
            for k in range(3):
                total += h[k, i] * h[k, j]
            strain[i, j] = total / 2
    minors = (
        h[0, 0] * h[1, 1]
        - h[0, 1] * h[1, 0]
        + h[1, 1] * h[2, 2]
        - h[1, 2] * h[2, 1]
        + h[0, 0] * h[2, 2]
        - h[0, 2] * h[2, 0]
    )
    determinant = (
        h[0, 0] * (h[1, 1] * h[2, 2] - h[1, 2] * h[2, 1])
        - h[0, 1] * (h[1, 0] * h[2, 2] - h[1, 2] * h[2, 0])
        + h[0, 2] * (h[1, 0] * h[2, 1] - h[1, 1] * h[2, 0])
    )
    growth = h[0, 0] + h[1, 1] + h[2, 2] + minors + determinant
    a, b, c = 1 + 2 * strain[0, 0], 1 + 2 * strain[1, 1], 1 + 2 * strain[2, 2]
    d, e, f = 2 * strain[0, 1], 2 * strain[1, 2], 2 * strain[0, 2]
    square = (1 + growth) * (1 + growth)
    inverse[0, 0] = (b * c - e * e) / square
    inverse[1, 1] = (a * c - f * f) / square
    inverse[2, 2] = (a * b - d * d) / square
    inverse[0, 1] = inverse[1, 0] = (e * f - d * c) / square
    inverse[1, 2] = inverse[2, 1] = (d * f - a * e) / square
    inverse[0, 2] = inverse[2, 0] = (d * e - b * f) / square
    return growth


@njit(cache=True, fastmath=FAST)
def _product(inverse: Array, other: Array, factor: float, out: Array) -> None:
    """Fill the six components of factor * inverse @ dev(other), for tensors that commute."""
    mean = (other[0, 0] + other[1, 1] + other[2, 2]) / 3
    for row in range(6):
        i, j = PAIRS[row]
        total = -mean * inverse[i, j]
        for k in range(3):
            total += inverse[i, k] * other[k, j]
        out[row] = factor * total


@njit(cache=True, fastmath=FAST)
def _invariants(
    strain: Array, inverse: Array, logarithm: float, first: Array, second: Array, scratch: Array
) -> tuple[float, float, float]:
    """Fill the derivatives (6,) of the isochoric I1 and I2 by C.

    logarithm: of J^(-2/3). Return I1 - 3, I2 - 3 and J^(-2/3).
    """
    trace = strain[0, 0] + strain[1, 1] + strain[2, 2]
    shrunk = np.expm1(logarithm)
    volume = 1.0 + shrunk
    _product(inverse, strain, 2 * volume, first)
    square = 0.0
    for i in range(3):
        for j in range(3):
            total = (2 + 4 * trace) * strain[i, j]
            for k in range(3):
                total -= 4 * strain[i, k] * strain[k, j]
            scratch[i, j] = total
            square += strain[i, j] * strain[i, j]
    _product(inverse, scratch, volume * volume, second)
    minors = (trace * trace - square) / 2
    one = 3 * shrunk + 2 * trace * volume
    two = 3 * shrunk * (2 + shrunk) + 4 * (trace + minors) * volume * volume
    return one, two, volume


@njit(cache=True, fastmath=FAST)
def stresses(
    gradient: Array,
    pressure: float,
    law: CompiledLaw,
    row: Array,
    isochoric: Array,
    volumetric: Array,
    work: Work,
) -> State:
    """Fill the elastic stresses (6,) of the displacement gradient; row: as `Material.row`.

    Return J - 1, J^(-2/3) and the derivatives of the energy of the law, times mu.
    """
    strain, inverse, first, second, scratch = work
    growth = _kinematics(gradient, strain, inverse)
    if growth <= -1.0:
        return growth, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    one, two, volume = _invariants(
        strain, inverse, -2 / 3 * np.log1p(growth), first, second, scratch
    )
    _, w1, w2, w11, w12, w22 = law(one, two, row[2:])
    mu = row[0]
    for k in range(6):
        i, j = PAIRS[k]
        isochoric[k] = 2 * mu * (w1 * first[k] + w2 * second[k])
        volumetric[k] = pressure * (1 + growth) * inverse[i, j]
    return growth, volume, mu * w1, mu * w2, mu * w11, mu * w12, mu * w22


@njit(cache=True, fastmath=FAST)
def _right(strain: Array, c: Array) -> tuple[float, float]:
    """Fill C (3, 3) of the Green-Lagrange strain; return its first two invariants."""
    square = 0.0
    for i in range(3):
        for j in range(3):
            c[i, j] = 2 * strain[i, j] + (1.0 if i == j else 0.0)
            square += c[i, j] * c[i, j]
    trace = c[0, 0] + c[1, 1] + c[2, 2]
    return trace, (trace * trace - square) / 2


@njit(cache=True, fastmath=FAST)
def moduli_of(
    pressure: float,
    gains: Array,
    state: State,
    work: Work,
    moduli: Array,
) -> None:
    """Fill dS / dE (6, 6) of gains[0] S_iso + gains[1] S_vol; shear strains count twice.

    `state` is what `stresses` returned, with what it left in `work`.
    """
    growth, volume, w1, w2, w11, w12, w22 = state
    strain, inverse, first, second, c = work
    trace, minors = _right(strain, c)
    four = 4 * gains[0]
    p = gains[1] * pressure * (1 + growth)
    v1, v2 = four * w1 * volume, four * w2 * volume * volume
    a11, a12, a22 = four * w11, four * w12, four * w22
    for row in range(6):
        i, j = PAIRS[row]
        unit_r = 1.0 if i == j else 0.0
        for column in range(row, 6):
            k, m = PAIRS[column]
            unit_c = 1.0 if k == m else 0.0
            outer = inverse[i, j] * inverse[k, m]
            mixed = (inverse[i, k] * inverse[j, m] + inverse[i, m] * inverse[j, k]) / 2
            total = a11 * first[row] * first[column] + p * (outer - 2 * mixed)
            total += a12 * (first[row] * second[column] + second[row] * first[column])
            total += a22 * second[row] * second[column]
            total += v1 * (
                -(unit_r * inverse[k, m] + inverse[i, j] * unit_c) / 3
                + trace / 9 * outer
                + trace / 3 * mixed
            )
            if v2 != 0.0:
                identity = 0.0
                if row == column:
                    identity = 1.0 if i == j else 0.5
                b_r, b_c = trace * unit_r - c[i, j], trace * unit_c - c[k, m]
                total += v2 * (
                    unit_r * unit_c
                    - identity
                    - 2 / 3 * (b_r * inverse[k, m] + inverse[i, j] * b_c)
                    + 4 / 9 * minors * outer
                    + 2 / 3 * minors * mixed
                )
            moduli[row, column] = total
            moduli[column, row] = total


def at_point(material: Material, gradient: Array) -> tuple[Array, Array]:
    """Return the isochoric stress (6,) and its moduli (6, 6) in kPa of a displacement gradient.

    Both are relaxed, of the second Piola-Kirchhoff stress and the Green-Lagrange strain, whose
    shears count twice.
    """
    isochoric, volumetric, moduli = np.empty(6), np.empty(6), np.empty((6, 6))
    work = (np.empty((3, 3)), np.empty((3, 3)), np.empty(6), np.empty(6), np.empty((3, 3)))
    law, row = compiled(material.law), material.row
    given = np.ascontiguousarray(gradient, float)
    state = stresses(given, 0.0, law, row, isochoric, volumetric, work)
    moduli_of(0.0, np.ones(2), state, work, moduli)
    return isochoric, moduli


@njit(cache=True, fastmath=FAST)
def add_volumetric_stiffness(
    stiffness: float, growth: float, inverse: Array, moduli: Array
) -> None:
    """Add a volumetric stiffness, the second derivative of stiffness (dJ)² / 2, to the moduli.

    A stiffness of 2/3 mu turns 2 mu dev e : dev e into 2 mu e : e.
    """
    factor = stiffness * (1 + growth) * (1 + growth)
    for row in range(6):
        i, j = PAIRS[row]
        for column in range(6):
            k, m = PAIRS[column]
            moduli[row, column] += factor * inverse[i, j] * inverse[k, m]


@njit(cache=True)
def project_to_semidefinite(moduli: Array, stress: Array) -> None:
    """Replace the moduli (6, 6) and the stress (6,) by their positive parts."""
    values, vectors = np.linalg.eigh(moduli)
    if values[0] < 0:  # in loops: products of arrays and their copies take seconds to compile
        for row in range(6):
            for column in range(row + 1):
                total = 0.0
                for k in range(6):
                    total += max(values[k], 0.0) * vectors[row, k] * vectors[column, k]
                moduli[row, column] = moduli[column, row] = total
    full = np.empty((3, 3))
    for row in range(6):
        i, j = PAIRS[row]
        full[i, j] = full[j, i] = stress[row]
    values, vectors = np.linalg.eigh(full)
    if values[0] < 0:
        for row in range(6):
            i, j = PAIRS[row]
            total = 0.0
            for k in range(3):
                total += max(values[k], 0.0) * vectors[i, k] * vectors[j, k]
            stress[row] = total
