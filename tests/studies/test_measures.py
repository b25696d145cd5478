"""Highest pressure, strain and stated errors in the rows of a study."""

from dataclasses import replace

import numpy as np
import pytest

import fefinger as ff
from fefinger.mechanics.evidence import stated_errors
from fefinger.mechanics.situation import Situation
from fefinger.pipeline import run
from fefinger.plan import choose
from fefinger.results import pressure
from fefinger.scene.ask import Scatter
from fefinger.scene.schema import split
from fefinger.studies import study_page
from fefinger.studies.grid import ERRORS, bounds, words
from fefinger.studies.measures import SPEED, rows, share
from fefinger.theory.contact.elliptic import Elliptic
from fefinger.theory.relaxation import Prony


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
ELASTIC = replace(FINGER, prony=Prony((1.0,), ()))


@pytest.fixture(scope="module")
def held():
    """Return a press of a plate that is held, by `hertz`."""
    motion = ff.RampHold(20, 1.0, hold=0.1)
    return run(ff.Scene(finger=FINGER, motion=motion, ask=ff.Ask(fields=False)), mechanics="hertz")


def test_the_highest_pressure_is_that_of_the_report_and_no_single_points():
    scene = ff.Scene(finger=ELASTIC, motion=ff.Ramp(60, 0.8), ask=ff.Ask(strain=False))
    result = run(scene, mechanics="linear")
    told = {row["at"]: row for row in rows(result, depths=(0.4,))}
    every = pressure.peaks(result.pad, result.pressure)
    assert told["end"]["highest_pressure_1mm2_kPa"] == pytest.approx(every[-1], rel=1e-3)
    there = np.interp(0.4, result.depth, every)
    assert told["0.4 mm"]["highest_pressure_1mm2_kPa"] == pytest.approx(there, rel=0.01)
    assert every[-1] < 0.85 * result.pressure[-1].max()
    assert not any("peak_pressure" in name for name in told["end"] if "hertz" not in name)


def test_that_of_elliptic_hertz_is_the_same_mean_of_its_closed_form():
    body = Elliptic(20.0, 9.8, 0.5, modulus=10.0, poisson=0.45)
    line = (np.arange(800) + 0.5) / 200 - 2
    x, y = np.meshgrid(line, line)
    weight = np.exp(-np.pi * (x**2 + y**2))  # one over 1 mm² in the middle, whole 1
    mean = (body.pressure(x, y) * weight).sum() / 200**2
    (found,) = share(np.array([body.semi_axes])) * body.peak_pressure
    assert found == pytest.approx(mean, rel=1e-5)
    small, large = share(np.array([[1e-3, 1e-3], [50.0, 30.0]]))
    assert small == pytest.approx(2 / 3 * np.pi * 1e-6, rel=1e-3)  # the force of a cap, on 1 mm²
    assert large == pytest.approx(1.0, abs=1e-3)


def test_strain_is_the_root_mean_square_norm_over_the_end_organs(held):
    end = rows(held)[1]
    squares = (held.strain[-1] ** 2).sum(axis=(1, 2))
    assert end["strain_rms_percent"] == pytest.approx(100 * np.sqrt(squares.mean()))


def test_errors_are_those_of_the_plan_at_the_largest_force_and_of_a_shallower_press_before(held):
    told = {row["at"]: row for row in rows(held, depths=(0.4,))}
    names = {"pressure": "highest_pressure", "area": "contact_area", "strain": "strain"}
    chosen = held.plan.chosen
    assert told["peak"]["force_rel_error"] == pytest.approx(chosen.error)
    shallow = replace(held.scene, motion=ff.Ramp(SPEED, 0.4, corner=0))
    there = choose(shallow, "hertz").chosen
    assert told["0.4 mm"]["force_rel_error"] == pytest.approx(there.error)
    assert there.error != chosen.error
    for name, column in names.items():
        assert told["peak"][f"{column}_rel_error"] == pytest.approx(chosen.errors[name])
        assert told["end"][f"{column}_rel_error"] == pytest.approx(chosen.errors[name])
        assert told["0.4 mm"][f"{column}_rel_error"] == pytest.approx(there.errors[name])
    fallen = held.force.max() / held.force[-1]
    assert fallen > 1.1
    assert told["end"]["force_rel_error"] == pytest.approx(chosen.error * fallen)


PRESCRIBED = (ff.RampHold(loading_rate=2.0, force=0.5, hold=0.2), ff.RampHold(20, 1.0, hold=0.1))


