"""Calibration on fingers whose curve is a formula; the finite elements are in the suite."""

import io
import json
import time
from contextlib import redirect_stdout
from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest
from fefinger.validation.calibration.subject_target import (
    SubjectTarget,
    calibrate_subject,
    printed,
    target_of,
)

import fefinger as ff
from fefinger.__main__ import main
from fefinger.calibration import (
    array_sensor,
    pad_radius,
    press_store,
    record_file,
    search,
    slow_press,
    targets,
)
from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.outcome import refuse_gross, stiffening
from fefinger.calibration.record import Calibration, Parameter, Stage
from fefinger.calibration.rig import lagged
from fefinger.calibration.slow_press import LATER, PART, SPARE
from fefinger.calibration.targets import errors
from fefinger.scene import library
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.theory.lumped import identify
from fefinger.theory.relaxation import Prony


OF_AH = ("none.csv", "--subject", "a.h.")
PRONY = Prony((0.3, 0.42, 0.16, 0.12), (220.0, 9.0, 0.6))


def record_of(one, factor, x0, noise=3e-3, give=0.0, lag=0.0, end=5.0):
    """Return a ramp and hold (n_t, 3) of a finger, with noise like that of the thesis.

    give: mm/N of the rig between the motor, whose position is recorded, and the skin; lag:
    s of a low-pass before the noise.
    """
    time = np.concatenate([np.arange(0, 0.033, 2e-4), 0.033 + np.geomspace(2e-4, 5, 400)])
    even = np.arange(0, end, 4e-4)
    position = np.minimum(60 * time, 1.98)
    finger = ForceLaw(one, PRONY, factor)
    pressed = finger.predicted(time, position - x0)
    for _ in range(30 if give else 0):  # half the distance, as give x stiffness is below 1
        pressed = (pressed + finger.loading(time, position - give * pressed - x0)) / 2
    force = lagged(even, np.interp(even, time, pressed), lag)
    rng = np.random.default_rng(1)
    off = noise * rng.normal(0, 1, (2, len(even)))
    return np.column_stack([even, np.minimum(60 * even, 1.98) + off[0], force + off[1]])


def wave_on(one, factor, x0):
    """Return a table of time s, position mm and force N of a sinusoid about a depth."""
    time = np.arange(0, 0.6, 1e-3)
    position = x0 + np.minimum(20 * time, 1.0) + 0.2 * np.sin(25 * time)
    force = ForceLaw(one, PRONY, factor).predicted(time, position - x0)
    return np.column_stack([time, position, force])


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"check": "none.csv"}, "none.csv: expected a file of a record"),
        ({"frames": "none.csv"}, "none.csv: expected a file of a record"),
        ({"finger": ff.Finger(3.0, 11.0)}, "finger.width: expected a finite number in mm at least"),
    ],
    ids=str,
)
def test_what_cannot_be_used_is_refused_before_anything_is_fitted(given, expected, monkeypatch):
    monkeypatch.setattr(record_file, "record", None)
    with pytest.raises(InputError, match=expected):
        ff.calibrate("press.csv", **{"finger": ff.Finger(15.0, 11.0)} | given)


@pytest.fixture(scope="module")
def fitted(tmp_path_factory, by_formula, start_once, linear, write):
    """Let the command fit a record and predict a sinusoid: what it prints, where, in which time."""
    folder, one = tmp_path_factory.mktemp("fitted"), linear.at(0.9, 14.0)
    press = write(folder / "press.csv", record_of(one, 1.3, 0.4))
    check = write(folder / "wave.csv", wave_on(one, 1.3, 0.4))
    words = ["calibrate", str(press), "--subject", "a.h.", "--mechanics", "condensed", "--json"]
    out, started = io.StringIO(), time.process_time()
    with pytest.MonkeyPatch.context() as patched, redirect_stdout(out):
        by_formula(patched)
        start_once(patched)
        patched.setattr("fefinger.pages.page.svg", lambda drawn: "data:,")
        assert main([*words, "--check", str(check), "-o", str(folder / "out")]) == 0
    return json.loads(out.getvalue()), folder, time.process_time() - started


