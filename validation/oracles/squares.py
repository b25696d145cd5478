"""Half-space under uniform pressures and tractions on squares: a boundary-element flexibility.

Independent of the finite elements: displacements at the centers of squares, in closed form.
Lengths in mm, moduli in kPa, forces in mN. Source: Love, Phil. Trans. R. Soc. A 228:377, 1929;
Johnson, Contact Mechanics, 1985, 3.3 and 3.6.
"""

import numpy as np

from fefinger.support.arrays import Array


def flexibility(places: Array, side: float, *, shear: float, poisson: float) -> Array:
    """Return F (3n, 3n): displacements times areas under unit stresses on squares at (n, 2) mm.

    Rows and columns are pressures (displacement into the body), then tractions along x and along y.
    """
    x, y = np.moveaxis(places[:, None] - places, 2, 0)
    h, count = side / 2, len(places)
    sums = {
        name: _square(kernel, x, y, h)
        for name, kernel in (("r", _inverse), ("xx", _xx), ("xy", _xy), ("x", _odd))
    }
    sums["yy"] = _square(_xx, y, x, h)
    sums["y"] = _square(_odd, y, x, h)
    nu, scale = poisson, side**2 / (2 * np.pi * shear)
    normal = (1 - nu) * sums["r"]
    along = (1 - nu) * sums["r"] + nu * sums["xx"]
    across = (1 - nu) * sums["r"] + nu * sums["yy"]
    both = nu * sums["xy"]
    # A pressure pulls the surface toward it; a traction sinks what lies ahead of it.
    radial = [-(1 - 2 * nu) / 2 * sums[name] for name in ("x", "y")]
    matrix = np.zeros((3, count, 3, count))
    matrix[0, :, 0], matrix[1, :, 1], matrix[2, :, 2] = normal, along, across
    matrix[1, :, 2] = matrix[2, :, 1] = both
    for k in (0, 1):
        matrix[k + 1, :, 0], matrix[0, :, k + 1] = radial[k], -radial[k]
    return scale * matrix.reshape(3 * count, 3 * count)


def _square(kernel: object, x: Array, y: Array, h: float) -> Array:
    """Integrate over a square of half side h about the origin by its antiderivative."""
    assert callable(kernel)
    return np.asarray(
        kernel(x + h, y + h) - kernel(x + h, y - h) - kernel(x - h, y + h) + kernel(x - h, y - h)
    )


def _inverse(x: Array, y: Array) -> Array:
    """Antiderivative of 1 / r."""
    return np.asarray(x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y)))


def _xx(x: Array, y: Array) -> Array:
    """Antiderivative of x² / r³."""
    return np.asarray(y * np.arcsinh(x / np.abs(y)))


def _xy(x: Array, y: Array) -> Array:
    """Antiderivative of x y / r³."""
    return -np.hypot(x, y)


def _odd(x: Array, y: Array) -> Array:
    """Antiderivative of x / r²."""
    return np.asarray(y * np.log(np.hypot(x, y)) + x * np.arctan2(y, np.abs(x)) * np.sign(x))
