"""Calibration on fingers whose curve is a formula; the finite elements are in the suite."""

import json
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

import fefinger as ff
from fefinger import cache, library
from fefinger.__main__ import main
from fefinger.calibration import inverse, jobs, pad, target, work
from fefinger.calibration import press as presses
from fefinger.calibration.curve import curve, family
from fefinger.calibration.force import Forces, predicted, prony_of, stiffness
from fefinger.calibration.outcome import errors, layer, line
from fefinger.calibration.press import Press, felt, press, pressed
from fefinger.calibration.record import Calibration
from fefinger.checks import ConvergenceError, InputError, Stopped
from fefinger.mechanics import hertz
from fefinger.theory import synthetic
from fefinger.theory.lumped import Spring
from fefinger.theory.relaxation import Prony
from fefinger.theory.sensor import ArraySensor, blurred


ROW = library.pawluk_bulk()["a.h."]
PRONY = Prony((0.3, 0.42, 0.16, 0.12), (220.0, 9.0, 0.6))


def formula(exponent=1.0, radius=14.0, ratio=1.0, count=24, deepest=1.8):
    """Return a press that stiffens with the exponent, of a pad as wide as Hertz's."""
    x = deepest * np.linspace(0, 1, count + 1)[1:]
    force = 0.2 * np.sqrt(radius * ratio) * x**1.5 * np.exp((0.2 + 0.25 * exponent) * x)
    few, share = shares(radius, deepest)
    share = np.stack([np.interp(x, few, column) for column in share.T], axis=1)
    return Press(x, force, force[:, None] * share, np.pi * radius * x, 1.0)


@lru_cache
def shares(radius, deepest):
    """Return depths (n,) mm and what the array feels of Hertz's pressure per newton, (n, 64)."""
    depth = deepest * np.linspace(0, 1, 25)[1:]
    return depth, np.array([hertzian(radius * d) for d in depth.tolist()])


def hertzian(a2):
    """Return what the array feels (64,) of Hertz's pressure of 1 N on a circle of area pi a2."""
    peak = 1.5e3 / (np.pi * a2)
    r = np.hypot(*ArraySensor().positions.T)
    return blurred(lambda s: peak * np.sqrt(np.maximum(1 - s**2 / a2, 0)), np.sqrt(a2), r)


@pytest.fixture(scope="module")
def law():
    return family((0.02, 1.5, 3.0, 4.5), 14.0, formula)


@pytest.fixture(scope="module")
def linear():
    return family((1.0,), 14.0, lambda _: formula(0.0, count=400))


# Curves


@pytest.mark.parametrize("count", [24, 400])
def test_a_curve_is_the_press_and_its_slope_and_inverse_are_its_own(count):
    one = formula(2.0, count=count)
    found, apart = curve(one)
    assert apart < 1e-4
    x = np.linspace(0.2, 1.7, 7)
    slope = (found.force(x + 1e-5) - found.force(x - 1e-5)) / 2e-5
    np.testing.assert_allclose(found.stiffness(x), slope, rtol=1e-6)
    np.testing.assert_allclose(found.depth(found.force(x)), x, rtol=1e-10)
    np.testing.assert_allclose(found.felt(one.depth[10:11])[0], one.felt[10], rtol=2e-2, atol=0.1)
    assert found.force([-1.0, 0.0]).tolist() == [0, 0]


def test_beyond_the_press_the_logarithm_goes_on_straight():
    found, _ = curve(formula(2.0))
    near, far = np.log(found.force([1.8, 1.9])), np.log(found.force([2.3, 2.4]))
    assert near[1] - near[0] == pytest.approx(far[1] - far[0])
    np.testing.assert_allclose(
        found.depth([2 * found.force(1.8)]), found.depth([2 * found.force(1.8)])
    )