def test_a_record_is_calibrated_and_a_sinusoid_predicted(fitted):
    _, folder, spent = fitted
    found = Calibration.load(folder / "out")
    truth = {"t_b": 1.3, "t_m": 0.9, "x0": 0.4, "c0": 0.3, "c1": 0.42, "v2": 9.0, "v3": 0.6}
    for name, value in truth.items():
        assert found[name].value == pytest.approx(value, abs=3 * found[name].sd)
        assert found[name].sd < 0.1 * value
    assert found.checks["record that was not fitted"]["mse"] < 1e-3
    assert [stage.name for stage in found.stages] == [
        "lumped",
        "condensed",
        "compliance of the rig",
        "lag of the rig",
    ]
    assert found.stages[0].cpu > 0.01 * spent  # the fit itself is a third of it
    assert "pad_radius: there are no frames, so it is not fitted" in found.unidentified
    assert "squared error" in found.status
    assert np.shape(found.correlations) == (13, 13) == (len(found.parameters),) * 2
    with pytest.raises(KeyError, match="'depth': expected one of the parameters t_b, t_m, x0"):
        found["depth"]


def test_condensed_presses_by_the_object_of_the_record(
    tmp_path, monkeypatch, solved, linear, write
):
    press = write(tmp_path / "press.csv", record_of(linear.at(0.9, 14.0), 1.3, 0.4, end=2.0))

    def small(finger, indenter):
        raise ConvergenceError(repr(indenter))

    monkeypatch.setattr(press_store, "small", small)
    how = {"finger": targets.finger_of("a.h."), "mechanics": "condensed"}
    with pytest.raises(ConvergenceError) as asked:
        ff.calibrate(press, indenter=ff.Sphere(5), **how)
    assert str(asked.value) == repr(ff.Sphere(5))
    monkeypatch.setattr(slow_press, "press", lambda finger, mechanics, indenter: indenter)
    assert slow_press.small(how["finger"], ff.Sphere(5)) == ff.Sphere(5)


def test_a_finger_that_does_not_show_its_record_is_no_calibration(fitted):
    _, folder, _ = fitted
    found = Calibration.load(folder / "out")
    wanted = record_file.record(folder / "press.csv", "coarse")
    refuse_gross(found, wanted)
    gross = replace(found, residuals=found.residuals | {"mse": 1.5})
    with pytest.raises(ConvergenceError, match=r"received 150 %; check the size of the finger"):
        refuse_gross(gross, wanted)
    late = replace(wanted, lumped=replace(wanted.lumped, warnings=("the force lags",)))
    with pytest.raises(ConvergenceError, match=r"press less deep than 0\.5 mm.* lags"):
        refuse_gross(replace(gross, deepest=0.5), late)
    many = replace(gross, unidentified=tuple(f"v{k}: at its bound" for k in range(9)))
    with pytest.raises(ConvergenceError, match=r"; v1: at its bound; and 7 more$"):
        refuse_gross(many, replace(wanted, lumped=replace(wanted.lumped, warnings=())))


@pytest.mark.usefixtures("plain_rig")
def test_a_record_without_noise_is_calibrated_within_the_error_of_one_g(
    tmp_path, solved, law, write
):
    """Its hold leaves G by 0.1 %, as at finite strain, and has no noise that would cover this."""
    table = record_of(law.at(2.4, 14.0), 0.7, 0.4, noise=0.0)
    held = np.maximum(table[:, 0] - 0.033, 0.0)
    table[:, 2] *= 1 + 1e-3 * np.sin(2 * held)
    found = ff.calibrate(
        write(tmp_path / "press.csv", table), finger=targets.finger_of("a.h."), resolution="coarse"
    )
    assert found.residuals["mse"] < 1e-4
    assert found["exponent"].value == pytest.approx(2.4, abs=0.3)


