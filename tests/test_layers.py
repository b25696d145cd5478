"""The rule of import, read from the syntax tree of every module.

A room imports rooms of a lower number only. What a function imports and what is imported for type
checking counts as well: for the direction, and for cycles. `reports` and `meshes` hold data alone.
"""

import ast
import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest


ROOT = Path(__file__).parents[1]
PACKAGES = {"fefinger": ROOT / "fefinger", "fefinger.validation": ROOT / "validation"}

ROOMS = {
    "fefinger.support": 1,
    "fefinger.theory": 1,
    "fefinger.geometry": 2,
    "fefinger.contact": 2,
    "fefinger.neural": 2,
    "fefinger.laws": 2,
    "fefinger.shapes": 3,
    "fefinger.scene": 3,
    "fefinger.fem": 3,
    "fefinger.mesh": 4,
    "fefinger.results": 4,
    "fefinger.mechanics": 5,
    "fefinger.view": 6,
    "fefinger.calibration": 6,
    "fefinger.plan": 6,
    "fefinger.mujoco": 6,
    "fefinger.afferents": 6,
    "fefinger.pages": 7,
    "fefinger.result": 8,
    "fefinger.pipeline": 9,
    "fefinger.studies": 10,
    "fefinger.live": 10,
    "fefinger.validation": 11,
    "fefinger.commands": 12,
    "fefinger.__main__": 13,
    "fefinger": 13,
}
"""Rooms, and modules that are a room of their own, with their numbers."""

ALONE = {
    "fefinger.neural": ("fefinger.support",),
    "fefinger.laws": ("fefinger.support",),
    "fefinger.contact": ("fefinger.support",),
    "fefinger.fem": (
        *("fefinger.support", "fefinger.geometry", "fefinger.contact", "fefinger.laws"),
    ),
    "fefinger.scene": ("fefinger.support", "fefinger.theory", "fefinger.geometry", "fefinger.laws"),
}
"""Rooms that import these rooms alone."""

MADE_SCANS = "fefinger.validation.evidence.scans"
"""Makes files as people bring them, with programs that people have."""

ONLY = {
    "pytetwild": "fefinger.mesh",
    "trimesh": ("fefinger.geometry", "fefinger.mesh", MADE_SCANS),
    "skfem": ("fefinger.fem", "fefinger.validation.problems.grids"),
    "pyvista": (
        *("fefinger.view", "fefinger.geometry.height_map", "fefinger.geometry.surface_repair"),
        MADE_SCANS,
    ),
    "vtk": "fefinger.view",
    "numba": "fefinger.support.compiled",
    "vtkmodules": "fefinger.view",
    "mujoco": "fefinger.mujoco",
}
"""Libraries that one place alone imports."""

HEAVY = (
    *("scipy", "skfem", "trimesh", "pytetwild", "pyvista", "vtk", "meshio", "matplotlib"),
    *("numba", "xarray", "h5py", "h5netcdf", "jinja2", "pypardiso", "rich", "tomli_w"),
)
LIGHT = (
    *("fefinger", "fefinger.__main__", "fefinger.pipeline", "fefinger.plan"),
    *("fefinger.scene.scene", "fefinger.scene.builtin", "fefinger.results.records"),
    *("fefinger.studies.study", "fefinger.studies.tasks"),
    *("fefinger.commands.console", "fefinger.mechanics.linear", "fefinger.mechanics.condensed"),
    *("fefinger.mechanics.hertz", "fefinger.mechanics.layered", "fefinger.mechanics.lumped"),
)
"""Modules that load none of HEAVY, so that `fefinger --help` and `explain` are quick.

The planner loads every mechanics of the ladder, so all of them belong here.
"""


class Edge(NamedTuple):
    """One import: by whom, of what, and whether it runs on import, in a call, or never."""

    importer: str
    imported: str
    when: str


def test_every_import_keeps_to_the_rule():
    found = violations(*walked())
    if found:
        pytest.fail("\n".join(found), pytrace=False)


def test_the_walk_sees_the_modules_it_is_about():
    modules, every = walked()
    for name in (*ROOMS, *LIGHT):
        assert name in modules, name
    seen = {edge.imported.partition(".")[0] for edge in every}
    assert {"numpy", "scipy", "skfem", "pyvista", "click"} <= seen


CLEAN = {
    "fefinger": "import importlib",
    "fefinger.support": "",
    "fefinger.support.checks": "",
    "fefinger.theory": "",
    "fefinger.theory.hertz": "import scipy",
    "fefinger.neural": "",
    "fefinger.neural.drives": "from fefinger.support.checks import InputError",
    "fefinger.scene": "",
    "fefinger.scene.scene": "import numpy\nfrom fefinger.support import checks",
    "fefinger.scene.motion": "",
    "fefinger.fem": "",
    "fefinger.fem.forms": "import skfem",
    "fefinger.results": "",
    "fefinger.results.records": "from fefinger.scene.scene import Scene",
    "fefinger.plan": "from fefinger.results import records",
    "fefinger.result": "def f():\n    from fefinger import plan",
}


