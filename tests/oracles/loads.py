"""Stress and displacement by loads on a half-space: point, line, strip, circle and rectangle.

Lengths in mm, moduli and stresses in kPa, forces in mN; z points into the body; stresses positive
in tension, loads positive in compression. Points on an edge of a load, where the stress is
infinite or has two values, are for the caller to avoid. Sources: Boussinesq, Flamant, Love 1929;
Johnson, Contact Mechanics, 1985, 2.3 to 3.4.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe, ellipkm1

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


def point_stress(r: ArrayLike, z: ArrayLike, *, force: float, poisson: float) -> Array:
    """Return sigma_r, sigma_theta, sigma_z, tau_rz (4, ...) in kPa below a normal point force.

    force in mN; r >= 0 and z > 0 in mm. Boussinesq.
    """
    r, z = np.broadcast_arrays(np.asarray(r, np.float64), np.asarray(z, np.float64))
    rho = np.hypot(r, z)
    # 1/r² - z/(rho r²), written so that it is regular on the axis.
    open_angle = 1 / (rho * (rho + z))
    scale, loose = force / (2 * np.pi), 1 - 2 * poisson
    return scale * np.array(
        [
            loose * open_angle - 3 * z * r**2 / rho**5,
            -loose * (open_angle - z / rho**3),
            -3 * z**3 / rho**5,
            -3 * r * z**2 / rho**5,
        ]
    )


def line_stress(x: ArrayLike, z: ArrayLike, *, line_force: float) -> Array:
    """Return sigma_x, sigma_z, tau_xz (3, ...) in kPa below a line force in mN/mm, z > 0."""
    x, z = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(z, np.float64))
    return -2 * line_force / np.pi * z / (x**2 + z**2) ** 2 * np.array([x**2, z**2, x * z])


def line_displacement(
    x: ArrayLike,
    z: ArrayLike,
    *,
    reference: float,
    line_force: float,
    modulus: float,
    poisson: float,
) -> Array:
    """Return u_x, u_z (2, ...) in mm below a line force in mN/mm, plane strain.

    u_z is relative to the surface at the distance `reference` mm: it has no absolute zero.
    """
    x, z = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(z, np.float64))
    scale = line_force / (2 * np.pi * elastic.shear_modulus(modulus, poisson))
    square = x**2 + z**2
    across = x * z / square - (1 - 2 * poisson) * np.arctan2(x, z)
    down = z**2 / square - (1 - poisson) * np.log(square / reference**2)
    return scale * np.array([across, down])


def strip_stress(x: ArrayLike, z: ArrayLike, *, half_width: float, pressure: float) -> Array:
    """Return sigma_x, sigma_z, tau_xz (3, ...) in kPa below a uniform pressure on |x| < w."""
    x, z = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(z, np.float64))
    first, second = np.arctan2(z, x - half_width), np.arctan2(z, x + half_width)
    turn = 2 * (first - second)
    sine = np.sin(2 * first) - np.sin(2 * second)
    cosine = np.cos(2 * first) - np.cos(2 * second)
    return pressure / (2 * np.pi) * np.array([-(turn + sine), -(turn - sine), cosine])


def flat_strip_pressure(x: ArrayLike, *, half_width: float, line_force: float) -> Array:
    """Return the pressure in kPa under a flat rigid strip with `line_force` mN/mm."""
    x = np.asarray(x, np.float64)
    inside = np.maximum(half_width**2 - x**2, 0.0)
    with np.errstate(divide="ignore"):
        shape = inside**-0.5
    return np.where(np.abs(x) <= half_width, line_force / np.pi * shape, 0.0)


def circle_axis_stress(z: ArrayLike, *, radius: float, pressure: float, poisson: float) -> Array:
    """Return sigma_r, sigma_z (2, ...) in kPa on the axis below a uniform pressure on a circle."""
    t = np.asarray(z, np.float64) / np.hypot(radius, z)
    radial = -(1 + 2 * poisson) / 2 + (1 + poisson) * t - t**3 / 2
    return pressure * np.array([radial, t**3 - 1])


def circle_displacement(
    r: ArrayLike, *, radius: float, pressure: float, modulus: float, poisson: float
) -> Array:
    """Return u_z in mm of the surface at r (...,) mm under a uniform pressure on a circle."""
    x = np.asarray(r, np.float64) / radius
    near = ellipe(np.minimum(x, 1.0) ** 2)
    inverse = 1 / np.maximum(x, 1.0)
    rest = 1 - inverse**2
    # rest * K tends to 0 at the edge, where K is infinite.
    far = ellipe(inverse**2) - rest * ellipkm1(np.maximum(rest, 1e-300))
    scale = 4 * pressure * radius / (np.pi * elastic.plane_modulus(modulus, poisson))
    return scale * np.where(x <= 1, near, x * far)


def rectangle_stress(
    place: ArrayLike, *, half_sides: tuple[float, float], pressure: float, poisson: float
) -> Array:
    """Return the stress tensor (..., 3, 3) in kPa below a uniform pressure on a rectangle.

    place (..., 3) mm from the middle of the rectangle |x| < half_sides[0], |y| < half_sides[1],
    with z > 0 into the body. Love 1929, by the derivatives of his
    potentials at the four corners.
    """
    x, y, z = np.moveaxis(np.asarray(place, np.float64), -1, 0)
    loose = 1 - 2 * poisson
    out = np.zeros((*x.shape, 3, 3))
    for sign, cx, cy in _corners(half_sides):
        big_x, big_y = x - cx, y - cy
        rho = np.sqrt(big_x**2 + big_y**2 + z**2)
        sunk = np.arctan2(big_x * big_y, z * rho)
        swell_x = big_x * big_y * z / ((big_x**2 + z**2) * rho)
        swell_y = big_x * big_y * z / ((big_y**2 + z**2) * rho)
        # chi_xx and chi_yy: an angle that vanishes on the axis of the corner, in one arctangent.
        turn_x = np.arctan2(big_y * big_x, rho * (rho + z) - big_y**2)
        turn_y = np.arctan2(big_x * big_y, rho * (rho + z) - big_x**2)
        out[..., 0, 0] += sign * (-2 * poisson * sunk + swell_x - loose * turn_x)
        out[..., 1, 1] += sign * (-2 * poisson * sunk + swell_y - loose * turn_y)
        out[..., 2, 2] += sign * (-sunk - swell_x - swell_y)
        out[..., 0, 1] -= sign * (loose * np.log(rho + z) + z / rho)
        # Up to a part that the corners cancel, so that no difference of large numbers is left.
        out[..., 0, 2] += sign * z**2 * big_y / (rho * (big_x**2 + z**2))
        out[..., 1, 2] += sign * z**2 * big_x / (rho * (big_y**2 + z**2))
    for i, j in ((0, 1), (0, 2), (1, 2)):
        out[..., j, i] = out[..., i, j]
    return pressure / (2 * np.pi) * out


def rectangle_displacement(
    place: ArrayLike,
    *,
    half_sides: tuple[float, float],
    pressure: float,
    modulus: float,
    poisson: float,
) -> Array:
    """Return u_z (...,) in mm of surface points (..., 2) mm under a uniform pressure (Love)."""
    x, y = np.moveaxis(np.asarray(place, np.float64), -1, 0)
    total = np.zeros(x.shape)
    for sign, cx, cy in _corners(half_sides):
        big_x, big_y = x - cx, y - cy
        for one, other in ((big_x, big_y), (big_y, big_x)):
            safe = np.where(one == 0, 1.0, np.abs(one))
            total += sign * np.where(one == 0, 0.0, one * np.arcsinh(other / safe))
    return pressure / (np.pi * elastic.plane_modulus(modulus, poisson)) * total


def _corners(half_sides: tuple[float, float]) -> list[tuple[int, float, float]]:
    """Return the sign and place of each corner of a rectangle in an integral over it."""
    return [(i * j, i * half_sides[0], j * half_sides[1]) for i in (1, -1) for j in (1, -1)]