def test_a_growing_curve_is_t_times_the_linear_one(linear):
    x = np.array([0.3, 1.0, 1.7])
    found, plain = linear.at(0.8, 14.0), curve(formula(0.0, count=400))[0]
    np.testing.assert_allclose(found.force(x), np.expm1(0.8 * x) / 0.8 * plain.force(x), rtol=1e-6)
    slope = (found.force(x + 1e-5) - found.force(x - 1e-5)) / 2e-5
    np.testing.assert_allclose(found.stiffness(x), slope, rtol=1e-5)


def test_a_family_has_the_presses_between_its_own(law):
    x = np.linspace(0.2, 1.8, 9)
    for exponent in (0.7, 2.2, 4.0):
        between = curve(formula(exponent))[0].force(x)
        np.testing.assert_allclose(law.at(exponent, 14.0).force(x), between, rtol=2e-3)


def test_a_family_learns_radius_ratio_and_a_better_press(law):
    x = np.linspace(0.2, 1.8, 9)
    wider = law.with_radius(formula(3.0, radius=11.2), 3.0, 11.2)
    np.testing.assert_allclose(
        wider.at(1.0, 12.6).force(x), curve(formula(1.0, 12.6))[0].force(x), rtol=2e-3
    )
    stiffer = law.with_ratio(formula(3.0, ratio=2.0), 3.0, 2.0)
    np.testing.assert_allclose(
        stiffer.at(1.0, 14.0, 1.5).force(x), curve(formula(1.0, ratio=1.5))[0].force(x), rtol=2e-3
    )
    better = replace(formula(2.0), force=1.1 * formula(2.0).force)
    np.testing.assert_allclose(
        law.corrected(better, 2.0, 14.0).at(2.0, 14.0).force(x),
        1.1 * curve(formula(2.0))[0].force(x),
        rtol=1e-4,
    )
    short = formula(2.0)
    part = {name: getattr(short, name)[:18] for name in ("depth", "force", "felt", "area")}
    ended = law.corrected(replace(short, **part), 2.0, 14.0).at(2.0, 14.0)
    assert ended.deepest == part["depth"][-1] < law.deepest
    x = np.linspace(0.2, 1.0, 5) * ended.deepest
    whole = law.at(2.0, 14.0)
    np.testing.assert_allclose(ended.force(x), whole.force(x), rtol=1e-4)
    np.testing.assert_allclose(ended.felt(x), whole.felt(x), rtol=2e-2, atol=0.1)
    with pytest.raises(InputError, match=r"family\.shapes: expected numbers that rise"):
        family((3.0, 1.0), 14.0, formula)


# Least squares


def unknown(name, **options):
    return inverse.Unknown(name, 1.0, 0.1, 10.0, "1", "test", **options)


def test_a_linear_problem_has_its_closed_form():
    rng = np.random.default_rng(0)
    design, sigma = rng.normal(size=(200, 2)), 0.1
    data = design @ [2.0, 3.0] + sigma * rng.normal(size=200)
    asked = [unknown("p", log=False), unknown("q", log=False)]
    found = inverse.solve(lambda v: (design @ [v["p"], v["q"]] - data) / sigma, asked)
    best, *_ = np.linalg.lstsq(design, data, rcond=None)
    np.testing.assert_allclose([found.values["p"], found.values["q"]], best, rtol=1e-6)
    scale = max(1.0, found.misfit)
    covariance = scale * sigma**2 * np.linalg.inv(design.T @ design)
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-6)
    assert found.weak == ()
    assert found.at_bounds == ()


def test_what_the_data_do_not_decide_is_named_and_keeps_its_prior():
    asked = [unknown("p", prior=(1.0, 0.7)), unknown("q", prior=(1.0, 0.7))]
    found = inverse.solve(lambda v: np.full(5, (np.log(v["p"] * v["q"]) - 1.0) / 0.01), asked)
    assert found.values["p"] * found.values["q"] == pytest.approx(np.e, rel=1e-3)
    assert found.correlation[0, 1] < -0.99
    assert found.deviations["p"] == pytest.approx(found.values["p"] * 0.7 / np.sqrt(2), rel=0.01)
    assert len(found.weak) == 1
    assert found.weak[0].startswith(("p with q^-1", "p^-1 with q"))


