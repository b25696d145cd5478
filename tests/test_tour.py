"""The tour: what the README shows is what a newcomer gets."""

import re
from pathlib import Path

import pytest

import fefinger as ff
from fefinger import scenes
from fefinger.__main__ import main


README = Path(__file__).resolve().parents[1] / "README.md"


def blocks(language: str) -> list[str]:
    """Return the fenced blocks of the README in a language."""
    text = README.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.S | re.M)


def test_the_scene_of_the_readme_is_the_scene_of_its_python() -> None:
    (toml,) = blocks("toml")
    written = ff.Scene.from_toml(toml)
    names: dict[str, object] = {}
    code = blocks("python")[0]
    exec(code[: code.index("result =")], names)
    shown = names["scene"]
    for part in ("finger", "indenter", "motion", "ask"):
        assert getattr(written, part) == getattr(shown, part)


def test_the_python_of_the_readme_runs_and_its_result_loads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    code = blocks("python")[0]
    exec(code.replace('subject("a.h.")', 'subject("a.h.", resolution="coarse")'), names)
    loaded = ff.load("out")
    assert loaded.force == pytest.approx(names["result"].force)
    assert loaded.spikes.count().tolist() == names["result"].spikes.count().tolist()
    assert {path.name for path in Path("out").iterdir()} == {
        "report.html",
        "result.nc",
        "result.vtkhdf",
        "spikes.csv",
    }


def test_the_loop_of_the_readme_steps_a_finger() -> None:
    names: dict[str, object] = {"ff": ff}
    code = blocks("python")[1]
    exec(code.replace('subject("a.h.")', 'subject("a.h.", resolution="coarse")'), names)
    assert names["step"].force > 0
    assert names["step"].contact_area > 0


def test_every_command_of_the_readme_is_one(capsys: pytest.CaptureFixture[str]) -> None:
    text = README.read_text(encoding="utf-8")
    shown = set(re.findall(r"`fefinger ([a-z]+)", text)) | {"run"}
    assert main(["--help"]) == 0
    listed = capsys.readouterr().out
    for command in shown:
        assert re.search(rf"^  {command}\b", listed, re.M), command


@pytest.mark.parametrize("name", scenes.names())
def test_every_built_in_scene_can_be_answered(name: str) -> None:
    plan = ff.explain(scenes.load(name))
    assert not plan.chosen.refusals
