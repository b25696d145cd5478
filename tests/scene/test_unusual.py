"""Numbers in another unit, a thousand times too small or too large, are cautioned of."""

from dataclasses import replace

import numpy as np
import pytest

import fefinger as ff
from fefinger.plan import choose
from fefinger.results import key_numbers
from fefinger.scene.cautions import unusual
from fefinger.scene.motion import Motion


FINGER, PRESS = ff.Finger.subject("a.h."), ff.RampHold(speed=20, depth=1.0, hold=0.5)
TIME = np.linspace(0.0, 1.0, 201)
RISE = np.minimum(TIME / 0.1, 1.0)


def of_moduli(skin: float, subcutaneous: float) -> ff.Finger:
    return replace(
        FINGER,
        skin=replace(FINGER.skin, modulus=skin),
        subcutaneous=replace(FINGER.subcutaneous, modulus=subcutaneous),
    )


def sampled(scale: float, *, seconds: float = 1.0, control: str = "depth") -> ff.Sampled:
    values = {control: tuple((scale * RISE).tolist())}
    return ff.Sampled(tuple((seconds * TIME).tolist()), **values)


@pytest.mark.parametrize(
    ("finger", "motion", "said"),
    [
        (of_moduli(0.08, 0.034), PRESS, "as if it were in MPa"),
        (of_moduli(8e4, 3.4e4), PRESS, "as if it were in Pa"),
        (FINGER, sampled(1.2e-3), "0.0012 mm, as if it were in m;"),
        (FINGER, ff.RampHold(speed=0.02, depth=1e-3, hold=0.5), "as if it were in m;"),
        (FINGER, sampled(1.2, seconds=1e3), "as if its times were in ms"),
        (FINGER, sampled(0.9, seconds=1e3, control="force"), "as if its times were in ms"),
        (of_moduli(80.0, 34.0), PRESS, ""),
        (of_moduli(2.0, 0.3), PRESS, ""),  # one of them
        (FINGER, sampled(0.02), ""),
        (FINGER, sampled(1e-4, control="force"), ""),  # a filament of von Frey
        (FINGER, ff.RampHold(speed=1e-3, depth=1.0, hold=500), ""),
    ],
)
def test_what_is_likely_in_another_unit_is_said(
    finger: ff.Finger, motion: Motion, said: str
) -> None:
    found = unusual(ff.Scene(finger=finger, motion=motion))
    assert len(found) == (said != "")
    assert all(said in each for each in found)


def test_it_stands_beside_the_plan_and_the_answer(synthetic: ff.Result) -> None:
    scene = ff.Scene(finger=of_moduli(0.08, 0.034), motion=PRESS)
    assert "Caution: the moduli of skin" in choose(scene, "pressed").sentence
    found = replace(synthetic, scene=replace(synthetic.scene, finger=scene.finger))
    assert any("as if it were in MPa" in each for each in key_numbers.cautions(found))