@pytest.mark.parametrize("motion", PRESCRIBED, ids=("by force", "by depth"))
def test_at_a_force_the_depth_has_an_error_and_at_a_depth_the_force(motion):
    held = run(ff.Scene(finger=FINGER, motion=motion, ask=ff.Ask(fields=False)), mechanics="hertz")
    top, deepest = float(held.response.force.max()), float(held.depth.max())
    told = {row["at"]: row for row in rows(held, forces=(0.2, top), depths=(0.4, deepest))}
    given, other = ("depth", "force")[:: 1 if motion.control == "depth" else -1]
    for at, known, unknown in (
        ("end", given, other),
        ("peak", given, other),
        ("0.2 N", "force", "depth"),
        ("0.4 mm", "depth", "force"),
        (f"{top:g} N", "force", "depth"),
        (f"{deepest:g} mm", "depth", "force"),
    ):
        assert f"{known}_rel_error" not in told[at]
        assert told[at][f"{unknown}_rel_error"] > 0
    errors = held.plan.chosen.errors
    assert told["end"]["contact_area_rel_error"] == errors["area"]
    assert told["end"].get("depth_rel_error") == errors.get("depth")
    press = replace(held.scene, motion=ff.Ramp(SPEED, told["0.2 N"]["depth_mm"], corner=0))
    there = choose(press, "hertz").chosen
    at_force = stated_errors.at_force(there.errors, there.error, Situation.of(press))
    for column, name in (("depth", "depth"), ("contact_area", "area"), ("strain", "strain")):
        assert told["0.2 N"][f"{column}_rel_error"] == pytest.approx(at_force[name], rel=1e-9)


def test_the_errors_of_rows_at_a_force_are_said_of_the_depth():
    held = run(
        ff.Scene(finger=FINGER, motion=PRESCRIBED[0], ask=ff.Ask(fields=False)), mechanics="hertz"
    )
    sentence = study_page.errors(rows(held, forces=(0.2,)))
    assert "depth" in sentence
    assert "force in" not in sentence


def test_what_no_press_is_like_or_has_withdrawn_has_no_error_of_pressure_area_and_strain():
    tilted = ff.Scene(finger=FINGER, indenter=ff.Flat(30, 40), motion=ff.Ramp(60, 0.5))
    back = ff.Scene(finger=FINGER, motion=ff.Trapezoid(20, 0.5, hold=0.0))
    for scene, at in ((tilted, 0), (back, 1)):
        asked = replace(scene, ask=ff.Ask(fields=False))
        row = rows(run(asked, mechanics="hertz"))[at]
        assert row["highest_pressure_1mm2_kPa"] >= 0
        for name in ("highest_pressure", "contact_area", "strain"):
            assert f"{name}_rel_error" not in row


def test_columns_say_their_units_and_errors_are_in_them():
    assert split("motion.speed_mm_per_s") == ("motion.speed", "mm/s")
    assert split("finger.subject") == ("finger.subject", "")
    assert words("indenter.angle_deg") == "indenter.angle / deg"
    assert words("highest_pressure_1mm2_kPa") == "highest pressure over 1 mm² / kPa"
    row = {"force_N": 2.0, "force_rel_error": 0.1, "contact_area_mm2": 5.0}
    assert bounds(row, "force_N") == pytest.approx((2 / 1.1, 2 / 0.9))
    assert bounds(row | {"force_rel_error": 1.2}, "force_N") == pytest.approx((2 / 2.2, 4.0))
    assert bounds(row, "contact_area_mm2") is None
    assert bounds(row, "depth_mm") is None
    assert set(ERRORS.values()) == {name for name in ERRORS.values() if name.endswith("_rel_error")}


def test_a_population_tells_the_seed_that_its_places_are_drawn_from():
    layout = Scatter(radius=1.0, seed=3)
    ask = ff.Ask(spikes=("SAI",), population=layout, fields=False)
    scene = ff.Scene(finger=FINGER, motion=ff.RampHold(20, 0.4, hold=0.02), ask=ask)
    assert [row["seed"] for row in rows(run(scene, mechanics="hertz"))] == [3, 3]


@pytest.mark.parametrize(("amplitude", "closed"), [(0.02, True), (0.45, False)])
def test_a_vibration_has_a_dynamic_stiffness_or_says_that_contact_opens(amplitude, closed):
    motion = ff.RampSinusoid(20, 0.3, amplitude=amplitude, frequency=20, cycles=4, settle=0.1)
    ask = ff.Ask(pressure=False, strain=False, fields=False)
    scene = ff.Scene(finger=ff.Finger.subject("a.h."), motion=motion, ask=ask)
    last = next(row for row in rows(run(scene, mechanics="lumped")) if row["at"] == "end")
    assert ("dynamic_stiffness_N_per_mm" in last) is closed
    assert ("contact opens" in last["stiffness_note"]) is not closed
