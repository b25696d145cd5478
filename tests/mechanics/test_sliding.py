"""Sliding fingers: outcomes in words, what results keep, what is refused and warned of."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.contact.active_set import DONE
from fefinger.contact.coulomb import CoulombSolver
from fefinger.geometry.profiles import frame
from fefinger.mechanics import condensed, linear
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.press.mesh_limits import check_reached
from fefinger.mechanics.situation import Situation
from fefinger.results import netcdf
from fefinger.support.checks import InputError


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
ASK = ff.Ask(fields=False)
SHORT = ff.Slide(20, 0.7, distance=0.01, settle=0.05)


pytestmark = pytest.mark.usefixtures("operators")


@cache
def respond(indenter, motion, **ask):
    scene = ff.Scene(
        finger=FINGER, indenter=indenter, motion=motion, ask=replace(ASK, **ask) if ask else ASK
    )
    return condensed.respond(scene)


@pytest.mark.parametrize(
    ("mu", "distance", "words"),
    [(0.5, 1.5, "Gross slip: from "), (0.5, 0.1, "Partial slip: at least "), (50.0, 0.1, "Stick")],
)
def test_the_outcome_is_told_in_words(mu, distance, words):
    response = respond(ff.Flat(30, friction=mu), replace(SHORT, distance=distance))
    note = response.lateral.outcome
    assert note.startswith(words)
    assert "residual" in note
    stick = response.lateral.stick_area
    if words == "Gross slip: from ":
        said = float(note.split("from ")[1].split(" s")[0])
        moving = response.time >= SHORT.recorded_from + 1e-9
        assert response.time[moving][stick[moving] == 0][0] == pytest.approx(said, rel=1e-3)
    else:
        assert stick[-1] > 0


def test_the_outcome_of_a_path_that_turns_back_says_how_often_all_of_it_slips():
    response = respond(ff.Flat(30, friction=0.4), replace(SHORT, distance=1.5, passes=2))
    stick, time = response.lateral.stick_area, response.time
    there = (time > SHORT.recorded_from) & (time < SHORT.recorded_from + 1.5 / SHORT.speed)
    back = time > SHORT.recorded_from + 1.5 / SHORT.speed
    assert stick[back].max() > 0
    first, last = (time[part][stick[part] == 0][0] for part in (there, back))
    words = response.lateral.outcome
    assert words.startswith(f"Gross slip: from {first:.4g} s on")
    assert f"2 times in all, as some stick in between, last from {last:.4g} s on" in words


def test_the_outcome_of_a_path_that_stays_at_its_place_is_that_of_a_press():
    press = ff.Sampled((0.0, 0.04, 0.06), (0.0, 0.7, 0.7))
    still = ff.SampledPath(press.time, (0.0,) * 3, (0.0,) * 3, depth=press.depth)
    pressed, stayed = (respond(ff.Flat(30, friction=0.4), each) for each in (press, still))
    assert pressed.lateral.outcome.startswith("Partial slip: ")
    assert stayed.lateral.outcome == pressed.lateral.outcome


def test_the_outcome_of_a_path_counts_from_its_start():
    time, depth = (0.0, 0.04, 0.08), (0.0, 0.7, 0.7)
    words = []
    for start in (0.0, 3.0):
        path = ff.SampledPath(time, (start, start, start + 1.0), (0.0,) * 3, depth=depth)
        words.append(respond(ff.Flat(30, friction=0.2), path).lateral.outcome)
    assert words[0].startswith("Gross slip: ")
    assert words[1] == words[0]


def test_time_steps_follow_a_texture_that_slides_fast():
    slide = ff.Slide(400, 0.5, distance=10, settle=0.05)
    path = ff.SampledPath((0.0, 0.05, 0.075), (0.0, 0.0, 10.0), (0.0,) * 3, depth=(0.0, 0.5, 0.5))
    for motion in (slide, path):
        for plate, fine in ((ff.Grating(2, 1, 0.3), True), (ff.Flat(30), False)):
            scene = ff.Scene(finger=FINGER, indenter=plate, motion=motion, ask=ASK)
            time = Situation.of(scene).times
            np.testing.assert_allclose(respond(plate, motion).time, time, rtol=1e-12)
            moved = np.linalg.norm(np.diff(motion.shift(time), axis=0), axis=1)
            assert (moved.max() < 0.101) == fine


def test_friction_resists_the_spread_of_a_press_and_moves_no_plate_aside():
    motion = ff.RampHold(20, 0.8, hold=0.05)
    smooth, rough = (respond(ff.Flat(30, friction=mu), motion) for mu in (0.0, 5.0))
    assert smooth.lateral is None
    assert rough.force.max() > 1.005 * smooth.force.max()
    assert np.abs(rough.lateral.shift).max() == 0
    assert rough.lateral.torque == pytest.approx(0, abs=1e-12)


def test_skin_that_slips_has_the_kinetic_coefficient():
    motion = replace(SHORT, distance=1.5)
    plates = [
        ff.Flat(30, friction=0.5),
        ff.Flat(30, friction=0.5, friction_kinetic=0.5),
        ff.Flat(30, friction=0.5, friction_kinetic=0.3),
    ]
    one, same, weaker = (respond(plate, motion) for plate in plates)
    np.testing.assert_allclose(one.lateral.force, same.lateral.force, rtol=1e-9)
    touching = weaker.force > 0.01 * weaker.force.max()
    pull = np.hypot(*weaker.lateral.force[touching].T) / weaker.force[touching]
    traction, pressure = weaker.lateral.traction[-1], weaker.pressure[-1]
    assert np.hypot(*traction.T) == pytest.approx(0.3 * pressure, abs=1e-8 * pressure.max())
    assert pull[-1] == pytest.approx(0.3, rel=1e-5)
    assert 0.3 < pull.max() < 0.5
    assert weaker.lateral.stick_area[-1] == 0
    assert any("kinetic" in note for note in weaker.notes)
    assert not any("kinetic" in note for note in one.notes)


def test_friction_loses_the_work_of_traction_on_slip_in_every_step():
    answer = respond(ff.Flat(30, friction=0.5), replace(SHORT, distance=1.5))
    lateral, pad = answer.lateral, answer.pad
    slid = np.diff(lateral.slip, axis=0)
    still = (answer.pressure[1:] > 0) & (answer.pressure[:-1] > 0)  # slip counts from first contact
    lost = -1e-3 * np.einsum("tpk,tpk,tp,p->t", lateral.traction[1:], slid, still, pad.areas)  # mJ
    steady = ((answer.pressure[1:] > 0) == (answer.pressure[:-1] > 0)).all(axis=1)
    work = np.diff(lateral.work)
    assert work[steady].sum() > 0.5 * lateral.work[-1]
    assert work[steady] == pytest.approx(lost[steady], rel=1e-6, abs=1e-6 * work.max())


@pytest.mark.parametrize("kinetic", [-0.1, 0.6, float("nan")])
def test_a_kinetic_coefficient_lies_between_none_and_the_static_one(kinetic):
    with refused("indenter.friction_kinetic"):
        ff.Flat(30, friction=0.5, friction_kinetic=kinetic)


def test_in_a_loop_skin_lets_go_as_in_a_scene_and_takes_hold_again():
    plate = ff.Flat(30, friction=0.5, friction_kinetic=0.3)
    finger = Loop(FINGER, plate, mechanics="condensed", deepest=1.0)
    finger.step(0.1, depth=0.7, shift=(0.0, 0.0))
    ratios, sticks = [], []
    for k in range(1, 61):
        now = finger.step(1e-3, depth=0.7, shift=(0.03 * k, 0.0))
        ratios.append(np.hypot(*now.lateral_force) / now.force)
        sticks.append(now.stick_area)
    assert ratios[-1] == pytest.approx(0.3, rel=1e-5)
    assert max(ratios) > 0.31
    assert sticks[0] > 0 == sticks[-1]
    assert finger.step(1e-3, depth=0.7, shift=(1.79, 0.0)).stick_area > 0  # it turns back
    assert finger.step(1e-3, depth=0.7, shift=(1.79, 0.0)).stick_area > 0


def test_a_torque_is_that_of_the_traction_about_the_center_of_pressure():
    at = ff.Sphere(4.0, at=(-1.0, 2.0), friction=0.4)
    response = respond(at, ff.Slide(10, 0.5, distance=1.0, direction=30, settle=0.05))
    pad, traction, weight = response.pad, response.lateral.traction[-1], response.pressure[-1]
    inward = -pad.normals[np.argmin(np.linalg.norm(pad.points[:, :2] - (-1.0, 2.0), axis=1))]
    plane = frame(inward)[:2]
    places = pad.points @ plane.T
    loads = pad.areas * weight
    x, y = (places - loads @ places / loads.sum()).T
    torque = pad.areas @ (x * traction[:, 1] - y * traction[:, 0]) * 1e-3
    assert response.lateral.torque[-1] == pytest.approx(torque, rel=0.1, abs=1e-4)
    heading = np.array([np.cos(np.radians(30)), np.sin(np.radians(30))])
    pulled = traction.T @ pad.areas * 1e-3
    assert pulled @ heading > 0.97 * np.hypot(*pulled)


def test_traction_on_the_pad_adds_up_to_the_lateral_force():
    response = respond(ff.Flat(30, friction=0.4), replace(SHORT, distance=1.0))
    total = np.einsum("p,tpk->tk", response.pad.areas, response.lateral.traction) * 1e-3
    # Areas of the pad are those of its hats; the patch has them across the plate.
    assert total[-1] == pytest.approx(response.lateral.force[-1], rel=0.05, abs=1e-3)
    assert response.lateral.slip[-1, :, 0].min() == pytest.approx(-1.0, abs=0.35)


def test_a_result_with_friction_is_saved_and_read_again(tmp_path: Path):
    dots, ask = ff.Dots(3, friction=0.3), replace(ASK, rel_error=1)
    scene = ff.Scene(finger=FINGER, indenter=dots, motion=SHORT, ask=ask)
    result = ff.run(scene, mechanics="condensed")
    result.save(tmp_path)
    again = ff.load(tmp_path)
    for name in ("shift", "force", "torque", "stick_area", "work"):
        # exact: a file keeps every bit
        assert np.array_equal(getattr(again.lateral, name), getattr(result.lateral, name))
    for name in ("traction", "slip"):  # of every vertex, in single precision
        given, read = getattr(result.lateral, name), getattr(again.lateral, name)
        np.testing.assert_allclose(read, given, rtol=1e-6, atol=1e-6 * np.abs(given).max())
    data = netcdf.dataset(result)
    assert data["lateral_force"].attrs["units"] == "N"
    assert list(data["lateral_axis"].values) == ["distal", "radial"]
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Sliding" in page
    assert "work of friction" in page
    assert "carries pressure only" not in page


def test_fields_of_a_sheared_finger_are_those_of_its_end_organs():
    scene = ff.Scene(
        finger=FINGER,
        indenter=ff.Flat(30, friction=0.4),
        motion=replace(SHORT, distance=0.5),
        ask=ff.Ask(),
    )
    both = [each.respond(scene) for each in (condensed, linear)]
    moved = [each.fields.displacement[-1] for each in both]
    assert moved[0] == pytest.approx(moved[1], abs=1e-9)
    skin = moved[0][np.argmax(np.abs(moved[0][:, 0]))]
    assert skin[0] > 0.1  # dragged distally, with the plate


def test_textures_finer_than_the_mesh_are_warned_of_with_the_number():
    fine = respond(ff.Dots(1.5, diameter=0.5, edge=0.05), SHORT)
    (note,) = (each for each in fine.notes if each.startswith("Warning"))
    assert "= 0.5 / 0.8" in note
    assert "< 1.5" in note
    lines = np.linspace(-8, 8, 81)
    relief = ff.Relief.of(lambda x, y: 0.1 * np.sin(2 * np.pi * x / 1.4) + 0 * y, lines, lines)
    assert any(each.startswith("Warning: the texture") for each in respond(relief, SHORT).notes)
    pressed = respond(ff.Dots(3), ff.Ramp(20, 0.4))
    assert any(each.startswith("Warning: the texture") for each in pressed.notes)
    wide = respond(ff.Grating(8, 4, 0.5, edge=0.5), SHORT)
    assert not [each for each in wide.notes if each.startswith("Warning")]


@pytest.mark.parametrize(
    ("indenter", "motion", "spikes", "told"),
    [
        (ff.Grating(8, 4, 0.5, edge=0.5), SHORT, ("SAI", "FAII"), True),
        (ff.Grating(8, 4, 0.5, edge=0.5), SHORT, ("SAI", "FAI"), False),
        (ff.Grating(16, 8, 0.5, edge=0.5), SHORT, ("FAII",), False),
        (ff.Flat(30), SHORT, ("FAII",), False),
        (ff.Dots(3), ff.Ramp(20, 0.4), ("FAII",), False),
    ],
    ids=["4.6 facets", "no FAII", "9.2 facets", "no texture", "no slide"],
)
def test_a_slide_says_that_faii_count_vertices_over_textures(indenter, motion, spikes, told):
    notes = respond(indenter, motion, spikes=spikes).notes
    assert any("count vertices of the mesh" in each for each in notes) == told


def test_a_force_is_judged_on_all_the_skin_that_bears_it():
    """On the first candidates, which are too few, it would press through the 5 mm of tissue."""
    motion = ff.Slide(40, force=0.85, distance=5.5, direction=90, settle=0.02, approach=10)
    response = respond(ff.Sphere(3, at=(0, 4)), motion)
    assert 4.5 < response.depth.max() < FINGER.pulp
    too_much = ff.Slide(40, force=8.5, distance=0.1, settle=0.02, approach=10)
    with pytest.raises(InputError, match="press less"):
        respond(ff.Flat(30), too_much)
    with pytest.raises(InputError, match="press less, or slide where the object stays on the pad"):
        check_reached(too_much, pulp=5.0, deepest=9.0)


def test_contact_that_reaches_the_end_of_the_object_is_a_sentence():
    with pytest.raises(InputError, match=r"at 0\.\d+ s, with the object moved by .* its end"):
        respond(ff.Letters("i"), ff.Slide(60, 0.8, distance=14, direction=180, settle=0.05))


@pytest.fixture(scope="module")
def loops(kept: Path) -> dict[float, Loop]:
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("XDG_CACHE_HOME", str(kept))
        return {
            mu: Loop(
                FINGER, ff.Dots(2.5, friction=mu), mechanics="condensed", deepest=1.0, reach=0.0
            )
            for mu in (0.0, 0.3)
        }


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_a_loop_reaches_its_force_and_forgets_on_reset(loops, mu):
    finger = loops[mu]
    finger.reset()
    first = [finger.step(5e-3, force=0.2, shift=(0.05 * k, 0.0)).depth for k in range(5)]
    assert finger.now.force == pytest.approx(0.2, rel=1e-6)
    finger.reset()
    assert (finger.now.force, finger.now.work, finger.now.stick_area) == (0.0, 0.0, 0.0)
    again = [finger.step(5e-3, force=0.2, shift=(0.05 * k, 0.0)).depth for k in range(5)]
    assert again == pytest.approx(first, rel=1e-9)
    assert finger.step(1e-3, depth=-1.0, shift=(0.0, 0.0)).force == 0.0


def test_friction_finds_the_law_for_every_coefficient_from_rest_and_from_before():
    rng = np.random.default_rng(4)
    basis = rng.normal(size=(60, 60))
    matrix = basis @ basis.T / 60 + 0.05 * np.eye(60)
    for mu in (0.0, 0.1, 0.5):
        state = CoulombSolver(matrix, mu)
        for _ in range(5):
            offset = rng.normal(size=60)
            assert state.solve(offset, 1e-10) == DONE
            x, rest = state.x, matrix @ state.x + offset
            p, t, w, s = x[:20], x[20:].reshape(2, 20), rest[:20], rest[20:].reshape(2, 20)
            assert p.min() >= 0
            assert w.min() > -1e-8
            assert np.abs(p * w).max() < 1e-8
            assert (np.hypot(*t) - mu * p).max() < 1e-8
            lost = -np.sum(t * s, axis=0)
            assert lost == pytest.approx(mu * p * np.hypot(*s), abs=1e-7)


def test_a_flexibility_without_an_inverse_ends_in_a_failure_not_in_an_exception():
    flat = np.zeros((6, 6))
    flat[:2, :2] = 1.0  # two vertices that move as one, and not along the plane
    state = CoulombSolver(flat, 0.3)
    offset = np.array([-1.0, -2.0, 0.0, 0.0, 0.0, 0.0])
    outcome = state.solve(offset, 1e-10)
    assert outcome != DONE or (flat @ state.x + offset)[:2].min() > -1e-9
