"""The main path: what it does with a check that fails."""

from dataclasses import replace

import numpy as np
import pytest

import fefinger as ff
from fefinger import afferents
from fefinger.mechanics import hertz
from fefinger.mechanics.evidence import costs
from fefinger.neural.trains import Rerun, SpikeTrains
from fefinger.support import processes
from fefinger.support.checks import ConvergenceError, Stopped


SCENE = ff.Scene(
    finger=ff.Finger.subject("a.h.", tissue="maeno1998"),
    indenter=ff.Flat(30.0),
    motion=ff.RampHold(speed=20, depth=0.3, hold=0.05),
    ask=ff.Ask(spikes=("FAI",), fields=False),
)


@pytest.mark.parametrize(
    "failure",
    [
        ff.InputError("no mesh"),
        ConvergenceError("no root"),
        Stopped("it folds", "a Response"),
        IndexError("a defect"),
    ],
    ids=lambda each: type(each).__name__,
)
def test_an_answer_outlives_a_mesh_check_that_fails(monkeypatch, failure):
    coarser = replace(SCENE, finger=replace(SCENE.finger, resolution="coarse"))
    answer = hertz.respond

    def respond(scene, progress=None):
        if scene.finger.resolution == "coarse":
            raise failure
        return answer(scene, progress)

    monkeypatch.setattr(hertz, "coarser", lambda _: coarser.finger)
    monkeypatch.setattr(hertz, "respond", respond)
    found = ff.run(SCENE, mechanics="hertz")
    assert found.spikes is not None
    said = f"Spike counts could not be checked when the mesh is coarse: {failure}"
    assert said in found.notes


@pytest.mark.parametrize(
    ("child", "expected"),
    [
        (processes.SERVE, "All spike counts are the same when the mesh is coarse."),
        ("raise SystemExit(3)", "Spike counts could not be checked when the mesh is coarse: the "),
    ],
    ids=["answers", "dies"],
)
def test_a_slow_answer_is_checked_by_a_process_beside_it(monkeypatch, child, expected):
    coarser = replace(SCENE.finger, resolution="coarse")
    answer = hertz.respond

    def respond(scene, progress=None):
        assert scene.finger.resolution != "coarse"  # not in this process
        return answer(scene, progress)

    monkeypatch.setattr(hertz, "coarser", lambda _: coarser)
    monkeypatch.setattr(hertz, "respond", respond)
    monkeypatch.setattr(costs, "beside", lambda seconds: True)
    monkeypatch.setattr(processes, "SERVE", child)
    notes = ff.run(SCENE, mechanics="hertz").notes
    assert any(note.startswith(expected) for note in notes)


def test_units_of_a_grid_are_checked_by_place_where_the_other_skin_has_fewer(monkeypatch):
    layout = ff.Grid(radius=2.0, spread=0.5, branched=False)
    ask = ff.Ask(spikes=("SAI", "FAI"), fields=False, population=layout)
    scene = replace(SCENE, ask=ask)
    coarser = replace(scene, finger=replace(scene.finger, resolution="coarse"))
    answer = hertz.respond

    def respond(scene, progress=None):
        found = answer(scene, progress)
        if scene.finger.resolution != "coarse":
            return found
        kept = np.arange(len(found.sites.types)) >= 2  # the first place is beside this skin
        fields = {
            name: getattr(found.sites, name)[kept] for name in ("points", "normals", "depths")
        }
        sites = replace(
            found.sites,
            **fields,
            types=found.sites.types[2:],
            unit=found.sites.unit[kept] - 2,
            number=found.sites.number[kept],
        )
        return replace(found, sites=sites, strain=found.strain[:, kept])

    monkeypatch.setattr(hertz, "coarser", lambda _: coarser.finger)
    monkeypatch.setattr(hertz, "respond", respond)
    notes = ff.run(scene, mechanics="hertz").notes
    assert "All spike counts are the same when the mesh is coarse." in notes
    assert any(note.startswith("Not compared: 2 of 26 units, whose places") for note in notes)


def test_a_run_that_stops_keeps_what_was_asked_of_it_without_spikes(monkeypatch):
    answer = hertz.respond

    def respond(scene, progress=None):
        message = "it folds"
        raise Stopped(message, answer(scene, progress))

    monkeypatch.setattr(hertz, "respond", respond)
    scene = replace(SCENE, ask=replace(SCENE.ask, strain=False))
    with pytest.raises(Stopped, match="it folds") as stopped:
        ff.run(scene, mechanics="hertz")
    kept = stopped.value.reached
    assert (kept.strain, kept.spikes) == (None, None)
    assert kept.force[-1] > 0
    assert kept.status == kept.response.status
    assert "scene_sha256" in kept.provenance


@pytest.mark.parametrize("given", ["sphere-press", SCENE], ids=["name", "scene"])
def test_a_scene_is_run_and_explained_with_changes(given):
    changes = {"motion.depth": 0.25, "ask.spikes": [], "motion.hold": 0.05, "ask.fields": False}
    found = ff.run(given, changes=changes, mechanics="hertz")
    assert found.scene.motion.depth == found.depth.max() == 0.25
    assert found.spikes is None
    assert ff.explain(given, changes=changes | {"ask.rel_error": 0.9}).chosen.error < 0.9
    with pytest.raises(ff.InputError, match="dept: unknown key"):
        ff.run(given, changes={"motion.dept": 1})


def test_a_class_in_place_of_an_object_gets_a_sentence():
    with pytest.raises(ff.InputError, match="expected an Indenter, received the class Sphere"):
        replace(SCENE, indenter=ff.Sphere)


def fired(count):
    """Return the trains of one FAI unit that fires `count` times."""
    flat, zero = np.zeros((2, 1)), np.zeros(1)
    times = (np.linspace(0.1, 0.9, count),)
    span = {"t_start": 0.0, "t_stop": 1.0, "time": np.array([0.0, 1.0])}
    rest = {"peak_mV": zero, "block_seconds": zero, "stimulus_driven": zero.astype(int)}
    return SpikeTrains(
        types=("FAI",), names=("FAI",), times=times, x_in=flat, current=flat, **span, **rest
    )


@pytest.mark.parametrize("counts", [(52, 58, 38), (3, 5, 5)], ids=["grating", "bar"])
def test_bounds_of_counts_under_what_slides_hold_what_every_mesh_fires(counts):
    """As found on the coarse, the standard and the fine mesh, each beside the one before."""
    slides = replace(SCENE, motion=ff.Slide(speed=20, depth=0.5, distance=10))
    for i, count in enumerate(counts):
        found = afferents._scattered(fired(count), scene=slides)
        if i:
            found = found.beside(Rerun("the mesh is coarser", np.array([counts[i - 1]])))
        (least,), (most,) = found.bounds()
        assert least <= min(counts) <= max(counts) <= most
    (least,), (most,) = afferents._scattered(fired(7), scene=SCENE).bounds()
    assert (least, most) == (6, 8)
    assert afferents._scattered(fired(0), scene=SCENE).bounds().ravel().tolist() == [0, 0]


def test_a_mesh_check_that_is_left_out_is_noted_and_not_run(monkeypatch):
    coarser = replace(SCENE.finger, resolution="coarse")
    monkeypatch.setattr(hertz, "coarser", lambda _: coarser)
    monkeypatch.setattr(afferents, "_spikes", lambda case: pytest.fail("it was run"))
    found = ff.run(SCENE, changes={"ask.check": False}, mechanics="hertz")
    assert afferents.UNCHECKED in found.notes
    assert "the mesh is coarse" not in found.spikes.reruns
