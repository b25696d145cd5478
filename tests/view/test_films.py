"""Films: their colors and formats; the titles of results that are shown side by side."""

import dataclasses
import re

import numpy as np
import pytest
from PIL import Image
from refusals import refused

from fefinger import view
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.motions import Sinusoid
from fefinger.view import pictures as films
from fefinger.view.drawing import titles


def test_a_gif_has_no_bands(tmp_path):
    """Three maps and their shades: 256 colors have to be mixed."""
    from matplotlib import colormaps

    value, shade = np.meshgrid(np.linspace(0, 1, 240), np.linspace(0.7, 1.0, 40))
    maps = [colormaps[name](value)[..., :3] for name in ("viridis", "OrRd", "plasma")]
    picture = np.concatenate([np.round(255 * shade[..., None] * each) for each in maps])
    picture = picture.astype(np.uint8)
    films.write(tmp_path / "a.gif", iter([picture] * 2), 8)
    with Image.open(tmp_path / "a.gif") as film:
        back = np.asarray(film.convert("RGB"), float)
    off = (back - picture).reshape(15, 8, 30, 8, 3).mean(axis=(1, 3))
    assert np.sqrt(np.mean(off**2)) < 1.0


def test_an_mp4_needs_its_extra(synthetic, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    with refused("--movie"):
        view.movie(synthetic, tmp_path / "a.mp4")
    with refused("--movie"):
        view.movie(synthetic, tmp_path / "a.avi")


def test_an_mp4_plays(tmp_path):
    pytest.importorskip("imageio_ffmpeg")
    shades = (np.full((33, 47, 3), shade, np.uint8) for shade in range(0, 250, 25))
    films.write(tmp_path / "a.mp4", shades, 8)
    assert (tmp_path / "a.mp4").read_bytes()[4:8] == b"ftyp"


def turned(result, angle):
    scene = dataclasses.replace(result.scene, indenter=Flat(angle))
    return dataclasses.replace(result, scene=scene)


def test_panels_are_called_as_their_folders_with_what_differs(synthetic):
    both = [turned(synthetic, angle) for angle in (30.0, 20.0)]
    name = synthetic.scene.name
    assert titles(both, ["runs/a-1.5", "runs/b/result.nc"]) == (
        f"a-1.5: {name}, indenter.angle 30 deg",
        f"b: {name}, indenter.angle 20 deg",
    )
    assert titles(both) == (f"{name}, indenter.angle 30 deg", f"{name}, indenter.angle 20 deg")
    assert titles(both[:1], ["runs/a"]) == (name,)
    slow = dataclasses.replace(both[0].scene, motion=Sinusoid(0.3, 5.0, 2))
    other = [both[1], dataclasses.replace(both[0], scene=slow)]
    assert titles(other)[1] == f"{name}, motion.kind sinusoid, indenter.angle 30 deg"
    faces = [dataclasses.replace(each, scene=dataclasses.replace(each.scene, indenter=indenter))
             for each, indenter in zip(both, (Sphere(3.0), Flat(10.0)), strict=True)]  # fmt: skip
    assert titles(faces)[0] == f"{name}, indenter.kind sphere"
    second = dataclasses.replace(faces[1].scene, finger=Finger.subject("p.w.", tissue="maeno1998"))
    told = titles([faces[0], dataclasses.replace(faces[1], scene=second)])[1].split(", ")
    assert told[1:3] == ["indenter.kind flat", "finger.subject p.w."]
    wide = dataclasses.replace(both[0].scene.finger, width=15, thickness=9, pad_radius=12)
    bare = dataclasses.replace(both[1].scene, finger=wide)
    far = titles([both[0], dataclasses.replace(both[1], scene=bare)])
    assert all(re.search(r", \d more$", title) for title in far)
