"""What presses would tell, against what a calibration of such a press states."""

import numpy as np
import pytest

import fefinger as ff
from fefinger.__main__ import main
from fefinger.calibration import design, targets
from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.design import Candidate
from fefinger.calibration.rig import Rig
from fefinger.scene import library
from fefinger.support.checks import InputError


RIG = Rig(force_noise=3.0, position_noise=2e-3)
FAST = Candidate(60.0, 1.5, 2.0, 5e3)
PRESSES = (FAST, Candidate(10.0, 1.5, 2.0, 5e3), Candidate(60.0, 1.5, 8.0, 5e3))


@pytest.fixture
def planned(solved):
    return [each.deviations for each in design.design(targets.finger_of("a.h."), RIG, PRESSES)]


def test_a_fast_ramp_tells_the_fast_term_and_a_long_hold_the_slow_one(planned):
    fast, slow, long = planned
    assert fast["v1"] < 0.95 * slow["v1"]
    assert fast["delay"] < slow["delay"]
    assert long["v3"] < 0.7 * fast["v3"]


@pytest.mark.usefixtures("plain_rig")
def test_what_is_expected_is_what_a_calibration_states(planned, law, tmp_path, write):
    """Of a record with that noise, of a finger near the expected one."""
    rng, time = np.random.default_rng(0), np.arange(0.0, 2.13, 2e-4)
    path = np.clip(60 * (time - 0.1), 0.0, 2.0)
    one = law.at(design.EXPECTED, 14.0)
    prony = ff.Prony((0.25, 0.45, 0.16, 0.14), (212.0, 10.0, 0.64))
    finger = ForceLaw(one, prony, library.tissue_set(design.MEANS).subcutaneous.modulus / 34.0)
    force = finger.loading(time, path - 0.5)
    off = rng.normal(size=(2, len(time)))
    table = np.column_stack([time, path + 2e-3 * off[0], force + 3e-3 * off[1]])
    press = write(tmp_path / "press.csv", table)
    found = ff.calibrate(press, finger=targets.finger_of("a.h."), resolution="coarse", rig=RIG)
    stated = {name: found[name].sd / found[name].value for name in ("modulus", "exponent", "v1")}
    stated["x0"] = found["x0"].sd
    for name, sd in stated.items():
        assert planned[0][name] == pytest.approx(sd, rel=0.5)


def test_the_command_prints_a_table_and_asks_for_data_without_it(solved, capsys, monkeypatch):
    monkeypatch.setattr(design.design, "__defaults__", (PRESSES[:2], None))
    assert main(["calibrate", "--design", "--subject", "a.h."]) == 0
    out = capsys.readouterr().out
    assert "Expected standard deviations" in out
    assert "v1: best by 60 mm/s to 1.5 mm, held 2 s at 5000 Hz: " in out
    assert main(["calibrate", "--subject", "a.h."]) == 2
    assert "DATA.csv" in capsys.readouterr().err


def test_a_press_with_too_few_samples_is_refused(law):
    one = ForceLaw(law.at(3.0, 14.0), ff.Prony((0.5, 0.5), (9.0,)))
    with pytest.raises(InputError, match=r"press at 100 mm/s, 1000 Hz: ramp in contact: expected"):
        design.expected(Candidate(100.0, 1.0, 2.0, 1e3), one, RIG)
