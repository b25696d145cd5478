"""`fefinger live`: what is on screen, and the file that it is recorded to."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from fefinger import live
from fefinger.__main__ import main
from fefinger.checks import InputError
from fefinger.fem.probe import strain_at
from fefinger.finger import Finger


FINGER = Finger.subject("a.h.", resolution="coarse")
SHORT = ((0.0, 0.0, 25.0), (0.06, 0.6, 25.0), (0.12, 0.6, 20.0))


@pytest.fixture(autouse=True)
def _short_and_own_cache(operators: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Play a tenth of a second, with the operators of this session."""
    monkeypatch.setattr(live, "SCRIPT", SHORT)


def test_a_frame_has_what_is_drawn() -> None:
    show = live.Show(FINGER)
    strain_at(show.rolling.solid.space, show.organs.points, medial=True)  # all inside
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


def test_it_is_recorded_with_the_rate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "new" / "show.gif"
    assert main(["live", "-o", str(file), "--resolution", "coarse"]) == 0
    assert "121 steps of 1 ms at" in capsys.readouterr().out
    with Image.open(file) as picture:
        assert picture.n_frames >= 3
        assert np.asarray(picture.convert("RGB")).std() > 10


def test_what_cannot_be_shown_gets_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"ends in \.gif or \.mp4"):
        live.record(FINGER, tmp_path / "show.avi")
    with pytest.raises(InputError, match=r"record with -o FILE\.gif"):
        live.watch(FINGER)