def test_what_is_held_stays_and_adds_to_the_uncertainty():
    def residual(v):
        return np.array([v["p"] + v["q"] - 3.0, v["p"] + v["q"] - 3.0]) / 0.01

    free = unknown("p", log=False)
    held = unknown("q", log=False, prior=(1.0, 0.5), held=True)
    found = inverse.solve(residual, [free, held])
    assert found.values["q"] == 1.0
    assert found.values["p"] == pytest.approx(2.0)
    assert found.deviations["p"] == pytest.approx(0.5, rel=0.01)


def test_a_bound_that_stops_the_search_is_named():
    found = inverse.solve(lambda v: np.array([v["p"] - 20.0, 0.1]), [unknown("p")])
    assert found.at_bounds == ("p",)


def test_a_search_that_fails_says_so(monkeypatch):
    monkeypatch.setattr(inverse, "EVALUATIONS", 1)
    with pytest.raises(ConvergenceError, match="did not converge in 1 evaluations from any of 1"):
        inverse.solve(lambda v: np.array([np.exp(v["p"]) - 3.0]), [unknown("p")])


# Targets and their residuals


def test_a_subject_is_the_line_of_table_2_1():
    found = target.subject("a.h.")
    assert line(found.force, found.stiffness) == pytest.approx((2.1, 0.18))
    scatter = np.random.default_rng(0).normal(0, found.stiffness_sd, (4000, len(found.force)))
    noisy = found.stiffness + scatter
    vaf = 1 - (scatter**2).sum() / ((noisy - noisy.mean()) ** 2).sum()
    assert vaf == pytest.approx(0.98, abs=2e-3)
    with pytest.raises(InputError, match="Did you mean"):
        target.subject("ah.")


def test_the_jacobian_passes_taylors_test(law):
    forces = Forces(target.subject("a.h."), law, 34.0, 3.0, 14.0)
    values = {each.name: each.start for each in forces.unknowns}
    rest = inverse.taylor(forces.residual, forces.unknowns, values)
    assert rest[:2] / rest[1:] == pytest.approx([4.0, 4.0], rel=0.15)


def test_stiffness_against_force_does_not_know_the_scale_of_depth(law):
    one = law.at(2.0, 14.0)
    force = np.array([0.5, 2.0])
    x = one.depth(0.3 * force / 1.7)
    slope = 1.7 * (one.force(x + 1e-5) - one.force(x - 1e-5)) / 2e-5 / 0.3
    np.testing.assert_allclose(stiffness(one, 1.7, PRONY, force), slope, rtol=1e-6)


def test_a_finger_of_the_family_is_found_again_from_its_own_stiffness(law):
    wanted = target.subject("a.h.")
    k = stiffness(law.at(2.4, 14.0), 25.0 / 34.0, wanted.prony, wanted.force)
    forces = Forces(replace(wanted, stiffness=k), law, 34.0, 3.0, 14.0)
    found = inverse.solve(forces.residual, forces.unknowns, forces.starts())
    for name, value in {"exponent": 2.4, "modulus": 25.0}.items():  # the prior of 34 kPa pulls
        assert found.values[name] == pytest.approx(value, abs=0.5 * found.deviations[name])
    assert found.values["skin_ratio"] == 3.0
    assert found.misfit < 0.01
    assert prony_of(found.values).weights[0] == pytest.approx(wanted.prony.weights[0], rel=0.05)


def trial(hold=4.0, seed=0):
    made = synthetic.ramp_and_hold(Spring(ROW.b, ROW.m, 0.5), PRONY, seed=seed, hold=hold)
    return np.column_stack([made.time, made.position, made.force])[::2]


def write(path, table, head="time,position,force"):
    np.savetxt(path, table, "%.7g", ",", header=head, comments="")
    return path


def swap(table):
    table = table.copy()
    table[[100, 200]] = table[[200, 100]]
    return table


