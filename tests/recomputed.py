"""Find comparisons that hang on the processor: `==` between floats that were computed apart.

Two processors round sums, logarithms and products of matrices differently, so that two ways to one
number agree to the last bit on one and not on the next. In the modules of the tests a function of
this module takes the place of every `==`, `!=`, `<=` and `>=`: it compares as Python does, and
raises where the answer rests on floats of many digits that are equal to the last and are not one
object. Those are to be compared to a tolerance. Where equality bit by bit is the contract (a file
keeps every bit, one call is made twice), a comment in the statement or above it says so:
`# exact: the reason`.
"""

import ast
import dataclasses
import math
import operator
import re
import zlib
from collections.abc import Callable, Iterator, Mapping, Set
from contextlib import suppress
from itertools import islice, pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np


COMPARISONS = {
    **{"Eq": operator.eq, "NotEq": operator.ne, "Lt": operator.lt, "LtE": operator.le},
    **{"Gt": operator.gt, "GtE": operator.ge, "Is": operator.is_, "IsNot": operator.is_not},
    **{"In": lambda one, all: one in all, "NotIn": lambda one, all: one not in all},
}
WATCHED = ("Eq", "NotEq", "LtE", "GtE")
OF_ARRAYS = ("array_equal", "array_equiv", "assert_array_equal", "assert_equal", "equals")
MARK = re.compile(r"# exact: \w")
DIGITS = {2: 3, 4: 6, 8: 12}  # of a float by its bytes; one with more was not typed by anyone
MANY_IN_TEXT = re.compile(rb"\d*\.\d{14,}")
MODULE = "@recomputed"  # a name that no test can have
LOOKED_AT = 1000  # elements of an array


class RecomputedError(AssertionError):
    """A comparison rests on two floats that were computed apart and agree to the last bit."""


def install(rewrite: ModuleType) -> None:
    """Let pytest's compiler of test modules, `_pytest.assertion.rewrite`, watch comparisons."""
    plain = rewrite.rewrite_asserts

    def rewrite_asserts(tree: ast.Module, source: bytes, path: str, *others: Any) -> None:
        plain(tree, source, path, *others)
        if Path(path).is_relative_to(Path(__file__).parent):
            watch(tree, source.decode())

    rewrite.rewrite_asserts = rewrite_asserts
    version = zlib.crc32(Path(__file__).read_bytes())
    rewrite.PYC_TAIL = f".{version:08x}{rewrite.PYC_TAIL}"  # of the files of compiled modules


def compile_share(rewrite: ModuleType, config: Any) -> None:
    """Compile a part of the test modules, another one in each process of `pytest -n`.

    All processes import all modules, and would compile all of them side by side.
    """
    process = getattr(config, "workerinput", None)
    if process is None:
        return
    given = [Path(each).resolve() for each in config.args]
    found = {file for each in given for file in [each, *each.rglob("test_*.py")]}
    files = sorted(file for file in found if file.is_file())
    first = int(process["workerid"].removeprefix("gw"))
    for file in files[first :: process["workercount"]]:
        folder = rewrite.get_cache_dir(file)
        kept = folder / (file.stem + rewrite.PYC_TAIL)
        if rewrite.try_makedirs(folder) and rewrite._read_pyc(file, kept) is None:
            with suppress(SyntaxError):  # which is said where the module is imported
                of_file, code = rewrite._rewrite_test(file, config)
                rewrite._write_pyc(config.stash[rewrite.assertstate_key], code, of_file, kept)


def watch(tree: ast.Module, source: str) -> None:
    """Replace the comparisons in a module by calls of `compare`, except for the marked ones."""
    lines = source.splitlines()
    marked = {i for i, line in enumerate(lines, 1) if MARK.search(line)}
    marked |= {i + 1 for i in marked if lines[i - 1].lstrip().startswith("#")}
    for node in ast.walk(ast.parse(source)) if marked else ():
        if isinstance(node, ast.stmt) and not hasattr(node, "body"):
            own = range(node.lineno, (node.end_lineno or 0) + 1)
            marked |= set() if marked.isdisjoint(own) else set(own)
    _replaced(tree, marked)
    first = int(ast.get_docstring(tree) is not None)
    while getattr(tree.body[first], "module", "") == "__future__":
        first += 1
    imported = ast.Import([ast.alias("recomputed", MODULE)], lineno=1, col_offset=0)
    tree.body.insert(first, ast.fix_missing_locations(imported))