def test_finger_and_rig_are_found_through_solid(tmp_path, solved, law, write, monkeypatch):
    """A force 2 ms late, with an offset of 30 mN and a drift of 8 mN/s."""
    monkeypatch.setattr(search, "with_rare", lambda result, *_: result)  # its own test is below
    table = record_of(law.at(2.4, 14.0), 0.7, 0.4)
    table[5:, 2] = table[:-5, 2].copy()
    table[:, 2] += 0.03 + 8e-3 * table[:, 0]
    press = write(tmp_path / "press.csv", table)
    found = ff.calibrate(press, finger=targets.finger_of("a.h."), resolution="coarse")
    assert {each[:3] for each in solved} == {("solid", "coarse", 14.0)}
    truth = {"exponent": 2.4, "modulus": 0.7 * 34, "x0": 0.4, "c0": 0.3}
    for name, value in (truth | {"delay": 2.0, "offset": 30.0, "drift": 8.0}).items():
        assert found[name].value == pytest.approx(value, abs=3 * found[name].sd)
    assert found["exponent"].sd < 0.1
    assert found["delay"].sd < 0.05
    assert found["offset"].sd < 2
    for said in ("skin_ratio", "one G relaxes the force", "take the pad radius as known"):
        assert any(said in each for each in found.unidentified)


@pytest.mark.usefixtures("one_start", "solved")
@pytest.mark.parametrize(
    ("fault", "size", "words"),
    [("compliance", 0.04, "position of the motor: "), ("lag", 3.0, "low-pass: ")],
)
def test_what_rigs_rarely_do_is_recognized_told_with_its_number_and_fitted(
    tmp_path, law, linear, write, fault, size, words
):
    """The position of a motor with 0.04 mm/N of give, or a force behind 3 ms of filter."""
    if fault == "compliance":  # a law of another exponent bends the curve as well
        table, how = record_of(law.at(2.4, 14.0), 0.7, 0.4, give=size), {"resolution": "coarse"}
        truth = {"exponent": 2.4, "x0": 0.4, "c0": 0.3}
    else:
        table = record_of(linear.at(0.9, 14.0), 1.3, 0.4, lag=1e-3 * size)
        how, truth = {"mechanics": "condensed"}, {"t_m": 0.9, "x0": 0.4, "c0": 0.3}
    press = write(tmp_path / "press.csv", table)
    found = ff.calibrate(press, finger=targets.finger_of("a.h."), **how)
    (told,) = (each for each in found.findings if each.startswith(words))
    assert f"{found[fault].value:.2g}" in told
    for name, value in (truth | {fault: size}).items():
        assert found[name].value == pytest.approx(value, abs=3 * found[name].sd)
    assert found[fault].sd < 0.3 * size
    assert words.removesuffix(": ") in [name for _, name in found.presses[0].marks]


@pytest.mark.usefixtures("plain_rig")
def test_a_ball_and_a_plate_are_fitted_together_and_another_ball_is_predicted(
    tmp_path, solved, law, write, ball_law
):
    """The force under the ball stiffens as its own family does; x0 of the last is its own."""
    files = []
    for one, x0, name in (
        (law, 0.4, "plate"),
        (ball_law(5.0), 0.6, "ball"),
        (ball_law(3.0), 0.3, "other"),
    ):
        seen = {"noise": 0.0, "end": 0.2} if name == "other" else {}
        table = record_of(one.at(2.4, 14.0), 0.7, x0, **seen)
        files.append(write(tmp_path / f"{name}.csv", table))
    objects = [ff.Flat(30), ff.Sphere(5.0), ff.Sphere(3.0)]
    found = ff.calibrate(
        files[:2],
        finger=targets.finger_of("a.h."),
        resolution="coarse",
        indenter=objects,
        check=files[2],
    )
    for name, value in {"exponent": 2.4, "x0": 0.4, "x0 2": 0.6, "c0": 0.3}.items():
        assert found[name].value == pytest.approx(value, abs=3 * found[name].sd)
    assert found.checks["record that was not fitted"]["mse"] < 1e-3
    assert [each.held_out for each in found.presses] == [False, False, True]


