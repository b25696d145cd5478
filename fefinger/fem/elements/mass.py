"""Consistent mass matrix of quadratic displacements on straight-sided tetrahedra.

On a reference tetrahedron the integrals of products of two shape functions are those of barycentric
coordinates, 6 V a! b! c! d! / (a + b + c + d + 3)!, so that no quadrature is needed.
"""

from collections.abc import Mapping
from itertools import product
from math import factorial

import numpy as np
from scipy import sparse

from fefinger.fem.elements.spaces import Space
from fefinger.support.arrays import Array


EDGES = (0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)
"""Edges of a cell in the order of the midside nodes of scikit-fem."""

Polynomial = dict[tuple[int, ...], float]


def mass(space: Space, densities: Mapping[int, float]) -> sparse.csr_matrix:
    """Return the symmetric mass matrix (n_displacements, n_displacements) of a space.

    `densities` gives the density of every label in `space.tissue`, in kg/mm³ for a matrix in kg: a
    force in mN is one in kg mm/s².
    """
    corners = space.points[space.vertices]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    heavy = volumes * np.array([densities[int(k)] for k in space.tissue])
    rows = np.repeat(space.nodes, 10, axis=1)
    columns = np.tile(space.nodes, (1, 10))
    values = heavy[:, None] * _reference().ravel()
    shape = (space.n_nodes, space.n_nodes)
    scalar = sparse.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=shape)
    return sparse.kron(scalar, sparse.eye(3), format="csr")


def _reference() -> Array:
    """Integrals (10, 10) of products of shape functions over a cell of volume 1."""
    shapes = _shapes()
    return np.array([[_integral(a, b) for b in shapes] for a in shapes])


def _shapes() -> list[Polynomial]:
    """Shape functions as polynomials in the barycentric coordinates: L (2 L - 1), and 4 L L'."""
    unit = np.eye(4, dtype=int)
    corners = [{tuple(2 * unit[i]): 2.0, tuple(unit[i]): -1.0} for i in range(4)]
    return corners + [{tuple(unit[a] + unit[b]): 4.0} for a, b in EDGES]


def _integral(first: Polynomial, second: Polynomial) -> float:
    total = 0.0
    for (powers, a), (others, b) in product(first.items(), second.items()):
        exponents = [p + q for p, q in zip(powers, others, strict=True)]
        share = 6 * np.prod([factorial(n) for n in exponents]) / factorial(sum(exponents) + 3)
        total += a * b * float(share)
    return total