def times(table, column, factor):
    table = table.copy()
    table[:, column] *= factor
    return table


def growing(table):
    table = table.copy()
    held = table[:, 0] > 0.1
    table[held, 2] = 2.0 + 0.2 * table[held, 0]
    return table


BAD = {
    "few points": (lambda t: t[:30], "at least 40 samples|duration"),
    "coarse": (lambda t: t[::200], "ramp in contact: expected at least 20 samples"),
    "no hold": (lambda t: np.column_stack([t[:160, 0] * 9, t[:160, 1:]]), "hold: expected"),
    "unsorted": (swap, "received an earlier time"),
    "repeated": (lambda t: np.insert(t, 100, t[99], axis=0), "received a repeated time"),
    "time in ms": (lambda t: times(t, 0, 1e3), "as if it were in ms"),
    "position in m": (lambda t: times(t, 1, 1e-3), "as if it were in m;"),
    "position in um": (lambda t: times(t, 1, 1e3), "as if it were in um"),
    "force in mN": (lambda t: times(t, 2, 1e3), "as if it were in mN"),
    "force in g": (lambda t: times(t, 2, 102), "as if it were in grams of force"),
    "a force that grows at rest": (growing, "force that falls in the hold|rises on the ramp"),
    "a pillow": (lambda t: times(times(t, 1, 20), 2, 0.02), "which no fingertip has"),
}


@pytest.mark.parametrize(("spoil", "message"), BAD.values(), ids=BAD)
def test_a_record_that_cannot_be_used_gets_a_sentence(tmp_path, spoil, message):
    file = write(tmp_path / "bad.csv", spoil(trial()))
    with pytest.raises(InputError, match=message):
        target.record(file)


def test_a_record_to_be_predicted_has_to_unload(tmp_path):
    with pytest.raises(InputError, match="expected a record that also unloads"):
        target.unloading(write(tmp_path / "a.csv", trial()))
    back = trial()
    back[:, 1] = 1.5 - 0.5 * np.cos(4 * back[:, 0]) * (back[:, 0] > 0.2) - 1.5 * (back[:, 0] <= 0.2)
    assert len(target.unloading(write(tmp_path / "b.csv", back))) == 3


HEADS = "time,position," + ",".join(f"p{i}" for i in range(1, 65))


def table_of_frames(one, factor=1.0):
    depth = one.depth
    return np.column_stack([depth / 0.2, depth, factor * one.felt])


def test_frames_are_read_about_their_center(tmp_path):
    one = formula(1.0)
    found = target.frames(write(tmp_path / "f.csv", table_of_frames(one), HEADS))
    assert found.pressure.shape == found.depth.shape == (24, 64)
    np.testing.assert_allclose(found.distance, np.hypot(*ArraySensor().positions.T), atol=1e-6)
    assert found.depth[3, 63] > found.depth[3, 0]  # read later


FRAMES = {
    "MPa": (lambda t: np.column_stack([t[:, :2], 1e-3 * t[:, 2:]]), "as if it were in MPa"),
    "Pa": (lambda t: np.column_stack([t[:, :2], 1e3 * t[:, 2:]]), "as if it were in Pa"),
    "none": (lambda t: np.column_stack([t[:, :2], 0 * t[:, 2:]]), "pressures above 0"),
    "unsorted": (lambda t: t[::-1], "received an earlier time"),
    "too few": (lambda t: t[:2], "expected 4 frames or more"),
}


@pytest.mark.parametrize(("spoil", "message"), FRAMES.values(), ids=FRAMES)
def test_frames_that_cannot_be_used_get_a_sentence(tmp_path, spoil, message):
    file = write(tmp_path / "f.csv", spoil(table_of_frames(formula())), HEADS)
    with pytest.raises(InputError, match=message):
        target.frames(file)
    with pytest.raises(InputError, match="one column 'p3'"):
        target.frames(write(tmp_path / "g.csv", np.ones((5, 4)), "time,position,p1,p2"))


