"""Work in threads: every part once, in order; results that do not depend on their number."""

import threading

import numpy as np
import pytest
from fefinger.validation.problems.grids import box
from threadpoolctl import threadpool_info, threadpool_limits

from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.hyperelastic.continuum import continuum
from fefinger.fem.hyperelastic.material import material_of
from fefinger.fem.linalg import multifrontal_indefinite
from fefinger.fem.linalg import system as solve
from fefinger.support import processes


@pytest.fixture(params=[1, 2, 5])
def count(request, monkeypatch):
    """Set a number of threads, whatever cores there are."""
    monkeypatch.setattr(processes, "threads", lambda: request.param)
    monkeypatch.setattr(processes, "_pool", lambda: pool)
    pool = processes.ThreadPoolExecutor(4)
    yield request.param
    pool.shutdown()


def test_every_blas_has_one_thread_and_then_as_many_as_before():
    def counts():
        return {each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"}

    with threadpool_limits(2, user_api="blas"):
        assert processes.one_thread(counts)() == {1}
        assert counts() == {2}


def test_the_values_are_those_of_the_parts_in_order(count):
    assert processes.together(lambda part: part**2, range(17)) == [part**2 for part in range(17)]
    assert processes.together(lambda part: part, []) == []


def test_parts_may_have_parts_of_their_own(count):
    def inner(part):
        return processes.together(lambda other: part * other, range(4))

    expected = [[part * other for other in range(4)] for part in range(6)]
    assert processes.together(inner, range(6)) == expected


def test_another_thread_takes_parts_while_this_one_works():
    """Each of two parts waits for the other to begin."""
    barrier = threading.Barrier(2)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(processes, "threads", lambda: 2)
        processes.together(lambda _: barrier.wait(timeout=20), range(2))


def test_a_failure_is_raised_and_ends_the_work(count):
    def fail(part):
        message = "a defect"
        raise IndexError(message)

    with pytest.raises(IndexError, match="a defect"):
        processes.together(fail, range(4))
    assert processes.together(abs, [-1, -2]) == [1, 2]


@pytest.fixture
def body():
    space = box(*3 * (np.linspace(0, 1, 6),))
    held = np.flatnonzero(np.repeat(space.node_points[:, 2] == 0, 3))
    return solve.prepare(space, stiffness(space, {1: Elastic(5.0, 0.4999)}), held)


def close(found, expected, part):
    """Whether no number is further off than a part of the largest."""
    return bool(np.abs(found - expected).max() <= part * np.abs(expected).max())


def test_factor_and_solution_are_the_same(count, body, monkeypatch):
    monkeypatch.setattr(multifrontal_indefinite, "STRIP", 64)  # several in a front of this body
    right = np.random.default_rng(0).normal(size=(len(body.free), 3))
    found = solve.approximate_factor(body.matrix, body)
    monkeypatch.setattr(processes, "threads", lambda: 1)
    alone = solve.approximate_factor(body.matrix, body)
    for branch, other in zip(found.branches, alone.branches, strict=True):
        assert close(branch.values, other.values, 1e-4)  # single precision
    assert found.negative == alone.negative
    expected = alone.solve(right)
    monkeypatch.setattr(processes, "threads", lambda: count)
    assert close(found.solve(right), expected, 1e-2)  # rounding, times the condition of the body
    assert close(found.solve(right[:, 0]), alone.solve(right[:, 0]), 1e-2)


def test_branches_are_disjoint_subtrees_and_the_fronts_above_them(body):
    fronts = body.dissection.fronts
    *branches, above = body.dissection.branches
    numbers = np.concatenate([*branches, above])
    assert np.array_equal(np.sort(numbers), np.arange(len(fronts)))
    assert len(branches) >= 4
    for branch in branches:
        inside = {part for number in branch for part in fronts[number].parts}
        assert inside == set(branch[:-1].tolist())


def test_internal_forces_are_the_same(count, body, monkeypatch):
    cells = continuum(body.space, {1: material_of(Elastic(5.0, 0.4999))})
    values = 0.002 * np.random.default_rng(1).normal(size=body.space.n_unknowns)
    found, least = cells.residual(values, cells.at_rest)
    stresses = cells.stress(values)
    monkeypatch.setattr(processes, "threads", lambda: 1)
    alone, same = cells.residual(values, cells.at_rest)
    assert close(found, alone, 1e-12)
    assert least == pytest.approx(same, rel=1e-12)
    assert same > 0
    for each, other in zip(stresses, cells.stress(values), strict=True):
        assert close(each, other, 1e-12)


@pytest.mark.parametrize(("limit", "expected"), [("", 3), ("1", 1), ("2", 2), ("8", 3)])
def test_threads_are_the_cores_or_fewer(limit, expected, monkeypatch):
    monkeypatch.setattr(processes, "cores", lambda: 3)
    monkeypatch.setenv(processes.THREADS, limit)
    assert processes.threads() == expected