def _replaced(node: ast.AST, marked: set[int]) -> ast.AST:
    """Replace what is below a node, then the node, faster than an `ast.NodeTransformer`."""
    for name in node._fields:
        value = getattr(node, name, None)
        if isinstance(value, list):
            value[:] = [_replaced(x, marked) if isinstance(x, ast.AST) else x for x in value]
        elif isinstance(value, ast.AST) and value._fields:
            setattr(node, name, _replaced(value, marked))
    if isinstance(node, ast.Compare):
        kinds = [type(operation).__name__ for operation in node.ops]
        if set(kinds) & set(WATCHED) and not _is_marked(node, marked):
            names = ast.copy_location(ast.Constant(" ".join(kinds)), node)
            return _call("compare", [names, node.left, *node.comparators], node)
    elif isinstance(node, ast.Attribute) and node.attr in OF_ARRAYS:
        if not _is_marked(node, marked):
            return _call("watched", [node], node)
    return node


def _is_marked(node: ast.expr, marked: set[int]) -> bool:
    return not marked.isdisjoint(range(node.lineno, (node.end_lineno or 0) + 1))


def _call(name: str, given: list[ast.expr], place: ast.expr) -> ast.Call:
    module = ast.copy_location(ast.Name(MODULE, ast.Load()), place)
    function = ast.copy_location(ast.Attribute(module, name, ast.Load()), place)
    return ast.copy_location(ast.Call(function, given, []), place)


def compare(kinds: str, *values: Any) -> Any:
    """Return what Python answers to comparisons in a row, as "LtE Lt" of three values.

    Raises
    ------
    RecomputedError
        If the answer rests on floats that were computed apart.
    """
    answer: Any = True
    for number, (kind, pair) in enumerate(zip(kinds.split(), pairwise(values), strict=True)):
        if number and not answer:  # as Python stops, and not asked of a single array
            break
        answer = COMPARISONS[kind](*pair)
        if kind in WATCHED and answer is not (kind == "NotEq"):  # the answer where they differ
            refuse(*pair)
    return answer


def watched(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that compares arrays, with the errors of `compare`."""

    def call(*given: Any, **options: Any) -> Any:
        answer = function(*given, **options)
        if answer is not False:
            refuse(*(given if len(given) > 1 else (function.__self__, *given))[:2])
        return answer

    return call


def refuse(left: Any, right: Any) -> None:
    """Raise a RecomputedError if two values hold equal floats that were computed apart."""
    for value in equal_floats(left, right):
        raise RecomputedError(
            "expected a tolerance between floats that were computed apart, received a comparison "
            f"that holds because {value} is the same to its last digit, which another processor "
            "rounds differently: compare with pytest.approx, or give the reason for equal bits in "
            "a comment of the statement, '# exact: the reason'"
        )


def equal_floats(left: Any, right: Any) -> Iterator[Any]:
    """Find the floats of many digits that are equal in two values, and not one object."""
    if left is right:
        return
    if isinstance(left, str | bytes):
        if type(left) is type(right) and left == right:
            yield from MANY_IN_TEXT.findall(left.encode() if isinstance(left, str) else left)[:1]
    elif _is_float(left) and _is_float(right):
        if left == right and has_many_digits(left):
            yield left
    elif _is_array(left) or _is_array(right):
        yield from _equal_elements(left, right)
    else:
        for pair in _parts(left, right):
            yield from equal_floats(*pair)


def _parts(left: Any, right: Any) -> Iterator[tuple[Any, Any]]:
    if isinstance(left, Mapping) and isinstance(right, Mapping):
        yield from ((left[key], right[key]) for key in left.keys() & right.keys())
    elif isinstance(left, list | tuple) and isinstance(right, list | tuple):
        yield from zip(left, right, strict=False)
    elif isinstance(left, Set) and isinstance(right, Set):
        of_right = {value: value for value in right}
        yield from ((value, of_right[value]) for value in left if value in of_right)
    elif dataclasses.is_dataclass(left) and type(left) is type(right):
        names = [field.name for field in dataclasses.fields(left) if field.compare]
        yield from ((getattr(left, name), getattr(right, name)) for name in names)


def _is_float(value: Any) -> bool:
    return isinstance(value, float | np.floating)


def _is_array(value: Any) -> bool:
    return hasattr(value, "__array__")


def _equal_elements(left: Any, right: Any) -> Iterator[Any]:
    if not all(
        _is_array(value) or isinstance(value, list | tuple | float) for value in (left, right)
    ):
        return
    try:
        left, right = np.broadcast_arrays(left, right)
    except ValueError:  # of different shapes
        return
    kinds = {left.dtype.kind, right.dtype.kind}
    if kinds == {"O"}:
        yield from equal_floats(left.ravel().tolist(), right.ravel().tolist())
    elif kinds <= {"f", "c"} and not np.shares_memory(left, right):
        equal = left[left == right][:LOOKED_AT]
        parts = (part for value in equal for part in (value.real, value.imag))
        yield from islice(filter(has_many_digits, parts), 1)


def has_many_digits(value: Any) -> bool:
    """Say whether a float has more digits than anyone types."""
    digits = DIGITS.get(getattr(value, "itemsize", 8), 12)
    return math.isfinite(value) and type(value)(f"{value:.{digits}g}") != value