# The array


def test_the_thesis_finds_its_own_half_space():
    """t(u) of the thesis on Hertz's pressures is the finger that its fit is of."""
    x = np.linspace(0, 1.8, 401)[1:]
    one = formula(0.0, count=400)
    t = np.expm1(1.5 * x) / 1.5
    scale = 8e-3 / 3 * 3.0 * np.sqrt(14.0) * x**1.5 * t / one.force
    own = replace(one, force=scale * one.force, felt=scale[:, None] * one.felt)
    frames = target.Frames(
        np.repeat(x[20::20, None], 64, 1), own.felt[20::20], np.hypot(*ArraySensor().positions.T)
    )
    found = pad.thesis_fit(frames)
    assert (found.radius, found.m, found.c0_b) == pytest.approx((14.0, 1.5, 3.0), rel=0.02)


def test_a_radius_is_found_where_the_fit_has_the_wanted_one():
    radius, power = pad.radius_for(13.0, (10.0, 14.0), (12.0, 15.0))
    assert power == pytest.approx(np.log(15 / 12) / np.log(1.4))
    assert 12 * (radius / 10) ** power == pytest.approx(13.0)
    with pytest.raises(InputError, match="expected the fitted R to grow"):
        pad.radius_for(13.0, (10.0, 14.0), (15.0, 12.0))


def test_the_next_radius_is_between_those_that_hold_the_wanted_r_or_beyond_the_nearest():
    """Fitted R that grow with the square of the pad radius are found at once."""
    between = pad.nearer(12.0, (14.0, 10.0, 30.0), (14.0**2 / 10, 10.0, 90.0))
    assert between == pytest.approx(np.sqrt(120.0))
    assert pad.nearer(11.0, (12.0, 10.0), (8.0, 10.0), 2.0) == pytest.approx(10 * 1.1**0.5)
    assert pad.nearer(9.0, (12.0, 10.0), (14.0, 10.0), 0.3) == pytest.approx(9.0)
    assert pad.nearer(20.0, (12.0, 10.0), (14.0, 10.0)) == pytest.approx(12.0 * pad.WITHIN)


def test_the_array_feels_the_whole_force_and_hertz():
    scene = pressed(ff.Finger.subject("a.h."), 0.08)
    response = hertz.respond(scene)
    read = felt(scene, response)
    assert read[-1].sum() * 4 == pytest.approx(1e3 * response.force[-1], rel=0.03)
    want = response.force[-1] * hertzian(14.0 * response.depth[-1])
    np.testing.assert_allclose(read[-1], want, atol=0.03 * want.max())


# Presses and their cache


def test_a_press_is_solved_once_and_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(presses, "root", lambda: tmp_path)
    solved = []

    class Way:
        @staticmethod
        def respond(scene, progress=None):
            solved.append(scene)
            return hertz.respond(scene)

    monkeypatch.setattr("fefinger.mechanics.get", lambda name: Way)
    finger = ff.Finger.subject("a.h.")
    first, again = press(finger, "condensed"), press(finger, "condensed")
    assert len(solved) == 1
    np.testing.assert_array_equal(first.felt, again.felt)
    other = replace(finger, subcutaneous=replace(finger.subcutaneous, modulus=20.0))
    press(other, "condensed")
    press(finger, "solid")
    assert len(solved) == 3
    (next(iter(tmp_path.glob("*.npz")))).write_bytes(b"damaged")
    for each in (finger, other):
        press(each, "condensed")
    press(finger, "solid")
    assert len(solved) == 4


def test_a_pad_that_condensed_does_not_reach_is_pressed_by_linear(tmp_path, monkeypatch):
    monkeypatch.setattr(presses, "root", lambda: tmp_path)

    def refuse(scene, progress=None):
        msg = "beyond the side of the finger"
        raise InputError(msg)

    ways = {"condensed": type("W", (), {"respond": refuse}), "linear": hertz}
    monkeypatch.setattr("fefinger.mechanics.get", ways.get)
    assert presses.small(ff.Finger.subject("a.h.")).depth[-1] == pytest.approx(1.8)


