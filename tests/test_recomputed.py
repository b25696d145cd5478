"""The search for comparisons that hang on the processor finds each kind of them, and no other."""

import ast
import json
from dataclasses import dataclass

import numpy as np
import pytest
from _pytest.assertion import rewrite
from recomputed import RecomputedError, compile_share, watch


@dataclass(frozen=True)
class Pair:
    """A record of floats."""

    a: float
    b: tuple[float, ...] = ()


def run(line: str) -> None:
    """Run a statement between two ways to one number, as it is run in a test."""
    tree = ast.parse(line)
    watch(tree, line)
    one, two = np.log([2.0, 3.0]), np.log([2.0, 3.0])
    names = {"np": np, "json": json, "pytest": pytest, "Pair": Pair, "one": one, "two": two}
    x, y = float(one[0]), float(two[0])
    exec(compile(tree, "test", "exec"), names | {"x": x, "y": y, "digits": one.astype(np.float32)})


@pytest.mark.parametrize(
    "line",
    [
        "assert x == y",
        "assert x == 0.6931471805599453",
        "assert not x != y",
        "assert x <= y",
        "assert x == y == 0.6931471805599453",
        "assert 0 < x <= y < 1",
        "assert one.min() >= y",
        "assert (one == two).all()",
        "assert not (one != two).any()",
        "assert (digits == digits.copy()).all()",
        "assert (1j * one == 1j * two).all()",
        "assert one.tolist() == two.tolist()",
        "assert {'scenes': 3, 'ratio': [x, None]} == {'scenes': 3, 'ratio': [y, None]}",
        "assert {x, 2.5} == {y, 2.5}",
        "assert Pair(1.5, (x,)) == Pair(1.5, (y,))",
        "assert np.array_equal(one, two)",
        "assert all(map(np.array_equal, [one], [two]))",
        "np.testing.assert_array_equal(one, two)",
        "assert json.dumps([x]) == json.dumps([y])",
        "# exact:\nassert x == y",
        "class Ring:\n    def near(self):\n        return x == y\nRing().near()",
    ],
)
def test_equality_of_floats_that_were_computed_apart_is_refused(line):
    with pytest.raises(RecomputedError, match="expected a tolerance between floats"):
        run(line)


@pytest.mark.parametrize(
    "line",
    [
        "assert x == pytest.approx(y)",
        "assert x == x and [x] == [x] and (one == one).all()",
        "assert (one[::-1][::-1] == one).all()",
        "assert x == y  # exact: a logarithm of one number, twice",
        "# exact: a logarithm of one number, twice\nassert x == y",
        "# exact: a logarithm of one number, twice\nassert [\n    x == y\n]",
        "assert 1.25 == 5 / 4 and 0.1 == float('0.1')",
        "assert np.array_equal([0.0, 0.1], np.array([0.0, 0.1]))",
        "assert x != y + 1e-9 and x <= y + 1e-9",
        "assert 0 <= x < 1 and not 1 <= x <= y and 1 == len([x]) != 2 and x is not y in [y]",
        "assert not np.array_equal(one, two * [1, 1.1])",
        "assert np.nan != x and (np.zeros(2) == 0.0).all() and np.array_equal(['a'], ['a'])",
        "assert 'a' == 'a' and b'a' == b'a' and 3 == 3.0 and None != x and {1: 'a'} == {1: 'a'}",
        "assert (one == np.ones(3)[:, None]).sum() == 0 and Pair(1.5) == Pair(1.5)",
    ],
)
def test_other_comparisons_answer_as_they_do_in_python(line):
    run(line)


def test_modules_of_tests_are_watched():
    one, two = (float(np.log(3.0)) for _ in range(2))
    with pytest.raises(RecomputedError, match=r"because 1\.0986"):
        assert one == two


def test_processes_share_the_compilation_of_the_modules(tmp_path, pytestconfig, monkeypatch):
    for name in "abcd":
        (tmp_path / f"test_{name}.py").write_text("assert 1" if name < "d" else "no python")
    paths, rewritten = [], rewrite.rewrite_asserts
    monkeypatch.chdir(tmp_path.parent)

    def rewrite_asserts(tree, source, path, *others):
        paths.append(path)
        rewritten(tree, source, path, *others)

    monkeypatch.setattr(rewrite, "rewrite_asserts", rewrite_asserts)
    process = {"workerid": "gw1", "workercount": 2}
    monkeypatch.setattr(pytestconfig, "workerinput", process, raising=False)
    monkeypatch.setattr(pytestconfig, "args", [tmp_path.name, str(tmp_path / "test_a.py::none")])
    compile_share(rewrite, pytestconfig)
    assert paths == [str(tmp_path.resolve() / "test_b.py")]  # a relative path is not watched
    assert [file.name.partition(".")[0] for file in tmp_path.rglob("*.pyc")] == ["test_b"]
