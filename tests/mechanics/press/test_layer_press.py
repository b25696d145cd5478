"""Any object on exact layers: the round ones as without a grid, and what has to stay the same."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.contact.gridded import GridContact
from fefinger.mechanics import layered
from fefinger.mechanics.press import layer_press
from fefinger.mechanics.press.layer_gap import LayerGap, grid_of
from fefinger.mechanics.press.layer_grid import LayerGrid
from fefinger.mechanics.press.layer_press import LayerPress, blocks, linear
from fefinger.mechanics.situation import Situation
from fefinger.plan import choose
from fefinger.scene import builtin
from fefinger.support.checks import InputError
from fefinger.support.progress import Stages


FINGER = ff.Finger.subject("a.h.", tissue="maeno1998")
ASK = ff.Ask(fields=False)
STACK = layered.stack(FINGER)
PRESS = ff.RampHold(20, 0.6, hold=0.3)
COARSE = LayerGrid(STACK, 96, 0.14, width=1.5)


def scene(**parts):
    given = {"finger": FINGER, "motion": PRESS, "ask": ASK, "indenter": ff.Flat()}
    return ff.Scene(**(given | parts))


def on(grid, asked):
    made = layer_press.respond(
        asked, grid, lambda: None, Stages(None), mechanics="layered", notes=()
    )
    return made


@pytest.mark.parametrize("motion", [PRESS, ff.Trapezoid(loading_rate=6, force=0.2, hold=0.03)])
def test_a_plate_is_answered_as_without_a_grid(motion):
    asked = scene(motion=motion)
    grid, exact = on(COARSE, asked), layered.respond(asked)
    assert grid.force == pytest.approx(exact.force, abs=0.015 * exact.force.max())
    assert grid.depth == pytest.approx(exact.depth, abs=0.015 * exact.depth.max())
    assert grid.contact_area == pytest.approx(
        exact.contact_area, abs=0.08 * exact.contact_area.max()
    )
    assert grid.strain == pytest.approx(exact.strain, abs=0.02 * np.abs(exact.strain).max())
    total = grid.pressure @ grid.pad.areas * 1e-3
    assert total == pytest.approx(grid.force, rel=1e-5, abs=1e-9)
    assert grid.numbers["images_over_displacement"] < 1e-2
    assert any("period" in note for note in grid.notes)


def test_an_object_beside_the_middle_is_answered_in_the_frame_of_the_finger():
    asked = scene(indenter=ff.Sphere(5.0, at=(1.5, 1.0)), motion=ff.RampHold(20, 0.4, hold=0.1))
    grid, exact = on(COARSE, asked), layered.respond(asked)
    assert grid.strain == pytest.approx(exact.strain, abs=0.03 * np.abs(exact.strain).max())
    touched = ~np.isnan(grid.centroid[:, 0])
    assert grid.centroid[touched] == pytest.approx(exact.centroid[touched], abs=0.02)


def test_between_solved_times_the_depth_is_that_of_the_motion_and_a_force_has_a_center():
    asked = scene(
        ask=ff.Ask(fields=False, strain=False, spikes=["FAII"]),
        motion=ff.RampHold(20, 0.3, hold=0.02),
    )
    answer = on(COARSE, asked)
    press = LayerPress(asked, COARSE)
    assert len(answer.time) > 1.5 * len(press.solve(Stages(None)).time)
    assert answer.depth == pytest.approx(asked.motion.value(answer.time), rel=1e-12, abs=1e-12)
    assert np.isfinite(answer.centroid[answer.force > 0]).all()


def test_ridges_without_a_height_are_the_smooth_pad():
    flat = replace(FINGER, ridges=ff.Ridges(height=0.0))
    axis = LayerPress(scene(), COARSE).first.axis
    smooth, ridged = (LayerGap.of(scene(finger=each), axis, COARSE) for each in (FINGER, flat))
    assert ridged((0.2, 0.1)) == pytest.approx(smooth((0.2, 0.1)), abs=1e-12)
    assert not layered.on_grid(flat, ff.Flat(), PRESS)


def test_a_texture_that_has_moved_by_its_period_repeats():
    """And pushes along the finger on the way, which ridges across it alone do."""
    elastic = replace(FINGER, prony=ff.Prony(c=(1.0,), v=()))
    slide = ff.Slide(40, 0.5, distance=3.0, settle=0.1, approach=20, corner=0.0)
    rows = LayerPress(
        scene(finger=elastic, indenter=ff.Grating(3.0, 1.5, 0.4, edge=0.3), motion=slide), COARSE
    ).solve(Stages(None))
    start = int(np.searchsorted(rows.time, slide.recorded_from))
    force = rows.rows["force"]
    assert force[-1] == pytest.approx(force[start], rel=2e-3)
    assert np.ptp(force[start:]) > 0.01 * force[start]
    push = rows.rows["push"]
    assert np.abs(push[start:, 0]).max() > 0.01 * force[start]
    assert np.abs(push[:, 1]).max() < 1e-6 * force[start]


def test_a_plate_with_friction_sticks_then_slides_and_its_work_is_lost():
    """Full slip pulls by mu times the force, and strain at the end organs leans with the pull."""
    grid = LayerGrid(STACK, 64, 0.21, width=1.5)
    slide = ff.Slide(20, 0.4, distance=0.8, settle=0.1, approach=20, corner=0.0)
    free, held = (on(grid, scene(motion=slide, indenter=ff.Flat(friction=mu))) for mu in (0.0, 0.4))
    pull = held.lateral.force[:, 0] / held.force
    assert pull[-1] == pytest.approx(0.4, abs=1e-4)
    assert pull[slide_start(held)] == pytest.approx(0.0, abs=0.02)
    assert held.lateral.stick_area[slide_start(held)] > 0.5 * held.contact_area[-1]
    assert held.lateral.stick_area[-1] == 0.0  # exact: a count of points
    assert held.lateral.outcome.startswith("Gross slip: from ")
    work = np.trapezoid(held.lateral.force[:, 0], held.lateral.shift[:, 0])
    assert 0.5 * work < held.lateral.work[-1] < work
    assert not free.lateral.force.any()
    leaning = np.abs(held.strain - free.strain)[-1]
    assert leaning.max() > 0.1 * np.abs(free.strain).max()
    for smooth in (ff.Flat(), ff.Bar(3.0, 1.0)):
        assert layered.inertia(Situation.of(scene(motion=slide, indenter=smooth))) == ()
    assert "Coulomb" in layered.causes(FINGER, ff.Flat(friction=0.4))[-1]
    assert "friction and inertia are left out" in layered.causes(FINGER, ff.Flat())[0]


def slide_start(answer):
    return int(np.searchsorted(answer.lateral.shift[:, 0], 1e-9)) - 1


def test_ridges_soften_the_first_touch_and_hardly_change_a_press():
    asked = scene(motion=ff.Ramp(40, 0.6))
    smooth, ridged = (
        on(LayerGrid(STACK, 112, 0.11, width=1.5), replace(asked, finger=each))
        for each in (FINGER, replace(FINGER, ridges=ff.Ridges(pitch=0.88, height=0.05)))
    )
    less = 1 - ridged.force / np.maximum(smooth.force, 1e-9)
    assert 0.0 < less[-1] < 0.2
    assert less[len(less) // 4] > less[-1]
    assert ridged.contact_area[-1] < 0.9 * smooth.contact_area[-1]


def test_what_a_grid_cannot_answer_is_refused_in_a_sentence():
    def field(asked):
        return [each.field for each in layered.refuse(Situation.of(asked))]

    dots = builtin.load("slide-dots")
    assert field(dots) == []
    assert field(replace(dots, indenter=replace(dots.indenter, friction=0.3))) == []
    wide = scene(finger=replace(FINGER, ridges=ff.Ridges(pitch=2.0)), motion=ff.Ramp(20, 0.05))
    assert field(wide) == ["finger.ridges.pitch"]
    sharp = scene(indenter=ff.Pin(0.2, corner=0.002))
    assert field(sharp) == ["indenter"]


def test_contact_at_the_border_of_the_grid_is_an_error():
    with refused("motion"):
        on(LayerGrid(STACK, 32, 0.1), scene(motion=ff.Ramp(20, 0.8)))


def test_the_planner_lists_it_for_textures_and_refuses_ridges_elsewhere():
    dots = builtin.load("slide-dots")
    ridged = replace(dots, finger=replace(dots.finger, ridges=ff.Ridges()))
    plan = choose(ridged, "layered")
    assert plan.mechanics == "layered"
    assert 0.05 < plan.chosen.error < 0.5
    assert np.isnan(layered.error(Situation.of(ridged), "pressure").error)
    assert 10.0 < plan.chosen.seconds < 1000.0
    other = choose(ridged, "condensed")
    assert "finger.ridges" in [each.field for each in other.chosen.refusals]


def test_a_relief_from_a_file_is_pressed_as_what_it_was_drawn_from_and_told_where_it_ends(tmp_path):
    lines = np.arange(-6.0, 6.01, 0.1)
    dots = ff.Dots(3.0, height=0.3, diameter=1.2, edge=0.3)
    heights = -dots.profile.rise(np.stack(np.meshgrid(lines, lines, indexing="ij"), axis=-1))
    np.savez(tmp_path / "dots.npz", x=lines, y=lines, height=heights)
    relief = ff.Relief.from_file(tmp_path / "dots.npz")
    grid = LayerGrid(STACK, 64, 0.2, width=1.5)
    drawn, read = (
        on(grid, scene(indenter=each, motion=ff.Ramp(40, 0.5))) for each in (dots, relief)
    )
    assert read.force == pytest.approx(drawn.force, abs=0.01 * drawn.force.max())
    away = ff.Slide(60, 0.4, distance=5.5, settle=0.02, approach=40, corner=0.0)
    with pytest.raises(InputError, match="expected a path on which the pad stays on the object"):
        on(grid, scene(indenter=relief, motion=away))


def test_an_answer_says_at_which_frequency_ridges_pass_and_what_inertia_changes_there():
    slow, fast = (
        layered.inertia(
            Situation.of(
                scene(
                    finger=replace(FINGER, ridges=ff.Ridges()),
                    motion=ff.Slide(speed, 0.5, distance=5),
                )
            )
        )[0]
        for speed in (20, 120)
    )
    assert "ridges pass at 44.4 Hz" in slow
    assert "ridges pass at 267 Hz" in fast
    changes = [float(each.split("by up to ")[1].split(" %")[0]) for each in (slow, fast)]
    assert 0.0 < changes[0] < 0.2 * changes[1]
    smooth = builtin.load("slide-dots", {"finger.ridges": None})
    (dots,) = layered.inertia(Situation.of(smooth))
    assert "parts of the object" in dots


def test_ridges_are_a_table_of_a_scene():
    text = scene(finger=replace(FINGER, ridges=ff.Ridges(height=0.2, shape="concentric"))).to_toml()
    again = ff.Scene.from_toml(text)
    assert again.finger.ridges == ff.Ridges(height=0.2, shape="concentric")
    assert "ridges" not in scene().to_dict()["finger"]
    with refused("finger.ridges.pitch"):
        ff.Scene.from_toml(text.replace("pitch = 0.45", "pitch = -1"))


def test_concentric_ridges_are_the_same_in_all_directions():
    ridges = ff.Ridges(shape="concentric")
    turn = np.linspace(0, 6, 13)
    ring = 1.3 * np.column_stack([np.cos(turn), np.sin(turn)])
    assert np.ptp(ridges.valleys(ring)) < 1e-12
    across = ff.Ridges(direction=90.0).valleys(np.array([[0.7, 0.0], [0.0, 0.225]]))
    assert across == pytest.approx([0.0, 0.1], abs=1e-12)


def test_blocks_keep_the_force_and_lines_join_times():
    values = np.random.default_rng(1).random((7, 7))
    assert blocks(values, 3).sum() * 9 == pytest.approx(values.sum())
    at, rows = np.array([0.0, 1.0, 3.0]), np.array([[0.0, 2.0], [1.0, 2.0], [5.0, 4.0]])
    assert linear(at, rows, np.array([0.5, 2.0, 3.0])) == pytest.approx(
        np.array([[0.5, 2.0], [3.0, 3.0], [5.0, 4.0]])
    )


def test_the_grid_contact_is_a_stepper_of_any_loop():
    gap = LayerGap.of(scene(), LayerPress(scene(), COARSE).first.axis, COARSE)
    contact = GridContact(COARSE.compliance, (96, 96), 0.14, gap, FINGER.prony.branches)
    assert contact.depth == 0.0  # exact: nothing has been pressed
    assert not contact.pressure.any()


@pytest.mark.parametrize("step", [1e-4, 1e-30])
def test_a_grid_that_would_not_fit_into_memory_is_refused(step: float) -> None:
    with pytest.raises(InputError, match=r"indenter: expected an object .* points a side"):
        grid_of(STACK, 2.0, step)
