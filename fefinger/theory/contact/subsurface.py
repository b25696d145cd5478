"""Displacement, strain and stress below an axisymmetric contact on a stack, by Hankel inversion.

The kernels of `stack.py` decay as exp(-xi z) and the transform of a contact's pressure is
known in closed form (`indentation.py`), so each component is one smooth integral over the
wavenumber. It is linear in the pressure: many contacts on one stack share the kernels and the
Bessel functions. Lengths in mm, moduli and stresses in kPa; z points into the body.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import j0, j1

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array
from fefinger.theory.contact.indentation import Contact, panels, panels_up_to
from fefinger.theory.contact.stack import Layer, Stack


@dataclass(frozen=True, eq=False)
class Field:
    """Displacement, strain and stress of n_c contacts at n_p points.

    displacement (n_c, 2, n_p) u_r and u_z in mm; strain (n_c, 4, n_p) and stress (n_c, 4, n_p) in
    kPa with the components r, theta, z and rz (tensor), positive in tension.
    """

    displacement: Array
    strain: Array
    stress: Array


def subsurface_field(
    stack: Stack, contacts: Sequence[Contact], r: ArrayLike, *, z: ArrayLike
) -> Field:
    """Compute the field below `contacts` on one `stack` at points r (n_p,), z (n_p,) in mm.

    ValueError for a contact on another body, r < 0, or z outside 0.02 a to the base.
    """
    r, z = elastic.points("subsurface_field", r, z)
    r, z = np.atleast_1d(r), np.atleast_1d(z)
    if not contacts or any(contact.body != stack for contact in contacts):
        msg = "subsurface_field: expected at least one contact, and only contacts with this stack"
        raise ValueError(msg)
    widest = max(contact.contact_radius for contact in contacts)
    # Smallest depth over the largest contact radius; the integral grows as its inverse.
    shallowest = 0.02
    if np.any(z < shallowest * widest):
        raise ValueError(
            f"subsurface_field: expected points at least {shallowest} contact radii = "
            f"{shallowest * widest:.3g} mm deep, received {z.min():.3g} mm; on the surface use the "
            f"pressure of the contact"
        )
    displacement = np.empty((len(contacts), 2, len(z)))
    strain = np.empty((len(contacts), 4, len(z)))
    stress = np.empty((len(contacts), 4, len(z)))
    shallow = float(z.min())
    decay = 28.0  # exponent at which the integrals are truncated: exp(-28) is 1e-12
    xi, weights = panels(
        1e-4 / min(stack.scales[1], shallow),
        decay / shallow,
        reach=float(r.max()) + widest,
    )
    loads = weights * np.array([contact.transform(xi) for contact in contacts])
    octave = np.floor(np.log2(z))
    for level in np.unique(octave):
        members = np.flatnonzero(octave == level)
        # Deeper points need fewer of the same wavenumbers, in whole panels.
        last = panels_up_to(xi, decay / float(z[members].min()))
        depths, place = np.unique(z[members], return_inverse=True)
        kernels = stack.depths(xi[:last], depths)
        for index, depth in enumerate(depths):
            here = members[place == index]
            layer = stack.layers[stack.locate(float(depth))[0]]
            parts = _integrate(loads[:, :last], layer, kernels[index], xi=xi[:last], r=r[here])
            displacement[:, :, here], strain[:, :, here], stress[:, :, here] = parts
    return Field(displacement, strain, stress)


def _integrate(
    loads: Array, layer: Layer, kernels: Array, *, xi: Array, r: Array
) -> tuple[Array, Array, Array]:
    """Integrate displacement, strain and stress (n_c, 2 or 4, n_p) at one depth.

    loads (n_c, n): transforms of the pressures times the weights; kernels (4, n) of the stack.
    """
    wave = np.multiply.outer(xi, r)
    even, odd = j0(wave), j1(wave)
    slide, sink, axial, shear = kernels
    nu, twice = layer.poisson, 2 * layer.shear
    stretch = ((1 - 2 * nu) * axial / twice - nu * slide) / (1 - nu)
    u_z, spread, strain_z, stress_z = (
        (loads * part) @ even for part in (sink, xi * slide, xi * stretch, xi * axial)
    )
    u_r, stress_rz = ((loads * part) @ odd for part in (slide, xi * shear))
    hoop = np.where(r > 0, u_r / np.where(r > 0, r, 1.0), spread / 2)
    strain = np.stack([spread - hoop, hoop, strain_z, stress_rz / twice], axis=1)
    # From sigma_z and strain differences, which stay finite in an incompressible layer.
    across = [stress_z + twice * (strain[:, i] - strain_z) for i in (0, 1)]
    stress = np.stack([*across, stress_z, stress_rz], axis=1)
    return np.stack([u_r, u_z], axis=1), strain, stress