@pytest.mark.parametrize(
    "given",
    [
        {"indenter": [ff.Flat(0), ff.Sphere(5)]},
        {"indenter": [ff.Flat(0), ff.Sphere(5)], "check": "c.csv", "mechanics": "condensed"},
        {"indenter": ff.Sphere(5), "frames": "f.csv"},
    ],
    ids=("two for one record", "two by condensed", "frames under a ball"),
)
def test_objects_that_do_not_fit_the_records_are_refused(given, monkeypatch, tmp_path, write):
    monkeypatch.setattr(record_file, "motion", lambda *a: ())
    monkeypatch.setattr(array_sensor, "frames", lambda file: file)
    with pytest.raises(InputError, match=r"indenter|frames|f\.csv"):
        ff.calibrate("press.csv", finger=ff.Finger(15.0, 11.0), **given)


@pytest.mark.usefixtures("plain_rig")
def test_presses_at_two_speeds_are_fitted_together_and_a_third_is_predicted(
    tmp_path, solved, linear, write
):
    """Each has its own touch and offset; they share a delay of 0.8 ms."""
    finger, files = ForceLaw(linear.at(0.9, 14.0), PRONY, 1.3), []
    rng = np.random.default_rng(2)
    for speed, x0, offset in ((60.0, 0.4, 0.02), (15.0, 0.5, -0.01), (30.0, 0.4, 0.03)):
        time = np.arange(0.0, 2.0 if speed != 30.0 else 0.4, 4e-4)
        path = np.clip(speed * (time - 0.05), 0.0, 1.9)
        force = np.interp(time - 8e-4, time, finger.loading(time, path - x0)) + offset
        off = 3e-3 * rng.normal(size=(2, len(time))) * (speed != 30.0)
        table = np.column_stack([time, path + off[0], force + off[1]])
        files.append(write(tmp_path / f"{speed:g}.csv", table))
    of_ah = targets.finger_of("a.h.")
    found = ff.calibrate(files[:2], finger=of_ah, mechanics="condensed", check=files[2])
    truth = {"t_m": 0.9, "x0": 0.4, "x0 2": 0.5, "delay": 0.8, "offset": 20, "offset 2": -10}
    for name, value in truth.items():
        assert found[name].value == pytest.approx(value, abs=3 * found[name].sd)
    assert found.target == f"{files[0]}, {files[1]}"
    assert found.checks["record that was not fitted"]["mse"] < 1e-3
    assert found.residuals["mse 2"] < 1e-4
    with pytest.raises(InputError, match="the file of a record or more, received none"):
        ff.calibrate([], finger=of_ah)


@pytest.mark.usefixtures("plain_rig")
def test_a_record_that_shows_fewer_terms_is_calibrated(
    tmp_path, solved, linear, write, monkeypatch
):
    def joint(*record, terms):
        if terms == 3:
            raise RuntimeError("joint: the fit did not converge")
        return identify.joint(*record, terms=terms)

    monkeypatch.setattr(record_file, "joint", joint)
    press = write(tmp_path / "press.csv", record_of(linear.at(0.9, 14.0), 1.3, 0.4))
    found = ff.calibrate(press, finger=targets.finger_of("a.h."), mechanics="condensed")
    assert found["t_m"].value == pytest.approx(0.9, abs=0.1)
    assert any("converges with 2 of 3 terms only" in each for each in found.unidentified)


