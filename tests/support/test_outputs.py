"""Output folders of any name are made, or refused in a sentence."""

import os
from pathlib import Path

import pytest

from fefinger.support.checks import InputError
from fefinger.support.outputs import output, output_file


def test_a_thousand_folders_in_one_another_are_made_and_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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
def test_a_folder_that_cannot_be_made_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    says = "output folder: expected a folder that can be written"
    with pytest.raises(InputError, match=says), output(name):
        pass
    assert not os.listdir(tmp_path)
    with pytest.raises(InputError, match=says):
        output_file(f"{name}/a.vtu", "-o")
