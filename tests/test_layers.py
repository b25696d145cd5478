"""The directions of import, read from the syntax tree of every module.

`reports` and `meshes` hold data alone. What a function imports counts for the directions and for
cycles; what is only imported for type checking counts for the directions.
"""

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import pytest


ROOT = Path(__file__).parents[1]
PACKAGES = {"fefinger": ROOT / "fefinger", "fefinger.validation": ROOT / "validation"}

BELOW = {
    "fefinger.theory": ("fefinger.theory",),
    "fefinger.neural": (
        *("fefinger.neural", "fefinger.checks", "fefinger.cores", "fefinger.theory"),
        *("fefinger.interrupt", "fefinger.writing"),
    ),
    "fefinger.fem": (
        *("fefinger.fem", "fefinger.checks", "fefinger.tolerances", "fefinger.stages"),
        *("fefinger.mesh.record", "fefinger.mesh.topology", "fefinger.units"),
        *("fefinger.profiles", "fefinger.laws"),
    ),
}
"""Packages that may import nothing of fefinger but these."""

STRANGERS = {
    **dict.fromkeys(
        ("fefinger.report", "fefinger.view", "fefinger.files", "fefinger.figures"),
        ("fefinger.fem", "fefinger.mechanics"),
    ),
    **dict.fromkeys(
        ("fefinger.page", "fefinger.validation_report"),
        ("fefinger.fem", "fefinger.mechanics", "fefinger.theory", "fefinger.validation"),
    ),
    **dict.fromkeys(
        ("fefinger.studies.report", "fefinger.studies.figures"),
        ("fefinger.fem", "fefinger.mechanics", "fefinger.mesh"),
    ),
    "fefinger.scene": ("fefinger.mechanics", "fefinger.fem", "fefinger.mesh", "fefinger.records"),
    "fefinger.mesh": ("fefinger.fem", "fefinger.mechanics", "fefinger.neural", "fefinger.records"),
    "fefinger.records": ("fefinger.fem", "fefinger.mechanics", "fefinger.mesh"),
    "fefinger.mechanics": ("fefinger.report", "fefinger.view", "fefinger.files", "fefinger.plan"),
}
"""Modules, and what they must not import."""

ONLY = {
    "pytetwild": "fefinger.mesh",
    "trimesh": "fefinger.mesh",
    "skfem": "fefinger.fem",
    "pyvista": ("fefinger.view", "fefinger.live_window"),
    "vtk": "fefinger.view",
    "vtkmodules": ("fefinger.view", "fefinger.mesh.surface_file"),
}
"""Libraries that one place alone imports."""

HEAVY = (
    *("scipy", "skfem", "trimesh", "pytetwild", "pyvista", "vtk", "meshio", "matplotlib"),
    *("numba", "xarray", "h5py", "h5netcdf", "jinja2", "pypardiso", "rich", "tomli_w"),
)
LIGHT = (
    *("fefinger", "fefinger.__main__", "fefinger.console", "fefinger.scenes", "fefinger.scene"),
    *("fefinger.records", "fefinger.plan", "fefinger.run", "fefinger.mechanics.linear"),
    *("fefinger.study", "fefinger.studies.tasks", "fefinger.studies.workers"),
    "fefinger.mechanics.condensed",
    "fefinger.mechanics.hertz",
    "fefinger.mechanics.layered",
    "fefinger.mechanics.lumped",
)
"""Modules that load none of HEAVY, so that `fefinger --help` and `explain` are quick.

The planner loads every mechanics of the ladder, so all of them belong here.
"""

CONVENIENCE = {
    ("fefinger.records", "fefinger.files"): "result.save() is result -> files, for convenience",
    ("fefinger.records", "fefinger.view"): "result.show() is result -> view, for convenience",
}
"""Imports inside a function that go against the direction; each only calls on what it is given."""


class Edge(NamedTuple):
    """One import: by whom, of what, and whether it runs on import, in a call, or never."""

    importer: str
    imported: str
    when: str


def test_every_import_keeps_to_the_directions():
    found = violations(sources())
    if found:
        pytest.fail("\n".join(found), pytrace=False)