def test_a_subject_is_calibrated_through_solid(tmp_path, solved):
    said = []
    found = calibrate_subject("a.h.", progress=lambda stage, part: said.append((stage, part)))
    assert [stage.name for stage in found.stages] == [
        *("solid, coarse", "array, coarse", "solid, standard", "array")
    ]
    assert ("solid, coarse", 1.0) in said
    numbers = np.array([each[2:] for each in solved[:10]])
    shapes = [(14, b, 1) for b in (0.02, 1.2, 2.8, 4.8, 7, 10, 13, 16)]
    np.testing.assert_allclose(numbers, [*shapes, (14, 3, 2), (12.6, 3, 1)])
    assert {each[1] for each in solved[:10]} == {"coarse"}
    assert {each[1] for each in solved[10:]} == {"standard"}
    assert found.residuals["array radius"] == pytest.approx(14.0, rel=0.02)
    assert found.residuals["m"] == pytest.approx(2.1, rel=0.1)
    assert {"modulus", "exponent", "skin_ratio", "c0"} <= {each.name for each in found.parameters}
    assert found["skin_ratio"].how == "held"
    assert set(found.checks) == {"2 Hz", "4 Hz", "8 Hz", "16 Hz"}
    files = found.save(tmp_path)
    assert Calibration.load(tmp_path) == found  # exact: JSON has every digit
    assert repr(found).startswith(found.status)
    assert len(repr(found)) < 5000
    scene = tmp_path / "scene.toml"
    scene.write_text(
        '[finger]\nsubject = "a.h."\ntissue = "tissue.toml"\n'
        '[motion]\nkind = "ramp"\nspeed = 1\ndepth = 1\n'
    )
    finger = ff.Scene.from_toml(scene).finger
    assert finger.skin.law == "demiray"
    assert finger.subcutaneous.exponent == pytest.approx(found["exponent"].value, abs=1e-4)
    assert finger.skin.exponent == pytest.approx(2.9 * found["exponent"].value, abs=3e-4)
    assert finger.subcutaneous.modulus == pytest.approx(found["modulus"].value)
    assert finger.skin.modulus == pytest.approx(found["modulus"].value * found["skin_ratio"].value)
    assert finger.prony == found.prony  # exact: handed on
    assert finger.pad_radius == found.finger["pad_radius"]
    assert (finger.tip_radius, finger.tip_tissue) == (2.5, 6.2)
    larger = ff.Finger(28, 20, tissue=str(tmp_path / "tissue.toml"))
    assert (larger.pad_radius, larger.tip_radius) == (2 * finger.pad_radius, 5.0)
    assert [name.rsplit("/", 1)[1] for name in files] == ["calibration.json", "tissue.toml"]


def test_a_pad_radius_that_the_frames_do_not_determine_is_told():
    assert search._undetermined(14.0, pad_radius.DETERMINED) == ()
    assert search._undetermined(14.0, None) == ()
    (said,) = search._undetermined(14.0, 0.3)
    assert said.endswith("hardly depends on it (as its power 0.3), so it remains 14 mm")


@pytest.mark.parametrize(("fitted", "radius"), [(14.2, 14.0), (15.0, 13.42)])
def test_a_pad_radius_whose_r_is_as_printed_remains(monkeypatch, fitted, radius):
    """R grows as the pad radius to the power 1.63; that of a.h. is 14 mm, printed to the mm."""
    work = press_store.Work(targets.finger_of("a.h."), None)
    smaller = fitted * 0.9**1.63
    fits = iter((fitted, smaller))
    monkeypatch.setattr(search.Search, "_solved", lambda *given: None)
    monkeypatch.setattr(search, "pad_fit", lambda result: SimpleNamespace(radius=next(fits)))
    found_by = search.Search(work, target_of("a.h."), None, printed("a.h."))
    found, power = found_by._radius(None, (14.0, 12.6), None)
    assert (found, power) == (radius, pytest.approx(1.63))


def test_the_command_prints_and_writes(fitted, monkeypatch, capsys):
    out, folder, _ = fitted
    press = str(folder / "press.csv")
    assert [each["target"] for each in out["calibrations"]] == [press]
    assert [file.split("/")[-1] for file in out["files"]] == [
        "calibration.json",
        "calibration.html",
    ]
    found, given = Calibration.load(folder / "out"), []
    assert out["calibrations"] == json.loads(json.dumps([found.record()]))  # exact: as written
    monkeypatch.setattr(
        "fefinger.calibration.calibrate.calibrate", lambda *all, **how: given.append(all) or found
    )
    assert main(["calibrate", press, "--subject", "a.h.", "--mechanics", "condensed"]) == 0
    assert given == [((press,),)]
    text = capsys.readouterr().out
    for said in ("Fitted ", "t_m", "+-", "not identified: pad_radius", "no tissue.toml"):
        assert said in text


