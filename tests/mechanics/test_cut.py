"""A plate along the finger reaches its proximal cut: told before anything is solved."""

from dataclasses import replace

import pytest

import fefinger as ff
from fefinger.checks import InputError
from fefinger.mechanics import _cut, _press, solid
from fefinger.mechanics._cut import FAR, NEAR
from fefinger.records import Response


def pressed(subject: str, depth: float, angle: float = 0.0) -> ff.Scene:
    finger = ff.Finger.subject(subject, resolution="coarse")
    ask = ff.Ask(pressure=False, strain=False, fields=False)
    motion = ff.Ramp(60.0, depth, corner=0.0)
    return ff.Scene(finger=finger, indenter=ff.Flat(angle), motion=motion, ask=ask)


METHODS = {  # no mesh for a plate along it is shipped of d.p.: that of the 30 degree plate
    "a.h.": _press.WHOLE_MESH,
    "d.p.": replace(_press.WHOLE_MESH, touch=lambda indenter: None),
}


@pytest.mark.parametrize("subject", METHODS)
def test_contact_reaches_the_cut_where_the_undeformed_gap_says(subject: str) -> None:
    def answer(depth: float) -> Response:
        asked = pressed(subject, depth)
        return _press.press(asked, mechanics="linear", notes=(), method=METHODS[subject])

    scene = pressed(subject, 1.0)
    gap = _cut._gap(scene.finger, ff.Flat(0.0))
    assert _cut.reached("linear", pressed(subject, 0.99 * NEAR * gap)) == ()
    assert answer(0.99 * NEAR * gap).force[-1] > 0
    (doubt,) = _cut.reached("linear", pressed(subject, 1.05 * gap))
    assert doubt.about == "accuracy"
    assert "contact may reach the cut" in doubt.reason
    with pytest.raises(InputError, match="it reaches the proximal cut"):
        answer(1.01 * FAR * gap)  # from 1.05 on, by the draw of the mesh
    (sure,) = _cut.reached("solid", pressed(subject, 1.01 * FAR * gap))
    assert sure.about == "ability"
    assert "contact reaches the cut" in sure.reason
    assert sure in solid.refuse(pressed(subject, 1.01 * FAR * gap))


def test_steeper_plates_and_other_objects_are_not_asked_about_it() -> None:
    deep = pressed("a.h.", 2.0, angle=30.0)
    assert _cut.reached("linear", deep) == ()
    ball = ff.Scene(finger=deep.finger, indenter=ff.Sphere(5.0), motion=deep.motion)
    assert _cut.reached("linear", ball) == ()
