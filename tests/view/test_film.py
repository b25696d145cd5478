"""Films: their colors, and the formats that they have."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from fefinger import view
from fefinger.result import Result
from fefinger.support.checks import InputError
from fefinger.view import film as films


def test_a_gif_has_no_bands(tmp_path: Path) -> None:
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


def test_an_mp4_needs_its_extra(
    synthetic: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    with pytest.raises(InputError, match=r"pip install 'fefinger\[film\]'`, or .*\.gif"):
        view.movie(synthetic, tmp_path / "a.mp4")
    with pytest.raises(InputError, match=r"ends in \.gif or \.mp4, received 'a\.avi'"):
        view.movie(synthetic, tmp_path / "a.avi")


def test_an_mp4_plays(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    shades = (np.full((33, 47, 3), shade, np.uint8) for shade in range(0, 250, 25))
    films.write(tmp_path / "a.mp4", shades, 8)
    assert (tmp_path / "a.mp4").read_bytes()[4:8] == b"ftyp"