def test_kept_presses_are_listed_in_the_cache(tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "root", lambda: tmp_path)
    monkeypatch.setattr("fefinger.mechanics.get", lambda name: hertz)
    press(ff.Finger.subject("a.h."), "condensed")
    (entry,) = cache.entries()
    assert (entry.kind, entry.paths[0].parent) == ("presses", tmp_path / "presses")
    assert 0 < entry.size < 1e6
    cache.remove([entry])
    assert cache.entries() == ()


def test_a_press_that_stops_is_kept_as_far_as_it_went(tmp_path, monkeypatch):
    monkeypatch.setattr(presses, "root", lambda: tmp_path)

    def stop(scene, progress=None):
        whole = hertz.respond(scene)
        n = len(whole.time) * 2 // 3
        cut = {
            name: getattr(whole, name)[:n]
            for name in ("time", "depth", "force", "contact_area", "pressure")
        }
        msg = "no further"
        raise Stopped(msg, replace(whole, **cut))

    monkeypatch.setattr("fefinger.mechanics.get", lambda name: type("W", (), {"respond": stop}))
    found = press(ff.Finger.subject("a.h."), "solid")
    assert found.halt == "no further"
    assert 1.0 < found.depth[-1] < 1.3


# The whole way


@pytest.fixture
def solved(monkeypatch):
    """Let every press be the formula; return the list of what was asked."""
    asked = []

    def answer(finger, mechanics, part=None):
        small = mechanics == "condensed"
        exponent = 0.0 if small else finger.skin.exponent
        ratio = finger.skin.modulus / finger.subcutaneous.modulus / (102.4 / 34)
        asked.append((mechanics, finger.resolution, finger.pad_radius, exponent, ratio))
        return formula(exponent, finger.pad_radius, ratio, 400 if small else 24, 2.0)

    monkeypatch.setattr(work, "press", answer)
    monkeypatch.setattr(work, "small", lambda finger: answer(finger, "condensed"))
    monkeypatch.setattr(pad, "thesis_fit", by_width)
    return asked


def by_width(frames):
    """Return R from the mean square distance 2 a² / 5 + 2 sigma² of Hertz's blurred pressure."""
    last, depth = frames.pressure[-1], frames.depth[-1, 0]
    square = float(last @ frames.distance**2 / last.sum()) - 2 * 0.96**2
    return pad.PadFit(2.5 * square / depth, 1.0, 1.0, 0.0)


def record_of(one, factor, x0):
    """Return a ramp and hold (n_t, 3) of a finger with the noise of the thesis."""
    time = np.concatenate([np.arange(0, 0.033, 2e-4), 0.033 + np.geomspace(2e-4, 5, 900)])
    even = np.arange(0, 5, 4e-4)
    position = np.minimum(60 * time, 1.98)
    force = np.interp(even, time, predicted(one, factor, PRONY, time, position - x0))
    rng = np.random.default_rng(1)
    noise = rng.normal(0, 3e-3, (2, len(even)))
    return np.column_stack([even, np.minimum(60 * even, 1.98) + noise[0], force + noise[1]])


def wave_on(one, factor, x0):
    """Return a table of time s, position mm and force N of a sinusoid about a depth."""
    time = np.arange(0, 1, 5e-4)
    position = x0 + np.minimum(20 * time, 1.0) + 0.2 * np.sin(25 * time)
    force = predicted(one, factor, PRONY, time, position - x0)
    return np.column_stack([time, position, force])


