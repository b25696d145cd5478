"""What the documentation states of the code, without building it."""

import importlib.util
import re
import tomllib
from pathlib import Path

import pytest

from fefinger.scene.scene import Scene


ROOT = Path(__file__).parents[1]


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


def test_every_extra_and_every_command_is_described(generate):
    assert "`nwb`" in "\n".join(generate.extras())
    assert "## `fefinger run`" in "\n".join(generate.commands())


def test_a_key_has_its_values_its_default_and_its_meaning(generate):
    from fefinger.scene.schema import schema

    text = "\n".join(generate.keys(schema()))
    assert '| `cut` | `"fixed"`, `"nail"` | `"fixed"` | Boundary condition' in text
    assert "| `speed` | number > 0 | needed | Speed in mm/s |" in text


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
    rows = re.findall(r"^\| .* \| `\[(indenter|motion)\]` `(kind = .*)` \|$", text, re.MULTILINE)
    assert len(rows) >= 6
    for part, keys in rows:
        written = tomllib.loads("\n".join(keys.split("`, `")))
        press = {"kind": "ramp-hold", "speed": 20, "depth": 1, "hold": 1}
        scene = Scene.from_dict({"finger": {"subject": "a.h."}, "motion": press} | {part: written})
        assert getattr(scene, part).kind == written["kind"]
