"""Hooke's law, input checks of the closed forms, and the half-space under a moving load.

Axially symmetric stress and strain are arrays (4, ...): radial, hoop, axial and rz components,
positive in tension; the rz strain is the tensor component, half of the engineering shear.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray


Array = NDArray[np.float64]


def require_positive(owner: str, **values: float) -> None:
    """Raise ValueError unless every value is finite and above zero."""
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"{owner}: expected {name} above 0, received {value!r}")


def require_not_negative(owner: str, **values: float) -> None:
    """Raise ValueError unless every value is finite and zero or above."""
    for name, value in values.items():
        if not (math.isfinite(value) and value >= 0):
            raise ValueError(f"{owner}: expected {name} of 0 or above, received {value!r}")


def require_elastic(owner: str, modulus: float, poisson: float) -> None:
    """Raise ValueError unless the modulus is above zero and Poisson's ratio in 0 to 0.5."""
    require_positive(owner, modulus=modulus)
    if not 0 <= poisson <= 0.5:
        raise ValueError(f"{owner}: expected a Poisson's ratio in 0 to 0.5, received {poisson!r}")


def require_small(owner: str, name: str, value: float, *, limit: float, of: str) -> None:
    """Raise ValueError if the length `value` mm is above the `limit` mm of linear theory."""
    if value > limit:
        raise ValueError(
            f"{owner}: expected {name} of at most {of} {limit:g} mm (small strain), received "
            f"{value:g} mm"
        )


def points(owner: str, r: ArrayLike, z: ArrayLike) -> tuple[Array, Array]:
    """Broadcast r and z; ValueError for a point outside the body."""
    r, z = np.broadcast_arrays(np.asarray(r, np.float64), np.asarray(z, np.float64))
    inside = np.all(r >= 0) and np.all(z >= 0)
    if not (inside and np.isfinite(r).all() and np.isfinite(z).all()):
        raise ValueError(f"{owner}: expected finite r >= 0 and z >= 0 mm (z points into the body)")
    return r, z


def numbers(
    owner: str, name: str, values: ArrayLike, *, least: float = -math.inf, above: float = -math.inf
) -> Array:
    """Convert values (...,) to an array; ValueError unless they are finite and in range."""
    array = np.asarray(values, np.float64)
    wrong = array[~(np.isfinite(array) & (array >= least) & (array > above))]
    if wrong.size or not array.size:
        limit = f" of {least:g} or more" if least > -math.inf else ""
        limit = f" above {above:g}" if above > -math.inf else limit
        received = f"{wrong.flat[0]:g}" if wrong.size else "none"
        raise ValueError(f"{owner}: expected finite {name}{limit}, received {received}")
    return array


def plane_modulus(modulus: float, poisson: float) -> float:
    """Contact modulus E* = E / (1 - nu²) under a rigid indenter."""
    return modulus / (1 - poisson**2)


def shear_modulus(modulus: float, poisson: float) -> float:
    """Shear modulus G = E / 2(1 + nu)."""
    return modulus / (2 * (1 + poisson))


def strain(stress: Array, modulus: float, poisson: float) -> Array:
    """Strain (4, ...) of an axially symmetric `stress` (4, ...) by Hooke's law."""
    require_elastic("strain", modulus, poisson)
    radial, hoop, axial, shear = stress
    trace = poisson * (radial + hoop + axial)
    grow = 1 + poisson
    normal = [grow * part - trace for part in (radial, hoop, axial)]
    return np.array([*normal, grow * shear]) / modulus


def amplification(speed: float) -> float:
    """Relative growth of the displacement of a half-space when its line load moves steadily.

    `speed`: over the speed of shear waves, M; incompressible body. The displacement is
    2 M² / [4 a - (1 + a²)²] times the one at rest, with a = sqrt(1 - M²) (Cole and Huth, J. Appl.
    Mech. 25:433, 1958); less 1 it is returned, infinite from the Rayleigh speed, M = 0.955, on.
    """
    # Speed over the speed of shear waves below which the limit of the quotient 0 / 0 is taken.
    still = 1e-3
    if speed < still:
        return 0.75 * speed**2
    a = math.sqrt(max(0.0, 1.0 - speed**2))
    rayleigh = 4 * a - (1 + a**2) ** 2
    return 2 * speed**2 / rayleigh - 1 if rayleigh > 0 else math.inf
