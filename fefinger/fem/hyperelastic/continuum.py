"""Finite-strain hyperelastic body: residual, tangent and stress of its elements.

The unknowns of `spaces.Space`: displacements, then hydrostatic pressures in units of
`scale`. At rest the tangent is the matrix of `assembly.stiffness`.

The check of a hyperelastic law in the elements is a Taylor test of the tangent, and the uniaxial
stress.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import Basis, ElementTetP1, MeshTet

from fefinger.fem.elements import assembly
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic import element_kernels
from fefinger.fem.hyperelastic.element_kernels import Elements
from fefinger.fem.hyperelastic.material import CompiledLaw, Material, at_point, compiled
from fefinger.laws import LAWS, Law
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError
from fefinger.support.processes import together
from fefinger.support.tensors import VOIGT


INCOMPRESSIBLE = 12.0
"""Bulk over shear modulus: that of a Poisson's ratio of 0.46. At 0.45 a cube of Mooney-Rivlin
tissue squeezed to half folds at its corner where gaps are weighted over the deformed skin."""

ENGINEERING = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
"""Times that a component in the order of VOIGT counts in a product of two symmetric tensors."""

PARTS = 4
"""Parts of the cells that threads take, the same ones whatever their number."""


@dataclass(frozen=True)
class HistoryStress:
    """Relaxation factors and history stress of one step: S = g_d S_iso + g_v S_vol + past.

    gains (n_cells, 2): g_d and g_v, which the Prony series gives for the length of the step; past
    (n_cells, n_q, 6) kPa: the second Piola-Kirchhoff stress that remains of earlier steps.
    """

    gains: Array
    past: Array

    @property
    def gain(self) -> float:
        """Mean factor, which the tangent is about proportional to."""
        return float(self.gains.mean())


@dataclass(frozen=True)
class Continuum:
    """Element data of a body for the compiled loops.

    laws, with the cells (n,) that have each; materials, jacobians, weights, reference and shapes
    (times `scale` kPa) as in `Elements`; pattern: the matrix with all of its places; slots
    (n_cells, 34, 34): where each entry of a cell goes.
    """

    space: Space
    laws: tuple[tuple[Law, Integers], ...]
    materials: Array
    jacobians: Array
    weights: Array
    reference: Array
    shapes: Array
    scale: float
    pattern: sparse.csr_matrix
    slots: NDArray[np.int32]

    @property
    def at_rest(self) -> HistoryStress:
        """Factors of 1 and no history stress: a purely elastic step."""
        cells, points = self.weights.shape
        return HistoryStress(np.ones((cells, 2)), np.zeros((cells, points, 6)))

    @property
    def nearly_incompressible(self) -> bool:
        """Whether every tissue has a bulk modulus above INCOMPRESSIBLE times its shear modulus."""
        return bool((self.materials[:, 0] * self.materials[:, 1] * INCOMPRESSIBLE < 1).all())

    @cached_property
    def _parts(self) -> list[tuple[Integers, CompiledLaw]]:
        """Cells of the parts of a loop over all of them, each of one law."""
        parts = []
        for law, cells in self.laws:
            ends = np.linspace(0, len(cells), PARTS + 1).astype(int)
            parts += [(cells[slice(*each)], compiled(law)) for each in pairwise(ends.tolist())]
        return parts

    @property
    def _elements(self) -> Elements:
        return Elements(
            self.space.unknowns,
            self.jacobians,
            self.weights,
            self.reference,
            self.shapes,
            self.materials,
        )

    def residual(self, values: Array, history: HistoryStress) -> tuple[Array, float]:
        """Return the derivative (n_unknowns,) of the potential, and the smallest J."""
        elements = self._elements

        def part(each: tuple[Integers, CompiledLaw]) -> tuple[Array, float]:
            out = np.zeros_like(values)
            least = element_kernels.residual(
                values, elements, *each, history.gains, history.past, out
            )
            return out, float(least)

        outs, least = zip(*together(part, self._parts), strict=True)
        return np.sum(outs, axis=0), min(least)

    def tangent(
        self, values: Array, history: HistoryStress, *, consistent: bool = True
    ) -> sparse.csr_matrix:
        """Return the second derivative of the potential, symmetric.

        Unless `consistent`, its displacement block is made positive definite, so that it can be
        factored in every state: good to iterate with, and no derivative (see
        `element_kernels.tangent`).
        """
        data = np.zeros_like(self.pattern.data)
        for law, cells in self.laws:
            element_kernels.tangent(
                values,
                self._elements,
                cells,
                compiled(law),
                history.gains,
                history.past,
                self.slots,
                consistent,
                data,
            )
        return sparse.csr_matrix(
            (data, self.pattern.indices, self.pattern.indptr), shape=self.pattern.shape
        )

    def stress(self, values: Array) -> tuple[Array, Array]:
        """Return the isochoric and volumetric elastic stress (n_cells, n_q, 6) in kPa."""
        isochoric = np.empty((*self.weights.shape, 6))
        volumetric = np.empty_like(isochoric)

        elements = self._elements

        def part(each: tuple[Integers, CompiledLaw]) -> None:
            element_kernels.stress(values, elements, *each, isochoric, volumetric)

        together(part, self._parts)
        return isochoric, volumetric

    def weighted_strain(self, values: Array) -> Array:
        """Return the Green-Lagrange strain (n_cells, n_q, 6) times the weights, in mm³.

        Its shears count twice: its product with a second Piola-Kirchhoff stress is their work.
        """
        moved = values[self.space.unknowns[:, :30]].reshape(-1, 10, 3).swapaxes(1, 2)
        local = moved @ self.reference.swapaxes(0, 1).reshape(10, -1)
        gradient = (local.reshape(len(moved), -1, 3) @ self.jacobians).reshape(len(moved), 3, -1, 3)
        components = [
            gradient[:, i, :, j]
            + gradient[:, j, :, i]
            + (gradient[..., i] * gradient[..., j]).sum(1)
            for i, j in VOIGT
        ]
        strain = np.stack(components, axis=-1)
        return np.asarray(strain * self.weights[..., None] * ENGINEERING / 2)


def continuum(
    space: Space, tissues: Mapping[int, Material], soft: Collection[int] | None = None
) -> Continuum:
    """Return the elements of `space`, with the material of every label in `space.tissue`.

    `soft` are the labels whose stiffness sets the scale, all by default.

    Raises InputError if a cell has no volume.
    """
    corners = space.points[space.cells]
    if not (np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) > 0).all():
        message = "mesh: expected cells of positive volume, received a flat one; repair the mesh"
        raise InputError(message)
    basis = space.scalar
    quadrature = basis.quadrature
    linear = Basis(basis.mesh, ElementTetP1(), quadrature=quadrature)
    scale = max(each.shear for k, each in tissues.items() if soft is None or k in soft)
    present = {int(k): tissues[int(k)] for k in np.unique(space.tissue)}
    materials = np.zeros((len(space.cells), max(len(each.row) for each in present.values())))
    for label, each in present.items():
        materials[space.tissue == label, : len(each.row)] = each.row
    by_law: dict[Law, list[int]] = {}
    for label, each in present.items():
        by_law.setdefault(each.law, []).append(label)
    n, members = space.n_unknowns, space.unknowns
    starts, columns = assembly.pattern(members, n)
    return Continuum(
        space=space,
        laws=tuple(
            (law, np.flatnonzero(np.isin(space.tissue, labels))) for law, labels in by_law.items()
        ),
        materials=materials,
        jacobians=np.ascontiguousarray(space.jacobians),
        weights=np.ascontiguousarray(basis.dx),
        reference=space.shape_gradients(quadrature[0]).transpose(2, 0, 1).copy(),
        shapes=scale * np.array([np.asarray(f[0])[0] for f in linear.basis]).T.copy(),
        scale=scale,
        pattern=sparse.csr_matrix((np.zeros(len(columns)), columns, starts), shape=(n, n)),
        slots=element_kernels.slots(members, starts, columns),
    )


STEPS = (1e-3, 5e-4)
"""Lengths of the steps of the Taylor test, along displacements of .1 of the cube."""

ORDER = 1.9
"""Least order of the remainder; that of a tangent with a wrong entry is 1."""


def check_law(law: Law | str, **parameters: float) -> float:
    """Check a hyperelastic law, a `Law` or the name of one, with these parameters.

    Its derivatives are compared with differences of its energy, at stretches of some 1.1. Then the
    tangent of six elements that are deformed at random is compared with their residual: what a
    first-order Taylor series leaves out falls as the square of the step. Return the order that is
    found, which is about 2.

    Raises
    ------
    InputError
        An unknown law, parameters that are not its own, or derivatives that do not fit.
    """
    chosen = law if isinstance(law, Law) else LAWS.named("law", law)
    values = chosen.values(parameters)
    chosen.check(values)
    edge = np.linspace(0.0, 1.0, 2)
    mesh = MeshTet.init_tensor(edge, edge, edge)
    cells = np.ascontiguousarray(mesh.t.T, dtype=np.int64)
    space = Space(np.ascontiguousarray(mesh.p.T), cells, np.ones(len(cells), dtype=np.int8))
    compressibility = 0.1  # 1 / K over 1 / mu in the cube of the Taylor test
    body = continuum(space, {1: Material(1.0, compressibility, chosen, values)})
    at, along = np.random.default_rng(0).uniform(-0.05, 0.05, (2, space.n_unknowns))
    start, slope = body.residual(at, body.at_rest)[0], body.tangent(at, body.at_rest) @ along
    left = [
        np.linalg.norm(body.residual(at + h * along, body.at_rest)[0] - start - h * slope)
        for h in STEPS
    ]
    order = float(np.log2(left[0] / left[1]))
    if not order > ORDER:
        raise InputError(
            f"law {chosen.name!r}: expected a tangent whose Taylor remainder falls with order 2, "
            f"received order {order:.2f}; correct its second derivatives"
        )
    return order


def uniaxial(law: Law | str, stretch: Array, **parameters: float) -> Array:
    """Return the nominal stress (n,) over the shear modulus of incompressible tissue.

    stretch: (n,) of a bar that is pulled or pressed along its axis. The stress comes from the
    elements.

    Raises InputError for an unknown law, or parameters that are not its own.
    """
    chosen = law if isinstance(law, Law) else LAWS.named("law", law)
    material = Material(1.0, 0.0, chosen, chosen.values(parameters))
    nominal = np.empty(len(stretch))
    for k, along in enumerate(stretch):
        across = along**-0.5
        stress, _ = at_point(material, np.diag([along, across, across]) - np.eye(3))
        pressure = -stress[1] * across**2  # that leaves the sides free
        nominal[k] = along * (stress[0] + pressure / along**2)
    return nominal
