"""Spectra of a slide: the span of one velocity, what it meets how often, and the drawn lines."""

from dataclasses import replace

import numpy as np
import pytest

import fefinger as ff
from fefinger.geometry.profiles import frame
from fefinger.pages import report
from fefinger.scene.indenter import direction
from fefinger.view import renderer, spectrum_figure


SLIDE = ff.Slide(20, 0.5, distance=10, direction=180, settle=0.1, corner=0.02)


def scene(indenter, ridges=None):
    finger = ff.Finger.subject("a.h.", tissue="maeno1998", ridges=ridges)
    return ff.Scene(finger=finger, indenter=indenter, motion=SLIDE)


@pytest.fixture
def slid(synthetic):
    """Return the synthetic result over a grating: inputs of 2 um at the rate of its ridges."""
    time = np.arange(0, SLIDE.duration, 5e-4)
    trains = replace(
        synthetic.spikes,
        times=(np.arange(0.1, SLIDE.duration, 1 / 40),) * len(synthetic.spikes),
        t_start=SLIDE.recorded_from,
        t_stop=SLIDE.duration,
        time=time,
        x_in=np.tile(2e-3 * np.sin(2 * np.pi * 40 * time), (len(synthetic.spikes), 1)).T,
        positions=None,
        current=np.ones((len(time), len(synthetic.spikes))),
    )
    grating = ff.Grating(period=0.5, ridge=0.2, depth=0.1)
    return replace(synthetic, scene=scene(grating, ff.Ridges(pitch=0.4)), spikes=trains)


OBJECTS = {
    "grating": ff.Grating(period=2.0, ridge=0.8, depth=0.3, roll=35.0),
    "dots along a line": ff.Dots(2.0),
    "dots along a diagonal": ff.Dots(2.0, roll=45.0),
    "fabric": ff.Fabric(yarn=1.5, roughness=0.0, roll=-90.0),
}


@pytest.mark.parametrize("name", OBJECTS)
def test_a_place_of_the_skin_meets_the_same_height_after_one_over_the_frequency(name):
    indenter, velocity = OBJECTS[name], np.array([-30.0, 12.0] if name == "grating" else [-30.0, 0])
    ((_, frequency),) = spectrum_figure.meetings(scene(indenter), velocity).items()
    axis = direction(indenter)
    moved = frame(axis, indenter.turn)[:2] @ frame(axis)[:2].T @ velocity
    rise, place = indenter.profile.rise, np.random.default_rng(1).uniform(-3, 3, (200, 2))
    assert rise(place + moved / frequency) == pytest.approx(rise(place), abs=1e-6)
    assert np.abs(rise(place + moved / (2 * frequency)) - rise(place)).max() > 0.01


def test_a_grid_that_moves_aslant_repeats_along_each_of_its_own_axes():
    found = spectrum_figure.meetings(scene(ff.Dots(2.0, roll=20.0)), np.array([-30.0, 0.0]))
    expected = 15 * np.cos(np.radians(20)), 15 * np.sin(np.radians(20))
    names = [f"speed / period along {axis}" for axis in "xy"]
    assert found == pytest.approx(dict(zip(names, expected, strict=True)))


def test_ridges_are_met_across_them_and_by_no_plate():
    velocity = np.array([-30.0, 40.0])
    texture = ff.Dots(2.0, arrangement="random")
    for ridges, expected in (
        (ff.Ridges(pitch=0.5), 60.0),
        (ff.Ridges(pitch=0.5, direction=90), 80.0),
        (ff.Ridges(pitch=0.5, shape="concentric"), 100.0),
    ):
        found = spectrum_figure.meetings(scene(texture, ridges), velocity)
        assert found["speed / ridge pitch"] == pytest.approx(expected)
        assert found["speed / period"] == 0
    assert "speed / ridge pitch" not in spectrum_figure.meetings(
        scene(ff.Flat(30.0), ff.Ridges()), velocity
    )


def test_a_press_and_a_slide_of_few_periods_have_no_spectrum(synthetic, slid):
    assert spectrum_figure.even_slide(synthetic) is None
    wide = replace(slid, scene=scene(ff.Grating(period=3.0, ridge=1.0, depth=0.3)))
    assert spectrum_figure.even_slide(wide) is None
    ridged = replace(wide, scene=replace(wide.scene, finger=slid.scene.finger))
    found = spectrum_figure.even_slide(ridged)
    assert list(found.marks) == ["speed / ridge pitch"]
    assert "repeats" not in spectrum_figure.caption(found)


def test_input_in_um_and_spikes_are_drawn_with_their_lines(slid):
    even = spectrum_figure.even_slide(slid)
    assert even.marks == pytest.approx({"speed / period": 40.0, "speed / ridge pitch": 50.0})
    assert even.start == pytest.approx(SLIDE.recorded_from + SLIDE.corner)
    drawn = spectrum_figure.draw(slid, even)
    tops = []
    for axis in drawn.axes:
        frequency, amplitude = axis.lines[0].get_data()
        near = np.abs(frequency - 40) < 10
        tops.append((frequency[near][amplitude[near].argmax()], amplitude[near].max()))
    assert tops[0] == pytest.approx((40.0, 2.0), rel=0.03)
    assert tops[1] == pytest.approx((40.0, 80.0), rel=0.03)
    assert "20 mm/s" in spectrum_figure.caption(even)


def test_the_report_of_an_even_slide_has_the_spectrum_and_does_not_deny_ridges(
    slid, tmp_path, monkeypatch
):
    monkeypatch.setattr(renderer, "renderer_lacking", lambda: "No renderer.")
    monkeypatch.setattr("fefinger.pages.page.svg", lambda drawn: "data:,")
    report.write(slid, tmp_path / "report.html")
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert '<section id="spectrum"' in html
    assert "the object slides at 20 mm/s, from" in html
    assert "No papillae: an end organ is a point" in html
    assert "No ridges" not in html