def test_a_clean_house_has_no_violation():
    assert violations(CLEAN, edges(CLEAN)) == []


@pytest.mark.parametrize(
    ("module", "source", "message"),
    [
        (
            "fefinger.theory.hertz",
            "from fefinger.support import checks",
            "fefinger.theory.hertz imports fefinger.support.checks",
        ),
        (
            "fefinger.neural.drives",
            "def f():\n    from fefinger.scene.scene import Scene",
            "fefinger.neural.drives imports fefinger.scene.scene",
        ),
        (
            "fefinger.neural.drives",
            "from fefinger.theory import hertz",
            "fefinger.neural.drives imports fefinger.theory.hertz: fefinger.neural imports",
        ),
        (
            "fefinger.neural.drives",
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import fefinger.fem.forms",
            "fefinger.neural.drives imports fefinger.fem.forms",
        ),
        (
            "fefinger.scene.scene",
            "from fefinger.neural import drives",
            "fefinger.scene.scene imports fefinger.neural.drives: fefinger.scene imports",
        ),
        (
            "fefinger.results.records",
            "def f():\n    from fefinger.result import save",
            "fefinger.results.records imports fefinger.result",
        ),
        ("fefinger.plan", "def f():\n    import pyvista as pv", "fefinger.plan imports pyvista"),
        (
            "fefinger.theory.hertz",
            "from skfem.helpers import grad",
            "fefinger.theory.hertz imports skfem",
        ),
        (
            "fefinger.support.checks",
            "import scipy.sparse",
            "fefinger.support.checks imports scipy when",
        ),
        (
            "fefinger.support.checks",
            "@njit(cache=True)\ndef f():\n    pass",
            "fefinger.support.checks imports numba when",
        ),
        (
            "fefinger.scene.motion",
            "def f():\n    from fefinger.scene.scene import Scene",
            "cycle: fefinger.scene.motion -> fefinger.scene.scene -> fefinger.scene.motion",
        ),
        ("fefinger.kitchen", "", "fefinger.kitchen is in no room"),
        ("fefinger.fem._forms", "", "fefinger.fem._forms begins with an underscore"),
        (
            "fefinger.plan",
            "from fefinger.results.records import _digest",
            "fefinger.plan imports fefinger.results.records._digest: a private name",
        ),
        (
            "fefinger.plan",
            "from fefinger.results import records\nrecords._digest()",
            "fefinger.plan uses records._digest: a private name",
        ),
    ],
)
def test_a_seeded_violation_is_found_and_named(module, source, message):
    seeded = CLEAN | {module: source}
    if module == "fefinger.scene.motion":
        seeded["fefinger.scene.scene"] = "from fefinger.scene.motion import Ramp"
    assert any(message in found for found in violations(seeded, edges(seeded)))


def test_files_that_comments_and_docstrings_name_exist():
    """As `fem/body.py`: from the package, from the repository, or beside the file."""
    missing = []
    for folder in PACKAGES.values():
        for file in folder.rglob("*.py"):
            for name in re.findall(r"(?<![\w/])[\w/]+\.py\b", file.read_text(encoding="utf-8")):
                places = (ROOT, ROOT / "fefinger", file.parent, folder)
                named = [place / name for place in places]
                if not any(path.is_file() for path in named) and "/" in name:
                    missing.append(f"{file.relative_to(ROOT)}: {name}")
    assert missing == []


def sources() -> dict[str, str]:
    """Return the source of every module by its dotted name."""
    found = {}
    for package, folder in PACKAGES.items():
        for file in sorted(folder.rglob("*.py")):
            parts = file.relative_to(folder).with_suffix("").parts
            name = ".".join((package, *parts)).removesuffix(".__init__")
            found[name] = file.read_text(encoding="utf-8")
    return found


def edges(modules: Mapping[str, str]) -> list[Edge]:
    """Return every import of every module."""
    return [edge for name, text in modules.items() for edge in _edges(name, text, modules)]


@cache
def walked() -> tuple[dict[str, str], list[Edge]]:
    """Return the sources of all modules and their imports, read once for all checks."""
    modules = sources()
    return modules, edges(modules)


def violations(modules: Mapping[str, str], every: list[Edge]) -> list[str]:
    """Return a sentence for everything that goes against the rule."""
    return [
        *_misplaced(modules),
        *_wrong_directions(every),
        *_strange_libraries(every),
        *_private_names(modules),
        *_heavy(every, modules),
        *_cycles(every, modules),
    ]


@cache
def room_of(module: str) -> str:
    """Return the room that a module is in, or nothing."""
    if module == "fefinger":
        return module
    found = [room for room in ROOMS if room != "fefinger" and _inside(module, room)]
    return max(found, key=len, default="")


