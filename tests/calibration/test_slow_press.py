"""Presses, and what is kept of them."""

from dataclasses import replace

import numpy as np
import pytest
from damage import flip

import fefinger as ff
from fefinger.calibration import slow_press as presses
from fefinger.calibration.slow_press import press
from fefinger.mechanics import hertz
from fefinger.support import cache
from fefinger.support.checks import InputError, Stopped


FINGER = ff.Finger.subject("a.h.", tissue="maeno1998")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Keep presses in a folder of the test, and solve them by `hertz`."""
    monkeypatch.setattr(cache, "root", lambda: tmp_path)
    monkeypatch.setattr("fefinger.mechanics.get", lambda name: hertz)
    return tmp_path / "presses"


def test_a_press_is_solved_once_and_kept(folder, monkeypatch):
    solved = []

    class Way:
        @staticmethod
        def respond(scene, progress=None):
            solved.append(scene)
            return hertz.respond(scene)

    monkeypatch.setattr("fefinger.mechanics.get", lambda name: Way)
    monkeypatch.setattr("fefinger.mechanics.solid.respond", lambda scene, **_: Way.respond(scene))
    finger = FINGER
    first, again = press(finger, "condensed"), press(finger, "condensed")
    assert len(solved) == 1
    # exact: a file keeps every bit
    np.testing.assert_array_equal(first.array_pressure, again.array_pressure)
    other = replace(finger, subcutaneous=replace(finger.subcutaneous, modulus=20.0))
    press(other, "condensed")
    press(finger, "solid")
    assert len(solved) == 3
    flip(next(iter(folder.glob("*/press.npz"))))
    for each in (finger, other):
        press(each, "condensed")
    press(finger, "solid")
    assert len(solved) == 4


@pytest.mark.parametrize("left", [0.0, 0.5])
def test_a_press_whose_file_was_cut_short_is_solved_again(folder, left):
    first = press(FINGER, "condensed")
    (file,) = folder.glob("*/press.npz")
    whole = file.read_bytes()
    file.write_bytes(whole[: int(left * len(whole))])
    again = press(FINGER, "condensed").array_pressure
    np.testing.assert_allclose(again, first.array_pressure, rtol=1e-9)
    with np.load(file) as kept:  # and kept anew
        np.testing.assert_array_equal(kept["array_pressure"], again)  # exact: a file keeps all bits


def test_a_pad_that_condensed_does_not_reach_is_pressed_by_linear(monkeypatch):
    def refuse(scene, progress=None):
        msg = "beyond the side of the finger"
        raise InputError(msg)

    ways = {"condensed": type("W", (), {"respond": refuse}), "linear": hertz}
    monkeypatch.setattr("fefinger.mechanics.get", ways.get)
    assert presses.small(FINGER).depth[-1] == pytest.approx(1.8)


def test_kept_presses_are_listed_in_the_cache(folder):
    press(FINGER, "condensed")
    (entry,) = cache.entries()
    assert (entry.kind, entry.path.parent) == ("presses", folder)
    assert 0 < entry.size < 1e6
    cache.remove([entry])
    assert cache.entries() == ()


def test_a_press_that_stops_is_kept_as_far_as_it_went(monkeypatch):
    def stop(scene, *, allowance):
        assert (allowance.usual, allowance.spare) == (presses.USUAL, presses.SPARE)
        whole = hertz.respond(scene)
        n = len(whole.time) * 2 // 3
        cut = {
            name: getattr(whole, name)[:n]
            for name in ("time", "depth", "force", "contact_area", "pressure")
        }
        msg = "no further"
        raise Stopped(msg, replace(whole, **cut))

    monkeypatch.setattr("fefinger.mechanics.solid.respond", stop)
    found = press(FINGER, "solid")
    assert found.halt == "no further"
    assert 1.0 < found.depth[-1] < 1.3
