"""Files in and out: regular ones alone, within bounds; folders of any name or a sentence."""

import os
import stat
import tomllib
from pathlib import Path

import pytest

from fefinger.support.atomic_write import output, output_file
from fefinger.support.checks import InputError
from fefinger.support.inputs import DEEPEST, bounded, parse_toml, read_json, read_text, unreadable


def test_what_is_no_file_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    os.mknod("socket", stat.S_IFSOCK)
    Path("loop").symlink_to("loop")
    Path("file").touch()
    Path("link").symlink_to("file")
    said = {name: unreadable(name) for name in ("pipe", "socket", "loop", "file", "link", ".")}
    nothing = "does not exist"
    assert said == {
        **{"pipe": "is a pipe", "socket": "is a socket", "loop": nothing},
        **{"file": "", "link": "", ".": "is a folder"},
    }
    assert unreadable("/dev/zero") == "is a device"
    assert unreadable("/proc/self/mem") == "cannot be read (Input/output error)"  # as a bad disk
    assert unreadable("x" * 5000) == unreadable("a\0b") == nothing


DEEP = {
    "lists": "a = " + "[" * 1000 + "]" * 1000,
    "within the parser's reach": "a = " + "[" * 99 + "]" * 99,
    "tables": "a = " + "{a = " * 1000 + "1" + "}" * 1000,
    "dotted keys": ".".join("a" * 1000) + " = 1",
    "dotted table": f"[{'.'.join('a' * 1000)}]",
    "digits": "a = " + "1" * 5000,
    "hexadecimal digits": "a = 0x" + "F" * 5000,
}


@pytest.mark.parametrize("text", DEEP.values(), ids=DEEP)
def test_toml_beyond_the_bounds_is_refused(text):
    with pytest.raises(InputError, match="expected values inside at most 32 tables") as refused:
        parse_toml("finger.tissue", text)
    assert refused.value.field == "finger.tissue"


def test_toml_within_the_bounds_is_read():
    inside = "[" * (DEEPEST - 1) + "1" + "]" * (DEEPEST - 1)
    assert parse_toml("x", f"a = {inside}\nb = 0xFFFFFFFFFFFFFFFF")["b"] == 2**64 - 1
    with pytest.raises(InputError):
        parse_toml("x", f"a = [{inside}]")
    with pytest.raises(tomllib.TOMLDecodeError):
        parse_toml("x", "a = = 1")
    circle: list[object] = []
    circle.append(circle)
    with pytest.raises(InputError):
        bounded("x", {"a": circle})


@pytest.mark.parametrize(
    "text", ["", "[" * 100_000, "[NaN]", "[Infinity]", "1" * 5000, '{"a": ' * 50 + "1" + "}" * 50]
)
def test_a_file_that_is_no_json_within_the_bounds_is_refused(tmp_path, text):
    file = tmp_path / "a.json"
    file.write_text('{"a": [1, 2.5, null]}')
    assert read_json(file) == {"a": [1, 2.5, None]}
    file.write_text(text)
    with pytest.raises(InputError):
        read_json(file)


def test_text_is_utf_8_with_or_without_a_mark(tmp_path):
    file = tmp_path / "a.txt"
    file.write_text("\ufeffmm²", encoding="utf-8")
    assert read_text("x", file, "a text") == "mm²"
    file.write_bytes(b"\xff")
    with pytest.raises(InputError, match=r"x: expected a text, received '.*', no text \(UTF-8\)"):
        read_text("x", file, "a text")


def test_a_thousand_folders_in_one_another_are_made_and_removed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the whole path has at most 4096 characters
    with output("a/" * 1500) as made:
        assert made is not None
        assert made.is_dir()
    assert made.is_dir()
    with pytest.raises(ZeroDivisionError), output("b/" * 1500):
        _ = 1 / 0
    assert not Path("b").exists()
    while made != Path():  # pytest removes folders by recursion
        made.rmdir()
        made = made.parent


@pytest.mark.parametrize("name", ["x" * 300, "a/" + "x" * 300, "a\0b", "/dev/null/x"])
def test_a_folder_that_cannot_be_made_is_refused(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    says = "output folder: expected a folder that can be written"
    with pytest.raises(InputError, match=says), output(name):
        pass
    assert not os.listdir(tmp_path)
    with pytest.raises(InputError, match=says):
        output_file(f"{name}/a.vtu", "-o")
