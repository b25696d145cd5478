"""Strain-energy density of the elements, averaged to the vertices of the mesh.

The energy of distortion follows from the gradient at the integration points. That of the change of
volume is p² / 2K with the mean stress p of the elements, which is K times the projection of J - 1
(at small strain div u) on the linear functions of a tissue. J - 1 itself fluctuates about it from
point to point, and K / 2 (J - 1)² is wrong without bound as K grows. A vertex gets the mean of its
cells, weighted by their volumes: so the integral over the mesh is that over the elements.
"""

from collections.abc import Mapping

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import cg

from fefinger.fem.elements.assembly import scattered
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.material import Material
from fefinger.support.arrays import Array


class StoredEnergy:
    """Strain energy of some tissues of a body, from its displacement.

    materials: of the tissues, by their labels in `space.tissue`; `finite`: with their laws at
    finite strain; otherwise Hooke's law at small strain with the same moduli. tissue (n_cells,):
    the label of each of their cells.
    """

    def __init__(self, space: Space, materials: Mapping[int, Material], *, finite: bool) -> None:
        self.finite, self._materials = finite, materials
        chosen = np.isin(space.tissue, list(materials))
        basis, self.tissue = space.scalar, space.tissue[chosen]
        x, y, z = basis.quadrature[0]
        self._linear = np.column_stack([1 - x - y - z, x, y, z])  # (n_q, 4)
        gradients = space.shape_gradients(basis.quadrature[0])
        self._slopes = gradients.transpose(0, 2, 1).reshape(10, -1)  # (10, 3 n_q)
        self._nodes, self._vertices = space.nodes[chosen], space.vertices[chosen]
        self._jacobians = space.jacobians[chosen]
        self._weights = np.asarray(basis.dx)[chosen]  # (n_cells, n_q) mm³
        each = [materials[int(label)] for label in self.tissue]
        self._shear = np.array([one.shear for one in each])
        compressibility = np.array([one.compressibility for one in each])
        # Tissue that cannot change its volume has no energy of it.
        able = compressibility > 0
        self._bulk = np.where(able, 1 / np.where(able, compressibility, 1.0), 0.0)
        self._count = len(space.points)
        self._pressures = np.unique(space.pressures[chosen], return_inverse=True)[1].reshape(-1, 4)
        self._mass = self._projection_matrix()

    def cells(self, displacement: Array) -> tuple[Array, Array]:
        """Return the mean densities of distortion and of the change of volume (n_cells,) in kPa.

        Of the cells of the tissues, in their order, for a displacement (n_nodes, 3) in mm.
        """
        h = self._gradient(displacement)
        distortion, growth = self._finite(h) if self.finite else self._small(h)
        projected = self._projected(growth.T)
        mean = self._weights / self._weights.sum(axis=1, keepdims=True)
        of_shape = self._shear * (mean * distortion.T).sum(axis=1)
        return of_shape, self._bulk / 2 * (mean * projected**2).sum(axis=1)

    def stiffening(self, displacement: Array) -> float:
        """Return the mean of `Law.stiffening` over the tissues.

        displacement: (n_nodes, 3) mm.

        It is weighted by the energy of distortion without stiffening.
        """
        first, second, _ = self._invariants(self._gradient(displacement))
        whole = stiffer = 0.0
        for label, material in self._materials.items():
            cells = self.tissue == label
            one, two, (w1, w2) = first[:, cells], second[:, cells], material.at_rest
            softly = np.maximum(w1 * one + w2 * two, 0.0)  # rounding may be below
            energy = self._weights[cells].T * softly
            whole += float(energy.sum())
            stiffer += float((energy * material.law.stiffening(one, two, material.values)).sum())
        return stiffer / whole if whole > 0 else 0.0

    def at_vertices(self, density: Array) -> Array:
        """Return the mean (n_points,) of a density (n_cells,) over the cells at each vertex.

        It is 0 where none of the tissues is.
        """
        volume = np.repeat(self._weights.sum(axis=1), 4)
        where = self._vertices.ravel()
        total = np.bincount(where, volume, self._count)
        stored = np.bincount(where, volume * np.repeat(density, 4), self._count)
        return np.asarray(stored / np.where(total > 0, total, 1.0))

    def _gradient(self, displacement: Array) -> Array:
        """Gradient (3, 3, n_q, n_cells) of a displacement (n_nodes, 3) in mm."""
        local = np.moveaxis(displacement[self._nodes], 1, 2) @ self._slopes
        gradient = local.reshape(len(local), -1, 3) @ self._jacobians
        by_entry = gradient.reshape(len(local), 3, -1, 3).transpose(1, 3, 2, 0)
        return np.ascontiguousarray(by_entry)

    def _small(self, h: Array) -> tuple[Array, Array]:
        """Return e' : e' of the deviator, and div u, of a gradient h (3, 3, n_q, n_cells)."""
        strain = (h + h.swapaxes(0, 1)) / 2
        trace = h[0, 0] + h[1, 1] + h[2, 2]
        return (strain**2).sum(axis=(0, 1)) - trace**2 / 3, trace

    def _finite(self, h: Array) -> tuple[Array, Array]:
        """Return the energy of the isochoric invariants for a shear modulus of 1, and J - 1."""
        first, second, growth = self._invariants(h)
        energy = np.empty_like(first)
        for label, each in self._materials.items():
            cells = self.tissue == label
            energy[:, cells] = each.law.at(first[:, cells], second[:, cells], each.values).w
        return energy, growth

    def _invariants(self, h: Array) -> tuple[Array, Array, Array]:
        """Return the isochoric I1 - 3 and I2 - 3, and J - 1, of a gradient (3, 3, n_q, n_cells).

        They are written in the Green-Lagrange strain, so that small ones keep digits.
        """
        strain = (h + h.swapaxes(0, 1) + np.einsum("kiqe,kjqe->ijqe", h, h)) / 2
        trace = strain[0, 0] + strain[1, 1] + strain[2, 2]
        minors = (trace**2 - (strain**2).sum(axis=(0, 1))) / 2
        growth = _growth(h)
        volume = -2 / 3 * np.log1p(growth)
        first = 3 * np.expm1(volume) + 2 * trace * np.exp(volume)
        second = 3 * np.expm1(2 * volume) + 4 * (trace + minors) * np.exp(2 * volume)
        return first, second, growth

    def _projection_matrix(self) -> sparse.csr_matrix:
        """Mass matrix of the linear functions, apart per tissue."""
        block = np.einsum("eq,qa,qb->eab", self._weights, self._linear, self._linear)
        rows, count = self._pressures[:, :, None], int(self._pressures.max()) + 1
        return scattered(block, rows, self._pressures[:, None], (count, count)).tocsr()

    def _projected(self, values: Array) -> Array:
        """Return the projection (n_cells, n_q) of values at the integration points."""
        load = (self._weights * values) @ self._linear
        right = np.bincount(self._pressures.ravel(), load.ravel())
        inverse = sparse.diags(1.0 / self._mass.diagonal())
        projected = 1e-8  # relative residual of the projection
        nodal, _ = cg(self._mass, right, rtol=projected, M=inverse)
        return np.asarray(nodal[self._pressures] @ self._linear.T)


def _growth(h: Array) -> Array:
    """Return J - 1 of a displacement gradient (3, 3, ...)."""
    minors = (
        (h[0, 0] * h[1, 1] - h[0, 1] * h[1, 0])
        + (h[1, 1] * h[2, 2] - h[1, 2] * h[2, 1])
        + (h[0, 0] * h[2, 2] - h[0, 2] * h[2, 0])
    )
    determinant = (
        h[0, 0] * (h[1, 1] * h[2, 2] - h[1, 2] * h[2, 1])
        - h[0, 1] * (h[1, 0] * h[2, 2] - h[1, 2] * h[2, 0])
        + h[0, 2] * (h[1, 0] * h[2, 1] - h[1, 1] * h[2, 0])
    )
    return np.asarray(h[0, 0] + h[1, 1] + h[2, 2] + minors + determinant)