def test_a_record_is_calibrated_and_a_sinusoid_predicted(tmp_path, solved, linear):
    one, x0 = linear.at(0.9, 14.0), 0.4
    table = record_of(one, 1.3, x0)
    check = write(tmp_path / "wave.csv", wave_on(one, 1.3, x0))
    found = ff.calibrate(
        write(tmp_path / "press.csv", table),
        finger=ff.Finger.subject("a.h."),
        mechanics="condensed",
        check=check,
    )
    truth = {"t_b": 1.3, "t_m": 0.9, "x0": x0, "c0": 0.3, "c1": 0.42, "v2": 9.0, "v3": 0.6}
    for name, value in truth.items():
        assert found[name].value == pytest.approx(value, abs=3 * found[name].sd)
        assert found[name].sd < 0.1 * value
    assert found.checks["record that was not fitted"]["mse"] < 1e-3
    assert [stage.name for stage in found.stages] == ["lumped", "condensed"]
    assert "pad_radius: there are no frames, so it is kept" in found.unidentified
    assert "squared error" in found.status
    assert len(found.correlations) == len(found.correlations[0]) == 9
    with pytest.raises(KeyError, match="'depth': expected one of the parameters t_b, t_m, x0"):
        found["depth"]


def test_a_subject_takes_no_check_and_nothing_is_solved(tmp_path, solved, linear):
    check = write(tmp_path / "wave.csv", wave_on(linear.at(0.9, 14.0), 1.3, 0.4))
    with pytest.raises(InputError, match="check: expected the record of a user"):
        ff.calibrate("a.h.", mechanics="condensed", check=check)
    assert solved == []


def test_a_record_is_calibrated_through_solid(tmp_path, solved, law):
    table = record_of(law.at(2.4, 14.0), 0.7, 0.4)
    found = ff.calibrate(
        write(tmp_path / "press.csv", table),
        finger=ff.Finger.subject("a.h."),
        resolution="coarse",
    )
    assert {each[:3] for each in solved} == {("solid", "coarse", 14.0)}
    for name, value in {"exponent": 2.4, "modulus": 0.7 * 34, "x0": 0.4, "c0": 0.3}.items():
        assert found[name].value == pytest.approx(value, abs=3 * found[name].sd)
    assert found["exponent"].sd < 0.2
    assert any("skin_ratio" in said for said in found.unidentified)


def test_a_subject_is_calibrated_through_solid(tmp_path, solved):
    said = []
    found = ff.calibrate("a.h.", progress=lambda stage, part: said.append((stage, part)))
    assert [stage.name for stage in found.stages] == [
        *("solid, coarse", "array, coarse", "solid, standard", "array")
    ]
    assert ("solid, coarse", 1.0) in said
    numbers = np.array([each[2:] for each in solved[:8]])
    shapes = [(14, b, 1) for b in (0.02, 1.5, 3, 4.5, 7, 10)]
    np.testing.assert_allclose(numbers, [*shapes, (14, 3, 2), (16.1, 3, 1)])
    assert {each[1] for each in solved[:8]} == {"coarse"}
    assert {each[1] for each in solved[8:]} == {"standard"}
    assert found.residuals["array radius"] == pytest.approx(14.0, rel=0.02)
    assert found.residuals["m"] == pytest.approx(2.1, rel=0.1)
    assert {"modulus", "exponent", "skin_ratio", "c0"} <= {each.name for each in found.parameters}
    assert found["skin_ratio"].how == "held"
    assert set(found.checks) == {"2 Hz", "4 Hz", "8 Hz", "16 Hz"}
    files = found.save(tmp_path)
    assert Calibration.load(tmp_path) == found
    scene = tmp_path / "scene.toml"
    scene.write_text(
        '[finger]\nsubject = "a.h."\ntissue = "tissue.toml"\n'
        '[motion]\nkind = "ramp"\nspeed = 1\ndepth = 1\n'
    )
    finger = ff.Scene.from_toml(scene).finger
    assert finger.skin.law == "demiray"
    assert finger.skin.exponent == pytest.approx(found["exponent"].value, abs=1e-4)
    assert finger.subcutaneous.modulus == pytest.approx(found["modulus"].value)
    assert finger.skin.modulus == pytest.approx(found["modulus"].value * 102.4 / 34)
    assert finger.prony == found.prony
    assert finger.pad_radius == found.finger["pad_radius"]
    assert [name.rsplit("/", 1)[1] for name in files] == ["calibration.json", "tissue.toml"]