REFUSED = {
    "nothing": ([], "DATA.csv"),
    "no size": (["none.csv"], "--width: expected the size of the finger"),
    "no file": (
        ["none.csv", "--width", "14", "--thickness", "10"],
        "'none.csv', which does not exist",
    ),
    "nobody": (["none.csv", "--subject", "x.y."], "finger.subject"),
    "mechanics": ([*OF_AH, "--mechanics", "hertz"], "mechanics: expected one of"),
    "resolution": (
        [*OF_AH, "--resolution", "best"],
        "resolution: expected one of 'coarse', 'standard', 'fine', received 'best'",
    ),
    "no one resolution": ([*OF_AH, "--resolution", "auto"], "received 'auto'"),
    "unmeasured": (["none.csv", "--subject", "f.c."], "width"),
}


@pytest.mark.parametrize(("words", "message"), REFUSED.values(), ids=REFUSED)
def test_the_command_refuses_what_it_cannot_use(words, message, capsys, solved):
    assert main(["calibrate", *words]) == 2
    assert message in capsys.readouterr().err
    assert solved == []


def test_a_refusal_leaves_no_empty_folder(tmp_path, solved):
    out = tmp_path / "new" / "out"
    assert main(["calibrate", *OF_AH, "--resolution", "auto", "-o", str(out)]) == 2
    assert list(tmp_path.iterdir()) == []


def test_an_empty_name_is_no_folder_of_a_calibration(capsys, solved):
    assert main(["calibrate", *OF_AH, "-o", ""]) == 2
    assert "output folder: expected a name" in capsys.readouterr().err
    assert solved == []


@pytest.mark.parametrize("name", ["tissue.toml", "calibration.json"])
def test_a_file_that_is_none_of_a_calibration_is_not_replaced(name, tmp_path, capsys, solved):
    own = tmp_path / name
    own.write_text("[1]\n")
    words = ["calibrate", *OF_AH, "--resolution", "coarse", "-o", str(tmp_path)]
    assert main(words) == 2
    assert f"'{name}'" in capsys.readouterr().err
    assert own.read_text() == "[1]\n"
    assert solved == []


def test_errors_are_those_of_equation_2_5():
    measured = np.array([0.0, 1.0, 2.0, 3.0])
    assert errors(measured, measured + 0.3) == pytest.approx({"mse": 0.36 / 5, "peak": 0.1})


def test_a_stiffening_finger_keeps_what_is_not_its_law():
    skin = ff.Tissue(100, 0.48, 1.0, law="mooney-rivlin", share=0.3)
    finger = ff.Finger(14, 10, skin=skin, subcutaneous=ff.Tissue(30, 0.48))
    stiff = stiffening(finger, 2.5, 0.5)
    assert (stiff.skin.modulus, stiff.skin.poisson, stiff.skin.thickness) == (50, 0.48, 1.0)
    assert (stiff.skin.law, stiff.skin.share) == ("demiray", None)
    assert (stiff.subcutaneous.modulus, stiff.subcutaneous.exponent) == (15, 2.5)
    assert stiff.skin.exponent == library.SKIN_EXPONENT_RATIO * 2.5
    assert stiffening(finger, None, 2.0).skin.law == "mooney-rivlin"


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


RECORD = Calibration(
    target="a.h.",
    mechanics="solid",
    finger={"width": 14.0},
    parameters=(Parameter("m", 30.0, 1.0, "kPa", (30.0, 5.0), "made up", (1.0, 90.0), "fitted"),),
    correlations=((1.0,),),
    residuals={"m": 2.0},
    unidentified=("skin",),
    stages=(Stage("solid", 1.0, 3, 2.0, None),),
    status="done",
    skin={"modulus": 80.0},
    subcutaneous={"modulus": 30.0},
    prony=Prony((0.5, 0.5), (1.0,)),
    deepest=1.5,
    q=(0.0, 1.0),
    shares=((0.5,), (1.0,)),
    growth=None,
    checks={"2 Hz": {"mse": 0.1}},
).record()


