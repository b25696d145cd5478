"""Work of the stress of one elastic press on the deformation of a deeper one, for `pressed`.

The theory is in `theory/contact/ting.py`. K(a, d) is a sum over the integration points of the
stress at the depth a and the derivative of the strain at the depth d, which a spline through the
strains of all depths gives.
"""

from collections.abc import Sequence

import numpy as np

from fefinger.fem.hyperelastic.continuum import Continuum
from fefinger.support.arrays import Array


def work_ratios(elements: Continuum, states: Sequence[Array], depth: Array, force: Array) -> Array:
    """Ratios W (n, n) of the stress at a depth (row) and the deformation at another (column).

    states: unknowns (n_unknowns,) of the body at each of the depths (n,) mm, from 0; force (n,) at
    them, in any unit. Where a mesh resolves no contact, they are those of the first depth where it
    does. Above the diagonal W(a, d) is as computed; below it, where contact never asks for it, it
    continues as 2 - W(d, a), so that what is interpolated across the diagonal is 1 on it.
    """
    from scipy.interpolate import CubicSpline

    strain = np.array([elements.weighted_strain(each).ravel() for each in states])
    rows = [strain @ np.add(*elements.stress(each)).ravel() for each in states]
    root = np.sqrt(depth)
    slopes = CubicSpline(root, np.eye(len(root)))(root, 1)
    work = np.array(rows) @ slopes.T
    first = int(np.argmax(force > 0))
    ratio = np.ones_like(work)
    touching = work[first:, first:]
    ratio[first:, first:] = touching / touching.diagonal() * force[first:] / force[first:, None]
    ratio[:first, first:] = ratio[first, first:]
    upper = np.triu(ratio, 1)
    return np.eye(len(depth)) + upper + np.tril(2 - upper.T, -1)
