"""Consistent mass matrix of quadratic displacements on straight-sided tetrahedra."""

from collections.abc import Mapping

import numpy as np
from scipy import sparse
from skfem import Basis, ElementTetP2, MeshTet

from fefinger.fem.elements.assembly import scattered
from fefinger.fem.elements.spaces import Space


def mass(space: Space, densities: Mapping[int, float]) -> sparse.csr_matrix:
    """Return the symmetric mass matrix (n_displacements, n_displacements) of a space.

    `densities` gives the density of every label in `space.tissue`, in kg/mm³ for a matrix in kg: a
    force in mN is one in kg mm/s².
    """
    corners = space.points[space.vertices]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    heavy = volumes * np.array([densities[int(k)] for k in space.tissue])
    reference = Basis(MeshTet.init_refdom(), ElementTetP2(), intorder=4)
    shapes = np.array([np.asarray(f[0])[0] for f in reference.basis])
    products = (shapes * (6 * reference.dx[0])) @ shapes.T  # of a cell of volume 1
    nodes, shape = space.nodes, (space.n_nodes, space.n_nodes)
    values = heavy[:, None, None] * products
    scalar = scattered(values, nodes[:, :, None], nodes[:, None, :], shape)
    return sparse.kron(scalar.tocsr(), sparse.eye(3), format="csr")
