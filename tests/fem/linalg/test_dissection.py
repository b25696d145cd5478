"""The nested dissection orders all unknowns, and its cuts are the smallest ones."""

from itertools import product

import numpy as np
import pytest
from fefinger.validation.problems.grids import box
from scipy import sparse

from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg import dissection, multifrontal, multifrontal_indefinite
from fefinger.fem.linalg.dissection import dissect_space, smallest_cut
from fefinger.support.checks import InputError


LINE = np.linspace(0, 1, 5)


@pytest.fixture
def space() -> Space:
    return box(LINE, LINE, LINE)


def test_every_unknown_is_eliminated_once_displacements_before_pressures(space: Space) -> None:
    parts = dissect_space(space, np.arange(space.n_unknowns))
    assert np.array_equal(np.sort(parts.order), np.arange(space.n_unknowns))
    for front in parts.fronts:
        assert (front.rest >= front.stop).all()
        pivots = parts.order[front.start : front.stop]
        of_pressure = np.arange(len(pivots)) >= front.pressure - front.start
        assert ((pivots >= space.n_displacements) == of_pressure).all()


def test_no_cell_lies_on_both_sides_of_a_separator(space: Space) -> None:
    parts = dissect_space(space, np.arange(space.n_unknowns))
    side = np.zeros(space.n_unknowns, dtype=int)
    top = parts.fronts[-1]
    first = parts.fronts[top.parts[0]].stop  # children first: its half was ordered before
    side[parts.order[:first]] = 1
    side[parts.order[first : top.start]] = 2
    of_cells = side[space.unknowns]
    assert {1, 2} <= set(side)
    assert not ((of_cells == 1).any(axis=1) & (of_cells == 2).any(axis=1)).any()


def test_the_factor_is_sparse(space: Space) -> None:
    signs = np.where(np.arange(space.n_unknowns) < space.n_displacements, 1e-3, -1e-3)
    matrix = stiffness(space, {1: Elastic(1.0, 0.3)}) + sparse.diags(signs, format="csr")
    parts = dissect_space(space, np.arange(space.n_unknowns))
    stored = multifrontal.factor(matrix, parts)
    entries = sum(front.lower.size + front.below.size for front in stored.fronts)
    assert entries == parts.entries < 0.4 * space.n_unknowns**2


@pytest.mark.parametrize(("pivot", "coupling"), [(1e-10, 1e20), (1e-30, 1e20)])
def test_elimination_beyond_the_precision_is_refused_without_a_warning(
    space: Space, pivot: float, coupling: float
) -> None:
    parts = dissect_space(space, np.arange(space.n_unknowns))
    front, one = parts.fronts[0], sparse.lil_matrix((space.n_unknowns, space.n_unknowns))
    one.setdiag(np.where(np.arange(space.n_unknowns) < front.stop, pivot, 1.0))
    for number in front.rest:
        one[number, : front.stop] = coupling
        one[: front.stop, number] = coupling
    place = np.argsort(parts.order)
    with pytest.raises(InputError, match="singular"):
        multifrontal_indefinite.factor(one.tocsr()[place][:, place], parts)


@pytest.mark.parametrize("seed", range(6))
def test_a_cut_shares_as_few_unknowns_as_the_best_of_all_divisions(seed: int) -> None:
    n_cells, low = 11, 2
    rng = np.random.default_rng(seed)
    local = np.array([rng.choice(14, 4, replace=False) for _ in range(n_cells)])
    local = np.hstack([local, local[:, :1] + 14])  # an unknown with the same cells as another
    real = np.isin(np.arange(28), local) & (rng.random(28) > 0.1)
    order = rng.permutation(n_cells)

    def shared(first: np.ndarray) -> int:
        return len(set(local[first].flat) & set(local[~first].flat) & set(np.flatnonzero(real)))

    divisions = []
    for middle in product([False, True], repeat=n_cells - 2 * low):
        first = np.zeros(n_cells, dtype=bool)
        first[order[:low]], first[order[low:-low]] = True, middle
        divisions.append(shared(first))
    cut = smallest_cut(local, real, order, low)
    assert cut[order[:low]].all()
    assert not cut[order[-low:]].any()
    assert shared(cut) == min(divisions) < max(divisions)


def test_cells_without_unknowns_are_cut_too() -> None:
    space = box(LINE, LINE, np.linspace(0, 4, 9))
    held = (space.points[space.vertices][:, :, 2] < 2).any(axis=1)
    free = np.setdiff1d(np.arange(space.n_unknowns), space.unknowns[held])
    assert (~np.isin(space.unknowns, free)).all(axis=1).any()
    assert np.array_equal(np.sort(dissect_space(space, free).order), np.arange(len(free)))


def test_a_dissection_is_kept_for_the_same_cells_places_and_unknowns_alone(space: Space) -> None:
    every = np.arange(space.n_unknowns)
    first = dissect_space(space, every)
    assert dissect_space(box(LINE, LINE, LINE), every) is first
    some = every[5:]
    others = [
        dissect_space(space, some),
        dissect_space(space, every, last=every[:7]),
        dissect_space(box(LINE**2, LINE, LINE), every),
    ]
    assert all(other is not first for other in others)
    assert len(others[0].order) == len(some)
    assert set(others[1].order[-7:]) == set(every[:7])
    assert dissect_space(space, every) is first
    for k in range(1, dissection.KEPT + 1):
        dissect_space(space, every[k:])
    assert dissect_space(space, every) is not first