@pytest.mark.parametrize("name", RECORD)
@pytest.mark.parametrize("value", [True, {"a": ["b"]}, [{}], [["x", None]]])
def test_a_stored_calibration_has_its_types(tmp_path, name, value):
    if isinstance(value, dict) and name in ("finger", "skin", "subcutaneous"):
        value = [value]  # a table of anything is one of these
    file = tmp_path / "calibration.json"
    file.write_text(json.dumps(RECORD))
    Calibration.load(file)
    file.write_text(json.dumps(RECORD | {name: value}))
    with pytest.raises(InputError, match=r"expected a calibration\.json"):
        Calibration.load(file)


@pytest.mark.parametrize("name", [f.name for f in fields(Parameter)])
def test_a_stored_parameter_has_its_types(tmp_path, name):
    file = tmp_path / "calibration.json"
    parameter = RECORD["parameters"][0] | {name: ["1", True]}
    file.write_text(json.dumps(RECORD | {"parameters": [parameter]}))
    with pytest.raises(InputError, match=f"{name}: .* belongs"):
        Calibration.load(file)


def test_after_a_press_that_buckled_later_ones_on_its_mesh_spare_less(monkeypatch, formula):
    """Each of up to six took all it was spared, which made ten minutes of every one."""
    spares = []

    def press(finger, mechanics, part=None, spare=None, indenter=None):
        spares.append(spare)
        halt = "too many factors" if finger.resolution == "standard" else ""
        return replace(formula(1.0, finger.pad_radius, 1.0), halt=halt)

    monkeypatch.setattr(press_store, "press", press)
    own = press_store.Work(targets.finger_of("a.h."), None)
    for mesh, exponent in (("coarse", 1.0), ("standard", 1.0), ("standard", 2.0), ("coarse", 2.0)):
        own.press("solid", mesh, 14.0, exponent)
    assert spares == [SPARE, SPARE, LATER, SPARE]


@pytest.mark.usefixtures("solved", "one_start")
@pytest.mark.parametrize("needed", [1.0, 3.0])
def test_a_press_that_ends_early_is_told_and_ends_those_after_it_if_it_holds_what_is_needed(
    monkeypatch, formula, needed
):
    """Why the curve of a buckling pad ended was lost, and so were frames that it did not reach."""
    asked = []

    def press(
        self, mechanics, resolution, radius, exponent=None, ratio=1.0, part=None, indenter=None
    ):
        deep = (part or PART[mechanics]) * self.finger.thickness
        ends = 0.96 * deep if resolution == "standard" and not asked else deep
        if resolution == "standard":
            asked.append((deep, ends))
        if len(asked) == 2 and needed > asked[0][1]:
            raise ConvergenceError("asked twice")
        found = formula(exponent or 1.0, radius, ratio, deepest=ends)
        found = replace(found, halt="" if ends == deep else "too many factors")
        self._note(replace(self.finger, resolution=resolution, pad_radius=radius), found)
        return found

    monkeypatch.setattr(press_store.Work, "press", press)
    monkeypatch.setattr(SubjectTarget, "reach", lambda *_: needed)
    if needed == 3.0:
        with pytest.raises(ConvergenceError, match="asked twice"):
            calibrate_subject("a.h.")
        assert asked[1][0] == pytest.approx(asked[0][0])
        return
    found = calibrate_subject("a.h.")
    assert asked[1][0] == pytest.approx(asked[0][1])
    said = " ".join(found.unidentified)
    assert "the press on the standard mesh" in said
    assert "ended early, at" in said
    assert "too many factors" in said
    assert "the frames of this finger end at" in said
