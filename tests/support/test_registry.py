"""Things of a user by name: registered, of a plugin, of an entry point, in child processes."""

import sys
from contextlib import nullcontext
from dataclasses import dataclass

import process_calls
import pytest
from refusals import refused

import fefinger as ff
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import INDENTERS
from fefinger.scene.raised import Raised
from fefinger.support import processes, registry
from fefinger.support.checks import InputError


PLUGIN = """
from dataclasses import dataclass
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Sphere

@dataclass(frozen=True)
class Marble(Indenter):
    kind = "marble"
    at: None = None
    profile = None

    def describe(self):
        return "a marble"
"""


@pytest.fixture(autouse=True)
def own_modules(own_registry, monkeypatch):
    """Forget what a test registers and imports."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(sys, "modules", dict(sys.modules))


def key_edge(kind="key-edge"):
    @dataclass(frozen=True)
    class KeyEdge(Indenter):
        at: tuple[float, float] | None = None
        profile = None

        def describe(self):
            return "the edge of a key"

    KeyEdge.kind = kind
    return KeyEdge


def test_what_is_shipped_stands_first_and_is_what_it_says():
    assert list(INDENTERS)[:2] == ["flat", "sphere"]
    assert INDENTERS["sphere"] is ff.Sphere
    assert [cls.kind for cls in INDENTERS.values()] == list(INDENTERS)


def test_a_thing_is_registered_under_its_name():
    one = ff.register(key_edge())
    assert INDENTERS["key-edge"] is one
    assert list(INDENTERS)[-1] == "key-edge"
    assert "key-edge" in INDENTERS
    assert len(INDENTERS) == len(INDENTERS.shipped) + 1


def test_a_second_definition_of_the_same_class_takes_its_place():
    ff.register(key_edge())
    again = ff.register(key_edge())
    assert INDENTERS["key-edge"] is again


@pytest.mark.parametrize("kind", [None, "Key Edge", "key_edge", "", "-key"])
def test_a_name_that_fits_nowhere_is_refused(kind):
    with pytest.raises(InputError, match="lower case"):
        ff.register(key_edge(kind))


def test_a_name_that_is_taken_is_refused():
    with pytest.raises(InputError, match="'sphere' is the name of the package"):
        ff.register(key_edge("sphere"))
    ff.register(key_edge())
    other = type("Other", (key_edge(),), {"kind": "key-edge"})
    with pytest.raises(InputError, match="'key-edge' is the name of another one"):
        ff.register(other)


@pytest.mark.parametrize("thing", [3, "sphere", print, Raised])
def test_what_is_of_no_kind_is_refused(thing):
    with pytest.raises(InputError, match="register: expected one of indenter"):
        ff.register(thing)


def test_an_unknown_name_gets_the_nearest_one():
    with refused("indenter.kind"):
        INDENTERS.named("indenter.kind", "spere")


def test_a_plugin_registers_what_it_defines_and_not_what_it_imports(tmp_path):
    (tmp_path / "my_marbles.py").write_text(PLUGIN)
    registry.load_plugin("my_marbles", tmp_path)
    registry.load_plugin("my_marbles", tmp_path)
    assert [name for name in INDENTERS if name not in INDENTERS.shipped] == ["marble"]
    assert registry.modules() == {"my_marbles"}


@pytest.mark.parametrize(
    ("name", "source", "sentence"),
    [
        ("my-marbles", "", "expected names of Python modules"),
        ("my_nothing", None, "expected a module in"),
        ("my_typo", "\n1 / 0", r"ZeroDivisionError: .* \(line 2 of my_typo\)"),
        ("my_needs", "import no_such_library", "failed with ModuleNotFound"),
        ("my_script", "raise SystemExit(3)", "failed with SystemExit: 3"),
        ("my_mute", "class E(Exception):\n __str__ = None\nraise E", "failed with my_mute.E"),
        ("my_trap", "class T:\n def __getattr__(s, n): 1 / 0\nt = T()", "ZeroDivisionError"),
        ("my_any", "class T:\n def __getattr__(s, n): return 1\nt = T()", None),
        ("my_law", "import fefinger as ff\nlaw = ff.Law('mine', 5)", "law.density"),
        (300 * "m", "", "failed with OSError|expected a module in"),  # from Python 3.14 on
        ("json", "", "rename the file"),
        ("my_taken", PLUGIN.replace("marble", "flat"), "'flat' is the name of the package"),
    ],
)
def test_a_plugin_that_cannot_be_loaded_is_named(tmp_path, name, source, sentence):
    if source is not None and len(name) < 256:
        (tmp_path / f"{name}.py").write_text(source)
    refused = pytest.raises(InputError, match=sentence) if sentence else nullcontext()
    with refused:
        registry.load_plugin(name, tmp_path)


def test_a_child_process_knows_what_its_parent_knows(tmp_path):
    (tmp_path / "my_marbles.py").write_text(PLUGIN)
    registry.load_plugin("my_marbles", tmp_path)
    with processes.in_background(process_calls.kinds, None) as found:
        assert found()[-1] == "marble"


def test_an_installed_distribution_extends_the_package(tmp_path, monkeypatch):
    (tmp_path / "my_marbles.py").write_text(PLUGIN)
    monkeypatch.syspath_prepend(tmp_path)
    installed(tmp_path, "marble = my_marbles:Marble")
    again = registry.Registry("indenter", "profile", {}, key="kind", classes=True)
    assert list(again) == ["marble"]
    assert again["marble"].kind == "marble"


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("sphere = my_marbles:Marble", "'sphere' is an entry point of marbles"),
        ("marble = my_marbles:dataclass", "expected my_marbles:dataclass to have 'profile'"),
        ("marble = my_marbles:Gone", "failed with AttributeError"),
    ],
)
def test_an_entry_point_that_cannot_be_used_is_named(tmp_path, monkeypatch, line, sentence):
    (tmp_path / "my_marbles.py").write_text(PLUGIN)
    monkeypatch.syspath_prepend(tmp_path)
    installed(tmp_path, line)
    shipped = {"sphere": "fefinger.scene.indenters:Sphere"}
    again = registry.Registry("indenter", "profile", shipped, key="kind", classes=True)
    with pytest.raises(InputError, match=sentence):
        again[line.partition(" ")[0]]


def installed(folder, line):
    info = folder / "marbles-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: marbles\nVersion: 1\n")
    (info / "entry_points.txt").write_text(f"[fefinger.indenters]\n{line}\n")


def test_names_of_classes_become_names_of_kinds():
    names = ["KeyEdge", "key_edge", "LNP", "HTTPServer", "Gent", "Ball2"]
    expected = ["key-edge", "key-edge", "lnp", "http-server", "gent", "ball2"]
    assert [registry.hyphenated(name) for name in names] == expected