def test_the_walk_sees_the_modules_it_is_about():
    modules = sources()
    for name in (*BELOW, *STRANGERS, *LIGHT, "fefinger.validation"):
        assert name in modules, name
    seen = {edge.imported.partition(".")[0] for edge in edges(modules)}
    assert {"numpy", "scipy", "skfem", "pyvista", "click"} <= seen


CLEAN = {
    "fefinger": "",
    "fefinger.scene": "import numpy",
    "fefinger.records": "from fefinger.scene import Scene\ndef f():\n    import fefinger.files",
    "fefinger.files": "from fefinger import records",
    "fefinger.theory": "",
    "fefinger.theory.hertz": "import scipy",
    "fefinger.neural": "",
    "fefinger.neural.drives": "from fefinger.checks import InputError",
    "fefinger.checks": "",
    "fefinger.fem": "",
    "fefinger.fem.forms": "import skfem",
    "fefinger.plan": "from fefinger import records",
}


def test_a_clean_house_has_no_violation():
    assert violations(CLEAN) == []


@pytest.mark.parametrize(
    ("module", "source", "message"),
    [
        (
            "fefinger.theory.hertz",
            "from fefinger import checks",
            "fefinger.theory.hertz imports fefinger.checks",
        ),
        (
            "fefinger.neural.drives",
            "def f():\n    from fefinger.scene import Scene",
            "fefinger.neural.drives imports fefinger.scene",
        ),
        (
            "fefinger.neural.drives",
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import fefinger.fem.forms",
            "fefinger.neural.drives imports fefinger.fem.forms",
        ),
        (
            "fefinger.files",
            "from fefinger.fem import forms",
            "fefinger.files imports fefinger.fem.forms",
        ),
        (
            "fefinger.plan",
            "def f():\n    import pyvista as pv",
            "fefinger.plan imports pyvista",
        ),
        (
            "fefinger.theory.hertz",
            "from skfem.helpers import grad",
            "fefinger.theory.hertz imports skfem",
        ),
        (
            "fefinger.checks",
            "import scipy.sparse",
            "fefinger.checks imports scipy",
        ),
        (
            "fefinger.scene",
            "def f():\n    from fefinger.plan import explain",
            "cycle: fefinger.plan -> fefinger.records -> fefinger.scene -> fefinger.plan",
        ),
        (
            "fefinger.scene",
            "import fefinger.records",
            "cycle: fefinger.records -> fefinger.scene -> fefinger.records",
        ),
    ],
)
def test_a_seeded_violation_is_found_and_named(module, source, message):
    seeded = CLEAN | {module: source}
    if message.endswith("imports scipy"):
        seeded["fefinger.scene"] = "from fefinger.checks import InputError"
    assert any(message in found for found in violations(seeded))


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


def violations(modules: Mapping[str, str]) -> list[str]:
    """Return a sentence for every import that goes against the directions."""
    every = edges(modules)
    return [
        *_wrong_directions(every),
        *_strange_libraries(every),
        *_heavy(every, modules),
        *_cycles(every, modules),
    ]


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
            elif isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
                yield from visit(child, "typing" if when == "typing" else "call")
            else:
                yield from visit(child, when)

    yield from visit(ast.parse(text), "import")


def _inside(module: str, packages: tuple[str, ...] | str) -> bool:
    names = (packages,) if isinstance(packages, str) else packages
    return any(module == name or module.startswith(f"{name}.") for name in names)


def _wrong_directions(every: list[Edge]) -> Iterator[str]:
    for edge in every:
        ours = _inside(edge.imported, "fefinger")
        for package, allowed in BELOW.items():
            if ours and _inside(edge.importer, package) and not _inside(edge.imported, allowed):
                yield f"{edge.importer} imports {edge.imported}: {package} is below it"
        for package, strangers in STRANGERS.items():
            if _inside(edge.importer, package) and _inside(edge.imported, strangers):
                yield f"{edge.importer} imports {edge.imported}: {package} must not know it"


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
        allowed = edge.when == "call" and (edge.importer, edge.imported) in CONVENIENCE
        if edge.when != "typing" and edge.imported in modules and not allowed:
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
