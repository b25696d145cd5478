"""What the documentation states of the code, without building it."""

import importlib.util
import re
import shlex
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

import fefinger
from fefinger.calibration.slow_press import PLATE
from fefinger.commands.cli import cli
from fefinger.mechanics import names as mechanics
from fefinger.scene import builtin
from fefinger.scene.scene import Scene
from fefinger.studies.grid import parse_over
from fefinger.support.vocabulary import TYPES


ROOT = Path(__file__).parents[1]
PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md")))


def commands() -> Iterator[tuple[str, list[str]]]:
    """Yield page and words of each command that a page shows, in a block or in a line."""
    for page in PAGES:
        text = page.read_text(encoding="utf-8").replace("\\\n", "")
        shown = re.findall(r"```sh\n(.*?)```", text, re.S) + re.findall(r"`([^`\n]+)`", text)
        for line in (part for block in shown for part in re.split(r"\n|&&", block)):
            words = shlex.split(line, comments=True)
            if words and words[0].rpartition("/")[2] in ("fefinger", "python", "python3"):
                yield page.name, words


@pytest.fixture(scope="module")
def generate():
    """Return the module that writes pages from the code."""
    spec = importlib.util.spec_from_file_location("generate", ROOT / "docs" / "generate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_of_the_api_lists_every_public_name(generate):
    generate.check_api(ROOT / "docs")


def test_a_public_name_that_is_not_listed_is_reported(generate, tmp_path):
    text = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    (tmp_path / "api.md").write_text(text.replace("   Sphere\n", ""), encoding="utf-8")
    with pytest.raises(ValueError, match="'Sphere'"):
        generate.check_api(tmp_path)


def test_the_package_names_only_what_is_public_in_its_help():
    table = fefinger.__doc__[fefinger.__doc__.index("answer  ") :].partition("\n\n")[0]
    named = set(re.findall(r"\b(?:[A-Z][a-z]+)+\b", table))
    assert len(named) > 20
    assert named <= set(fefinger.__all__)


def test_every_extra_and_every_command_is_described(generate):
    assert "`nwb`" in "\n".join(generate.extras())
    commands = "\n".join(generate.commands())
    assert "## `fefinger run`" in commands
    assert "a folder that `fefinger run -o` wrote" in commands


def test_a_key_has_its_values_its_default_and_its_meaning(generate):
    from fefinger.scene.schema import schema

    text = "\n".join(generate.keys(schema()))
    assert '| `cut` | `"fixed"`, `"nail"` | `"fixed"` | Boundary condition' in text
    assert "| `speed` | number > 0 | needed | Speed [mm/s] |" in text


def test_the_readme_is_a_page_and_begins_with_the_two_commands():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 100
    blocks = text.split("```sh\n")[1:3]
    assert "fefinger run flat-press -o out" in blocks[0]
    assert "pytest" in blocks[1]


def test_every_folder_of_modules_is_a_package_of_the_wheel():
    """One that is missing works from the checkout, and not for who installs the wheel."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    listed = set(tomllib.loads(text)["tool"]["setuptools"]["packages"])
    for top, name in (("fefinger", "fefinger"), ("validation", "fefinger.validation")):
        for init in (ROOT / top).rglob("__init__.py"):
            parts = init.parent.relative_to(ROOT / top).parts
            assert ".".join((name, *parts)) in listed


def test_what_the_page_on_scenes_says_to_write_is_a_scene():
    """Each row of its table changes one table of a press."""
    text = (ROOT / "docs" / "scenes.md").read_text(encoding="utf-8")
    rows = re.findall(
        r"^\| .* \| `\[(indenter|motion)\]` `(kind = .*)` \|[^|]*\|$", text, re.MULTILINE
    )
    assert len(rows) >= 6
    for part, keys in rows:
        written = tomllib.loads("\n".join(keys.split("`, `")))
        press = {"kind": "ramp-hold", "speed": 20, "depth": 1, "hold": 1}
        scene = Scene.from_dict({"finger": {"subject": "a.h."}, "motion": press} | {part: written})
        assert getattr(scene, part).kind == written["kind"]


@pytest.mark.parametrize(
    "words",
    [words for _, words in commands() if words[0].endswith("fefinger")],
    ids=" ".join,
)
def test_a_command_of_the_pages_takes_its_options_and_its_fields(words: list[str]) -> None:
    asked = words[1 : words.index(">") if ">" in words else None]
    if len(asked) < 2 or "..." in asked:  # a command that is named
        assert not asked or asked[0] in cli.commands or asked[0].startswith("-")
        return
    command = cli.commands[asked[0]]
    given = command.make_context(asked[0], asked[1:]).params
    assert given.get("mechanics") in (None, "each", "NAME", *mechanics())
    assert set(given.get("types") or ()) <= set(TYPES)
    changes = [text for text in given.get("changes", ()) if ".toml" not in text]
    scene = given.get("name" if asked[0] == "scenes" else "scene")
    if scene is not None:
        fields = parse_over(given.get("grid", ()))
        first = {field: values[0] for field, values in fields.items()}
        own = scene.endswith(".toml") or scene == "SCENE"
        builtin.load("flat-press" if own else scene, builtin.settings(changes) | first)


def test_a_module_that_the_pages_run_is_one() -> None:
    modules = {
        words[words.index("-m") + 1]
        for _, words in commands()
        if "-m" in words and words[0].rpartition("/")[2].startswith("python")
    }
    assert "fefinger.validation.afferents.fit" in modules
    for module in modules:
        assert importlib.util.find_spec(module) is not None, module


def test_who_calibrates_is_told_the_angle_of_the_plate() -> None:
    """At another angle the same press takes another force, and would give another tissue."""
    page = (ROOT / "docs" / "calibrate.md").read_text(encoding="utf-8")
    for text in (fefinger.calibrate.__doc__, cli.commands["calibrate"].help, page):
        assert f"a plate at {PLATE.angle:g} degrees to the bone" in " ".join(str(text).split())
