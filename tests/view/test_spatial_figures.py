"""Spikes on the object: where units were over it, rates over the time that they were there."""

from dataclasses import replace

import numpy as np
import pytest

import fefinger as ff
from fefinger.results.records import Lateral
from fefinger.view import frames, spatial_figures


SLIDE = ff.Slide(20, 0.5, distance=4, direction=180, settle=0.1, passes=2)


@pytest.fixture
def slid(synthetic):
    """Return the synthetic result with dots that slide under its units, one spike a millisecond."""
    time = np.linspace(0, SLIDE.duration, 400)
    scene = replace(synthetic.scene, indenter=ff.Dots(2.0, roll=90), motion=SLIDE)
    shift = SLIDE.shift(time)
    trains = synthetic.spikes
    spikes = np.arange(0.2, SLIDE.duration, 1e-3)
    trains = replace(
        trains,
        times=(spikes,) * len(trains),
        t_start=SLIDE.recorded_from,
        t_stop=SLIDE.duration,
        positions=np.tile([0.0, 0.3, 0.0], (len(trains), 1)),
        stimulus_driven=np.zeros(len(trains), dtype=int),
    )
    count = len(time)
    response = replace(
        synthetic.response,
        time=time,
        depth=np.zeros(count),
        force=np.ones(count),
        lateral=Lateral(shift, np.zeros((count, 2))),
    )
    return replace(synthetic, scene=scene, response=response, spikes=trains)


def test_a_spike_is_drawn_at_the_place_of_the_object_that_was_over_its_unit(slid):
    spots, times = spatial_figures.places(slid, np.array([0]))
    shift = SLIDE.shift(times)
    # With a roll of 90 degrees the object's x lies along the finger's y, its y against the x.
    expected = np.column_stack([0.3 - shift[:, 1], shift[:, 0]])
    assert spots == pytest.approx(expected, abs=0.02)


def test_a_path_that_starts_aside_has_its_spikes_where_the_object_was(slid):
    response = slid.response
    aside = np.array([3.0, -1.0])
    shift = aside + response.lateral.shift
    columns = (tuple(each.tolist()) for each in (response.time, *shift.T))
    path = ff.SampledPath(*columns, depth=(0.5,) * len(shift))
    there = replace(response, lateral=replace(response.lateral, shift=shift))
    moved = replace(slid, scene=replace(slid.scene, motion=path), response=there)
    before, after = (spatial_figures.places(each, np.array([0]))[0] for each in (slid, moved))
    assert after - before == pytest.approx(np.tile([-aside[1], aside[0]], (len(after), 1)))


def test_conduction_delays_move_no_spike_on_the_object(slid):
    near, units = slid.spikes, np.arange(len(slid.spikes))
    delays = np.linspace(0.005, 0.02, len(near))
    late = tuple(times + delay for times, delay in zip(near.times, delays, strict=True))
    far = replace(near, times=late, delays=delays, t_stop=near.t_stop + 0.02)
    spots, times = spatial_figures.places(replace(slid, spikes=far), units)
    expected, at_skin = spatial_figures.places(slid, units)
    np.testing.assert_allclose(spots, expected, atol=1e-9)
    np.testing.assert_allclose(times, at_skin, atol=1e-12)
    for one, other in zip(
        spatial_figures.rates(replace(slid, spikes=far), units),
        spatial_figures.rates(slid, units),
        strict=True,
    ):
        np.testing.assert_allclose(one, other, rtol=0.01)


def test_rates_are_spikes_over_the_time_that_a_unit_spent_there(slid):
    edges, rate = spatial_figures.rates(slid, np.array([0]))
    inside = rate[2:-2]
    assert np.diff(edges) == pytest.approx(spatial_figures.PLACE_BIN)
    assert inside == pytest.approx(1000.0, rel=0.05)


def test_a_sliding_object_is_drawn_where_it_is_and_as_its_plane_where_it_cannot_be(slid):
    there = frames.pose(slid, 0.0, float(SLIDE.recorded_from + 0.1))
    texture, time = frames.texture(slid), float(SLIDE.recorded_from + 0.1)
    drawn = texture.first.places(np.random.default_rng(1).uniform(-5, 5, (200, 2)))
    drawn = drawn + texture.rise(time, drawn)[:, None] * texture.first.axis
    local = (drawn - there.origin) @ there.frame.T
    assert local[:, 2] == pytest.approx(-there.profile.rise(local[:, :2]), abs=1e-9)
    still = frames.pose(slid, 0.0)
    assert still.profile.plane
    assert there.profile is not still.profile
    moved = np.linalg.norm(there.origin - still.origin)
    assert moved == pytest.approx(20 * (0.1 - SLIDE.corner / 2), rel=0.02)


@pytest.mark.parametrize(
    "draw", [spatial_figures.events, spatial_figures.scan_lines, spatial_figures.sideways]
)
def test_every_figure_is_drawn(slid, draw, tmp_path):
    drawn = draw(slid)
    drawn.savefig(tmp_path / "figure.png")
    assert len(drawn.axes) >= 2


def test_the_map_of_rates_shows_the_pressed_pad_and_all_units(synthetic):
    count = len(synthetic.spikes)
    places = np.column_stack([np.linspace(-0.1, 0.1, count), *np.zeros((2, count))])
    spikes = replace(synthetic.spikes, positions=places)
    pressed = synthetic.pad.points[synthetic.pressure[synthetic.peak] > 0, :2]
    assert np.ptp(pressed, axis=0).max() > 1.0
    drawn = spatial_figures.rate_map(replace(synthetic, spikes=spikes))
    axis = drawn.axes[0]
    for limits, across in zip((axis.get_xlim(), axis.get_ylim()), pressed.T, strict=True):
        assert limits[0] < across.min()
        assert across.max() < limits[1]
