"""Page of a calibration: residuals with their noise, marks of faults, a press that is held out."""

from dataclasses import replace

import numpy as np
import pytest

from fefinger.calibration.record import Calibration, Parameter, PressFit
from fefinger.pages import calibration_page
from fefinger.theory.relaxation import Prony


N = 300


def press(*, keeps=0.0, held_out=False):
    """Return a press whose residual keeps a part of itself from one average to the next."""
    rng, off = np.random.default_rng(0), np.zeros(N)
    for i in range(1, N):
        off[i] = keeps * off[i - 1] + rng.normal()
    time = np.linspace(0, 0.5, N)
    force = np.clip(40 * (time - 0.1), 0, 2)
    depth, sds = np.clip(30 * (time - 0.1), -1, 1.5), (1e-3,) * N
    rows = (tuple(each.tolist()) for each in (time, depth, force, force + 1e-3 * off))
    noise = {} if held_out else {"noise": sds, "spread": sds, "marks": ((0.15, "late force"),)}
    return PressFit("press.csv", *rows, held_out=held_out, **noise)


@pytest.mark.parametrize("keeps", [0.0, 0.6])
def test_the_autocorrelation_of_a_residual_is_that_of_its_process(keeps):
    """An autoregressive one has the power of what it keeps; 95 % of white noise is in the band."""
    found = calibration_page.autocorrelation(press(keeps=keeps))
    assert found[0] == pytest.approx(1.0)
    np.testing.assert_allclose(found[1:4], keeps ** np.arange(1, 4), atol=4 / np.sqrt(N))


def test_a_page_shows_every_press_with_units_and_marks(tmp_path):
    modulus = Parameter("modulus", 9.0, 1.0, "kPa", (34.0, 1.39), "a source", (0.3, 2e3), "fitted")
    empty = {"correlations": (), "residuals": {}, "unidentified": ("v3: no",), "stages": ()}
    found = Calibration(
        **{"target": "press.csv", "mechanics": "solid", "finger": {"width": 15.0}, **empty},
        **{"parameters": (modulus,), "status": "Fitted.", "skin": {}, "subcutaneous": {}},
        **{"prony": Prony((1.0,), ()), "deepest": 1.0, "q": (), "shares": (), "growth": None},
        findings=("late force: it is 1 ms behind the position",),
        presses=(press(), press(held_out=True)),
    )
    file = tmp_path / "calibration.html"
    calibration_page.write(found, file)
    html = file.read_text(encoding="utf-8")
    for text in ("modulus", "7.04 to 11", "late force", "press.csv: held out", "v3: no"):
        assert text in html
    for unit in ("residual%20/%20mN", "residual / mN"):
        assert html.count(unit) in (0, 6)
    assert "mN" in calibration_page.summary(press())
    quiet = replace(press(), noise=(), spread=())
    assert "noise" not in calibration_page.summary(quiet)