def _edges(name: str, text: str, modules: Mapping[str, str]) -> Iterator[Edge]:
    def visit(node: ast.AST, when: str) -> Iterator[Edge]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Import):
                for alias in child.names:
                    yield Edge(name, alias.name, when)
            elif isinstance(child, ast.ImportFrom):
                assert child.level == 0, f"{name}: imports are absolute"
                for alias in child.names:
                    full = f"{child.module}.{alias.name}"
                    yield Edge(name, full if full in modules else str(child.module), when)
            elif isinstance(child, ast.If) and "TYPE_CHECKING" in ast.dump(child.test):
                yield from visit(child, "typing")
            elif isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
                yield from visit(child, "typing" if when == "typing" else "call")
            elif not isinstance(child, ast.expr):  # no expression holds an import
                yield from visit(child, when)

    yield from visit(tree(text), "import")


@cache
def tree(text: str) -> ast.Module:
    """Parse a source, once for all checks."""
    return ast.parse(text)


def _inside(module: str, packages: tuple[str, ...] | str) -> bool:
    names = (packages,) if isinstance(packages, str) else packages
    return any(module == name or module.startswith(f"{name}.") for name in names)


def _misplaced(modules: Mapping[str, str]) -> Iterator[str]:
    for name in modules:
        leaf = name.rpartition(".")[2]
        if not room_of(name):
            yield f"{name} is in no room"
        if leaf.startswith("_") and leaf != "__main__":
            yield f"{name} begins with an underscore"


def _wrong_directions(every: list[Edge]) -> Iterator[str]:
    for edge in every:
        here, there = room_of(edge.importer), room_of(edge.imported)
        if not _inside(edge.imported, "fefinger") or not there or here in ("", there):
            continue
        if ROOMS[there] >= ROOMS[here]:
            yield f"{edge.importer} imports {edge.imported}: {there} is not below {here}"
        elif here in ALONE and there not in ALONE[here]:
            yield f"{edge.importer} imports {edge.imported}: {here} imports {ALONE[here]} alone"


def _private_names(modules: Mapping[str, str]) -> Iterator[str]:
    for name, text in modules.items():
        siblings, nodes = set(), list(ast.walk(tree(text)))
        for node in nodes:
            if isinstance(node, ast.ImportFrom) and _inside(str(node.module), "fefinger"):
                for alias in node.names:
                    if alias.name.startswith("_"):
                        yield f"{name} imports {node.module}.{alias.name}: a private name"
                    if f"{node.module}.{alias.name}" in modules:
                        siblings.add(alias.asname or alias.name)
        for node in nodes:
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                private = node.attr.startswith("_") and not node.attr.startswith("__")
                if private and node.value.id in siblings:
                    yield f"{name} uses {node.value.id}.{node.attr}: a private name"


def _strange_libraries(every: list[Edge]) -> Iterator[str]:
    for edge in every:
        library = edge.imported.partition(".")[0]
        if library in ONLY and not _inside(edge.importer, ONLY[library]):
            yield f"{edge.importer} imports {library}: only {ONLY[library]} does"


def _heavy(every: list[Edge], modules: Mapping[str, str]) -> Iterator[str]:
    loads: dict[str, set[str]] = {name: set(_parents(name)) for name in modules}
    for edge in every:
        if edge.when == "import":
            loads[edge.importer] |= {edge.imported, *_parents(edge.imported)}
    for name, text in modules.items():
        if re.search(r"^@njit\b", text, re.MULTILINE):  # whose decorator imports numba
            loads[name].add("numba")
    for start in LIGHT:
        loaded = _reachable(start, loads)
        for name in sorted(loaded & modules.keys()):
            for imported in sorted({i.partition(".")[0] for i in loads[name]} & set(HEAVY)):
                yield f"{name} imports {imported} when {start} is imported, which has to be quick"


def _parents(name: str) -> list[str]:
    parts = name.split(".")
    return [".".join(parts[:i]) for i in range(1, len(parts))]


def _reachable(start: str, graph: Mapping[str, set[str]]) -> set[str]:
    seen, todo = set(), [start]
    while todo:
        name = todo.pop()
        if name not in seen:
            seen.add(name)
            todo += graph.get(name, ())
    return seen


def _cycles(every: list[Edge], modules: Mapping[str, str]) -> Iterator[str]:
    graph: dict[str, set[str]] = {name: set() for name in modules}
    for edge in every:
        if edge.imported in modules:
            graph[edge.importer].add(edge.imported)
    for name in sorted(graph):
        cycle = _way_back(name, graph)
        if cycle and name == min(cycle):
            yield f"cycle: {' -> '.join(cycle)}"


def _way_back(start: str, graph: Mapping[str, set[str]]) -> list[str]:
    """Return the shortest way from a module back to itself, or nothing."""
    ways, seen = [[start]], set()
    while ways:
        way = ways.pop(0)
        for name in sorted(graph[way[-1]]):
            if name == start:
                return [*way, name]
            if name not in seen:
                seen.add(name)
                ways.append([*way, name])
    return []