def test_the_command_prints_and_writes(tmp_path, solved, capsys):
    words = ["calibrate", "--subject", "a.h.", "--subject", "d.s.", "--mechanics", "condensed"]
    assert main([*words, "--json", "-o", str(tmp_path / "out")]) == 0
    out = json.loads(capsys.readouterr().out)
    assert [each["target"] for each in out["calibrations"]] == ["a.h.", "d.s."]
    assert [file.split("/")[-2] for file in out["files"]] == ["ah", "ds"]
    assert main([*words[:3], *words[5:]]) == 0
    text = capsys.readouterr().out
    for said in ("Fitted a.h. in", "t_m", "+-", "not identified: pad_radius", "not fitted"):
        assert said in text


REFUSED = {
    "nothing": ([], "expected DATA.csv or --subject"),
    "no size": (["none.csv"], "--width: expected the size of the finger"),
    "no file": (["none.csv", "--width", "14", "--thickness", "10"], "cannot be read"),
    "nobody": (["--subject", "x.y."], "finger.subject"),
    "two": (["none.csv", "--subject", "a.h.", "--subject", "d.s."], "expected one beside DATA.csv"),
    "mechanics": (["--subject", "a.h.", "--mechanics", "hertz"], "mechanics: expected one of"),
    "resolution": (["--subject", "a.h.", "--resolution", "best"], "finger.resolution"),
    "check": (["--subject", "a.h.", "--check", "x.csv"], "check: expected the record of a user"),
    "frames": (["--subject", "a.h.", "--frames", "x.csv"], "cannot be read"),
    "unmeasured": (["--subject", "f.c."], "width"),
}


@pytest.mark.parametrize(("words", "message"), REFUSED.values(), ids=REFUSED)
def test_the_command_refuses_what_it_cannot_use(words, message, capsys, solved):
    assert main(["calibrate", *words]) == 2
    assert message in capsys.readouterr().err
    assert solved == []


def test_subjects_are_calibrated_in_processes_of_their_own():
    todo = [jobs.Job(name, {"mechanics": "condensed"}) for name in ("nobody", "no one")]
    with pytest.raises(InputError, match="expected a subject"):
        jobs.run(todo, workers=2)


def test_errors_are_those_of_equation_2_5():
    measured = np.array([0.0, 1.0, 2.0, 3.0])
    assert errors(measured, measured + 0.3) == pytest.approx({"mse": 0.36 / 5, "peak": 0.1})


def test_a_layer_keeps_what_is_not_its_law():
    skin = ff.Tissue(100, 0.48, 1.0, law="mooney-rivlin", share=0.3)
    stiff = layer(skin, 2.5, 0.5)
    assert (stiff.modulus, stiff.poisson, stiff.thickness) == (50, 0.48, 1.0)
    assert (stiff.law, stiff.exponent, stiff.share) == ("demiray", 2.5, None)
    assert layer(skin, None, 2.0).law == "mooney-rivlin"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected \\[skin\\] and \\[subcutaneous\\]"),
        ("skin = 3", "expected \\[skin\\] and"),
        ("[bone]\nmodulus = 3", "bone"),
        ("not toml", "expected a TOML file with a tissue set"),
        ("[skin]\nmodulus = -3\npoisson = 0.4\n", "above 0"),
    ],
)
def test_a_file_that_is_no_tissue_set_is_refused(tmp_path, text, message):
    file = tmp_path / "tissue.toml"
    file.write_text(text)
    with pytest.raises(InputError, match=message):
        library.tissue_set(str(file))


def test_a_file_that_is_no_calibration_is_refused(tmp_path):
    (tmp_path / "calibration.json").write_text('{"target": 3}')
    for place in (tmp_path, tmp_path / "none.json"):
        with pytest.raises(InputError, match=r"expected a calibration\.json"):
            Calibration.load(place)
