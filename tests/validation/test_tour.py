"""The tour: what the README shows is what a newcomer gets."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import fefinger as ff
from fefinger import view
from fefinger.__main__ import main
from fefinger.scene import builtin


README = Path(__file__).resolve().parents[2] / "README.md"


def blocks(language):
    """Return the fenced blocks of the README in a language."""
    text = README.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.S | re.M)


def test_what_the_readme_shows_runs_loads_and_is_drawn(tmp_path, monkeypatch, capsys):
    """The scene and the Python, the section in the report, a picture, a page."""
    monkeypatch.chdir(tmp_path)
    (scene,), (code,) = blocks("toml"), blocks("python")
    assert "\nhold = 2 " in scene
    coarse = scene.replace("[finger]", '[finger]\nresolution = "coarse"')
    coarse = coarse.replace("\nhold = 2 ", "\nhold = 0.2 ")
    Path("mine.toml").write_text(coarse, encoding="utf-8")
    assert ff.Scene.from_toml(scene).ask.rel_error == 0.1
    names: dict[str, Any] = {}
    exec(code, names)
    assert 0.05 < names["compression"].max() < 0.5
    loaded = ff.load("out")
    assert loaded.force == pytest.approx(names["result"].force)
    assert loaded.spikes.count().tolist() == names["result"].spikes.count().tolist()
    assert {path.name for path in Path("out").iterdir()} == {
        "report.html",
        "result.nc",
        "result.vtkhdf",
        "spikes.csv",
        "units.csv",
    }
    assert 'id="section"' in Path("out/report.html").read_text(encoding="utf-8")
    assert main(["view", "out", "--field", "tensile strain", "--html", "strain.html"]) == 0
    page = Path("strain.html").read_text(encoding="utf-8")
    assert '"my-press", "words": "pressed (logarithmic strain)"' in page
    if not view.renderer_lacking():
        assert main(["view", "out", "--field", "pressure", "--screenshot", "pad.png"]) == 0
        with Image.open("pad.png") as picture:
            assert np.ptp(np.asarray(picture)) > 100
    assert "Traceback" not in capsys.readouterr().err


def test_every_command_of_the_readme_is_one(capsys):
    text = README.read_text(encoding="utf-8")
    shown = set(re.findall(r"`fefinger ([a-z]+)", text)) | {"run"}
    assert main(["--help"]) == 0
    listed = capsys.readouterr().out
    for command in shown:
        assert re.search(rf"^  {command}\b", listed, re.M), command


# The protocols of the thesis are asked in test_protocols.py.
@pytest.mark.parametrize("name", [name for name in builtin.names() if not name[1:2].isdigit()])
def test_every_built_in_scene_can_be_answered(name):
    scene = builtin.load(name)
    plan = ff.explain(scene)
    if scene.ask.mechanics is None:
        assert not plan.chosen.refusals
    else:
        assert plan.mechanics == scene.ask.mechanics
