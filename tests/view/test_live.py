"""`fefinger live`: what is on screen, and the file that it is recorded to."""

import subprocess

import numpy as np
import pytest
from PIL import Image

from fefinger.__main__ import main
from fefinger.fem.elements.probe import strain_at
from fefinger.scene.finger import Finger
from fefinger.scene.library import PUBLISHED
from fefinger.support.checks import InputError
from fefinger.view import live, renderer_lacking
from fefinger.view.live import Show, Window, watch


FINGER = Finger.subject("a.h.", resolution="coarse", tissue=PUBLISHED)
SCRIPT = live.SCRIPT
SHORT = ((0.0, 0.0, 25.0), (0.06, 0.6, 25.0), (0.12, 0.6, 20.0))


@pytest.fixture(autouse=True)
def _short_and_own_cache(operators, monkeypatch):
    """Play a tenth of a second, with the operators of this session."""
    monkeypatch.setattr(live, "SCRIPT", SHORT)


@pytest.fixture
def _renderer():
    """Skip where VTK cannot draw."""
    if lacking := renderer_lacking():
        pytest.skip(lacking)  # a library of the system, which no Python package brings


def test_a_frame_has_what_is_drawn():
    show = Show(FINGER)
    strain_at(show.rolling.solid.space, show.organs.points, (1,))  # all inside
    frames = list(show.frames())
    assert [frame.time for frame in frames] == pytest.approx([0.0, 0.04, 0.08, 0.12])
    first, last = frames[0], frames[-1]
    assert first.force == 0.0
    assert last.force > 0.05
    assert last.angle == pytest.approx(20)
    assert last.strain.shape == (len(show.section), 6)
    assert (last.steps, len(last.spikes)) == (121, len(frames[-1].spikes))
    assert {show.organs.types[unit] for unit, _ in last.spikes} >= {"SAI", "FAI"}
    assert last.rate > 0
    assert np.isfinite(last.strain).all()


@pytest.mark.usefixtures("_renderer")
def test_it_is_recorded_with_the_rate(tmp_path, capsys):
    file = tmp_path / "new" / "show.gif"
    assert main(["live", "-o", str(file), "--resolution", "coarse"]) == 0
    assert "121 steps of 1 ms at" in capsys.readouterr().out
    with Image.open(file) as picture:
        assert picture.n_frames >= 3
        assert np.asarray(picture.convert("RGB")).std() > 10


@pytest.mark.usefixtures("_renderer")
def test_it_is_recorded_as_a_film_that_browsers_play(tmp_path):
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    file = tmp_path / "show.mp4"
    live.record(FINGER, file)
    words = [imageio_ffmpeg.get_ffmpeg_exe(), *("-i", file), *("-f", "rawvideo")]
    words += ["-pix_fmt", "rgb24", "-"]
    played = subprocess.run(words, capture_output=True, check=True)
    assert b"h264" in played.stderr
    assert b"900x900" in played.stderr
    pictures = np.frombuffer(played.stdout, np.uint8).reshape(-1, 900, 900, 3)
    assert len(pictures) == 4
    assert pictures[0].std() > 10
    assert not np.array_equal(pictures[0], pictures[-1])


@pytest.mark.usefixtures("_renderer")
def test_a_window_shows_what_is_recorded():
    show = Show(FINGER)
    window = Window(show, off_screen=True)
    pictures = []
    for frame in show.frames():
        window.draw(frame)
        pictures.append(window.plotter.screenshot(return_img=True).astype(float))
    window.plotter.close()
    top, bottom = slice(0, 600), slice(660, 880)
    assert np.abs(pictures[-1][top] - pictures[0][top]).max() > 50  # pressure and strain
    assert np.abs(pictures[-1][bottom] - pictures[0][bottom]).max() > 50  # spikes
    assert frame.pressure.max() > 0
    assert window.pad["pressure, kPa"].max() == pytest.approx(frame.pressure.max(), rel=1e-6)
    assert "steps/s" in window.text.GetText(2)


def test_what_cannot_be_shown_gets_a_sentence(tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"ends in \.gif or \.mp4"):
        live.record(FINGER, tmp_path / "show.avi")
    for display in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(display, raising=False)
    with pytest.raises(InputError, match=r"[Rr]ecord with -o FILE\.gif"):
        watch(FINGER)


@pytest.mark.parametrize("subject", ["d.p.", "p.w."])  # the thinnest and the thickest
def test_the_script_stays_within_the_contact_of_every_subject(monkeypatch, subject):
    monkeypatch.setattr(live, "SCRIPT", SCRIPT)
    monkeypatch.setattr(live, "DT", 0.01)
    frames = list(Show(Finger.subject(subject, resolution="coarse", tissue=PUBLISHED)).frames())
    assert frames[-1].steps == 361
    assert max(frame.depth for frame in frames) == pytest.approx(1.0)
