"""A plate along the finger reaches its proximal cut: told before anything is solved."""

from dataclasses import replace

import pytest

import fefinger as ff
from fefinger.mechanics import solid
from fefinger.mechanics.press import proximal_cut, small_strain
from fefinger.mechanics.press.proximal_cut import FAR, NEAR
from fefinger.mechanics.situation import Situation
from fefinger.results.records import Response
from fefinger.support.checks import InputError


def pressed(subject: str, depth: float, angle: float = 0.0) -> ff.Scene:
    finger = ff.Finger.subject(subject, resolution="coarse", tissue="maeno1998")
    ask = ff.Ask(pressure=False, strain=False, fields=False)
    motion = ff.Ramp(60.0, depth, corner=0.0)
    return ff.Scene(finger=finger, indenter=ff.Flat(angle), motion=motion, ask=ask)


METHODS = {  # no mesh for a plate along it is shipped of d.p.: that of the 30 degree plate
    "a.h.": small_strain.WHOLE_MESH,
    "d.p.": replace(small_strain.WHOLE_MESH, touch=lambda indenter: None),
}


@pytest.mark.parametrize("subject", METHODS)
def test_contact_reaches_the_cut_where_the_undeformed_gap_says(subject: str) -> None:
    def answer(depth: float) -> Response:
        asked = pressed(subject, depth)
        return small_strain.respond(asked, mechanics="linear", notes=(), method=METHODS[subject])

    scene = pressed(subject, 1.0)
    gap = proximal_cut._gap(scene.finger, ff.Flat(0.0))
    assert proximal_cut.reached("linear", Situation.of(pressed(subject, 0.99 * NEAR * gap))) == ()
    assert answer(0.99 * NEAR * gap).force[-1] > 0
    (doubt,) = proximal_cut.reached("linear", Situation.of(pressed(subject, 1.05 * gap)))
    assert doubt.about == "accuracy"
    assert "contact may reach the cut" in doubt.reason
    with pytest.raises(InputError, match="it reaches the proximal cut"):
        answer(1.01 * FAR * gap)  # from 1.05 on, by the draw of the mesh
    (sure,) = proximal_cut.reached("solid", Situation.of(pressed(subject, 1.01 * FAR * gap)))
    assert sure.about == "ability"
    assert "contact reaches the cut" in sure.reason
    assert sure in solid.refuse(Situation.of(pressed(subject, 1.01 * FAR * gap)))


def test_steeper_plates_and_other_objects_are_not_asked_about_it() -> None:
    deep = pressed("a.h.", 2.0, angle=30.0)
    assert proximal_cut.reached("linear", deep) == ()
    ball = ff.Scene(finger=deep.finger, indenter=ff.Sphere(5.0), motion=deep.motion)
    assert proximal_cut.reached("linear", ball) == ()
