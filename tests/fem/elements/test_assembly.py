"""The compiled element loop: equal to scikit-fem's own forms, in a pattern made beforehand."""

from itertools import pairwise

import numpy as np
import pytest
from fefinger.validation.problems.grids import box
from skfem import Basis, BilinearForm, ElementTetP1, ElementTetP2, ElementVector
from skfem.helpers import ddot, div, sym_grad

from fefinger.fem.elements import assembly
from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.elements.spaces import Space


TISSUES = {1: Elastic(3.0, 0.3), 2: Elastic(50.0, 0.4999)}


@pytest.fixture
def space() -> Space:
    even = box(*3 * (np.linspace(0, 1, 4),))
    points = even.points + np.random.default_rng(0).uniform(-0.04, 0.04, even.points.shape)
    labels = np.where(np.arange(len(even.cells)) % 3, 1, 2).astype(np.int8)
    return Space(points, even.cells, labels)


def by_scikit_fem(space: Space, one: Elastic, label: int) -> tuple[np.ndarray, ...]:
    """Return A, B and M of the cells with a label, in scikit-fem's numbering."""
    mesh = space.scalar.mesh
    cells = np.flatnonzero(space.tissue == label)
    options = {"elements": cells, "intorder": 2}
    wide = Basis(mesh, ElementVector(ElementTetP2()), **options)
    narrow = Basis(mesh, ElementTetP1(), **options)

    @BilinearForm
    def shear(u, v, _):
        a, b = sym_grad(u), sym_grad(v)
        return 2 * one.shear * (ddot(a, b) - div(u) * div(v) / 3)

    volume = BilinearForm(lambda u, q, _: div(u) * q)
    mass = BilinearForm(lambda p, q, _: p * q)
    return (
        shear.assemble(wide).toarray(),
        volume.assemble(wide, narrow).toarray(),
        mass.assemble(narrow).toarray(),
        wide,
    )


def test_the_matrix_is_that_of_scikit_fem(space: Space) -> None:
    matrix = stiffness(space, TISSUES).toarray()
    expected = np.zeros_like(matrix)
    for label, one in TISSUES.items():
        a, b, m, wide = by_scikit_fem(space, one, label)
        ours = np.empty(wide.N, dtype=np.int64)
        cells = (3 * space.nodes[:, :, None] + np.arange(3)).reshape(len(space.cells), -1)
        ours[wide.dofs.element_dofs.T.ravel()] = cells.ravel()
        inside = space.tissue == label
        pressures = np.zeros(len(space.points), dtype=np.int64)
        pressures[space.vertices[inside]] = space.n_displacements + space.pressures[inside]
        has = np.unique(space.vertices[inside])
        p = pressures[has]
        scale = one.shear
        expected[np.ix_(ours, ours)] += a
        expected[np.ix_(p, ours)] += scale * b[has]
        expected[np.ix_(ours, p)] += scale * b[has].T
        expected[np.ix_(p, p)] -= scale**2 * one.compressibility * m[np.ix_(has, has)]
    assert np.abs(matrix - expected).max() < 1e-14 * np.abs(expected).max()
    assert np.array_equal(matrix, matrix.T)


def test_the_pattern_holds_all_pairs_of_a_cell_in_order(space: Space) -> None:
    unknowns = space.unknowns
    starts, columns = assembly.pattern(unknowns, space.n_unknowns)
    pairs = {(int(a), int(b)) for cell in unknowns for a in cell for b in cell}
    rows = np.repeat(np.arange(space.n_unknowns), np.diff(starts))
    assert set(zip(rows.tolist(), columns.tolist(), strict=True)) == pairs
    assert len(columns) == len(pairs)
    assert all((np.diff(columns[a:b]) > 0).all() for a, b in pairwise(starts))
