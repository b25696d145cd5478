"""The main path: what it does with a check that fails."""

from dataclasses import replace

import pytest

import fefinger as ff
from fefinger.checks import ConvergenceError, Stopped
from fefinger.mechanics import hertz


SCENE = ff.Scene(
    finger=ff.Finger.subject("a.h."),
    indenter=ff.Flat(30.0),
    motion=ff.RampHold(speed=20, depth=0.3, hold=0.05),
    ask=ff.Ask(spikes=("FAI",), fields=False),
)


@pytest.mark.parametrize(
    "failure",
    [ff.InputError("no mesh"), ConvergenceError("no root"), Stopped("it folds", "a Response")],
    ids=lambda each: type(each).__name__,
)
def test_an_answer_outlives_a_mesh_check_that_fails(monkeypatch, failure):
    coarser = replace(SCENE, finger=replace(SCENE.finger, resolution="coarse"))
    answer = hertz.respond

    def respond(scene, progress=None):
        if scene.finger.resolution == "coarse":
            raise failure
        return answer(scene, progress)

    monkeypatch.setattr(hertz, "coarser", lambda _: coarser)
    monkeypatch.setattr(hertz, "respond", respond)
    found = ff.run(SCENE, mechanics="hertz")
    assert found.spikes is not None
    said = f"Spike counts could not be checked when the mesh is coarse: {failure}"
    assert said in found.notes
