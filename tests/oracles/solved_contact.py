"""Displacement of the surface and load within a radius, of a contact that `indentation` solved."""

import numpy as np
from numpy.polynomial import legendre
from scipy.special import j0

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array
from fefinger.theory.contact.indentation import Contact, spectrum


def surface_displacement(contact: Contact, r: Array) -> Array:
    """Displacement u_z (n,) of the surface in mm at r (n,) mm, inside and outside the contact."""
    a, series = contact.contact_radius, np.zeros(2 * len(contact.phi) - 1)
    series[::2] = contact.phi
    top = np.arcsin(np.where(r > a, a / np.where(r > a, r, a), 1.0))
    nodes, weights = legendre.leggauss(2 * len(contact.phi) + 8)
    t = r[:, None] * np.sin(top[:, None] * (nodes + 1) / 2)
    displacement = legendre.legval(t / a, series) @ weights * top / 2
    xi, weight = spectrum(contact.body, float(r.max()) + a)
    if len(xi):
        displacement -= j0(r[:, None] * xi) @ (weight * contact.transform(xi))
    return displacement * 2 / elastic.plane_modulus(*contact.body.surface)


def load_within(contact: Contact, r: Array) -> Array:
    """Force (n,) in mN within r (n,) mm of the axis, by quadrature of the pressure."""
    nodes, weights = legendre.leggauss(120)
    # r = a sin(s) removes the root in which the pressure ends.
    end = np.arcsin(np.minimum(r / contact.contact_radius, 1.0))[:, None]
    s = end / 2 * (nodes + 1)
    at = contact.contact_radius * np.sin(s)
    ring = contact.pressure(at) * at * contact.contact_radius * np.cos(s)
    return 2 * np.pi * (ring * end / 2) @ weights
