"""Small-strain isotropic elasticity in displacement and mean stress (Herrmann), assembled at once.

For every v and q: integral of 2 mu dev eps(u) : dev eps(v) + p div v equals the load on v, and
integral of q div u - q p / K = 0; the mean stress p = K div u, and 1 / K = 0 at nu = 0.5.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from skfem import Basis, ElementTetP1

from fefinger.fem.spaces import Array, Space


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

    `tissues` gives the elasticity of every label in `space.tissue`. The pressure is measured in
    units of the largest shear modulus, so that all blocks have like size.
    """
    shear = np.array([tissues[int(k)].shear for k in space.tissue])
    compressibility = np.array([tissues[int(k)].compressibility for k in space.tissue])
    scale = pressure_scale(tissues)
    gradients = _gradients(space)
    dx = space.scalar.dx
    linear = _linear(space)
    a = _shear_energy(gradients, dx * shear[:, None])
    b = _divergence(gradients, linear, dx * scale)
    weight = -(scale**2) * compressibility[:, None] * dx
    mass = np.einsum("iq,jq,eq->eij", linear, linear, weight)
    blocks = np.concatenate(
        [
            np.concatenate([a, b.transpose(0, 2, 1)], axis=2),
            np.concatenate([b, mass], axis=2),
        ],
        axis=1,
    )
    rows = np.broadcast_to(space.unknowns[:, :, None], blocks.shape).ravel()
    columns = np.broadcast_to(space.unknowns[:, None, :], blocks.shape).ravel()
    n = space.n_unknowns
    return sparse.coo_matrix((blocks.ravel(), (rows, columns)), shape=(n, n)).tocsr()


def pressure_scale(tissues: Mapping[int, Elastic]) -> float:
    """Return the pressure in kPa that one pressure unknown stands for."""
    return max(tissue.shear for tissue in tissues.values())


def _gradients(space: Space) -> Array:
    """Gradients of the scalar quadratics: (n_local, 3, n_cells, n_q)."""
    return np.array([f[0].grad for f in space.scalar.basis])


def _linear(space: Space) -> Array:
    """Linear shape functions at the quadrature points of the quadratics: (4, n_q)."""
    basis = Basis(space.scalar.mesh, ElementTetP1(), quadrature=space.scalar.quadrature)
    return np.array([np.asarray(f[0])[0] for f in basis.basis])


def _shear_energy(gradients: Array, weight: Array) -> Array:
    """Element matrices of mu (grad u : grad v + grad u : grad v' - 2/3 div u div v)."""
    n = len(gradients)
    outer = np.einsum("iaeq,jbeq,eq->eiajb", gradients, gradients, weight, optimize=True)
    trace = np.einsum("eiaja->eij", outer)
    full = outer.transpose(0, 1, 4, 3, 2) - (2 / 3) * outer
    for c in range(3):
        full[:, :, c, :, c] += trace
    return full.reshape(len(outer), 3 * n, 3 * n)


def _divergence(gradients: Array, linear: Array, weight: Array) -> Array:
    """Element matrices of q div u: (n_cells, 4, 3 n_local)."""
    block = np.einsum("kq,iaeq,eq->ekia", linear, gradients, weight, optimize=True)
    return block.reshape(len(block), len(linear), -1)
