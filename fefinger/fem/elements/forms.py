"""Stiffness and mass matrices of small-strain isotropic elasticity.

The stiffness is that in displacement and mean stress (Herrmann).

For every v and q: integral of 2 mu dev eps(u) : dev eps(v) + p div v equals the load on v, and
integral of q div u - q p / K = 0; the mean stress p = K div u, and 1 / K = 0 at nu = 0.5.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from skfem import Basis, ElementTetP2, MeshTet

from fefinger.fem.elements import assembly
from fefinger.fem.elements.spaces import Space


@dataclass(frozen=True)
class Elastic:
    """Isotropic elasticity: Young's modulus in kPa and Poisson's ratio, 0 <= poisson <= 0.5."""

    modulus: float
    poisson: float

    @property
    def shear(self) -> float:
        """Shear modulus mu in kPa."""
        return self.modulus / (2 * (1 + self.poisson))

    @property
    def compressibility(self) -> float:
        """1 / K in 1/kPa, K the bulk modulus: 0 at nu = 0.5."""
        return 3 * (1 - 2 * self.poisson) / self.modulus


def stiffness(space: Space, tissues: Mapping[int, Elastic]) -> sparse.csr_matrix:
    """Return the symmetric matrix [[A, B'], [B, -M / K]] of the space, mN/mm and mm².

    Its shape is (n_unknowns, n_unknowns). `tissues` gives the elasticity of every label in
    `space.tissue`. A pressure is measured in units of the shear modulus of its own tissue, so that
    moduli 1e9 apart stay within rounding.
    """
    count, numbers = space.n_unknowns, space.unknowns
    starts, columns = assembly.pattern(numbers, count)
    data = np.zeros(len(columns))
    assembly.small_strain(
        space.points[space.vertices],
        numbers,
        np.array([tissues[int(k)].shear for k in space.tissue]),
        np.array([tissues[int(k)].compressibility for k in space.tissue]),
        starts,
        columns,
        data,
    )
    return sparse.csr_matrix((data, columns, starts), shape=(count, count))


def mass(space: Space, densities: Mapping[int, float]) -> sparse.csr_matrix:
    """Return the consistent mass matrix (n_displacements, n_displacements) of a space.

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
    scalar = assembly.scattered(values, nodes[:, :, None], nodes[:, None, :], shape)
    return sparse.kron(scalar.tocsr(), sparse.eye(3), format="csr")
